#include "compare/tables/truth_table.hpp"

#include <fmt/color.h>
#include <fmt/format.h>

#include <nlohmann/json.hpp>

namespace compare {

using nlohmann::json;

TextGrid truth_grid(const std::vector<PublishedCheck>& checks) {
  TextGrid grid;
  grid.add({"case", "", "CFD", "u", "u method", "published", "u published", "difference", "combined u", "goal", "verdict", "source"});
  for (const PublishedCheck& check : checks) {
    const char* format = check.is_angle() ? "{:.1f}" : check.quantity == "C_spin" ? "{:.5f}" : "{:.3f}";
    grid.add({check.case_name + (check.of_record ? "" : " (not of record)"), check.quantity, number_text(check.cfd, format),
              number_text(check.u, "{:.2g}") + (check.discretisation_assessed ? "" : "*"),
              check.u_method > 0.0 ? number_text(check.u_method, "{:.2g}") : "", number_text(check.published.value, format),
              number_text(check.published.uncertainty, "{:.2g}"), fmt::format("{:+.1f}{}", check.difference_in_unit(), check.unit()),
              fmt::format("{:.1f}{}", check.in_unit(check.combined_uncertainty()), check.unit()),
              check.goal ? fmt::format("{:g}{}", *check.goal, check.unit()) : "", check.verdict(),
              check.published.citation + (check.published.conversion.empty() ? "" : ", converted")},
             check.agrees() && check.within_goal() ? fmt::text_style{} : fg(fmt::terminal_color::red));
  }
  return grid;
}

std::string render(const std::vector<PublishedCheck>& checks, Format format, bool colour) {
  if (format == Format::json) return to_json(checks).dump(2) + "\n";
  if (format == Format::csv) {
    std::string text =
        "case,flow_model,of_record,quantity,cfd,u,discretisation_assessed,u_method,published,u_published,difference,difference_percent,"
        "combined_u,goal,verdict,kind,citation,confidence,conversion\n";
    for (const PublishedCheck& check : checks) {
      const auto full = [](const std::optional<double>& value) { return number_text(value, "{:.9g}"); };
      text +=
          csv_line({check.case_name, check.flow_model, check.of_record ? "1" : "0", check.quantity, full(check.cfd), full(check.u),
                    check.discretisation_assessed ? "1" : "0", full(check.u_method), full(check.published.value),
                    full(check.published.uncertainty), full(check.difference()), check.is_angle() ? "" : full(check.difference_percent()),
                    full(check.combined_uncertainty()), full(check.goal), check.verdict(), check.published.kind, check.published.citation,
                    check.published.confidence, check.published.conversion});
    }
    return text;
  }
  const std::string title = "The CFD against published values, on the reference areas of docs/conventions.md";
  const std::string legend =
      "u: one standard uncertainty, numerical, the CFD's without the part of its method (u method), which this comparison is to show; u*: "
      "without the part of the mesh. "
      "agrees: |difference| <= 2 sqrt(u^2 + u_published^2).\n";
  if (format == Format::table) return title + "\n" + aligned(truth_grid(checks), colour) + legend;
  return "### " + title + "\n\n" + markdown(truth_grid(checks)) + "\n" + legend;
}

json to_json(const std::vector<PublishedCheck>& checks) {
  json list = json::array();
  for (const PublishedCheck& check : checks)
    list.push_back({{"case", check.case_name},
                    {"flow_model", check.flow_model},
                    {"of_record", check.of_record},
                    {"quantity", check.quantity},
                    {"cfd", check.cfd},
                    {"u_cfd", check.u},
                    {"discretisation_assessed", check.discretisation_assessed},
                    {"u_method", check.u_method},
                    {"published", check.published.value},
                    {"uncertainty", check.published.uncertainty},
                    {"difference", check.difference()},
                    {"difference_percent", check.is_angle() ? json(nullptr) : json(check.difference_percent())},
                    {"combined_u", check.combined_uncertainty()},
                    {"goal", check.goal ? json(*check.goal) : json(nullptr)},
                    {"goal_unit", check.is_angle() ? "deg" : "%"},
                    {"within_goal", check.within_goal()},
                    {"agrees", check.agrees()},
                    {"verdict", check.verdict()},
                    {"kind", check.published.kind},
                    {"citation", check.published.citation},
                    {"confidence", check.published.confidence},
                    {"conversion", check.published.conversion}});
  return list;
}

}  // namespace compare
