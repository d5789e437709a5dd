#include "compare/peers/peers.hpp"

#include <Eigen/Geometry>

#include "compare/peers/extents.hpp"

namespace peers {
namespace {

class ProjectedBox : public Peer {
 public:
  ProjectedBox(const dragcore::TriangleMesh& mesh, double density) : density_(density) {
    const Eigen::AlignedBox3d box = extents(mesh);
    const Eigen::Vector3d size = box.sizes();
    faces_ = {size.y() * size.z(), size.z() * size.x(), size.x() * size.y()};
    middle_ = box.center();
  }

  dragcore::Wrench wrench(const Eigen::Vector3d& wind) override {
    const Eigen::Vector3d force = 0.5 * density_ * wind.cwiseAbs().dot(faces_) * wind;  // |u| times the projected area
    return {force, middle_.cross(force)};
  }

 private:
  Eigen::Vector3d faces_, middle_;
  double density_;
};

}  // namespace

Eigen::AlignedBox3d extents(const dragcore::TriangleMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& vertex : mesh.vertices) box.extend(vertex);
  return box;
}

std::unique_ptr<Peer> jolt_formula(const dragcore::TriangleMesh& mesh, double density) {
  return std::make_unique<ProjectedBox>(mesh, density);
}

const std::vector<Engine>& engines() {
  static const std::vector<Engine> list = {
      {"Jolt's formula", false, jolt_formula},
#ifdef DRAG_MUJOCO
      {"MuJoCo box", false, mujoco_box},
      {"MuJoCo ellipsoid", false, mujoco_ellipsoid},
#endif
#ifdef DRAG_BULLET
      {"Bullet", true, bullet},
#endif
  };
  return list;
}

}  // namespace peers
