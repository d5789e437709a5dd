#include "body/creeping.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <numbers>

#include "support/ellipsoid_resistance.hpp"
#include "support/gauss_legendre.hpp"

namespace dragcore {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

constexpr double thinnest = 1e-4;  // of the largest semi-axis: what is thinner resists as this does, within as much

/// Second moments of the surface of an ellipsoid, per area: over the unit sphere, x_i = a_i n_i and dS = |(bc n_x, ca n_y, ab n_z)| dOmega.
Vector3d moments_of(const Vector3d& semi) {
  static const GaussLegendre<12> gauss;
  const Vector3d crossed(semi[1] * semi[2], semi[2] * semi[0], semi[0] * semi[1]);
  double area = 0.0;
  Vector3d moments = Vector3d::Zero();
  for (std::size_t i = 0; i < gauss.point.size(); ++i)  // one octant stands for all
    for (std::size_t k = 0; k < gauss.point.size(); ++k) {
      const double z = gauss.point[i], ring = std::sqrt(1.0 - z * z), turn = gauss.point[k] * std::numbers::pi / 2.0;
      const Vector3d n(ring * std::cos(turn), ring * std::sin(turn), z);
      const double dS = gauss.weight[i] * gauss.weight[k] * crossed.cwiseProduct(n).norm();
      area += dS;
      moments += dS * n.cwiseAbs2();
    }
  return moments.cwiseProduct(semi.cwiseAbs2()) / area;
}

}  // namespace

Vector3d semi_axes_of(const Vector3d& moments) {
  const double largest = moments.maxCoeff();
  if (!(largest > 0.0)) return Vector3d::Zero();
  // The factor between a_i^2 and the moment is 8/3 to 4: each round brings it near to that of the shape just found.
  const Vector3d wanted = (moments / largest).cwiseMax(thinnest * thinnest / 4.0);
  Vector3d semi = (3.0 * wanted).cwiseSqrt();
  for (int round = 0; round < 40; ++round) {
    const Vector3d factor = wanted.cwiseQuotient(moments_of(semi)).cwiseSqrt();
    semi = semi.cwiseProduct(factor);
    if ((factor.array() - 1.0).abs().maxCoeff() < 1e-10) break;
  }
  return std::sqrt(largest) * semi;
}

void find_creeping_resistance(const Matrix3d& second_moment, CreepingResistance& creeping) {
  const Eigen::SelfAdjointEigenSolver<Matrix3d> principal(second_moment);
  const Vector3d moments = principal.eigenvalues().cwiseMax(0.0);
  if (!(moments.maxCoeff() > 0.0) || !std::isfinite(moments.sum())) return;
  // Ascending: the shortest axis to the pole of the rule of moments_of(), where it does no harm.
  const EllipsoidResistance ellipsoid = ellipsoid_resistance(semi_axes_of(moments.reverse()));
  const Matrix3d axes = principal.eigenvectors().rowwise().reverse();
  Vector3d spread;
  for (int i = 0; i < 3; ++i) {
    // The traction makes a torque of spread times the area's moment about the axis.
    const double about = creeping.wetted * (moments.sum() - moments[2 - i]);
    spread[i] = about > 0.0 ? ellipsoid.angular[i] / about : 0.0;
  }
  const auto turned = [&axes](const Vector3d& along) -> Matrix3d { return axes * along.asDiagonal() * axes.transpose(); };
  creeping.drag = turned(ellipsoid.linear), creeping.turning = turned(ellipsoid.angular), creeping.spread = turned(spread);
}

}  // namespace dragcore
