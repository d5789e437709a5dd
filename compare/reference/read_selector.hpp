#pragma once

#include <toml++/toml.h>

#include <string>

#include "compare/reference/case_selector.hpp"

namespace compare {

/// Takes a key of a TOML entry if it is one of a CaseSelector: a number stands for itself within 1 % (an angle within half a degree), a
/// pair for everything between. @return false for any other key
bool read_selector(CaseSelector& selector, const std::string& key, const toml::node& node);

}  // namespace compare
