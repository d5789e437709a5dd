#pragma once

#include <cstdint>
#include <cstring>

#include "tests/dragcore/drag/hostile.hpp"

/// A few hundred seeded cases that have every effect, and a hash of the bits of all they give.
namespace effects_cases {

inline std::uint64_t hash_of_results(dragcore::Effects effects) {
  using namespace dragcore;
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
    }
    model.effects = effects;
    Motion motion = hostile::motion(random);
    std::vector<Eigen::Vector3d> winds;
    if (seed % 3 == 0) motion.wind_gradient = random.rotation();
    if (seed % 3 == 1) {
      for (Eigen::Index i = 0; i < surface.size(); ++i) winds.push_back(random.vector(5.0));
      motion.triangle_wind = winds;
    }
    for (const Wrench& term : wrench(surface, motion, {}, model).terms)
      for (int k = 0; k < 3; ++k) add(term.force[k] + 0.0), add(term.torque[k] + 0.0);  // -0 is 0
    const TriangleForces parts = triangle_forces(surface, motion, {}, model);
    for (Eigen::Index i = 0; i < surface.size(); ++i)
      for (int k = 0; k < 3; ++k) add(parts.force(k, i) + 0.0), add(parts.torque(k, i) + 0.0);
  }
  return hash;
}

}  // namespace effects_cases
