#include "compare/reference/case_of_record.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <tuple>

#include "compare/reference/coefficients.hpp"
#include "compare/reference/method_uncertainty.hpp"

namespace compare {
namespace {

using case_record::CaseRecord;
using case_record::is_usable;
using Channels = CaseRecord::Channels;
using Eigen::Vector3d;

std::string variant_of(const CaseFamily& family) { return split_name(family.record->name, family.record->mesh_level).variant; }

/// Body, pose, spin, flow: what families must share to answer the same question. Angles and rates to 1e-6.
auto question_of(const CaseRecord& record) {
  const auto rounded = [](double value) { return std::llround(value * 1e6); };
  const Vector3d& spin = record.angular_velocity;
  return std::tuple(dragcore::kind(record.shape), dragcore::parameters(record.shape), flow_class(record), rounded(record.reynolds),
                    record.still_air,
                    std::array{rounded(record.pose.incidence), rounded(record.pose.yaw), rounded(record.pose.roll), rounded(spin.x()),
                               rounded(spin.y()), rounded(spin.z())});
}

/// A force that is wrong by some per cent: every channel is.
void add_method(CaseFamily& family, double relative) {
  LoadUncertainty& u = family.uncertainty;
  Channels load;
  load << family.record->load.force(), family.record->load.moment();
  u.method = relative * load.cwiseAbs();
  u.total = (u.numerical.cwiseAbs2() + u.method.cwiseAbs2()).cwiseSqrt();
}

Vector3d force_coefficients(const CaseFamily& family) { return coefficients(*family.record).values.head<3>(); }
double force_uncertainty(const CaseFamily& family, const Channels& u) { return u.head<3>().norm() / coefficient_scales(*family.record)[0]; }

/// Of the force vector; of the moment, of a body that spins in still air. Relative to the family's own: a method that finds too little is
/// not surer for it.
double relative_uncertainty(const CaseFamily& family) {
  const CaseRecord& record = *family.record;
  return record.still_air ? family.uncertainty.total.tail<3>().norm() / record.load.moment().norm()
                          : family.uncertainty.total.head<3>().norm() / record.load.force().norm();
}

/// Does u hold the mesh? What is not known is not small.
bool is_complete(const CaseFamily& family) {
  if (family.uncertainty.discretisation_assessed) return true;
  const MethodUncertainty* known = method_uncertainty(*family.record);
  return known && known->holds_mesh;
}

/// Half the difference between two branches is the standard deviation of a flow that is on one of them.
void add_branches(std::vector<CaseFamily>& families) {
  for (CaseFamily& up : families)
    for (CaseFamily& down : families) {
      if (variant_of(up) != "up" || variant_of(down) != "down" || up.record->flow_model != down.record->flow_model) continue;
      if (!is_usable(up.record->status) || !is_usable(down.record->status)) continue;
      const double half = 0.5 * (force_coefficients(up) - force_coefficients(down)).norm();
      for (CaseFamily* branch : {&up, &down}) {
        const MethodUncertainty* known = method_uncertainty(*branch->record);
        add_method(*branch, std::max(known ? known->relative : 0.0, half / force_coefficients(*branch).norm()));
      }
    }
}

/// The two were solved by the same method on the same mesh: what they share does not excuse their difference.
bool on_another_branch(const CaseFamily& a, const CaseFamily& b) {
  const bool stepped = (variant_of(a) == "up" && variant_of(b) == "down") || (variant_of(a) == "down" && variant_of(b) == "up");
  if (!stepped || a.record->flow_model != b.record->flow_model || !is_usable(a.record->status) || !is_usable(b.record->status))
    return false;
  const double u = std::hypot(force_uncertainty(a, a.uncertainty.numerical), force_uncertainty(b, b.uncertainty.numerical));
  return (force_coefficients(a) - force_coefficients(b)).norm() > 2.0 * u;
}

std::string value_text(const CaseFamily& family) {
  if (!is_usable(family.record->status)) return family.record->name + ": " + case_record::to_string(family.record->status);
  const Coefficients c = coefficients(*family.record);
  std::string text = fmt::format("{}: C_D {:.3f}", family.record->name, c.values[0]);
  const Channel lateral = family.record->pose.yaw != 0.0 ? Channel::side : Channel::lift;
  if (c[lateral]) text += fmt::format(", {} {:.3f}", symbol(lateral), *c[lateral]);
  text += fmt::format(", u {:.1f} %", 100.0 * relative_uncertainty(family));
  if (family.record->is_experiment()) return text + ", measured";
  return text + fmt::format(" ({:.1f} % the method{})",
                            100.0 * force_uncertainty(family, family.uncertainty.method) / c.values.head<3>().norm(),
                            is_complete(family) ? "" : ", without the mesh");
}

CaseOfRecord chosen_from(std::vector<CaseFamily> families) {
  for (CaseFamily& family : families) {
    const MethodUncertainty* known = method_uncertainty(*family.record);
    add_method(family, known ? known->relative : 0.0);
  }
  add_branches(families);
  // Variants of the numerics are a study of their own, unless there is nothing else.
  const auto ordinary = [](const CaseFamily& family) {
    const std::string variant = variant_of(family);
    return variant.empty() || variant == "up" || variant == "down";
  };
  if (std::any_of(families.begin(), families.end(), ordinary))
    std::erase_if(families, [&](const CaseFamily& family) { return !ordinary(family); });

  const auto rank = [](const CaseFamily& family) {
    return std::tuple(!is_usable(family.record->status), !family.record->knows_force(), !is_complete(family), relative_uncertainty(family));
  };
  const auto best =
      std::min_element(families.begin(), families.end(), [&](const CaseFamily& a, const CaseFamily& b) { return rank(a) < rank(b); });
  CaseOfRecord result;
  result.family = std::move(*best);
  families.erase(best);
  result.alternatives = std::move(families);
  result.held_out = result.family.record->held_out || (result.family.record->is_experiment() &&
                                                       std::any_of(result.alternatives.begin(), result.alternatives.end(),
                                                                   [](const CaseFamily& solved) { return solved.record->held_out; }));
  for (std::size_t i = 0; i < result.alternatives.size(); ++i) {
    const bool branch = on_another_branch(result.family, result.alternatives[i]);
    if (branch) result.other_branch = i;
    result.note += (i == 0 ? value_text(result.family) + "; taken, not " : "; ") + value_text(result.alternatives[i]) +
                   (branch ? ", the other of two branches" : "");
  }
  return result;
}

}  // namespace

std::string flow_class(const CaseRecord& record) {
  if (record.is_experiment()) return record.reynolds >= 1e4 ? "k_omega_sst" : "laminar";
  const std::string& model = record.flow_model;
  for (const std::string_view kind : {"_ddes", "_lm", "_unsteady"})
    if (model.ends_with(kind)) return model.substr(0, model.size() - kind.size());
  return model;
}

bool same_question(const CaseRecord& a, const CaseRecord& b) { return question_of(a) == question_of(b); }

std::vector<CaseOfRecord> cases_of_record(const std::vector<CaseRecord>& records) {
  std::map<decltype(question_of(records.front())), std::vector<CaseFamily>> questions;
  for (CaseFamily& family : case_families(records)) {
    auto question = question_of(*family.record);
    questions[std::move(question)].push_back(std::move(family));
  }
  std::vector<CaseOfRecord> list;
  for (auto& [question, families] : questions) list.push_back(chosen_from(std::move(families)));
  std::sort(list.begin(), list.end(), [](const CaseOfRecord& a, const CaseOfRecord& b) { return a.family.name < b.family.name; });
  return list;
}

}  // namespace compare
