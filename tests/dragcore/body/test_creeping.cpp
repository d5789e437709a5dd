// Stokes' resistance of a part: that of the ellipsoid whose surface has the same second moments.

#include <Eigen/Eigenvalues>
#include <catch2/catch.hpp>
#include <dragcore/fluid_terms.hpp>
#include <numbers>

#include "body/creeping.hpp"
#include "tests/support/zoo.hpp"

using namespace dragcore;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using std::numbers::pi;

namespace {

const CreepingResistance& resistance_of(const Surface& surface) { return surface.parts[0].creeping; }

}  // namespace

TEST_CASE("ellipsoids have their own resistance, as the triangles get finer", "[creeping][analytic][convergence]") {
  for (const Ellipsoid& shape : {Ellipsoid{0.5, 0.5, 0.5}, Ellipsoid{1.25, 0.5, 0.5}, Ellipsoid{0.2, 0.5, 0.5}, Ellipsoid{0.8, 0.5, 0.3}}) {
    const Matrix6d exact = stokes_resistance({shape}, Vector3d::Zero(), 1.0);
    double previous = 0.0;
    for (const int divisions : {8, 16, 32}) {
      const CreepingResistance& found = resistance_of(zoo::surface(shape, divisions));
      const double error = std::max((found.drag - exact.topLeftCorner<3, 3>()).norm() / exact.topLeftCorner<3, 3>().norm(),
                                    (found.turning - exact.bottomRightCorner<3, 3>()).norm() / exact.bottomRightCorner<3, 3>().norm());
      if (previous > 0.0) CHECK(error < previous / 3.0);  // second order: 4
      previous = error;
    }
    CHECK(previous < 2e-3);  // of the facets: 1.6e-3 for the ball's torque, which goes with the cube of its size
  }
}

TEST_CASE("a thin disc resists as Oberbeck's, broadside and edge-on, and a cube within 3 %", "[creeping][analytic]") {
  const CreepingResistance& disc = resistance_of(Surface(triangulate(Cylinder{.diameter = 1.0, .length = 1e-3}, 32)));
  // 16 a broadside, 32/3 a edge-on, 32/3 a^3 about any axis [lamb_1932] art. 339. Rim and facets: 1 %.
  CHECK(disc.drag(0, 0) == Approx(8.0).epsilon(0.01));
  CHECK(disc.drag(1, 1) == Approx(16.0 / 3.0).epsilon(0.01));
  for (int axis = 0; axis < 3; ++axis) CHECK(disc.turning(axis, axis) == Approx(4.0 / 3.0).epsilon(0.01));
  // The radius of the ball that resists as a unit cube lies between those of its inscribed and circumscribed balls; the 4 % above
  // the truth for the isotropic traction, l/2 = sqrt(6/pi)/2 = 0.691, puts it at 0.664.
  CHECK(resistance_of(zoo::surface(Box{}, 1)).drag(0, 0) / (6.0 * pi) == Approx(0.664).epsilon(0.03));
}

TEST_CASE("creeping resistance turns, moves and scales with the body, and does not know the triangulation", "[creeping][invariance]") {
  zoo::Random random(7);
  for (const Shape& shape : zoo::shapes()) {
    const Surface coarse = zoo::surface(shape, 4);
    const Matrix3d turn = random.rotation();
    TriangleMesh moved = triangulate(shape, 4);
    for (Vector3d& v : moved.vertices) v = turn * (3.0 * v) + Vector3d(1, 2, 3);
    const Surface other(moved, zoo::sides_of(shape));
    const CreepingResistance &a = resistance_of(coarse), &b = resistance_of(other);
    INFO(kind(shape));
    CHECK((b.drag - 3.0 * turn * a.drag * turn.transpose()).norm() <= 1e-8 * b.drag.norm());
    CHECK((b.turning - 27.0 * turn * a.turning * turn.transpose()).norm() <= 1e-8 * b.turning.norm());
    CHECK((b.centre - turn * 3.0 * a.centre - Vector3d(1, 2, 3)).norm() <= 1e-12 * 10.0);
    CHECK(Eigen::SelfAdjointEigenSolver<Matrix3d>(a.drag).eigenvalues()[0] > 0.0);
    CHECK(Eigen::SelfAdjointEigenSolver<Matrix3d>(a.turning).eigenvalues()[0] > 0.0);
  }
  const CreepingResistance &coarse = resistance_of(zoo::surface(Box{.length = 2.0}, 1)), &fine = resistance_of(zoo::surface(Box{.length = 2.0}, 7));
  CHECK((coarse.drag - fine.drag).norm() <= 1e-10 * fine.drag.norm());
}

TEST_CASE("semi-axes come back from the moments of the surface, down to a disc and a needle", "[creeping][limit]") {
  // A disc has a^2/4, the surface of a needle a^2/4 along and 3/8 b^2 across, a ball a^2/3.
  const auto check = [](const Vector3d& moments, const Vector3d& semi, double tolerance) {
    CHECK((semi_axes_of(moments) - semi).norm() <= tolerance * semi.norm());
  };
  check({0.25, 0.25, 0.0}, {1.0, 1.0, 0.0}, 1e-3);
  check({0.25, 3.0 / 8.0 * 1e-4, 3.0 / 8.0 * 1e-4}, {1.0, 0.01, 0.01}, 2e-3);
  check(Vector3d::Constant(1.0 / 3.0), Vector3d::Ones(), 1e-9);
  CHECK(semi_axes_of(Vector3d::Zero()).isZero(0.0));
}
