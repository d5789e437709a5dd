#include "drag/fast_wrench.hpp"

#include <cmath>

#include "drag/energy_balance.hpp"
#include "kernels/part_flow.hpp"

namespace dragcore {

using Eigen::Vector3d;

std::optional<WrenchByTerm> fast_wrench(const Surface& surface, const Motion& motion, const Medium& medium, const Model& model) {
  if (!kernels::know(surface, model)) return std::nullopt;
  kernels::BodyFlow flow(surface, motion, medium, model);
  WrenchByTerm result;
  EnergyBalance balance;
  for (std::size_t p = 0; p < surface.parts.size(); ++p) {
    const std::optional<kernels::PartFlow> part = flow.of(p);
    if (!part) return std::nullopt;
    if (part->speed == 0.0) continue;
    const kernels::PartSums sums = kernels::part_sums(part->task);
    double taken = sums.taken, given = sums.given;
    for (std::size_t term = 0; term < sums.terms.size(); ++term) {
      const auto& sum = sums.terms[term];
      const Vector3d force(sum[0], sum[1], sum[2]), torque(sum[3], sum[4], sum[5]);
      if (!part->task.varies) (kernels::pushes(term) ? given : taken) += std::abs(force.dot(part->relative));
      result.terms[term] += part->in_newton(force, torque);
    }
    balance.add(part->to_newton * part->speed * taken, part->to_newton * part->speed * given);
  }
  // Eq. 13.
  if (balance.has_gain())
    for (const Term term : {Term::curvature, Term::rear_recovery})
      result[term] = {balance.gain_share() * result[term].force, balance.gain_share() * result[term].torque};
  return result;
}

}  // namespace dragcore
