#include "compare/mesh_table.hpp"

#include <fmt/color.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "compare/text_grid.hpp"

namespace compare {

namespace {

std::string percent(double share) { return fmt::format("{:.1f} %", 100.0 * share); }

/// Components of the force that symmetry makes zero, in the worst case, as MeshRow::null.
double asymmetry(const CaseFamily& family) {
  const auto& u = family.uncertainty;
  double worst = 0.0;
  for (Eigen::Index k = 1; k < 3; ++k) {
    const double null = family.record->u_null[k];
    const double open = std::hypot(std::max(u.discretisation[k], u.discretisation[0]), family.record->u_iteration[k], family.record->u_statistical[k]);
    if (null > 0.0) worst = std::max(worst, open > 0.0 ? null / open : HUGE_VAL);
  }
  return worst;
}

}  // namespace

std::vector<MeshRow> mesh_rows(const std::vector<case_record::CaseRecord>& records) {
  std::map<std::pair<std::string, std::string>, MeshRow> rows;
  std::map<std::pair<std::string, std::string>, std::vector<double>> shares;
  for (const CaseFamily& family : case_families(records)) {
    const case_record::CaseRecord& record = *family.record;
    const std::string variant = split_name(record.name, record.mesh_level).variant;
    if (!is_usable(record.status) || record.spins() || !(variant.empty() || variant == "up" || variant == "down")) continue;
    const std::pair key(dragcore::kind(record.shape), fmt::format("Re {:g}, {}", record.reynolds, record.flow_model));
    MeshRow& row = rows[key];
    row.body = key.first, row.flow = key.second;
    row.aim = record.flow_model == "laminar" ? 0.015 : 0.03;
    ++row.poses;
    if (!family.uncertainty.discretisation_assessed) {
      ++row.unknown;
      continue;
    }
    const auto levels = family.usable_levels().size();
    ++(levels >= 3 ? row.three_levels : levels == 2 ? row.two_levels : row.carried);
    const double share = family.uncertainty.discretisation[0] / std::abs(record.load.force().x());
    shares[key].push_back(share);
    if (share <= row.aim) ++row.within_aim;
    if (share >= row.largest) row.largest = share, row.worst = record.name + ": " + family.uncertainty.branches.front();
    row.null = std::max(row.null, asymmetry(family));
  }
  std::vector<MeshRow> list;
  for (auto& [key, row] : rows) {
    if (auto& found = shares[key]; !found.empty()) {
      const auto middle = found.begin() + static_cast<std::ptrdiff_t>(found.size() / 2);
      std::nth_element(found.begin(), middle, found.end());
      row.median = *middle;
    }
    list.push_back(std::move(row));
  }
  return list;
}

std::string render(const std::vector<MeshRow>& rows, Format format, bool colour) {
  if (format == Format::json) return to_json(rows).dump(2) + "\n";
  if (format == Format::csv) {
    std::string text = "body,flow,aim,poses,within_aim,three_levels,two_levels,carried,unknown,median,largest,worst,null\n";
    for (const MeshRow& row : rows)
      text += csv_line({row.body, row.flow, fmt::format("{:g}", row.aim), std::to_string(row.poses), std::to_string(row.within_aim), std::to_string(row.three_levels),
                        std::to_string(row.two_levels), std::to_string(row.carried), std::to_string(row.unknown), fmt::format("{:.9g}", row.median),
                        fmt::format("{:.9g}", row.largest), row.worst, fmt::format("{:.9g}", row.null)});
    return text;
  }
  TextGrid grid;
  grid.add({"body", "flow", "poses", "of 3 levels", "of 2", "carried", "unknown", "median u", "largest u", "aim", "within", "null", "largest in"});
  int poses = 0, within = 0;
  for (const MeshRow& row : rows) {
    const bool known = row.unknown < row.poses;
    grid.add({row.body, row.flow, std::to_string(row.poses), std::to_string(row.three_levels), std::to_string(row.two_levels), std::to_string(row.carried),
              std::to_string(row.unknown), known ? percent(row.median) : "", known ? percent(row.largest) : "", percent(row.aim),
              fmt::format("{} of {}", row.within_aim, row.poses), row.null > 0.0 ? fmt::format("{:.2f}", row.null) : "", row.worst},
             row.within_aim == row.poses ? fmt::text_style{} : fg(fmt::terminal_color::yellow));
    poses += row.poses, within += row.within_aim;
  }
  const std::string title = "What the mesh leaves open of C_D: u_disc over C_D, by body and flow";
  const std::string legend = fmt::format(
      "{} of {} poses are within their aim. of 3 levels: three or more meshes; of 2: two, safety factor 3; carried: from the nearest case of three.\n"
      "null: force components that symmetry makes zero, at their largest, over what mesh and iteration leave open; below 1 is inside.\n",
      within, poses);
  if (format == Format::table) return title + "\n" + aligned(grid, colour) + legend;
  return "### " + title + "\n\n" + markdown(grid) + "\n" + legend;
}

nlohmann::json to_json(const std::vector<MeshRow>& rows) {
  nlohmann::json list = nlohmann::json::array();
  for (const MeshRow& row : rows)
    list.push_back({{"body", row.body},
                    {"flow", row.flow},
                    {"aim", row.aim},
                    {"poses", row.poses},
                    {"within_aim", row.within_aim},
                    {"three_levels", row.three_levels},
                    {"two_levels", row.two_levels},
                    {"carried", row.carried},
                    {"unknown", row.unknown},
                    {"median", row.median},
                    {"largest", row.largest},
                    {"worst", row.worst},
                    {"null", row.null}});
  return list;
}

}  // namespace compare
