#include "compare/gate/odds.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <dragcore/bake.hpp>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>
#include <stdexcept>

#include "compare/tables/text_grid.hpp"

namespace compare {
namespace {

using case_record::CaseRecord;
using dragcore::Wrench;
using Eigen::Vector3d;

/// The model that defects are seeded into: what people use.
std::vector<NamedModel> watched() {
  for (const NamedModel& named : gated_models())
    if (named.choice.by_class) return {named};
  throw std::logic_error("no law by class among the gated models");
}

/// predict() with every step open to a fault.
Wrench predict_with(const CaseRecord& record, const dragcore::Surface& surface, const dragcore::Model& model,
                    const dragcore::Medium& medium) {
  const Eigen::Matrix3d to_wind = record.pose.rotation();
  const Wrench body = dragcore::wrench(surface, motion_of(record), medium, model).total();
  return {to_wind * body.force, to_wind * body.torque};
}

const dragcore::Surface& surface_for(const CaseRecord& record) { return prepared_surface(record.shape, default_divisions(record.shape)); }

// How faults enter a prediction: through its result, the case as it was understood, or the model on its surface.

template <class Change>
std::function<void(Trial&)> in_result(Change change) {
  return [change](Trial& trial) {
    trial.predictor_of = [change](const NamedModel& named) -> Predictor {
      return [change, predict_case = predictor(named.choice)](const CaseRecord& record) {
        Wrench wrench = predict_case(record);
        change(wrench, record);
        return wrench;
      };
    };
  };
}

template <class Change>
std::function<void(Trial&)> in_case(Change change) {
  return [change](Trial& trial) {
    trial.predictor_of = [change](const NamedModel& named) -> Predictor {
      return [change, predict_case = predictor(named.choice)](CaseRecord record) {
        change(record);
        return predict_case(record);
      };
    };
  };
}

template <class Change>
std::function<void(Trial&)> in_model(Change change) {
  return [change](Trial& trial) {
    trial.predictor_of = [change](const NamedModel& named) -> Predictor {
      return [change, choice = named.choice](const CaseRecord& record) {
        const dragcore::Surface& surface = surface_for(record);
        dragcore::Model model = choice.on(surface);
        change(model);
        return predict_with(record, surface, model, medium_of(record));
      };
    };
  };
}

std::function<void(Trial&)> without_effect(dragcore::Effects effect) {
  return in_model([effect](dragcore::Model& model) { model.effects = model.effects.without(effect); });
}

/// @param surface_of  (record) -> surface, where it is not the right one
template <class SurfaceOf>
std::function<void(Trial&)> in_surface(SurfaceOf make_surface) {
  return [make_surface](Trial& trial) {
    const auto made = std::make_shared<std::map<std::string, dragcore::Surface>>();
    trial.predictor_of = [make_surface, made](const NamedModel& named) -> Predictor {
      return [make_surface, made, choice = named.choice](const CaseRecord& record) {
        auto found = made->find(shape_label(record.shape));
        if (found == made->end()) found = made->emplace(shape_label(record.shape), make_surface(record)).first;
        return predict_with(record, found->second, choice.on(found->second), medium_of(record));
      };
    };
  };
}

template <class Change>
std::function<void(Trial&)> in_references(Change change) {
  return [change](Trial& trial) {
    for (CaseRecord& record : trial.records)
      if (!record.is_experiment()) change(record);
  };
}

dragcore::Surface scaled(const CaseRecord& record, double factor) {
  dragcore::TriangleMesh mesh = dragcore::triangulate(record.shape, default_divisions(record.shape));
  for (Vector3d& vertex : mesh.vertices) vertex *= factor;
  return dragcore::Surface(mesh);
}

/// A map that was baked from the note's law and never again, of bodies of up to a few hundred triangles where viscosity is no matter.
Wrench from_stale_map(const CaseRecord& record, const ModelChoice& choice) {
  static std::map<std::string, dragcore::BakedBody> maps;
  const dragcore::Surface& surface = surface_for(record);
  dragcore::Model model = choice.on(surface);
  if (surface.size() > 300 || record.reynolds < 1e4) return predictor(choice)(record);
  const std::string body = shape_label(record.shape);
  auto found = maps.find(body);
  if (found == maps.end()) {
    dragcore::Model old = model;
    old.law = dragcore::note_law();
    old.sheets.reset();
    old.precision = dragcore::Precision::single;
    found = maps.emplace(body, dragcore::bake(surface, old, {.rms_error = 0.02})).first;
  }
  const Eigen::Matrix3d to_wind = record.pose.rotation();
  const Wrench wrench = dragcore::wrench(found->second, motion_of(record), {.density = record.density});
  return {to_wind * wrench.force, to_wind * wrench.torque};
}

std::vector<Defect> make_defects() {
  using dragcore::Effect;
  constexpr double degree = std::numbers::pi / 180.0;
  const std::string prediction = "prediction", references = "references", baseline = "baseline";
  const auto length = [](const CaseRecord& record) { return dragcore::properties(record.shape).reference_length; };
  std::vector<Defect> list = {
      {prediction, "half the reference area", in_result([](Wrench& w, const CaseRecord&) { w.force *= 2.0, w.torque *= 2.0; })},
      {prediction, "twice the reference length", in_result([](Wrench& w, const CaseRecord&) { w.torque *= 0.5; })},
      {prediction, "force of the wrong sign", in_result([](Wrench& w, const CaseRecord&) { w.force = -w.force; })},
      {prediction, "pitch of the wrong sign", in_result([](Wrench& w, const CaseRecord&) { w.torque.y() *= -1.0; })},
      {prediction, "yaw moment of the wrong sign", in_result([](Wrench& w, const CaseRecord&) { w.torque.z() *= -1.0; })},
      {prediction, "y and z swapped", in_result([](Wrench& w, const CaseRecord&) { std::swap(w.force.y(), w.force.z()); })},
      {prediction, "force left in the body frame",
       in_result([](Wrench& w, const CaseRecord& r) { w.force = r.pose.rotation().transpose() * w.force; })},
      {prediction, "torque left in the body frame",
       in_result([](Wrench& w, const CaseRecord& r) { w.torque = r.pose.rotation().transpose() * w.torque; })},
      {prediction, "moment about the nose", in_result([length](Wrench& w, const CaseRecord& r) {
         w.torque -= (r.pose.rotation() * Vector3d(-0.5 * length(r), 0.0, 0.0)).cross(w.force);
       })},
      {prediction, "moment about a point a thousandth of a length away",
       in_result([length](Wrench& w, const CaseRecord& r) { w.torque -= Vector3d(0.0, 1e-3 * length(r), 0.0).cross(w.force); })},
      {prediction, "moment left out", in_result([](Wrench& w, const CaseRecord&) { w.torque.setZero(); })},
      {prediction, "one part in a million too much", in_result([](Wrench& w, const CaseRecord&) { w.force *= 1.0 + 1e-6; })},
      {prediction, "degrees for radians", in_case([](CaseRecord& r) {
         r.pose = {r.pose.incidence / degree, r.pose.yaw / degree, r.pose.roll / degree};
       })},
      {prediction, "incidence of the wrong sign", in_case([](CaseRecord& r) { r.pose.incidence = -r.pose.incidence; })},
      {prediction, "incidence for yaw", in_case([](CaseRecord& r) { std::swap(r.pose.incidence, r.pose.yaw); })},
      {prediction, "roll forgotten", in_case([](CaseRecord& r) { r.pose.roll = 0.0; })},
      {prediction, "viscosity ten times too large", in_case([](CaseRecord& r) { r.viscosity *= 10.0; })},
      {prediction, "viscosity forgotten", in_case([](CaseRecord& r) { r.viscosity = 0.0; })},
      {prediction, "law of sheets for every body", in_model([](dragcore::Model& m) { m.law = dragcore::sheet_law(); })},
      {prediction, "law of closed bodies for sheets", in_model([](dragcore::Model& m) {
         m.law = dragcore::closed_law();
         m.sheets.reset();
       })},
      {prediction, "single precision for double", in_model([](dragcore::Model& m) { m.precision = dragcore::Precision::single; })},
      {prediction, "pillow off", without_effect(Effect::pillow)},
      {prediction, "base suction masked off", without_effect(Effect::base_suction)},
      {prediction, "recovery masked off", without_effect(Effect::recovery)},
      {prediction, "shelter masked off", without_effect(Effect::shelter)},
      {prediction, "curvature masked off", without_effect(Effect::curvature)},
      {prediction, "friction masked off", without_effect(Effect::friction | Effect::viscous)},
      {prediction, "exposure off", in_surface([](const CaseRecord& r) {
         const auto* body = std::get_if<dragcore::MeshBody>(&r.shape);
         return body ? dragcore::Surface(dragcore::prepare(*body->mesh)) : surface_for(r);
       })},
      {prediction, "round bodies of few facets",
       in_surface([](const CaseRecord& r) { return surface_of(r.shape, std::min(8, default_divisions(r.shape))); })},
      {prediction, "a body a thousandth too large", in_surface([](const CaseRecord& r) {
         return std::holds_alternative<dragcore::MeshBody>(r.shape) ? dragcore::Surface(surface_for(r)) : scaled(r, 1.001);
       })},
      {prediction, "stale baked map",
       [](Trial& trial) {
         trial.predictor_of = [](const NamedModel& named) -> Predictor {
           return [choice = named.choice](const CaseRecord& r) { return from_stale_map(r, choice); };
         };
       }},
      {references, "viscous part left out",
       in_references([](CaseRecord& r) { r.load.force_viscous.setZero(), r.load.moment_viscous.setZero(); })},
      {references, "pressure counted twice", in_references([](CaseRecord& r) {
         r.load.force_viscous += r.load.force_pressure, r.load.moment_viscous += r.load.moment_pressure;
       })},
      {references, "half models counted once", in_references([](CaseRecord& r) {
         if (!r.half_model) return;
         for (Vector3d* part : {&r.load.force_pressure, &r.load.force_viscous, &r.load.moment_pressure, &r.load.moment_viscous})
           *part *= 0.5;
       })},
      {references, "a tenth of the drag as side force",
       in_references([](CaseRecord& r) { r.load.force_pressure.y() += 0.1 * r.load.force().x(); })},
      {references, "pitch of the wrong sign",
       in_references([](CaseRecord& r) { r.load.moment_pressure.y() *= -1.0, r.load.moment_viscous.y() *= -1.0; })},
      {references, "moment about the nose", in_references([length](CaseRecord& r) {
         r.load.moment_pressure -= (r.pose.rotation() * Vector3d(-0.5 * length(r), 0.0, 0.0)).cross(r.load.force());
       })},
      {references, "loads of two cases swapped",
       [](Trial& trial) {
         std::vector<CaseRecord*> usable;
         for (CaseRecord& r : trial.records)
           if (case_record::is_usable(r.status) && !r.is_experiment() && !r.spins()) usable.push_back(&r);
         if (usable.size() > 1) std::swap(usable.front()->load, usable.back()->load);
       }},
      {references, "a planned case left out",
       [](Trial& trial) {
         const std::string gone = trial.baseline.planned.front();
         std::erase_if(trial.records, [&](const CaseRecord& r) { return r.name == gone; });
       }},
      {references, "a diverged case",
       [](Trial& trial) {
         for (CaseRecord& r : trial.records)
           if (r.name == trial.baseline.planned.front()) r.status = case_record::Status::diverged;
       }},
      {references, "uncertainty ten times too large",
       in_references([](CaseRecord& r) { r.u_iteration *= 10.0, r.u_statistical *= 10.0, r.u_null *= 10.0; })},
      {baseline, "a budget that passes anything", [](Trial& trial) { trial.baseline.case_budget = 1e9; }},
      {baseline, "an rms error edited",
       [](Trial& trial) {
         for (auto& [name, model] : trial.baseline.models)
           for (auto& [group, channels] : model.groups)
             for (auto& [channel, entry] : channels) entry.rms *= 2.0;
       }},
      {baseline, "a model missing", [](Trial& trial) { trial.baseline.models.erase(watched().front().name); }},
  };
  return list;
}

/// What the gate sees of one planned case, without a fault.
struct Sound {
  const CaseRecord* record;
  CaseRecord::Channels predicted, stored;
};

std::vector<Sound> sound_cases(const Baseline& baseline, const std::vector<CaseRecord>& records, const NamedModel& named) {
  std::vector<Sound> cases;
  const std::set<std::string> planned(baseline.planned.begin(), baseline.planned.end());
  const Predictor predict_case = predictor_of_choice(named);
  for (const CaseRecord& record : records) {
    if (!planned.contains(record.name)) continue;
    const Wrench wrench = predict_case(record);
    cases.push_back({&record, coefficients(record, wrench.force, wrench.torque).values, coefficients(record).values});
  }
  return cases;
}

/// How many coefficients a defect changes: one that changes nothing shows nothing.
int changed_coefficients(const Trial& trial, const std::vector<Sound>& sound, const NamedModel& named) {
  int changed = 0;
  const Predictor predict_case = trial.predictor_of(named);
  std::map<std::string, const CaseRecord*> records;
  for (const CaseRecord& record : trial.records) records[record.name] = &record;
  for (const Sound& was : sound) {
    const auto found = records.find(was.record->name);
    if (found == records.end() || found->second->status != was.record->status) {
      changed += 6;
      continue;
    }
    const Wrench wrench = predict_case(*was.record);
    const auto predicted = coefficients(*was.record, wrench.force, wrench.torque).values, stored = coefficients(*found->second).values;
    const CaseRecord::Channels u = found->second->own_variance() - was.record->own_variance();
    for (int k = 0; k < 6; ++k)
      changed += std::abs(predicted[k] - was.predicted[k]) > rounding || std::abs(stored[k] - was.stored[k]) > rounding || u[k] != 0.0;
  }
  return changed;
}

/// Names of the checks that failed, without the model's.
std::vector<std::string> red(const GateResult& result) {
  std::vector<std::string> names;
  for (const GateCheck& check : result.checks) {
    if (check.passed) continue;
    const auto colon = check.name.rfind(": ");
    names.push_back(colon == std::string::npos ? check.name : check.name.substr(colon + 2));
  }
  return names;
}

}  // namespace

const std::vector<Defect>& defects() {
  static const std::vector<Defect> list = make_defects();
  return list;
}

int Odds::missed() const {
  return static_cast<int>(std::count_if(defects.begin(), defects.end(), [](const DefectVerdict& verdict) { return !verdict.caught; }));
}

Odds gate_odds(const Baseline& baseline, const std::vector<CaseRecord>& records, const std::vector<CaseRecord>& solved) {
  const std::vector<NamedModel> models = watched();
  if (baseline.planned.empty())
    throw std::invalid_argument(
        "a baseline without planned cases: there is nothing to seed a defect in; dragval baseline accept makes one");
  const std::vector<Sound> sound = sound_cases(baseline, records, models.front());
  Odds odds;
  odds.unchanged_passes = run_gate(baseline, records, models).passed();
  for (const Defect& defect : defects()) {
    Trial trial{.records = records, .baseline = baseline};
    defect.seed(trial);
    const GateResult result = run_gate(trial.baseline, trial.records, models, trial.predictor_of);
    const int changed = defect.where == "baseline" ? 0 : changed_coefficients(trial, sound, models.front());
    odds.defects.push_back({defect.where, defect.name, !result.passed(), changed, red(result)});
  }
  for (const CaseRecord& run : solved) {
    if (const int seed = seeded_name(run.name).seed; seed == 0 || seed > judged_seeds) continue;
    ++odds.repeats;
    if (const GateCheck check = check_solved_again(baseline, records, {run}); !check.passed) odds.false_alarms.push_back(check.detail);
  }
  return odds;
}

std::string render(const Odds& odds, Format format) {
  if (format == Format::csv) throw std::invalid_argument("--format csv: odds are table, md or json");
  if (format == Format::json) {
    nlohmann::json document = {{"unchanged_passes", odds.unchanged_passes},
                               {"repeats", odds.repeats},
                               {"false_alarms", odds.false_alarms},
                               {"missed", odds.missed()},
                               {"defects", nlohmann::json::array()}};
    for (const DefectVerdict& d : odds.defects)
      document["defects"].push_back(
          {{"where", d.where}, {"name", d.name}, {"caught", d.caught}, {"coefficients", d.coefficients}, {"checks", d.checks}});
    return document.dump(2) + "\n";
  }
  TextGrid grid;
  grid.add({"in the", "defect", "gate", "coefficients changed", "by its checks"});
  for (const DefectVerdict& d : odds.defects)
    grid.add({d.where, d.name, d.caught ? "red" : "MISSED", d.where == "baseline" ? "" : std::to_string(d.coefficients),
              fmt::format("{}", fmt::join(d.checks, ", "))});
  std::string text = (format == Format::markdown ? markdown(grid) : aligned(grid, false)) +
                     fmt::format("\n{} of {} defects missed; unchanged code {}\n", odds.missed(), odds.defects.size(),
                                 odds.unchanged_passes ? "passes" : "is STOPPED by the gate: first mend that, or accept the baseline");
  if (odds.repeats == 0)
    return text + "false alarms: not measured, no case of the matrix seeds (dragval run seeds, then dragval odds --cache .dragval)\n";
  text += fmt::format("{} false alarms in {} cases that unchanged code solved again on meshes of other seeds\n", odds.false_alarms.size(),
                      odds.repeats);
  for (const std::string& alarm : odds.false_alarms) text += "  " + alarm + "\n";
  return text;
}

}  // namespace compare
