#include "compare/tables/variants.hpp"

#include <fmt/color.h>
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "compare/tables/text_grid.hpp"

namespace compare {
namespace {

using case_record::CaseRecord;
using case_record::is_usable;
using Channels = CaseRecord::Channels;
using Eigen::Vector3d;
using nlohmann::json;

/// What is compared of a case: drag, lateral force, moment.
using Triple = std::array<double, 3>;

/// As coefficients; `channels` are those of the load or of its uncertainty.
Triple triple_of(const CaseRecord& record, const Channels& channels) {
  const Channels c = channels.cwiseQuotient(coefficient_scales(record));
  const bool yawed = record.pose.yaw != 0.0;
  const double moment = record.still_air ? c.tail<3>().dot(record.angular_velocity.normalized()) : c[yawed ? 5 : 4];
  return {c[0], c[yawed ? 1 : 2], moment};
}

Triple triple_of(const CaseRecord& record) {
  Channels load;
  load << record.load.force(), record.load.moment();
  return triple_of(record, load);
}

/// A base case with what its variants are measured against.
struct Base {
  const CaseRecord* record = nullptr;
  std::optional<Triple> u;  ///< u_disc of its mesh
};

double cpu_of(const CaseRecord& record) {
  double seconds = 0.0;
  for (const auto& [stage, cost] : record.cost) seconds += cost.cpu_s;
  return seconds;
}

std::array<Change, 3> changes(const Base& base, const Triple& difference) {
  constexpr double nothing = 0.01;  // a moment below a hundredth of the force has no percentages
  const Coefficients c = coefficients(*base.record);
  const double force = c.values.head<3>().norm(), moment = c.values.tail<3>().norm();
  const bool still = base.record->still_air;
  const Triple scale = {still ? 0.0 : force, still ? 0.0 : force, still || moment > nothing * force ? moment : 0.0};
  std::array<Change, 3> result;
  for (std::size_t k = 0; k < 3; ++k) {
    if (scale[k] > 0.0) result[k].percent = 100.0 * difference[k] / scale[k];
    if (const bool shown = !still || k == 2; shown && base.u && (*base.u)[k] > 0.0) result[k].in_u = difference[k] / (*base.u)[k];
  }
  return result;
}

std::string percent(const Change& change, const char* format = "{:+.2f} %") { return number_text(change.percent, format); }

json to_json(const Change& change) {
  return {{"percent", change.percent ? json(*change.percent) : json(nullptr)},
          {"in_u_disc", change.in_u ? json(*change.in_u) : json(nullptr)}};
}

}  // namespace

VariantTable variant_table(const std::vector<CaseRecord>& records) {
  std::map<std::string, Base> bases;  // by the name of the case
  for (const CaseFamily& family : case_families(records))
    for (const CaseRecord* level : family.levels) {
      const CaseName name = split_name(level->name, level->mesh_level);
      // Of a flow followed up and down in angle the way up is what the others are compared with.
      if (!name.variant.empty() && name.variant != "up") continue;
      Base& base = bases[name.stem + "_" + level->mesh_level];
      if (base.record && !name.variant.empty()) continue;
      base.record = level;
      if (!is_usable(level->status)) continue;
      if (const auto u = discretisation_at(family, *level)) {
        base.u = triple_of(*level, *u);
        if (level->still_air)
          (*base.u)[2] = propagated(*level, *u,
                                    [&](const Vector3d&, const Vector3d& moment) {
                                      return std::optional(moment.dot(level->angular_velocity.normalized()));
                                    }) /
                         coefficient_scales(*level)[3];
      }
    }
  VariantTable table;
  std::map<std::string, std::vector<Triple>> seeds;  // by the name of the base
  for (const CaseRecord& record : records) {
    const CaseName name = split_name(record.name, record.mesh_level);
    if (name.variant.empty()) continue;
    const auto found = bases.find(name.stem + "_" + record.mesh_level);
    if (found != bases.end() && found->second.record->name == record.name) continue;
    if (found == bases.end()) {
      table.without_base.push_back(record.name);
      continue;
    }
    const Base& base = found->second;
    VariantRow row{
        .base = base.record->name, .variant = name.variant, .status = case_record::to_string(record.status), .reason = record.reason};
    row.iterations = record.iterations;
    if (const double before = cpu_of(*base.record), after = cpu_of(record); before > 0.0 && after > 0.0) row.cpu_ratio = after / before;
    if (!is_usable(base.record->status)) {
      row.reason = "its base ended as " + case_record::to_string(base.record->status);
    } else if (is_usable(record.status)) {
      Triple difference = triple_of(record);
      const Triple reference = triple_of(*base.record);
      if (name.variant.starts_with("seed-")) {
        if (seeds[row.base].empty()) seeds[row.base].push_back(reference);
        seeds[row.base].push_back(difference);
      }
      for (std::size_t k = 0; k < 3; ++k) difference[k] -= reference[k];
      const auto change = changes(base, difference);
      row.drag = change[0], row.lateral = change[1], row.moment = change[2];
      ++table.compared;
    }
    table.rows.push_back(std::move(row));
  }
  std::stable_sort(table.rows.begin(), table.rows.end(), [](const VariantRow& a, const VariantRow& b) { return a.base < b.base; });
  for (const auto& [name, values] : seeds) {
    Triple deviation{};
    const auto n = static_cast<double>(values.size());
    for (std::size_t k = 0; k < 3; ++k) {
      double mean = 0.0, squares = 0.0;
      for (const Triple& value : values) mean += value[k] / n;
      for (const Triple& value : values) squares += (value[k] - mean) * (value[k] - mean);
      deviation[k] = std::sqrt(squares / (n - 1.0));
    }
    const auto scatter = changes(bases.at(name), deviation);
    table.seeds.push_back({name, static_cast<int>(values.size()), scatter[0], scatter[1], scatter[2]});
  }
  return table;
}

std::string render(const VariantTable& table, Format format, bool colour) {
  if (format == Format::json) return to_json(table).dump(2) + "\n";
  if (format == Format::csv) {
    std::string text =
        "base,variant,dC_D_percent,dC_lateral_percent,dC_moment_percent,dC_D_in_u,dC_lateral_in_u,dC_moment_in_u,cpu_ratio,iterations,"
        "status,reason\n";
    const auto full = [](const std::optional<double>& value) { return number_text(value, "{:.9g}"); };
    const auto add = [&](const std::string& base, const std::string& variant, const Change& drag, const Change& lateral,
                         const Change& moment, const std::vector<std::string>& rest) {
      std::vector<std::string> cells = {base,
                                        variant,
                                        full(drag.percent),
                                        full(lateral.percent),
                                        full(moment.percent),
                                        full(drag.in_u),
                                        full(lateral.in_u),
                                        full(moment.in_u)};
      cells.insert(cells.end(), rest.begin(), rest.end());
      text += csv_line(cells);
    };
    for (const VariantRow& row : table.rows)
      add(row.base, row.variant, row.drag, row.lateral, row.moment,
          {full(row.cpu_ratio), std::to_string(row.iterations), row.status, row.reason});
    for (const SeedScatter& seed : table.seeds)
      add(seed.base, fmt::format("scatter of {} seeds", seed.n), seed.drag, seed.lateral, seed.moment, {"", "", "", ""});
    return text;
  }
  const bool terminal = format == Format::table;
  const auto block = [&](const std::string& title, const TextGrid& grid) {
    if (grid.rows.size() == 1) return std::string();
    return terminal ? title + "\n" + aligned(grid, colour) + "\n" : "### " + title + "\n\n" + markdown(grid) + "\n";
  };
  TextGrid rows, seeds;
  rows.add({"case", "variant", "C_D", "C_L, C_S", "moment", "C_D / u", "C_L / u", "moment / u", "CPU", "iterations", "status"});
  for (const VariantRow& row : table.rows)
    rows.add({row.base, row.variant, percent(row.drag), percent(row.lateral), percent(row.moment), number_text(row.drag.in_u, "{:+.1f}"),
              number_text(row.lateral.in_u, "{:+.1f}"), number_text(row.moment.in_u, "{:+.1f}"), number_text(row.cpu_ratio, "{:.2f}"),
              std::to_string(row.iterations), row.status + (row.reason.empty() ? "" : ": " + row.reason)},
             row.reason.empty() ? fmt::text_style{} : fg(fmt::terminal_color::red));
  seeds.add({"case", "meshes", "C_D", "C_L, C_S", "moment", "C_D / u", "C_L / u", "moment / u"});
  for (const SeedScatter& seed : table.seeds)
    seeds.add({seed.base, std::to_string(seed.n), percent(seed.drag, "{:.2f} %"), percent(seed.lateral, "{:.2f} %"),
               percent(seed.moment, "{:.2f} %"), number_text(seed.drag.in_u, "{:.1f}"), number_text(seed.lateral.in_u, "{:.1f}"),
               number_text(seed.moment.in_u, "{:.1f}")});
  std::string text = block("Variants against their base on the same mesh level", rows) +
                     block("Scatter over seeds of the mesh, the base among them: standard deviation", seeds);
  text += "Differences in % of the base's force (of its moment, for the moment), and over its u_disc; CPU: time over the base's.\n";
  for (const std::string& name : table.without_base) text += (terminal ? "" : "* ") + ("no base case: " + name) + "\n";
  return text;
}

json to_json(const VariantTable& table) {
  json result = {{"compared", table.compared}, {"rows", json::array()}, {"seeds", json::array()}, {"without_base", table.without_base}};
  for (const VariantRow& row : table.rows)
    result["rows"].push_back({{"base", row.base},
                              {"variant", row.variant},
                              {"status", row.status},
                              {"reason", row.reason},
                              {"drag", to_json(row.drag)},
                              {"lateral", to_json(row.lateral)},
                              {"moment", to_json(row.moment)},
                              {"cpu_ratio", row.cpu_ratio ? json(*row.cpu_ratio) : json(nullptr)},
                              {"iterations", row.iterations}});
  for (const SeedScatter& seed : table.seeds)
    result["seeds"].push_back({{"base", seed.base},
                               {"n", seed.n},
                               {"drag", to_json(seed.drag)},
                               {"lateral", to_json(seed.lateral)},
                               {"moment", to_json(seed.moment)}});
  return result;
}

}  // namespace compare
