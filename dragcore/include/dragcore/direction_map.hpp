#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

namespace dragcore {

/// Rows of eight floats over the sphere of directions: force coefficients x y z, 0, torque coefficients x y z, 0.
///
/// Every face of an octahedron is cut into frequency^2 triangles, and values are linear over each: continuous, also over the octahedron's
/// edges. These lie where the faces of a box along the axes stand edge-on, so that the kinks which laws have there cost nothing.
/// Nodes are stored as a square of (2 frequency + 1)^2, the octahedron unfolded about +z: node (i, j) is at row j, column i.
struct DirectionMap {
  int frequency = 0;  ///< 0: no map
  int columns = 0;    ///< rows of eight at each node
  std::vector<float> values;

  int side() const { return 2 * frequency + 1; }
  int nodes() const { return side() * side(); }
  const float* row(int node, int column) const { return values.data() + 8 * (static_cast<std::size_t>(node) * columns + column); }

  /// Three nodes and their weights: not negative, sum 1.
  struct Sample {
    std::array<int, 3> node;
    std::array<float, 3> weight;
  };
  Eigen::Vector3d direction(int node) const;  ///< unit

  static DirectionMap zero(int frequency, int columns);
  void set(int node, int column, const Eigen::Vector3d& force, const Eigen::Vector3d& torque);
};

}  // namespace dragcore
