#include "compare/report/html.hpp"

#include <fmt/format.h>

#include <cmath>

namespace compare::html {
namespace {

std::string with_minus(std::string digits) {
  if (!digits.empty() && digits.front() == '-') {
    const bool zero = digits.find_first_of("123456789") == std::string::npos;
    digits.replace(0, 1, zero ? "" : "\u2212");
  }
  return digits;
}

}  // namespace

std::string escape(std::string_view text) {
  std::string safe;
  for (const char letter : text) {
    if (letter == '&')
      safe += "&amp;";
    else if (letter == '<')
      safe += "&lt;";
    else if (letter == '>')
      safe += "&gt;";
    else if (letter == '"')
      safe += "&quot;";
    else
      safe += letter;
  }
  return safe;
}

std::string symbol(std::string_view name) {
  const auto bar = name.find('_');
  if (bar == std::string_view::npos) return "<i>" + escape(name) + "</i>";
  return "<i>" + escape(name.substr(0, bar)) + "</i><sub>" + escape(name.substr(bar + 1)) + "</sub>";
}

std::string number(const std::optional<double>& value, int decimals, bool with_sign) {
  if (!value || !std::isfinite(*value)) return "\u2013";
  const std::string digits = with_minus(fmt::format("{:.{}f}", *value, decimals));
  return with_sign && *value > 0.0 && digits.find_first_of("123456789") != std::string::npos ? "+" + digits : digits;
}

std::string magnitude(double value) {
  const double size = std::abs(value);
  if (size != 0.0 && size < 1e-3) return with_minus(fmt::format("{:.2e}", value));
  if (size >= 1e3) return count(value);
  return number(value, size >= 100 ? 0 : size >= 10 ? 1 : size >= 1 ? 2 : 3);
}

std::string count(double value) {
  std::string digits = fmt::format("{:.0f}", std::abs(value));
  for (auto place = static_cast<int>(digits.size()) - 3; place > 0; place -= 3)
    digits.insert(static_cast<std::size_t>(place), "\u202f");  // a narrow space
  return value < 0.0 ? "\u2212" + digits : digits;
}

std::string Table::text() const {
  const auto line = [](const std::vector<Cell>& cells, const char* tag) {
    std::string row = "<tr>";
    for (const Cell& cell : cells) {
      row += fmt::format("<{}", tag);
      if (!cell.kind.empty()) row += fmt::format(" class=\"{}\"", cell.kind);
      if (!cell.title.empty()) row += fmt::format(" title=\"{}\"", escape(cell.title));
      if (cell.columns > 1) row += fmt::format(" colspan=\"{}\"", cell.columns);
      row += fmt::format(">{}</{}>", cell.html, tag);
    }
    return row + "</tr>\n";
  };
  std::string html = fmt::format("<div class=\"wide\"><table id=\"{}\">\n<caption>{}</caption>\n<thead>\n", id, caption);
  for (const auto& cells : head) html += line(cells, "th");
  html += "</thead>\n<tbody>\n";
  for (const auto& cells : rows) html += line(cells, "td");
  return html + "</tbody>\n</table></div>\n";
}

}  // namespace compare::html
