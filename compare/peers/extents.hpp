#pragma once

#include <Eigen/Geometry>
#include <dragcore/mesh.hpp>

namespace peers {

/// The box along the axes that holds the mesh.
Eigen::AlignedBox3d extents(const dragcore::TriangleMesh& mesh);

}  // namespace peers
