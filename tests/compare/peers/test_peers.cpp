#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <dragcore/shapes.hpp>
#include <map>
#include <numbers>

#include "compare/peers/peers.hpp"

using Catch::Matchers::WithinAbs;
using Eigen::Vector3d;

namespace {

constexpr double air = 1.225, speed = 10.0, pressure = 0.5 * air * speed * speed, deg = std::numbers::pi / 180.0;

/// C_D and the size of the force across the wind, of a wind of 10 m/s along `direction`.
std::pair<double, double> coefficients(const peers::Engine& engine, const dragcore::Shape& shape, const Vector3d& direction, double area) {
  const auto body = engine.make(dragcore::triangulate(shape, 16), air);
  const Vector3d force = body->wrench(speed * direction).force;
  const double drag = force.dot(direction);
  return {drag / (pressure * area), (force - drag * direction).norm() / (pressure * area)};
}

}  // namespace

TEST_CASE("other engines say of cube, plate and ball what was measured of them by hand", "[peers][regression]") {
  struct Pose {
    dragcore::Shape shape;
    Vector3d direction;
    double area;
  };
  const auto plate = [](double incidence) {
    return Pose{dragcore::Plate{}, {std::cos(incidence * deg), 0.0, std::sin(incidence * deg)}, 1.0};
  };
  const std::vector<Pose> poses = {{dragcore::Box{}, Vector3d::UnitX(), 1.0},
                                   {dragcore::Box{}, Vector3d(1, 1, 0).normalized(), 1.0},
                                   plate(0),
                                   plate(30),
                                   plate(45),
                                   plate(90),
                                   {dragcore::Sphere{}, Vector3d::UnitX(), std::numbers::pi / 4.0}};
  // Measured before with MuJoCo 2.2.2 and Bullet 3.24 in programs of their own: cube 0 and 45 deg, plate 0, 30, 45, 90 deg, ball.
  const std::map<std::string, std::vector<double>> drag = {{"Jolt's formula", {1.000, 1.414, 0.050, 0.544, 0.743, 1.000, 1.273}},
                                                           {"MuJoCo box", {1.000, 0.707, 0.050, 0.158, 0.371, 1.000, 0.764}},
                                                           {"MuJoCo ellipsoid", {0.785, 0.785, 0.412, 0.784, 0.785, 0.785, 1.000}},
                                                           {"Bullet", {2.000, 2.828, 0.100, 1.087, 1.485, 2.000, 1.975}}};
  const std::map<std::string, std::pair<double, double>> across = {{"Jolt's formula", {0.0, 0.0}},  // plate at 30 and 45 deg
                                                                   {"MuJoCo box", {0.198, 0.336}},
                                                                   {"MuJoCo ellipsoid", {0.681, 0.784}},
                                                                   {"Bullet", {0.0, 0.0}}};
  for (const peers::Engine& engine : peers::engines()) {
    INFO(engine.name);
    for (std::size_t i = 0; i < poses.size(); ++i) {
      INFO("pose " << i);
      const auto [c_d, c_across] = coefficients(engine, poses[i].shape, poses[i].direction, poses[i].area);
      // Three decimals were written down; the ball of that day had other facets, which are 1.1 % of Bullet's sum over them.
      CHECK_THAT(c_d, WithinAbs(drag.at(engine.name)[i], i == 6 ? 0.012 * drag.at(engine.name)[i] : 0.0015));
      if (i == 3) CHECK_THAT(c_across, WithinAbs(across.at(engine.name).first, 0.001));
      if (i == 4) CHECK_THAT(c_across, WithinAbs(across.at(engine.name).second, 0.001));
    }
  }
}

TEST_CASE("every engine's drag goes with the square of the speed and with density, and has no torque on a centred cube",
          "[peers][analytic]") {
  for (const peers::Engine& engine : peers::engines()) {
    INFO(engine.name);
    const dragcore::TriangleMesh cube = dragcore::triangulate(dragcore::Box{}, 2);
    const dragcore::Wrench once = engine.make(cube, air)->wrench({10, 0, 0}), twice = engine.make(cube, 2 * air)->wrench({20, 0, 0});
    // Bullet works in single precision: 1e-6 of sums over some 50 faces.
    CHECK_THAT(twice.force.x(), WithinAbs(8.0 * once.force.x(), 1e-5 * twice.force.x()));
    CHECK(once.torque.norm() < 1e-5 * once.force.norm());
    CHECK(engine.make(cube, air)->wrench(Vector3d::Zero()).force.isZero());
  }
}

TEST_CASE("a body that is not at its origin has the torque of its arm", "[peers][sign]") {
  const dragcore::TriangleMesh moved =
      dragcore::transformed(dragcore::triangulate(dragcore::Box{}, 1), Eigen::Matrix3d::Identity(), Vector3d(0, 2, 0));
  for (const peers::Engine& engine : peers::engines()) {
    INFO(engine.name);
    const dragcore::Wrench wrench = engine.make(moved, air)->wrench({10, 0, 0});
    CHECK_THAT(wrench.torque.z(), WithinAbs(-2.0 * wrench.force.x(), 1e-5 * wrench.force.x()));  // (0, 2, 0) x (F, 0, 0); single precision
  }
}

#ifdef DRAG_BULLET
TEST_CASE("a soft body of Bullet that is stretched has the drag of its new faces, by their new normals", "[peers][analytic]") {
  dragcore::TriangleMesh sheet = dragcore::triangulate(dragcore::Plate{.thickness = 0.0}, 4);  // in the x-y plane
  peers::BulletMesh body(sheet, air);
  body.aerodynamic_forces({0, 0, -10});
  const double flat = body.total().force.z();
  CHECK_THAT(flat, WithinAbs(pressure, 1e-5 * pressure));  // drag coefficient 1, counted once: a sheet's faces are one layer
  for (Vector3d& vertex : sheet.vertices) vertex = Vector3d(0.0, vertex.y(), vertex.x());  // turned edge-on
  body.move_to(sheet.vertices);
  body.aerodynamic_forces({0, 0, -10});
  CHECK(std::abs(body.total().force.z()) < 1e-5 * flat);
  sheet.vertices.pop_back();
  CHECK_THROWS_WITH(body.move_to(sheet.vertices), Catch::Contains("give one place for each"));
}
#endif
