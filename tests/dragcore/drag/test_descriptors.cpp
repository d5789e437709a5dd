#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <dragcore/descriptors.hpp>
#include <numbers>

#include "tests/support/zoo.hpp"

using namespace dragcore;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;
using Eigen::Vector3d;
using std::numbers::pi;

namespace {

// Flat-sided bodies: exact but for rounding.
constexpr double rounding = 1e-12;

}  // namespace

TEST_CASE("a cube face-on, edge-on and corner-on has the frontal area, depth and sharpness of geometry", "[descriptors][analytic]") {
  const Surface cube = zoo::surface(Box{}, 2);
  const auto face = describe(cube, {1, 0, 0}), edge = describe(cube, {1, 1, 0}), corner = describe(cube, {1, 1, 1});
  CHECK_THAT(face.frontal_area, WithinRel(1.0, rounding));
  CHECK_THAT(edge.frontal_area, WithinRel(std::sqrt(2.0), rounding));
  CHECK_THAT(corner.frontal_area, WithinRel(std::sqrt(3.0), rounding));
  CHECK_THAT(face.depth, WithinRel(1.0, rounding));
  CHECK_THAT(edge.depth, WithinRel(std::pow(2.0, -0.75), rounding));
  CHECK_THAT(face.sharpness, WithinRel(1.0, rounding));
  CHECK_THAT(edge.sharpness, WithinRel(std::sqrt(0.5), rounding));  // two faces at 45 degrees
  CHECK_THAT(corner.sharpness, WithinRel(std::sqrt(1.0 / 3.0), rounding));
  CHECK_THAT(face.aspect, WithinRel(1.0, rounding));
  CHECK_THAT(edge.aspect, WithinRel(std::sqrt(2.0), rounding));  // a rectangle of sqrt(2) by 1
  CHECK_THAT(corner.aspect, WithinRel(1.0, 1e-7));               // a hexagon; the root of a rounding error
}

TEST_CASE("frontal area, depth and sharpness of a ball are those of a ball, to second order", "[descriptors][convergence]") {
  const auto error = [](int divisions) {
    const auto ball = describe(zoo::surface(Sphere{.diameter = 1.0}, divisions), {0.3, -0.5, 0.8});
    return std::abs(ball.frontal_area / (pi / 4) - 1.0) + std::abs(ball.depth / (pi / 6 / std::pow(pi / 4, 1.5)) - 1.0) +
           std::abs(std::pow(ball.sharpness, 4) / (1.0 / 3.0) - 1.0);  // k^4 = int c^5 dA / int c dA = (1/6)/(1/2)
  };
  CHECK(error(32) < 0.01);
  CHECK(error(16) / error(32) > 3.0);  // 4 for second order
}

TEST_CASE("descriptors do not depend on how faces are cut into triangles, nor on size, place or attitude", "[descriptors][invariance]") {
  zoo::Random random(7);
  const Box box{.length = 2.0, .width = 0.7, .height = 0.4};
  const TriangleMesh coarse = triangulate(box, 2), fine = triangulate(box, 9);
  for (int i = 0; i < 20; ++i) {
    const Vector3d u = random.vector(1.0);
    const Eigen::Matrix3d turn = random.rotation();
    const auto a = describe(Surface(coarse), u), b = describe(Surface(fine), u);
    const auto c = describe(Surface(transformed(coarse, 3.0 * turn, random.vector(5.0))), turn * u);
    for (const auto& [other, scale] : {std::pair{b, 1.0}, std::pair{c, 9.0}}) {
      CHECK_THAT(other.frontal_area, WithinRel(scale * a.frontal_area, 1e-10));
      CHECK_THAT(other.depth, WithinRel(a.depth, 1e-10));
      CHECK_THAT(other.sharpness, WithinRel(a.sharpness, 1e-10));
      CHECK_THAT(other.aspect, WithinRel(a.aspect, 1e-8));
    }
  }
}

TEST_CASE("curvature is 1/R on a ball, around a cylinder and 0 along it, and 0 on flat faces", "[descriptors][analytic]") {
  const Surface ball = zoo::surface(Sphere{.diameter = 2.0}, 24);
  double largest = 0.0, smallest = 1e9;
  for (Eigen::Index i = 0; i < ball.size(); ++i) {
    const Vector3d n = ball.normal.row(i).matrix(), t = n.unitOrthogonal();
    const double chi = curvature_along(ball, i, t);
    largest = std::max(largest, chi), smallest = std::min(smallest, chi);
  }
  // x = 2 gives chi = 4/4.45; the triangles of a globe grid share their bending unevenly between the edges, by up to a half of it.
  CHECK(largest < 0.97);
  CHECK(smallest > 0.6);

  const Surface cylinder = zoo::surface(Cylinder{.diameter = 1.0, .length = 2.0}, 12);
  const double x = std::sqrt(cylinder.total_area / pi) / 0.5;
  for (Eigen::Index i = 0; i < cylinder.size(); ++i) {
    const Vector3d n = cylinder.normal.row(i).matrix();
    if (std::abs(n.x()) > 0.5) {
      CHECK(curvature_along(cylinder, i, Vector3d::UnitY()) == 0.0);  // end faces
      continue;
    }
    CHECK_THAT(curvature_along(cylinder, i, Vector3d::UnitX()), WithinAbs(0.0, 1e-12));
    CHECK_THAT(curvature_along(cylinder, i, n.cross(Vector3d::UnitX())), WithinAbs(x * x / (x * x + 0.45), 0.01));  // facets of 1/48 turn
  }
  const Surface cube = zoo::surface(Box{}, 3);
  CHECK((cube.curvature.abs() < 1e-12).all());
}

TEST_CASE("the class of a body is found from its mesh", "[descriptors][analytic]") {
  const auto class_of = [](const Shape& shape) { return zoo::surface(shape, 12).body_class; };
  CHECK(class_of(Plate{.thickness = 0.0}) == BodyClass::sheet);
  CHECK(class_of(Plate{.thickness = 0.05}) == BodyClass::sheet);
  CHECK(class_of(Cylinder{.diameter = 1.0, .length = 0.05}) == BodyClass::sheet);  // a disc
  CHECK(class_of(Box{}) == BodyClass::sharp);
  CHECK(class_of(Box{.length = 0.5}) == BodyClass::sharp);
  CHECK(class_of(Box{.length = 30.0}) == BodyClass::sharp);  // a rod is no sheet, however slender
  CHECK(class_of(Cone{}) == BodyClass::sharp);
  CHECK(class_of(Cylinder{.diameter = 1.0, .length = 2.0}) == BodyClass::sharp);
  CHECK(class_of(Prism{}) == BodyClass::sharp);
  const TriangleMesh corner{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
  CHECK(Surface(corner).body_class == BodyClass::sharp);  // thin by 2 V/A, but not flat
  CHECK(class_of(Sphere{}) == BodyClass::smooth);
  CHECK(class_of(Ellipsoid{.semi_x = 0.8, .semi_y = 0.5, .semi_z = 0.3}) == BodyClass::smooth);
  CHECK(class_of(Teardrop{.diameter = 1.0, .length = 3.0}) == BodyClass::smooth);

  TriangleMesh open = triangulate(Box{}, 2);
  open.triangles.resize(open.triangles.size() - 2);  // 1 of 24 squares: a body with a hole
  CHECK(Surface(open).body_class == BodyClass::sharp);
  CHECK_THAT(Surface(open).volume, WithinAbs(1.0, 1e-14));
  open.triangles.resize(open.triangles.size() - 2);
  CHECK(Surface(open).body_class == BodyClass::sharp);  // no hole makes a sheet of it: lids close them
  CHECK_THAT(Surface(open).volume, WithinAbs(1.0, 1e-14));
  CHECK(Surface(TriangleMesh{}).body_class == BodyClass::sheet);
}

TEST_CASE("nothing is described in still air or without a surface", "[descriptors][hard]") {
  CHECK(describe(zoo::surface(Box{}, 2), Vector3d::Zero()).frontal_area == 0.0);
  CHECK(describe(Surface(TriangleMesh{}), Vector3d::UnitX()).frontal_area == 0.0);
  CHECK(describe(zoo::surface(Plate{.thickness = 0.0}, 2), Vector3d::UnitX()).depth == 0.0);  // edge-on sheet: no area to divide by
}
