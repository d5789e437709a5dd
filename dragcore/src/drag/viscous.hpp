#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "drag/body_law.hpp"
#include "support/cross_matrix.hpp"

namespace dragcore {

// What viscosity does to a part, eq. 15 to 17; all of it but the friction of the boundary layer, which is in BodyLaw.

/// Re_l = rho |u| l/mu.
inline double reynolds(const Part& part, double speed, const Medium& medium) {
  return medium.density * speed * part.creeping.length() / medium.viscosity;
}

/// a/sqrt(Re_l) of a flow of 1 m/s; 0 where the viscous terms are off, or no inertia makes a boundary layer.
inline double layer_scale(const Law& law, const Part& part, const Medium& medium, const ActiveEffects& active) {
  if (!active.has<Effect::viscous>() || !(part.creeping.wetted > 0.0) || !(medium.density > 0.0)) return 0.0;
  return law.layer / std::sqrt(reynolds(part, 1.0, medium));
}

/// The pillow at the part's Reynolds number, eq. 17.
inline Pillow pillow_at(const Pillow& pillow, const Part& part, double speed, const Medium& medium, const ActiveEffects& active) {
  if (!active.has<Effect::viscous>() || pillow.form != PillowForm::tilt || pillow.viscous_gain == 0.0) return pillow;
  Pillow felt = pillow;
  // In still air no direction has a pillow; in air without inertia the Reynolds number is 0.
  const double root = std::sqrt(reynolds(part, speed, medium));
  felt.factor = root > 0.0 ? std::min(largest_tilt, pillow.factor + pillow.viscous_gain / root) : largest_tilt;
  return felt;
}

/// Eq. 15: what air without inertia would do to a part. Linear in the motion, and the same whatever stands around it.
struct CreepingFlow {
  double viscosity = 0.0;                             ///< sigma mu
  Eigen::Vector3d arm = Eigen::Vector3d::Zero();      ///< from the reference point to the centre of resistance [m]
  Eigen::Vector3d u = Eigen::Vector3d::Zero();        ///< of the air relative to the part, at that centre [m/s]
  Eigen::Vector3d turning = Eigen::Vector3d::Zero();  ///< of the part relative to the air [rad/s]

  CreepingFlow(const Part& part, std::size_t index, const RelativeFlow& flow, const Motion& motion, const Law& law, const Medium& medium)
      : viscosity(law.stokes * medium.viscosity),
        arm(part.creeping.centre - motion.reference_point),
        u(flow.at_place(index, part.creeping.centre)),
        turning(flow.turning()) {
    instrument::count(Effect::viscous);
  }

  Eigen::Vector3d force(const Part& part) const { return viscosity * part.creeping.drag * u; }
  Eigen::Vector3d couple(const Part& part) const { return -viscosity * part.creeping.turning * turning; }  ///< about the centre
  Wrench wrench(const Part& part) const {
    const Eigen::Vector3d f = force(part);
    return {f, couple(part) + arm.cross(f)};
  }
  double power(const Part& part) const { return force(part).dot(u) - couple(part).dot(turning); }  ///< taken, never negative [W]

  /// Traction of one side at a place, from the centre of resistance; over the wetted area its sum is wrench() [Pa].
  Eigen::Vector3d traction(const Part& part, const Eigen::Vector3d& place) const {
    return viscosity * (part.creeping.drag / part.creeping.wetted * u - (part.creeping.spread * turning).cross(place));
  }

  /// wrench = S (air - body) in a uniform wind, about the reference point: force and torque by velocity and spin.
  Eigen::Matrix<double, 6, 6> matrix(const Part& part) const {
    const Eigen::Matrix3d drag = viscosity * part.creeping.drag, lever = cross_matrix(arm);
    Eigen::Matrix<double, 6, 6> s;
    s << drag, -drag * lever, lever * drag, viscosity * part.creeping.turning - lever * drag * lever;
    return 0.5 * (s + s.transpose());  // to the last bit
  }
};

/// Calls visit(part, CreepingFlow) for every part that feels it.
template <class Visit>
void for_each_creeping_flow(const Surface& surface, const Motion& motion, const Medium& medium, const Model& model, const Visit& visit) {
  if (!(medium.viscosity > 0.0)) return;
  const RelativeFlow flow(surface, motion, ActiveEffects(motion, model));
  for (std::size_t p = 0; p < surface.parts.size(); ++p) {
    const Part& part = surface.parts[p];
    const Law& law = model.law_of(part.body_class);
    if (ActiveEffects(motion, model, law, {}, medium).has<Effect::viscous>() && law.stokes > 0.0)
      visit(part, CreepingFlow(part, p, flow, motion, law, medium));
  }
}

}  // namespace dragcore
