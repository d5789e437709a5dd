#pragma once

#include <map>
#include <string>
#include <vector>

#include "compare/report/report_sweep.hpp"

namespace compare {

/// The sections of the page from the verdict to the provenance, as HTML.
/// @param specs   figures(): a section shows those that there are
/// @param bodies  the sections on bodies in three dimensions, which follow the figures
std::string report_sections(const Report& report, const std::vector<Sweep>& list, const std::map<std::string, nlohmann::json>& specs,
                            const std::string& bodies);

}  // namespace compare
