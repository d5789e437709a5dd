#pragma once

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

namespace dragcore {

/// The box along the principal axes of area that holds a set of triangles: extents in ascending order [m], and their directions as columns.
struct PrincipalBox {
  Eigen::Vector3d extents = Eigen::Vector3d::Zero();
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
};

/// @param corners  of a triangle by its index, as std::array<Eigen::Vector3d, 3>
template <class CornersOf>
PrincipalBox principal_box(Eigen::Index count, CornersOf&& corners) {
  using Eigen::Vector3d;
  if (count == 0) return {};
  const Vector3d origin = corners(0)[0];
  double total = 0.0;
  Vector3d first = Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
  for (Eigen::Index i = 0; i < count; ++i) {
    const std::array<Vector3d, 3> p = corners(i);
    const double area = 0.5 * (p[1] - p[0]).cross(p[2] - p[0]).stableNorm();
    total += area;
    first += area * ((p[0] + p[1] + p[2]) / 3.0 - origin);
    for (int k = 0; k < 3; ++k) {  // midpoints of edges: exact for second moments
      const Vector3d middle = 0.5 * (p[k] + p[(k + 1) % 3]) - origin;
      second += area / 3.0 * middle * middle.transpose();
    }
  }
  if (!(total > 0.0)) return {};
  first /= total;
  const Eigen::Matrix3d axes = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(second / total - first * first.transpose()).eigenvectors();
  Vector3d low = axes.transpose() * (corners(0)[0] - origin), high = low;
  for (Eigen::Index i = 0; i < count; ++i)
    for (const Vector3d& corner : corners(i)) {
      const Vector3d place = axes.transpose() * (corner - origin);
      low = low.cwiseMin(place);
      high = high.cwiseMax(place);
    }
  const Vector3d size = high - low;
  std::array<int, 3> order{0, 1, 2};
  std::sort(order.begin(), order.end(), [&](int a, int b) { return size[a] < size[b]; });
  PrincipalBox box;
  for (int k = 0; k < 3; ++k) {
    box.extents[k] = size[order[static_cast<std::size_t>(k)]];
    box.axes.col(k) = axes.col(order[static_cast<std::size_t>(k)]);
  }
  return box;
}

/// Whether a body is a sheet to the air: its mean thickness 2 V/A is below 0.12 of its middle extent, a twentieth for the plates and discs
/// that the sheet law was fitted to, a quarter for a box of half depth. A tetrahedron is thin by that measure, too, but not flat.
inline bool is_sheet(double volume, double area, const Eigen::Vector3d& extents) {
  return 2.0 * std::abs(volume) < 0.12 * extents[1] * area && extents[0] < 0.3 * extents[1];
}

}  // namespace dragcore
