// What a face is must not depend on how flat it is, nor on how and in which order it is cut into triangles.
#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>

#include "tests/support/zoo.hpp"

using namespace dragcore;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;
using Eigen::Vector3d;

namespace {

TriangleMesh sheet(int n, double sag, double noise, unsigned order) {
  TriangleMesh mesh;
  std::mt19937 engine(1);
  std::normal_distribution<double> normal;
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j) {
      const double x = static_cast<double>(i) / n - 0.5, y = static_cast<double>(j) / n - 0.5;
      mesh.vertices.push_back({x, y, -2 * sag * (x * x + y * y) + (noise > 0 ? noise * normal(engine) : 0.0)});
    }
  const auto id = [n](int i, int j) { return i * (n + 1) + j; };
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      mesh.triangles.push_back({id(i, j), id(i + 1, j), id(i + 1, j + 1)});
      mesh.triangles.push_back({id(i, j), id(i + 1, j + 1), id(i, j + 1)});
    }
  if (order > 0) {
    std::mt19937 shuffler(order);
    std::shuffle(mesh.triangles.begin(), mesh.triangles.end(), shuffler);
  }
  return mesh;
}

Wrench at_20_degrees(const TriangleMesh& mesh) {
  const Surface surface(mesh);
  const double a = 20 * std::numbers::pi / 180;
  const Motion motion{.wind = 10 * Vector3d(std::cos(a), 0, std::sin(a)), .reference_point = surface.centre};
  return wrench(surface, motion, {1.2}, zoo::exactly(model_for(surface))).total();
}

}  // namespace

TEST_CASE("the pillow of a sheet does not depend on how flat it is", "[pillow][invariance]") {
  const double flat = at_20_degrees(sheet(2, 0, 0, 0)).torque.y() / 60;
  CHECK_THAT(flat, WithinRel(0.0798, 0.01));
  for (const int n : {2, 10, 40})
    for (const double sag : {0.0, 1e-4, 3e-4, 1e-3, 1e-2}) {
      const Wrench w = at_20_degrees(sheet(n, sag, 0, 0));
      // Up to a sag of 1e-3 its parts turn by at most 0.23 degrees; at 1e-2 by 2.3 of the 20 degrees.
      CHECK_THAT(w.torque.y() / 60, WithinRel(flat, sag == 0.0 ? 1e-9 : sag <= 1e-3 ? 0.01 : 0.1));
      CHECK_THAT(w.torque.x() / 60, WithinAbs(0.0, 1e-9));  // by symmetry
    }
  for (const double noise : {1e-6, 1e-5, 3e-5, 1e-4, 1e-3}) {
    const Wrench w = at_20_degrees(sheet(40, 0, noise, 0));
    CHECK_THAT(w.torque.y() / 60, WithinRel(flat, 0.1));
    CHECK_THAT(w.torque.x() / 60, WithinAbs(0.0, 2e-3));  // of noise there is a little of everything
  }
  for (const unsigned order : {1u, 2u, 3u, 4u, 5u}) {
    const Wrench sorted = at_20_degrees(sheet(40, 3e-4, 0, 0)), shuffled = at_20_degrees(sheet(40, 3e-4, 0, order));
    CHECK((sorted.torque - shuffled.torque).norm() < 1e-10 * sorted.torque.norm());
  }
}

TEST_CASE("noise of a thousandth of its size does not give a cube lift, curvature or another class", "[pillow][invariance]") {
  TriangleMesh mesh = triangulate(Box{}, 16);
  std::mt19937 engine(5);
  std::normal_distribution<double> normal;
  for (Vector3d& v : mesh.vertices) v += 1e-3 * Vector3d(normal(engine), normal(engine), normal(engine));
  const Surface noisy(mesh), clean(triangulate(Box{}, 16));
  CHECK(noisy.body_class == BodyClass::sharp);
  for (const double degrees : {0.0, 20.0, 45.0}) {
    const double a = degrees * std::numbers::pi / 180;
    const auto of = [&](const Surface& surface) {
      return Vector3d(wrench(surface, {.wind = 10 * Vector3d(std::cos(a), 0, std::sin(a))}, {1.2}, zoo::exactly(model_for(surface))).total().force / 60);
    };
    CHECK((of(noisy) - of(clean)).norm() < 0.02);
  }
}

TEST_CASE("a region is exact where geometry is: flat faces, balls, cylinders", "[pillow][analytic]") {
  const Surface box = zoo::surface(Box{.length = 2.0, .width = 1.0, .height = 0.6}, 3);
  for (Eigen::Index i = 0; i < box.size(); ++i) {
    const Vector3d n = box.normal.row(i).matrix();
    const Vector3d squares = Vector3d(4.0, 1.0, 0.36) / 12.0;
    const Eigen::Matrix3d expected = (squares.array() * (1.0 - n.array().abs())).matrix().asDiagonal();
    CHECK((symmetric(box.second_moment.row(i)) - expected).norm() < 1e-12);
  }
  // Of a ball every cap is alike; sums over facets are of second order.
  const Surface ball = zoo::surface(Sphere{.diameter = 2.0}, 16);
  const double first = symmetric(ball.second_moment.row(0)).trace();
  for (Eigen::Index i = 0; i < ball.size(); ++i) {
    const Vector3d n = ball.normal.row(i).matrix(), t = n.unitOrthogonal();
    CHECK_THAT(t.dot(symmetric(ball.curvature.row(i)) * t), WithinAbs(1.0, 0.01));
    CHECK_THAT(symmetric(ball.second_moment.row(i)).trace(), WithinRel(first, 0.03));
  }
}

TEST_CASE("the pillow does not react to the spin of a body in still air", "[pillow][limit]") {
  const Surface cube = zoo::surface(Box{}, 3);
  const Motion spin{.angular_velocity = {0, 0, 1}};
  const Model with = model_for(cube);
  Model without = with;
  without.pillow = {};
  CHECK(wrench(cube, spin, {}, with).total().torque == wrench(cube, spin, {}, without).total().torque);
  // In a wind that outruns the spin it is there as without spin.
  const Vector3d wind(10, 0, 4);
  const Wrench still = wrench(cube, {.wind = wind}, {}, with).total(),
               slow = wrench(cube, {.wind = wind, .angular_velocity = {0, 1e-6, 0}}, {}, with).total();
  CHECK((still.torque - slow.torque).norm() < 1e-5 * still.torque.norm());
}

TEST_CASE("a spheroid has a pillow: its torque at 45 degrees turns it broadside", "[pillow][sign]") {
  const Surface spheroid = zoo::surface(Ellipsoid{.semi_x = 1.25, .semi_y = 0.5, .semi_z = 0.5}, 12);
  const Model with = model_for(spheroid);
  Model without = with;
  without.pillow = {};
  const Motion oblique{.wind = {7, 0, 7}};
  const double by_law = wrench(spheroid, oblique, {}, without).total().torque.y(),
               by_both = wrench(spheroid, oblique, {}, with).total().torque.y();
  CHECK(by_both > 1.2 * by_law);
  CHECK(by_law > 0.0);
}
