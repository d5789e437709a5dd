#include "drag/fast_wrench.hpp"

#include <cmath>

#include "drag/energy_balance.hpp"
#include "drag/viscous.hpp"
#include "kernels/part_flow.hpp"

namespace dragcore {

using Eigen::Vector3d;

namespace {

/// Terms that the kernels sum for a law.
bool is_on(Term term, const kernels::ResolvedLaw& law) {
  switch (term) {
    case Term::windward_pressure:
      return true;
    case Term::leeward_suction:
      return law.leeward;
    case Term::base_suction:
      return law.base;
    case Term::rear_recovery:
      return law.recovery;
    case Term::curvature:
      return law.curvature;
    case Term::friction:
      return law.friction || law.viscous;
    case Term::correction:
    case Term::count:
      break;
  }
  return false;
}

}  // namespace

bool fast_wrench(const Surface& surface, const Motion& motion, const Medium& medium, const Model& model, WrenchByTerm& result) {
  if (!kernels::know(surface, model)) return false;
  kernels::BodyFlow flow(surface, motion, medium, model);
  EnergyBalance balance;
  kernels::PartFlow part;
  for (std::size_t p = 0; p < surface.parts.size(); ++p) {
    if (!flow.of(p, part)) return false;
    if (part.speed == 0.0) continue;
    const kernels::PartSums sums = kernels::part_sums(part.task);
    double taken = sums.taken, given = sums.given;
    for (std::size_t k = 0; k < sums.terms.size(); ++k) {
      const Term term = static_cast<Term>(k);
      if (!is_on(term, part.task.law)) continue;
      const double* sum = sums.terms[k].data();
      const Eigen::Map<const Vector3d> force(sum), torque(sum + 3);
      if (!part.task.varies) (kernels::pushes(term) ? given : taken) += std::abs(force.dot(part.relative));
      result[term] += part.in_newton(force, torque);
    }
    balance.add(part.to_newton * part.speed * taken, part.to_newton * part.speed * given);
  }
  for_each_creeping_flow(surface, motion, medium, model, [&](const Part& creeping_part, const CreepingFlow& creeping) {
    balance.add(creeping.power(creeping_part), 0.0);
    result[Term::friction] += creeping.wrench(creeping_part);
  });
  // Eq. 13.
  if (balance.has_gain()) {
    const double share = balance.gain_share();
    for (const Term term : {Term::curvature, Term::rear_recovery}) result[term].force *= share, result[term].torque *= share;
  }
  return true;
}

}  // namespace dragcore
