#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <dragcore/descriptors.hpp>
#include <stdexcept>
#include <string>

#include "drag/local_forces.hpp"
#include "drag/silhouette.hpp"
#include "support/triangle_second_moment.hpp"

namespace dragcore {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

/// Sums over what faces the flow along one direction.
class Silhouette {
 public:
  Silhouette(const Part& part, const Vector3d& direction) : part_(part) {
    if (const double length = direction.norm(); length > 0.0) along_ = direction / length;
  }

  /// @param reached  share of the area that the flow reaches
  void add(const Vector3d& normal, const Vector3d& centroid, double area, const Eigen::Matrix3d& second_moment, double reached = 1.0) {
    double c = -along_.dot(normal);
    if (part_.two_sided) c = std::abs(c);
    if (!(c > 0.0)) return;
    const double weight = reached * area * c;
    const Vector3d arm = centroid - part_.centre;
    sums_.whole += area * c;
    sums_.frontal += weight;
    sums_.sharp += weight * (c * c) * (c * c);
    sums_.first += weight * arm;
    sums_.second += weight * (second_moment + arm * arm.transpose());
  }

  Descriptors result() const { return descriptors_of(sums_, part_, along_); }

 private:
  const Part& part_;
  Vector3d along_ = Vector3d::Zero();
  SilhouetteSums sums_;
};

}  // namespace

Descriptors descriptors_of(const SilhouetteSums& sums, const Part& part) {
  Descriptors result;
  if (!(sums.frontal > 0.0)) {
    if (sums.whole > 0.0) result.reached = 0.0;
    return result;
  }
  result.frontal_area = sums.frontal;
  result.reached = sums.frontal / sums.whole;
  // Finite even where a body a hair thick is seen edge-on; a sheet has none there either.
  if (part.volume > 0.0) result.depth = std::min(1e100, part.volume / (sums.frontal * std::sqrt(sums.frontal)));
  result.sharpness = std::min(1.0, std::sqrt(std::sqrt(sums.sharp / sums.frontal)));
  return result;
}

Descriptors descriptors_of(const SilhouetteSums& sums, const Part& part, const Vector3d& direction) {
  Descriptors result = descriptors_of(sums, part);
  if (!(sums.frontal > 0.0)) return result;
  Eigen::Matrix<double, 2, 3> project;
  project.row(0) = direction.unitOrthogonal().transpose();
  project.row(1) = direction.cross(Vector3d(project.row(0).transpose())).transpose();
  const Vector2d first = project * sums.first / sums.frontal;
  const Matrix2d second = project * sums.second * project.transpose() / sums.frontal - first * first.transpose();
  // Principal radii of gyration of the silhouette; of a needle seen from the side the short one is rounding error and may even be
  // negative.
  const double mean = 0.5 * second.trace(), spread = std::hypot(0.5 * (second(0, 0) - second(1, 1)), second(0, 1));
  result.aspect = std::sqrt((mean + spread) / std::max(mean - spread, 1e-8 * (mean + spread)));
  return result;
}

std::vector<Descriptors> describe_parts(const Surface& surface, const std::vector<Vector3d>& directions) {
  std::vector<Silhouette> seen;
  for (std::size_t p = 0; p < surface.parts.size(); ++p) seen.emplace_back(surface.parts[p], directions[p]);
  if (!surface.exposure) {
    for (const Patch& patch : surface.patches)
      seen[static_cast<std::size_t>(patch.part)].add(patch.normal, patch.centroid, patch.area, patch.second_moment);
  } else {
    std::vector<Exposure::Sample> samples;
    for (const Vector3d& direction : directions) samples.push_back(surface.exposure->towards(-direction));
    for (Eigen::Index i = 0; i < surface.size(); ++i) {
      const auto p = static_cast<std::size_t>(surface.part[static_cast<std::size_t>(i)]);
      const Vector3d ab = surface.edge_ab.row(i).matrix(), ac = surface.edge_ac.row(i).matrix();
      seen[p].add(surface.normal.row(i).matrix(), surface.centroid.row(i).matrix(), surface.area[i], triangle_second_moment(ab, ac),
                  surface.exposure->share(i, samples[p]));
    }
  }
  std::vector<Descriptors> found;
  for (const Silhouette& silhouette : seen) found.push_back(silhouette.result());
  return found;
}

Descriptors describe(const Surface& surface, const Vector3d& direction, std::size_t part) {
  if (part >= surface.parts.size())
    throw std::invalid_argument("describe: part = " + std::to_string(part) + ", but the surface has " +
                                std::to_string(surface.parts.size()));
  return describe_parts(surface, std::vector<Vector3d>(surface.parts.size(), direction))[part];
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
  const Part& body = surface.parts[static_cast<std::size_t>(surface.part[static_cast<std::size_t>(triangle)])];
  const double x = turning / size * std::sqrt(body.area / 3.14159265358979323846);
  return x * x / (x * x + 0.45);
}

}  // namespace dragcore
