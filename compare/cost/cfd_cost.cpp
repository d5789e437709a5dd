#include "compare/cost/cfd_cost.hpp"

#include <cmath>
#include <map>

#include "compare/reference/coefficients.hpp"
#include "compare/reference/uncertainty.hpp"

namespace compare {

namespace {

using case_record::CaseRecord;

double cpu_of(const CaseRecord& record, const std::string& stage) {
  const auto found = record.cost.find(stage);
  return found == record.cost.end() ? 0.0 : found->second.cpu_s;
}

}  // namespace

std::vector<CfdCost> cfd_costs(const std::vector<CaseRecord>& records) {
  std::vector<CfdCost> rows;
  for (const CaseFamily& family : case_families(records))
    for (const CaseRecord* level : family.levels) {
      if (!is_usable(level->status) || level->is_experiment()) continue;
      CfdCost row{
          .case_name = level->name, .shape = dragcore::kind(level->shape), .mesh_level = level->mesh_level, .reynolds = level->reynolds};
      row.cells = level->cells;
      row.iterations = level->iterations;
      row.mesh_s = cpu_of(*level, "mesh");
      row.convert_s = cpu_of(*level, "convert");
      row.solve_s = cpu_of(*level, "solve");
      for (const auto& [stage, cost] : level->cost) row.total_s += cost.cpu_s;
      row.finest = level == family.record && family.levels.size() > 1;
      if (level != family.record) row.drag_error = std::abs(coefficients(*level).values[0] - coefficients(*family.record).values[0]);
      rows.push_back(row);
    }
  return rows;
}

std::vector<CostCheck> check_cost(const std::vector<CaseRecord>& records, const CostPredictor& predict) {
  std::vector<CostCheck> checks;
  for (const char* quantity : {"cells", "iterations", "mesh", "convert", "solve", "post", "total"})
    checks.push_back({.quantity = quantity});
  for (const CaseRecord& record : records) {
    if (record.is_experiment() || (!is_usable(record.status) && record.status != case_record::Status::drifting)) continue;
    const auto predicted = predict(record);
    if (!predicted) continue;
    std::map<std::string, std::pair<double, double>> both{{"cells", {predicted->cells, record.cells}},
                                                          {"iterations", {predicted->iterations, record.iterations}}};
    auto& total = both["total"];
    for (const auto& [stage, seconds] : predicted->cpu_s) {
      both[stage] = {seconds, cpu_of(record, stage)};
      if (both[stage].second == 0.0) continue;  // not run
      total.first += seconds;
      total.second += both[stage].second;
    }
    for (CostCheck& check : checks) {
      const auto [expected, found] = both[check.quantity];
      if (!(expected > 0.0 && found > 0.0)) continue;
      ++check.cases;
      check.predicted += expected;
      check.found += found;
      check.rms += std::pow(std::log(found / expected), 2);
      if (check.worst_case.empty() || std::abs(std::log(found / expected)) > std::abs(std::log(check.worst))) {
        check.worst = found / expected;
        check.worst_case = record.name;
      }
    }
  }
  std::erase_if(checks, [](const CostCheck& check) { return check.cases == 0; });
  for (CostCheck& check : checks) check.rms = std::sqrt(check.rms / check.cases);
  return checks;
}

}  // namespace compare
