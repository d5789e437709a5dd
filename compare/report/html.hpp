#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

/// The little HTML that the report needs. Everything returned is safe to put between tags.
namespace compare::html {

std::string escape(std::string_view text);

/// "C_D" as a letter with its subscript.
std::string symbol(std::string_view name);

/// Fixed decimals with a true minus sign, never "-0.00"; `with_sign` adds a plus. An empty value becomes a dash.
std::string number(const std::optional<double>& value, int decimals, bool with_sign = false);

/// For quantities that span decades: three significant digits.
std::string magnitude(double value);

/// A whole number with its thousands apart.
std::string count(double value);

struct Cell {
  std::string html;
  std::string kind = {};  ///< CSS classes: "text" (left), "faint", "bad", "good", ...
  int columns = 1;
  std::string title = {};  ///< plain text that a browser shows on the cell
};

/// A table with a caption; numbers are right-aligned unless the cell is of kind "text".
struct Table {
  std::string id;
  std::string caption;
  std::vector<std::vector<Cell>> head;
  std::vector<std::vector<Cell>> rows;
  std::string text() const;
};

}  // namespace compare::html
