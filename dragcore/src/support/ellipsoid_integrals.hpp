#pragma once

#include <Eigen/Core>
#include <cmath>

#include "support/gauss_legendre.hpp"

namespace dragcore {

/// Visits the points of a rule for integrals over 0 < tau < infinity of functions of 1 / (1 + tau a_i^2), tau^(n/2) and square roots of
/// those, which is what drag, added mass and Stokes' resistance of an ellipsoid are.
/// Calls visit(tau, d tau, shrink, root): shrink_i = 1 / (1 + tau a_i^2), root = sqrt(prod shrink).
///
/// All singularities lie at tau = -1/a_i^2. In sqrt(tau) below 1, ln(tau) up to 1/a_min^2 and 1/sqrt(tau) beyond they keep their distance
/// from every panel, so that 12 Gauss points reach 1e-12 at any aspect ratio: only the number of middle panels grows, with its logarithm.
/// @param scaled  semi-axes over the largest of them
template <int Points = 12, class Visit>
void for_each_ellipsoid_node(const Eigen::Vector3d& scaled, Visit&& visit) {
  static const GaussLegendre<Points> gauss;
  const double smallest = scaled.minCoeff(), middle = -2.0 * std::log(smallest);
  // Panels of length at most 4 in ln(tau): the Bernstein ellipse through the singularities at distance pi has radius 3.4 at least,
  // error 3.4^-24.
  const int panels = static_cast<int>(std::ceil(middle / 4.0 - 1e-12));
  const auto at = [&](double tau, double d_tau) {
    const Eigen::Vector3d shrink = (1.0 + tau * scaled.array().square()).inverse();
    visit(tau, d_tau, shrink, std::sqrt(shrink.prod()));
  };
  for (int i = 0; i < Points; ++i) {
    const double x = gauss.point[i], weight = gauss.weight[i];
    at(x * x, 2.0 * x * weight);
    for (int panel = 0; panel < panels; ++panel) {
      const double tau = std::exp(middle * (panel + x) / panels);
      at(tau, tau * weight * middle / panels);
    }
    const double v = smallest * x;  // tau = v^-2
    at(1.0 / (v * v), 2.0 / (v * v * v) * weight * smallest);
  }
}

}  // namespace dragcore
