#pragma once

#include <cstdint>
#include <cstring>

#include "tests/dragcore/drag/hostile.hpp"

/// Cases that have every effect.
namespace effects_cases {

using namespace dragcore;

inline Effect effect(unsigned i) { return static_cast<Effect>(1u << i); }

/// A model and a motion that have every effect, and what takes one of them away.
inline Model whole_model() {
  Model model{.law = closed_law(), .pillow = {PillowForm::tilt, 0.8}};
  model.law.leeward = {0.0, 0.2, 0.1, 0.0, 0.0};
  model.law.friction = 0.02;
  auto correction = std::make_shared<Correction>();
  correction->map = DirectionMap::zero(1, 1);
  for (int node = 0; node < correction->map.nodes(); ++node)
    correction->map.set(node, 0, 0.01 * correction->map.direction(node), Eigen::Vector3d(0, 0.01, 0));
  model.correction = correction;
  return model;
}

inline const Motion whole_motion{
    .wind = {5, 1, 2}, .velocity = {0, 1, 0}, .angular_velocity = {1, 2, 3}, .wind_gradient = 0.2 * Eigen::Matrix3d::Identity()};

inline constexpr Medium viscous_medium{.viscosity = 0.3};  // Re of order 10

inline void take_away(unsigned i, Model& model, Motion& motion) {
  switch (effect(i)) {
    case Effect::leeward_suction:
      model.law.leeward = {};
      break;
    case Effect::friction:
      model.law.friction = 0.0;
      break;
    case Effect::base_suction:
      model.law.base_suction = 0.0;
      break;
    case Effect::recovery:
      model.law.recovery = 0.0;
      break;
    case Effect::shelter:
      model.law.shelter = 0.0;
      break;
    case Effect::curvature:
      model.law.curvature = 0.0;
      break;
    case Effect::pillow:
      model.pillow = {};
      break;
    case Effect::spin:
      motion.angular_velocity.setZero();
      break;
    case Effect::wind_variation:
      motion.wind_gradient.setZero();
      break;
    case Effect::viscous:
      model.law.stokes = model.law.layer = 0.0;
      break;
    case Effect::correction:
      model.correction.reset();
      break;
  }
}

/// A hash of the bits of all that a few hundred seeded cases give.
inline std::uint64_t hash_of_results(Effects effects) {
  std::uint64_t hash = 14695981039346656037u;  // FNV-1a
  const auto add = [&hash](double value) {
    std::uint64_t bits;
    std::memcpy(&bits, &value, sizeof bits);
    for (int k = 0; k < 8; ++k) hash = (hash ^ ((bits >> (8 * k)) & 0xffu)) * 1099511628211u;
  };
  for (unsigned seed = 0; seed < 400; ++seed) {
    zoo::Random random(seed);
    const hostile::Body body = seed % 8 == 0 ? hostile::Body{triangulate(Sphere{}, 2)} : hostile::body(random, false);
    const Surface surface = body.surface();
    Model model = hostile::model(random, false, false);
    if (seed % 2) {  // all that a law can have
      model.law = closed_law();
      model.law.leeward = {0.0, 0.2, 0.1, 0.0, 0.0};
      model.law.friction = 0.02;
      model.law.aspect_gain = 0.3;
      model.correction = whole_model().correction;
    }
    model.effects = effects;
    Motion motion = hostile::motion(random);
    std::vector<Eigen::Vector3d> winds;
    if (seed % 3 == 0) motion.wind_gradient = random.rotation();
    if (seed % 3 == 1) {
      for (Eigen::Index i = 0; i < surface.size(); ++i) winds.push_back(random.vector(5.0));
      motion.triangle_wind = winds;
    }
    const Medium medium = seed % 4 < 2 ? Medium{} : viscous_medium;
    for (const Wrench& term : wrench(surface, motion, medium, model).terms)
      for (int k = 0; k < 3; ++k) add(term.force[k] + 0.0), add(term.torque[k] + 0.0);  // -0 is 0
    const TriangleForces parts = triangle_forces(surface, motion, medium, model);
    for (Eigen::Index i = 0; i < surface.size(); ++i)
      for (int k = 0; k < 3; ++k) add(parts.force(k, i) + 0.0), add(parts.torque(k, i) + 0.0);
  }
  return hash;
}

}  // namespace effects_cases
