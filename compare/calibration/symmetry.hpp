#pragma once

#include <Eigen/Core>
#include <dragcore/mesh.hpp>
#include <vector>

namespace compare {

/// Distance over the radius within which a mesh that was turned or mirrored is the same body.
inline constexpr double symmetry_tolerance = 2e-3;

/// Rotations and reflections about the centroid of its area that map a body onto itself; the identity is the first, and products of two are
/// among them. Found from the mesh itself: whatever they are, they map the principal axes of its area and its farthest corners onto such,
/// which leaves few to be tried; one is taken if it carries the corners and the middles of the triangles onto the surface, however that is
/// cut. Of round bodies some of those of
/// their polygons, at most a hundred; of a ball the 48 of the cube.
std::vector<Eigen::Matrix3d> symmetry_group(const dragcore::TriangleMesh& mesh);

/// Unit normals of the mirror planes of a group, one of each pair of opposite ones.
std::vector<Eigen::Vector3d> mirror_normals(const std::vector<Eigen::Matrix3d>& group);

}  // namespace compare
