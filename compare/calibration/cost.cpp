#include "compare/calibration/cost.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <set>

#include "compare/calibration/prediction.hpp"
#include "compare/reference/coefficients.hpp"
#include "compare/reference/uncertainty.hpp"

namespace compare {

namespace {

using case_record::CaseRecord;
using Clock = std::chrono::steady_clock;

/// Median over repetitions of the mean time of a batch long enough for the clock.
double microseconds_per_call(const std::function<void()>& call, bool quick) {
  const auto time = [&](int calls) {
    const auto start = Clock::now();
    for (int i = 0; i < calls; ++i) call();
    return std::chrono::duration<double, std::micro>(Clock::now() - start).count();
  };
  const double single = std::max(time(1), 0.05);
  const int batch = std::clamp(static_cast<int>((quick ? 20.0 : 400.0) / single), 1, 4000);
  std::vector<double> means;
  for (int repetition = 0; repetition < 3; ++repetition) means.push_back(time(batch) / batch);
  std::sort(means.begin(), means.end());
  return means[1];
}

std::vector<ModelCost> model_costs(const std::vector<const CaseRecord*>& cases, const Calibration& calibration, bool quick) {
  const dragcore::Law fitted = calibration.fits.front().model.law;
  std::vector<ModelCost> rows;
  const dragcore::Shape& shape = cases.front()->shape;
  const bool round = default_divisions(shape) > 8;
  // About 12 to 20,000 triangles: 12 n^2 for a box, 16 n^2 for a body of revolution.
  std::vector<int> meshes = round ? std::vector{1, 3, 9, 35} : std::vector{1, 3, 10, 40};
  if (std::holds_alternative<dragcore::Plate>(shape)) meshes = {1, 5, 20, 70};
  if (quick) meshes = {1, 3};
  for (const int divisions : meshes) {
    const dragcore::Surface surface = surface_of(shape, divisions);
    dragcore::Law by_class = dragcore::law_for(surface.body_class);
    by_class.name = "by class";
    for (const dragcore::Law& law : {dragcore::note_law(), dragcore::consistent_law(), fitted, by_class})
      for (const auto form :
           {dragcore::PillowForm::none, dragcore::PillowForm::triangle, dragcore::PillowForm::patch, dragcore::PillowForm::tilt}) {
        dragcore::Model model{.law = law};
        if (law.name == by_class.name) {
          const dragcore::Pillow pillow = dragcore::class_pillow(surface.body_class);
          if (form != dragcore::PillowForm::none && form != pillow.form) continue;
          if (form != dragcore::PillowForm::none) model.pillow = pillow;
        } else if (form != dragcore::PillowForm::none)
          model.pillow =
              calibration.fit("pillow " + to_string(form) + " on law " + (law.name == fitted.name ? fitted.name : "note")).model.pillow;
        double drag = 0.0, moment = 0.0;
        for (const CaseRecord* record : cases) {
          const dragcore::Wrench wrench = predict(*record, model, divisions).total();
          const auto predicted = coefficients(*record, wrench.force, wrench.torque), found = coefficients(*record);
          const int channel = static_cast<int>(record->pose.yaw != 0.0 ? Channel::yaw : Channel::pitch);
          drag += std::pow(predicted.values[0] - found.values[0], 2);
          moment += std::pow(predicted.values[channel] - found.values[channel], 2);
        }
        for (const auto order : {dragcore::Quadrature::one, dragcore::Quadrature::three, dragcore::Quadrature::six}) {
          model.quadrature = order;
          // An oblique wind, so that no face is edge-on; the spin is of the size of a tumbling body's.
          dragcore::Motion motion{.wind = {1.0, 0.3, 0.2}};
          const auto time = [&] { return microseconds_per_call([&] { wrench(surface, motion, {}, model); }, quick); };
          ModelCost row{.shape = kind(shape), .law = law.name, .pillow = to_string(form), .quadrature = static_cast<int>(order)};
          row.triangles = static_cast<int>(surface.size());
          row.microseconds = time();
          motion.angular_velocity = {0.5, 0.3, 0.4};
          row.spinning_microseconds = time();
          row.cases = static_cast<int>(cases.size());
          row.rms_drag_error = std::sqrt(drag / row.cases);
          row.rms_moment_error = std::sqrt(moment / row.cases);
          rows.push_back(row);
        }
      }
  }
  return rows;
}

double cpu_of(const CaseRecord& record, const std::string& stage) {
  const auto found = record.cost.find(stage);
  return found == record.cost.end() ? 0.0 : found->second.cpu_s;
}

}  // namespace

CostTable measure_cost(const std::vector<CaseRecord>& records, const Calibration& calibration, bool quick) {
  CostTable table;
  std::map<std::string, std::vector<const CaseRecord*>> by_shape;
  const std::set<std::string> fitted(calibration.fits.front().cases.begin(), calibration.fits.front().cases.end());
  for (const CaseFamily& family : case_families(records)) {
    if (fitted.contains(family.record->name)) by_shape[dragcore::kind(family.record->shape)].push_back(family.record);
    for (const CaseRecord* level : family.levels) {
      if (!is_usable(level->status)) continue;
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
      table.cfd.push_back(row);
    }
  }
  for (const auto& [shape, cases] : by_shape) {
    const auto rows = model_costs(cases, calibration, quick);
    table.models.insert(table.models.end(), rows.begin(), rows.end());
  }
  return table;
}

std::vector<CostCheck> check_cost(const std::vector<CaseRecord>& records, const CostPredictor& predict) {
  std::vector<CostCheck> checks;
  for (const char* quantity : {"cells", "iterations", "mesh", "convert", "solve", "post", "total"})
    checks.push_back({.quantity = quantity});
  for (const CaseRecord& record : records) {
    if (!is_usable(record.status) && record.status != case_record::Status::drifting) continue;
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
