#include "compare/tables/mesh_table.hpp"

#include <fmt/color.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "compare/reference/coefficients.hpp"
#include "compare/tables/text_grid.hpp"

namespace compare {

namespace {

std::string percent(double share) { return fmt::format("{:.1f} %", 100.0 * share); }

/// Components of the force that symmetry makes zero, in the worst case, as MeshRow::null.
double asymmetry(const CaseFamily& family) {
  const auto& u = family.uncertainty;
  double worst = 0.0;
  for (Eigen::Index k = 1; k < 3; ++k) {
    const double null = family.record->u_null[k];
    const double open =
        std::hypot(std::max(u.discretisation[k], u.discretisation[0]), family.record->u_iteration[k], family.record->u_statistical[k]);
    if (null > 0.0) worst = std::max(worst, open > 0.0 ? null / open : HUGE_VAL);
  }
  return worst;
}

/// Solved on a mesh, usable, at rest, and no variant of the numerics; the two ways through a range of angles are cases of their own.
bool is_counted(const case_record::CaseRecord& record) {
  const std::string variant = split_name(record.name, record.mesh_level).variant;
  return is_usable(record.status) && !record.is_experiment() && !record.spins() && (variant.empty() || variant == "up" || variant == "down");
}

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

std::vector<MeshRow> mesh_rows(const std::vector<case_record::CaseRecord>& records) {
  std::map<std::pair<std::string, std::string>, MeshRow> rows;
  std::map<std::pair<std::string, std::string>, std::vector<double>> shares;
  for (const CaseFamily& family : case_families(records)) {
    const case_record::CaseRecord& record = *family.record;
    if (!is_counted(record)) continue;
    const std::pair key(dragcore::kind(record.shape), fmt::format("Re {:g}, {}", record.reynolds, record.flow_model));
    MeshRow& row = rows[key];
    row.body = key.first, row.flow = key.second;
    row.aim = flow_class(record) == "laminar" ? 0.015 : 0.03;
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
    if (auto& found = shares[key]; !found.empty()) row.median = median(found);
    list.push_back(std::move(row));
  }
  return list;
}

std::string render(const std::vector<MeshRow>& rows, Format format, bool colour) {
  if (format == Format::json) return to_json(rows).dump(2) + "\n";
  if (format == Format::csv) {
    std::string text = "body,flow,aim,poses,within_aim,three_levels,two_levels,carried,unknown,median,largest,worst,null\n";
    for (const MeshRow& row : rows)
      text += csv_line({row.body, row.flow, fmt::format("{:g}", row.aim), std::to_string(row.poses), std::to_string(row.within_aim),
                        std::to_string(row.three_levels), std::to_string(row.two_levels), std::to_string(row.carried),
                        std::to_string(row.unknown), fmt::format("{:.9g}", row.median), fmt::format("{:.9g}", row.largest), row.worst,
                        fmt::format("{:.9g}", row.null)});
    return text;
  }
  TextGrid grid;
  grid.add({"body", "flow", "poses", "of 3 levels", "of 2", "carried", "unknown", "median u", "largest u", "aim", "within", "null",
            "largest in"});
  int poses = 0, within = 0;
  for (const MeshRow& row : rows) {
    const bool known = row.unknown < row.poses;
    grid.add({row.body, row.flow, std::to_string(row.poses), std::to_string(row.three_levels), std::to_string(row.two_levels),
              std::to_string(row.carried), std::to_string(row.unknown), known ? percent(row.median) : "", known ? percent(row.largest) : "",
              percent(row.aim), fmt::format("{} of {}", row.within_aim, row.poses), row.null > 0.0 ? fmt::format("{:.2f}", row.null) : "",
              row.worst},
             row.within_aim == row.poses ? fmt::text_style{} : fg(fmt::terminal_color::yellow));
    poses += row.poses, within += row.within_aim;
  }
  const std::string title = "What the mesh leaves open of C_D: u_disc over C_D, by body and flow";
  const std::string legend = fmt::format(
      "{} of {} poses are within their aim. of 3 levels: three or more meshes; of 2: two, safety factor 3; carried: from the nearest case "
      "of three.\n"
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

std::vector<HeldBackRow> held_back_rows(const std::vector<case_record::CaseRecord>& records) {
  std::map<std::pair<std::string, std::string>, HeldBackRow> rows;
  std::map<std::pair<std::string, std::string>, std::vector<double>> shares;
  for (const CaseFamily& family : case_families(records)) {
    auto levels = family.usable_levels();
    if (!is_counted(*family.record) || levels.size() < 3 || !family.uncertainty.discretisation_assessed) continue;
    const double truth = levels.back()->load.force().x();
    levels.pop_back();
    std::vector<double> cells, drag;
    for (const auto* level : levels) cells.push_back(level->cells), drag.push_back(level->load.force().x());
    const GridStudy study = mesh_study(cells, drag, family.record->flow_model);
    const std::pair key(levels.size() == 2 ? "two meshes, factor 3" : fmt::format("three or more, factor {:g}", study.safety),
                        family.record->flow_model);
    HeldBackRow& row = rows[key];
    row.rule = key.first, row.flow = key.second;
    const double away = std::abs(truth - drag.back());
    const double share = away == 0.0 ? 0.0 : away / (2.0 * study.uncertainty);
    shares[key].push_back(share);
    ++row.poses;
    if (share <= 1.0) ++row.within;
    const double to_coefficient = 1.0 / coefficient_scales(*family.record)[0];
    if (share >= row.largest)
      row.largest = share,
      row.worst = fmt::format("{}: C_D {:.4f} +- {:.4f} (2u), then {:.4f}", levels.back()->name, drag.back() * to_coefficient,
                              2.0 * study.uncertainty * to_coefficient, truth * to_coefficient);
  }
  std::vector<HeldBackRow> list;
  for (auto& [key, row] : rows) {
    row.median = median(shares[key]);
    list.push_back(std::move(row));
  }
  return list;
}

std::string render(const std::vector<HeldBackRow>& rows, Format format, bool colour) {
  if (format == Format::json) return to_json(rows).dump(2) + "\n";
  if (format == Format::csv) {
    std::string text = "rule,flow,poses,within,median,largest,worst\n";
    for (const HeldBackRow& row : rows)
      text += csv_line({row.rule, row.flow, std::to_string(row.poses), std::to_string(row.within), fmt::format("{:.9g}", row.median),
                        fmt::format("{:.9g}", row.largest), row.worst});
    return text;
  }
  TextGrid grid;
  grid.add({"u of", "flow", "next mesh within 2u", "median", "largest", "largest in"});
  for (const HeldBackRow& row : rows)
    grid.add({row.rule, row.flow, fmt::format("{} of {}", row.within, row.poses), fmt::format("{:.2f}", row.median),
              fmt::format("{:.2f}", row.largest), row.worst},
             row.within == row.poses ? fmt::text_style{} : fg(fmt::terminal_color::yellow));
  const std::string title = "Does u_disc hold? The finest mesh of each pose against the meshes before it";
  const std::string legend =
      "median, largest: distance in C_D over 2u, where 2u is meant for 95 %. Of second order, and without a safety factor, half of it "
      "shows on the next mesh.\n";
  if (format == Format::table) return title + "\n" + aligned(grid, colour) + legend;
  return "### " + title + "\n\n" + markdown(grid) + "\n" + legend;
}

nlohmann::json to_json(const std::vector<HeldBackRow>& rows) {
  nlohmann::json list = nlohmann::json::array();
  for (const HeldBackRow& row : rows)
    list.push_back({{"rule", row.rule},
                    {"flow", row.flow},
                    {"poses", row.poses},
                    {"within", row.within},
                    {"median", row.median},
                    {"largest", row.largest},
                    {"worst", row.worst}});
  return list;
}

}  // namespace compare
