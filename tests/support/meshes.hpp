#pragma once

#include <Eigen/Core>
#include <dragcore/shapes.hpp>
#include <utility>
#include <vector>

/// Meshes from others, for tests.
namespace support {

inline dragcore::TriangleMesh moved(const dragcore::TriangleMesh& mesh, const Eigen::Vector3d& by) {
  return transformed(mesh, Eigen::Matrix3d::Identity(), by);
}

/// About the origin.
inline dragcore::TriangleMesh scaled(const dragcore::TriangleMesh& mesh, double by) {
  return transformed(mesh, by * Eigen::Matrix3d::Identity(), Eigen::Vector3d::Zero());
}

/// Every triangle wound the other way.
inline dragcore::TriangleMesh flipped(dragcore::TriangleMesh mesh) {
  for (Eigen::Vector3i& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

/// Triangles of all, corners joined nowhere.
inline dragcore::TriangleMesh together(const std::vector<dragcore::TriangleMesh>& meshes) {
  dragcore::TriangleMesh all;
  for (const dragcore::TriangleMesh& mesh : meshes) {
    const Eigen::Vector3i offset = Eigen::Vector3i::Constant(static_cast<int>(all.vertices.size()));
    all.vertices.insert(all.vertices.end(), mesh.vertices.begin(), mesh.vertices.end());
    for (const Eigen::Vector3i& t : mesh.triangles) all.triangles.push_back(t + offset);
  }
  return all;
}

inline dragcore::TriangleMesh box(const Eigen::Vector3d& low, const Eigen::Vector3d& high, int divisions = 1) {
  const Eigen::Vector3d size = high - low;
  return moved(triangulate(dragcore::Box{size.x(), size.y(), size.z()}, divisions), 0.5 * (low + high));
}

/// A parallelogram of two triangles, seen from where a x b points.
inline dragcore::TriangleMesh rectangle(const Eigen::Vector3d& corner, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return {{corner, corner + a, corner + a + b, corner + b}, {{0, 1, 2}, {0, 2, 3}}};
}

/// The cube of side 1 with a square hole in the middle of its face towards +x; of side 1, that face is not there.
inline dragcore::TriangleMesh box_with_hole(double hole) {
  dragcore::TriangleMesh mesh = triangulate(dragcore::Box{}, 1);
  if (hole == 0.0) return mesh;
  std::erase_if(mesh.triangles, [&](const Eigen::Vector3i& t) {
    double x = 0.0;
    for (const int corner : t) x += mesh.vertices[static_cast<std::size_t>(corner)].x();
    return x > 1.0;
  });
  if (hole == 1.0) return mesh;
  const double yz[4][2] = {{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}};
  dragcore::TriangleMesh frame;
  for (const double side : {1.0, hole})
    for (const auto& [y, z] : yz) frame.vertices.emplace_back(0.5, side * y, side * z);
  for (int k = 0; k < 4; ++k) {
    const int next = (k + 1) % 4;
    frame.triangles.insert(frame.triangles.end(), {{k, next, 4 + next}, {k, 4 + next, 4 + k}});
  }
  return together({mesh, frame});
}

}  // namespace support
