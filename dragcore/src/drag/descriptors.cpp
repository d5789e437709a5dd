#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <dragcore/descriptors.hpp>

#include "drag/local_forces.hpp"

namespace dragcore {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;

Descriptors describe(const Surface& surface, const Vector3d& direction) {
  Descriptors result;
  const double length = direction.norm();
  if (!(length > 0.0)) return result;
  const Vector3d along = direction / length;
  const Vector3d right = along.unitOrthogonal(), up = along.cross(right);

  double frontal = 0.0, sharp = 0.0;
  Vector2d first = Vector2d::Zero();
  Matrix2d second = Matrix2d::Zero();  // about the surface's centre
  Eigen::Matrix<double, 2, 3> project;
  project << right.transpose(), up.transpose();
  for (const Patch& patch : surface.patches) {
    double c = -along.dot(patch.normal);
    if (surface.two_sided()) c = std::abs(c);
    if (!(c > 0.0)) continue;
    const double weight = patch.area * c;
    const Vector2d arm = project * (patch.centroid - surface.centre);
    frontal += weight;
    sharp += weight * (c * c) * (c * c);
    first += weight * arm;
    second += weight * (project * patch.second_moment * project.transpose() + arm * arm.transpose());
  }
  if (!(frontal > 0.0)) return result;
  result.frontal_area = frontal;
  // Finite even where a body a hair thick is seen edge-on; a sheet has none there either.
  if (surface.volume > 0.0) result.depth = std::min(1e100, surface.volume / (frontal * std::sqrt(frontal)));
  result.sharpness = std::min(1.0, std::sqrt(std::sqrt(sharp / frontal)));
  first /= frontal;
  second = second / frontal - first * first.transpose();
  // Principal radii of gyration of the silhouette; of a needle seen from the side the short one is rounding error and may even be negative.
  const double mean = 0.5 * second.trace(), spread = std::hypot(0.5 * (second(0, 0) - second(1, 1)), second(0, 1));
  result.aspect = std::sqrt((mean + spread) / std::max(mean - spread, 1e-8 * (mean + spread)));
  return result;
}

double curvature_along(const Surface& surface, Eigen::Index triangle, const Vector3d& tangential) {
  return curvature_along(surface, triangle, tangential, 1.0);
}

double curvature_along(const Surface& surface, Eigen::Index triangle, const Vector3d& tangential, double side) {
  const auto k = surface.curvature.row(triangle);
  const Vector3d& t = tangential;
  const double size = t.squaredNorm();
  const double crossed = k[1] * t.x() * t.y() + k[2] * t.x() * t.z() + k[4] * t.y() * t.z();
  const double turning = side * (k[0] * t.x() * t.x() + k[3] * t.y() * t.y() + k[5] * t.z() * t.z() + 2.0 * crossed);
  if (!(turning > 0.0) || !(size > 0.0)) return 0.0;
  // In units of the body: 2 for a ball. Half the indicator's rise is at a third of a ball's curvature.
  const double x = turning / size * std::sqrt(surface.total_area / 3.14159265358979323846);
  return x * x / (x * x + 0.45);
}

}  // namespace dragcore
