#pragma once

#include <Eigen/Geometry>
#include <dragcore/shapes.hpp>
#include <string>
#include <utility>
#include <vector>

/// Bodies of thin parts that stand in each other's wind: what exposure between its directions is hardest for.
namespace thin_bodies {

inline void add(dragcore::TriangleMesh& all, const dragcore::TriangleMesh& mesh) {
  const Eigen::Vector3i offset = Eigen::Vector3i::Constant(static_cast<int>(all.vertices.size()));
  all.vertices.insert(all.vertices.end(), mesh.vertices.begin(), mesh.vertices.end());
  for (const Eigen::Vector3i& t : mesh.triangles) all.triangles.push_back(t + offset);
}

inline dragcore::TriangleMesh box(const Eigen::Vector3d& centre, const Eigen::Vector3d& size, double yaw = 0.0, int divisions = 2) {
  return transformed(triangulate(dragcore::Box{size.x(), size.y(), size.z()}, divisions),
                     Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix(), centre);
}

/// Two crossed arms a twentieth as thick as long, a hub, and motors with flat rotors on the ends: 1 m across.
inline dragcore::TriangleMesh quadrotor() {
  constexpr double eighth = 0.78539816339744831;
  dragcore::TriangleMesh mesh;
  for (const double yaw : {eighth, -eighth}) add(mesh, box({0, 0, 0}, {1.0, 0.04, 0.02}, yaw));
  add(mesh, box({0, 0, 0.02}, {0.2, 0.12, 0.05}));
  for (const double x : {-0.34, 0.34})
    for (const double y : {-0.34, 0.34}) {
      add(mesh, box({x, y, 0.02}, {0.05, 0.05, 0.05}));
      add(mesh, box({x, y, 0.06}, {0.3, 0.03, 0.004}, x * y > 0.0 ? 0.6 : -0.3));
    }
  return mesh;
}

/// Two square plates, 1 m wide and 20 mm thick, one above the other.
inline dragcore::TriangleMesh two_decks() {
  dragcore::TriangleMesh mesh;
  for (const double z : {-0.15, 0.15}) add(mesh, box({0, 0, z}, {1.0, 1.0, 0.02}, 0.0, 6));
  return mesh;
}

/// The edges of a box of 1 x 0.8 x 0.6 m as bars of 30 mm.
inline dragcore::TriangleMesh frame() {
  dragcore::TriangleMesh mesh;
  const Eigen::Vector3d size(1.0, 0.8, 0.6);
  for (int axis = 0; axis < 3; ++axis)
    for (const double u : {-0.5, 0.5})
      for (const double v : {-0.5, 0.5}) {
        Eigen::Vector3d centre = Eigen::Vector3d::Zero(), bar = Eigen::Vector3d::Constant(0.03);
        bar[axis] = size[axis];
        centre[(axis + 1) % 3] = u * size[(axis + 1) % 3];
        centre[(axis + 2) % 3] = v * size[(axis + 2) % 3];
        add(mesh, box(centre, bar));
      }
  return mesh;
}

inline std::vector<std::pair<std::string, dragcore::TriangleMesh>> all() {
  return {{"quadrotor", quadrotor()}, {"two decks", two_decks()}, {"frame of bars", frame()}};
}

}  // namespace thin_bodies
