#pragma once

#include <fmt/color.h>

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

namespace compare {

/// A table of text; its first row is the heading.
struct TextGrid {
  std::vector<std::vector<std::string>> rows;
  std::vector<fmt::text_style> styles;  ///< per row

  void add(std::vector<std::string> cells, fmt::text_style style = {}) {
    rows.push_back(std::move(cells));
    styles.push_back(style);
  }
};

std::string aligned(const TextGrid& grid, bool colour);  ///< for a terminal: words to the left, numbers to the right
std::string markdown(const TextGrid& grid);

std::string csv_line(const std::vector<std::string>& cells);  ///< quoted where needed, with its line end

/// Empty for no value. @param format  of fmt, for one double
std::string number_text(const std::optional<double>& value, const char* format = "{:.3f}");

nlohmann::json optional_json(const std::optional<double>& value);  ///< null for no value

}  // namespace compare
