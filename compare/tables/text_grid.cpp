#include "compare/tables/text_grid.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <nlohmann/json.hpp>

namespace compare {
namespace {

/// Printed width: UTF-8 continuation bytes take no room.
std::size_t width(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

}  // namespace

std::string aligned(const TextGrid& grid, bool colour) {
  std::vector<std::size_t> widths(grid.rows.front().size(), 0);
  for (const std::vector<std::string>& row : grid.rows)
    for (std::size_t k = 0; k < row.size(); ++k) widths[k] = std::max(widths[k], width(row[k]));
  std::string text;
  for (std::size_t i = 0; i < grid.rows.size(); ++i) {
    std::string line;
    for (std::size_t k = 0; k < grid.rows[i].size(); ++k) {
      const std::string& cell = grid.rows[i][k];
      const std::string pad(widths[k] - width(cell), ' ');
      // Words to the left, numbers to the right.
      const bool word = k == 0 || std::isalpha(static_cast<unsigned char>(cell.empty() ? 'a' : cell[0]));
      line += (k ? "  " : "") + (word ? cell + pad : pad + cell);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    const fmt::text_style style = i == 0 ? fmt::text_style(fmt::emphasis::bold) : grid.styles[i];
    text += (colour && (style.has_foreground() || style.has_emphasis()) ? fmt::format(style, "{}", line) : line) + "\n";
  }
  return text;
}

std::string markdown(const TextGrid& grid) {
  std::string text;
  for (std::size_t i = 0; i < grid.rows.size(); ++i) {
    text += "|";
    for (const std::string& cell : grid.rows[i]) text += " " + cell + " |";
    text += "\n";
    if (i > 0) continue;
    text += "|";
    for (std::size_t k = 0; k < grid.rows[0].size(); ++k) text += k ? "---:|" : "---|";
    text += "\n";
  }
  return text;
}

std::string csv_line(const std::vector<std::string>& cells) {
  std::string text;
  for (std::size_t k = 0; k < cells.size(); ++k) {
    if (k > 0) text += ",";
    if (cells[k].find_first_of(",\"\n") == std::string::npos) {
      text += cells[k];
      continue;
    }
    text += "\"";
    for (const char c : cells[k]) text += c == '"' ? "\"\"" : std::string(1, c);
    text += "\"";
  }
  return text + "\n";
}

std::string number_text(const std::optional<double>& value, const char* format) {
  if (!value) return "";
  std::string text = fmt::format(fmt::runtime(format), *value);
  // A rounded -0.000 would suggest a sign.
  if ((text.starts_with('-') || text.starts_with('+')) && text.find_first_of("123456789") == std::string::npos) text.erase(0, 1);
  return text;
}

nlohmann::json optional_json(const std::optional<double>& value) { return value ? nlohmann::json(*value) : nlohmann::json(nullptr); }

}  // namespace compare
