#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "compare/reference/published.hpp"
#include "compare/tables/error_table.hpp"
#include "compare/tables/text_grid.hpp"

namespace compare {

/// The CFD against published values, one row per check; a row with a bad verdict in red.
TextGrid truth_grid(const std::vector<PublishedCheck>& checks);

std::string render(const std::vector<PublishedCheck>& checks, Format format, bool colour = false);
nlohmann::json to_json(const std::vector<PublishedCheck>& checks);

}  // namespace compare
