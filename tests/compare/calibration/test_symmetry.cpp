#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <dragcore/mesh_file.hpp>
#include <dragcore/shapes.hpp>
#include <numbers>

#include "compare/calibration/symmetry.hpp"

using namespace dragcore;
using compare::symmetry_group;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// Turned by no nice angle, moved and scaled: what a body is by itself may not depend on its axes.
TriangleMesh anyhow(const TriangleMesh& mesh) {
  const Matrix3d turn = Eigen::AngleAxisd(0.7, Vector3d(1, 2, -0.5).normalized()).toRotationMatrix();
  return transformed(mesh, 0.03 * turn, Vector3d(5, -1, 2));
}

bool is_group(const std::vector<Matrix3d>& group) {
  for (const Matrix3d& a : group)
    for (const Matrix3d& b : group) {
      bool found = false;
      for (const Matrix3d& c : group) found = found || (a * b - c).norm() < 0.02;
      if (!found) return false;
    }
  return group.front() == Matrix3d::Identity();
}

}  // namespace

TEST_CASE("the symmetries of a mesh are those of its body, however it stands and is cut", "[symmetry][analytic]") {
  struct Body {
    const char* name;
    Shape shape;
    int divisions;
    std::size_t order, mirrors;
  };
  for (const Body& body :
       {Body{"cube", Box{1, 1, 1}, 1, 48, 9}, Body{"cube, cut finer", Box{1, 1, 1}, 3, 48, 9}, Body{"box", Box{3, 2, 1}, 2, 8, 3},
        Body{"square box", Box{2, 1, 1}, 2, 16, 5}, Body{"square plate", Plate{1, 1, 0.05}, 2, 16, 5},
        Body{"square sheet", Plate{1, 1, 0.0}, 2, 16, 5}, Body{"cone, 16 sides", Cone{}, 4, 32, 16},
        Body{"cylinder, 16 sides", Cylinder{}, 4, 64, 17}, Body{"prism of equal sides", Prism{}, 2, 12, 4}}) {
    INFO(body.name);
    for (const bool moved : {false, true}) {
      const TriangleMesh mesh = triangulate(body.shape, body.divisions);
      const std::vector<Matrix3d> group = symmetry_group(moved ? anyhow(mesh) : mesh);
      CHECK(group.size() == body.order);
      CHECK(compare::mirror_normals(group).size() == body.mirrors);
      CHECK(is_group(group));
    }
  }
}

TEST_CASE("an L-bracket has its two mirrors, a skew body nothing, a ball as much as a cube, a many-sided cone a part",
          "[symmetry][analytic]") {
  const TriangleMesh bracket = read_mesh(std::string(SOURCE_FOLDER) + "/cfd_cases/bodies/l_bracket.stl");
  CHECK(symmetry_group(bracket).size() == 4);  // across its width, and legs of the same length exchanged
  Matrix3d skew;
  skew << 1, 0.3, 0.1, 0, 0.8, 0.25, 0, 0, 0.5;
  const TriangleMesh lone = transformed(triangulate(Cone{}, 3), skew, Vector3d::Zero());
  const std::vector<Matrix3d> of_lone = symmetry_group(lone);
  CHECK(of_lone.size() <= 2);  // a skewed cone may keep one mirror of its ellipse
  CHECK(symmetry_group(triangulate(Sphere{}, 4)).size() == 48);
  const std::vector<Matrix3d> many = symmetry_group(triangulate(Cone{}, 32));
  CHECK(many.size() >= 32);
  CHECK(many.size() <= 100);
  CHECK(is_group(many));
}
