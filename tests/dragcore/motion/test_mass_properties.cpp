#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <dragcore/mass_properties.hpp>
#include <dragcore/shapes.hpp>
#include <numbers>

using namespace dragcore;
using Catch::Matchers::Contains;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using std::numbers::pi;

namespace {

// Sums of some hundred terms, each rounded at 1e-16 of the largest.
constexpr double rounding = 1e-13;

void check_same(const MeshMass& found, const MeshMass& expected, double tolerance) {
  CHECK_THAT(found.mass, WithinRel(expected.mass, tolerance));
  const double size = std::sqrt(expected.inertia.trace() / expected.mass);
  CHECK_THAT((found.centre_of_mass - expected.centre_of_mass).norm(), WithinAbs(0.0, tolerance * size));
  CHECK_THAT((found.inertia - expected.inertia).norm(), WithinAbs(0.0, tolerance * expected.inertia.norm()));
}

TriangleMesh joined(TriangleMesh first, const TriangleMesh& second) {
  const int count = static_cast<int>(first.vertices.size());
  first.vertices.insert(first.vertices.end(), second.vertices.begin(), second.vertices.end());
  for (const auto& t : second.triangles) first.triangles.emplace_back(t.array() + count);
  return first;
}

TriangleMesh turned_inside_out(TriangleMesh mesh) {
  for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

}  // namespace

TEST_CASE("boxes and sheets have the mass and inertia of their formulas", "[mass_properties][analytic]") {
  const double a = 2.0, b = 1.0, c = 0.6;
  for (const int divisions : {1, 5}) {
    MeshMass box;
    box.mass = 700 * a * b * c;
    box.inertia = box.mass / 12 * Vector3d(b * b + c * c, a * a + c * c, a * a + b * b).asDiagonal().toDenseMatrix();
    check_same(mass_properties(triangulate(Box{a, b, c}, divisions), 700), box, rounding);

    MeshMass sheet;
    sheet.mass = 0.08 * a * b;
    sheet.inertia = sheet.mass / 12 * Vector3d(b * b, a * a, a * a + b * b).asDiagonal().toDenseMatrix();
    check_same(sheet_mass_properties(triangulate(Plate{a, b, 0.0}, divisions), 0.08), sheet, rounding);
  }
}

TEST_CASE("a hollow cube is its six walls", "[mass_properties][analytic]") {
  // Each wall of mass m: two with the axis across them, m s^2/6; four along it, m (s^2/12 + s^2/4). Sum 10/6 m s^2 about any axis.
  const MeshMass found = sheet_mass_properties(triangulate(Box{3.0, 3.0, 3.0}, 2), 2.0);
  CHECK_THAT(found.mass, WithinRel(6 * 18.0, rounding));
  CHECK_THAT((found.inertia - 10.0 / 6 * 18.0 * 9.0 * Matrix3d::Identity()).norm(), WithinAbs(0.0, rounding * 270));
}

TEST_CASE("balls, ellipsoids and cones converge with second order to the inertia of their formulas", "[mass_properties][convergence]") {
  const double h = 0.5 / std::tan(0.35), r = 0.5, mass = pi * r * r * h / 3;
  const struct {
    Shape shape;
    Vector3d inertia;
  } bodies[] = {{Sphere{1.0}, Vector3d::Constant(pi / 6 * 0.1)},
                {Ellipsoid{0.8, 0.5, 0.3}, 4.0 / 15 * pi * 0.12 * Vector3d(0.34, 0.73, 0.89)},
                {Cone{1.0, 0.7}, mass * Vector3d(0.3 * r * r, 0.15 * r * r + 0.0375 * h * h, 0.15 * r * r + 0.0375 * h * h)}};
  for (const auto& body : bodies) {
    INFO(kind(body.shape));
    double error[2];
    for (int level = 0; level < 2; ++level) {
      const MeshMass found = mass_properties(triangulate(body.shape, 16 << level), 1.0);
      error[level] = (found.inertia - body.inertia.asDiagonal().toDenseMatrix()).norm() / body.inertia.norm();
      CHECK_THAT(found.centre_of_mass.norm(), WithinAbs(0.0, rounding));
    }
    // Falls by 4; 0.1 allows for the next term of the expansion, of relative size 1/16^2 times some ten.
    CHECK_THAT(std::log2(error[0] / error[1]), WithinAbs(2.0, 0.1));
    CHECK(error[1] < 6e-3);  // chords of a circle in 128 parts lack 0.16 % of its area, a solid's inertia up to 5/2 times that
  }
}

TEST_CASE("mass properties go along when a body is moved and turned", "[mass_properties][invariance]") {
  const TriangleMesh mesh = triangulate(Teardrop{0.4, 1.1}, 6);
  const Matrix3d turn = Eigen::AngleAxisd(1.1, Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
  // At 1000 m coordinates have 1e-13 of the body's size left, and its thickness 1e-12.
  for (const auto& [shift, tolerance] : {std::pair{Vector3d(3, -4, 5), 1e-12}, {Vector3d(1000, 500, -800), 1e-10}})
    for (const bool skin : {false, true}) {
      const auto of = [skin](const TriangleMesh& m) { return skin ? sheet_mass_properties(m, 0.3) : mass_properties(m, 300); };
      MeshMass expected = of(mesh);
      expected.inertia = turn * expected.inertia * turn.transpose();
      expected.centre_of_mass = turn * expected.centre_of_mass + shift;
      check_same(of(transformed(mesh, turn, shift)), expected, tolerance);
    }
}

TEST_CASE("two bodies together obey the parallel-axis theorem", "[mass_properties][analytic]") {
  const TriangleMesh one = triangulate(Box{1.0, 0.5, 0.2}, 2);
  const TriangleMesh two = transformed(triangulate(Cylinder{0.3, 0.7}, 4), Matrix3d::Identity(), {2.0, 1.0, -0.5});
  const MeshMass a = mass_properties(one, 500), b = mass_properties(two, 500);
  MeshMass expected;
  expected.mass = a.mass + b.mass;
  expected.centre_of_mass = (a.mass * a.centre_of_mass + b.mass * b.centre_of_mass) / expected.mass;
  for (const MeshMass& part : {a, b}) {
    const Vector3d d = part.centre_of_mass - expected.centre_of_mass;
    expected.inertia += part.inertia + part.mass * (d.squaredNorm() * Matrix3d::Identity() - d * d.transpose());
  }
  check_same(mass_properties(joined(one, two), 500), expected, rounding);
}

TEST_CASE("a shell wound inwards is a cavity", "[mass_properties][analytic]") {
  const TriangleMesh hollow = joined(triangulate(Box{2, 2, 2}, 1), turned_inside_out(triangulate(Box{1, 1, 1}, 1)));
  const MeshMass found = mass_properties(hollow, 10);
  CHECK_THAT(found.mass, WithinRel(70.0, rounding));
  CHECK_THAT(found.inertia(0, 0), WithinRel(10.0 / 6 * (32 - 1), rounding));
}

TEST_CASE("a steel ball found from its mesh steps as it should", "[mass_properties]") {
  const MeshMass ball = mass_properties(triangulate(Sphere{0.1}, 16), 7850);
  const Vector6d weight = (Vector6d() << 0, 0, -9.81 * ball.mass, 0, 0, 0).finished();
  // No air: v = g t to rounding.
  CHECK_THAT(step_secant_implicit(Matrix6d::Zero(), ball, {}, weight, 0.5)[2], WithinRel(-4.905, 1e-14));
}

TEST_CASE("meshes that enclose no solid are refused with the reason", "[mass_properties][hard]") {
  const TriangleMesh box = triangulate(Box{1, 1, 1}, 1);
  TriangleMesh open = box;
  open.triangles.pop_back();
  CHECK_THROWS_WITH(mass_properties(open, 1), Contains("edges = 3") && Contains("close the holes"));
  CHECK_THROWS_WITH(mass_properties(turned_inside_out(box), 1), Contains("volume = -") && Contains("inside out"));
  TriangleMesh twisted = box;
  std::swap(twisted.triangles[0][1], twisted.triangles[0][2]);
  CHECK_THROWS_WITH(mass_properties(twisted, 1), Contains("inconsistent winding = 3"));
  CHECK_THROWS_WITH(mass_properties({}, 1), Contains("no triangles"));
  CHECK_THROWS_WITH(mass_properties(box, 0.0), Contains("density = 0"));
  CHECK_THROWS_WITH(mass_properties(box, NAN), Contains("density"));
  const TriangleMesh flat = transformed(box, Vector3d(1, 1, 0).asDiagonal().toDenseMatrix(), Vector3d::Zero());
  CHECK_THROWS_WITH(mass_properties(flat, 1), Contains("volume = 0") && Contains("sheet_mass_properties"));
  CHECK_THROWS_WITH(sheet_mass_properties({}, 1), Contains("no triangles"));
  CHECK_THROWS_WITH(sheet_mass_properties(transformed(box, Matrix3d::Zero(), Vector3d::Zero()), 1), Contains("area of the mesh = 0"));
  // Found by the fuzzer: a mass that underflows to zero came back as if it were one.
  CHECK_THROWS_AS(mass_properties(transformed(box, 1e-3 * Matrix3d::Identity(), Vector3d::Zero()), 1e-320), std::overflow_error);
  CHECK_THROWS_AS(sheet_mass_properties(transformed(box, 1e120 * Matrix3d::Identity(), Vector3d::Zero()), 1.0), std::overflow_error);
  TriangleMesh wild = box;
  wild.triangles[3][1] = 99;
  CHECK_THROWS_WITH(sheet_mass_properties(wild, 1), Contains("vertex 99"));
}

TEST_CASE("recentred puts the centre of mass, or the point given, at the origin", "[mass_properties]") {
  for (const Shape& shape : {Shape(Prism{1.0, 0.7, 0.4}), Shape(Plate{1.0, 2.0, 0.0})}) {
    const TriangleMesh away = transformed(triangulate(shape, 3), Matrix3d::Identity(), {5, 6, 7});
    const TriangleMesh back = recentred(away);
    const bool sheet = kind(shape) == "plate";
    const MeshMass found = sheet ? sheet_mass_properties(back, 1) : mass_properties(back, 1);
    CHECK_THAT(found.centre_of_mass.norm(), WithinAbs(0.0, 1e-14));  // rounding of coordinates of some metres, averaged
    CHECK(recentred(away, {5, 6, 7}).vertices[2].isApprox(triangulate(shape, 3).vertices[2], 1e-14));
  }
  CHECK_THROWS_WITH(recentred(triangulate(Box{}, 1), {0, INFINITY, 0}), Contains("origin"));
  CHECK(recentred(TriangleMesh{}).triangles.empty());
}
