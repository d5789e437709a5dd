#pragma once

#include <dragcore/stepping.hpp>
#include <dragcore/wind.hpp>
#include <optional>
#include <string>
#include <vector>

namespace dragcore {

/// What a body may meet: the question to required_effects().
struct Scene {
  const Surface& surface;
  Motion motion{};  ///< with the largest relative speed and spin to expect; `wind_gradient` and `triangle_wind` count as given
  /// The air moves the body, which may then come to spin, to glide edge-on and to drift elsewhere, whatever its motion now. False: held, or
  /// moved by something else, always as in `motion`.
  bool free = true;
  Medium medium{};
  Model model{};
  const Wind* wind = nullptr;  ///< instead of, and on top of, `motion.wind`: looked at around `place`; null: the wind is uniform
  Eigen::Vector3d place = Eigen::Vector3d::Zero();  ///< of the surface's centre in the world [m]
  std::optional<MassProperties> body{};             ///< for added mass; empty: not judged
  double viscosity = 1.8e-5;                        ///< dynamic, of air at 15 C, to judge low Reynolds numbers where `medium` has none [Pa s]
  double tolerance = 0.01;                          ///< an omission is free to cost this share of the scales of force and torque
};

/// Verdict on one effect: of wrench(), or (`effect` empty) of fluid_terms.hpp.
struct EffectNeed {
  std::string name;
  std::optional<Effect> effect;
  bool needed = false;
  double force = 0.0;   ///< upper bound of what leaving it out changes [N]
  double torque = 0.0;  ///< the same about `motion.reference_point` [N m]
  std::string why;      ///< a sentence with the numbers that decided
};

struct RequiredEffects {
  std::vector<EffectNeed> needs;                        ///< one for each effect, in the order of Effect, then the fluid terms
  Effects effects;                                      ///< those of wrench() that are needed: give it to Model::effects
  WindSampling wind_sampling = WindSampling::constant;  ///< cheapest way to give the body its wind within the tolerance
  double force_scale = 0.0;                             ///< q A/4 for a closed body, q A for a sheet, q of the largest speed [N]
  double torque_scale = 0.0;                            ///< force_scale times the surface's radius [N m]
};

/// Which effects a scene calls for, and what leaving each of the others out may cost at most.
///
/// Bounds come from the law's largest coefficients, the largest speed, areas and arms; for spin and wind from the law's largest slope in u:
/// |dF/du| <= rho/2 |u| sqrt(4 C^2 + C'^2 (1 - c^2)) dA. They hold for every direction of motion at that speed, and are several times the
/// error of a typical one. Two parts are estimates: the change of a body's descriptors with its spin, and the energy guard (Law), whose
/// share in ordinary flows is below 1e-3. Several effects left out cost at most the sum of their bounds.
///
/// A free body keeps what brakes the motions it may come to: spin and what is viscous always, friction unless it is within the tolerance of the pressure on the
/// smallest frontal area (none, of a sheet), and the variation of a wind field.
///
/// Ask once for a kind of body and the range of its motion, not every frame: the question costs several evaluations (docs/model.md), and
/// what is masked off stays off.
///
/// @throws std::invalid_argument  as wrench(); if the tolerance is not positive, or the motion is rest
RequiredEffects required_effects(const Scene& scene);

}  // namespace dragcore
