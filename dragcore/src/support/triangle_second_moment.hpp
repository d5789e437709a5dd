#pragma once

#include <Eigen/Core>

namespace dragcore {

/// Integral of (r - centroid)(r - centroid)^T over a triangle, per area [m^2].
/// @param ab, ac  from one corner to the others [m]
inline Eigen::Matrix3d triangle_second_moment(const Eigen::Vector3d& ab, const Eigen::Vector3d& ac) {
  return (ab * ab.transpose() + ac * ac.transpose()) / 18.0 - (ab * ac.transpose() + ac * ab.transpose()) / 36.0;
}

}  // namespace dragcore
