#pragma once

#include <Eigen/Core>
#include <cmath>
#include <numbers>

#include "support/ellipsoid_integrals.hpp"

namespace dragcore {

/// Of an ellipsoid in creeping flow, along its principal axes and about its centre, per viscosity: 6 pi a and 8 pi a^3 for a ball.
struct EllipsoidResistance {
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();   ///< [m]
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();  ///< [m^3]
};

/// Accuracy 1e-12. @source [oberbeck_1876], [jeffery_1922], [lamb_1932] art. 339
/// @param semi  semi-axes, all above 0 [m]
inline EllipsoidResistance ellipsoid_resistance(const Eigen::Vector3d& semi) {
  using Eigen::Vector3d;
  const double size = semi.maxCoeff();
  const Vector3d scaled = semi / size, squared = scaled.cwiseAbs2();
  double chi = 0.0;                   // int dlambda / Delta
  Vector3d alpha = Vector3d::Zero();  // int dlambda / ((a_i^2 + lambda) Delta), without the factor abc
  for_each_ellipsoid_node(scaled, [&](double tau, double d_tau, const Vector3d& shrink, double root) {
    chi += root / std::sqrt(tau) * d_tau;
    alpha += root * std::sqrt(tau) * d_tau * shrink;
  });
  const Vector3d weighted = squared.cwiseProduct(alpha);
  EllipsoidResistance resistance;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    resistance.linear[i] = 16.0 * std::numbers::pi * size / (chi + weighted[i]);
    resistance.angular[i] =
        16.0 / 3.0 * std::numbers::pi * size * size * size * (squared[j] + squared[k]) / (weighted[j] + weighted[k]);
  }
  return resistance;
}

}  // namespace dragcore
