#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <dragcore/rotation_split.hpp>

#include "tests/support/zoo.hpp"

using namespace dragcore;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;
using Eigen::Vector3d;

namespace {

/// The same integrals by brute force on n x n sub-triangles with six points each; the pressure has a kink in slope where v_n = 0.
Wrench brute(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& omega, double share, int n) {
  const Vector3d normal = (b - a).cross(c - a).normalized(), centroid = (a + b + c) / 3;
  const double s = normal.cross(omega).norm() / omega.norm(), area = 0.5 * (b - a).cross(c - a).norm() / (n * n);
  Wrench sum;
  const auto add = [&](const Vector3d& p, const Vector3d& q, const Vector3d& r) {
    for (const Vector3d& at : {Vector3d((4 * p + q + r) / 6), Vector3d((p + 4 * q + r) / 6), Vector3d((p + q + 4 * r) / 6)}) {
      const double v = omega.cross(at - centroid).dot(normal);
      const Vector3d force = -(1 - s / 2) * v * v * (v > 0 ? 1.0 : -share) * area / 3 * normal;
      sum += {force, (at - centroid).cross(force)};
    }
  };
  const auto at = [&](int i, int j) { return Vector3d(a + (b - a) * i / n + (c - a) * j / n); };
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n - i; ++j) {
      add(at(i, j), at(i + 1, j), at(i, j + 1));
      if (j + 1 < n - i) add(at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
    }
  return sum;
}

}  // namespace

TEST_CASE("the mended closed form of a spinning triangle agrees with brute-force integration", "[rotation][analytic]") {
  zoo::Random random(41);
  for (int i = 0; i < 30; ++i) {
    const Vector3d a = random.vector(1), b = random.vector(1), c = random.vector(1), omega = random.vector(2);
    for (const double share : {0.0, 1.0}) {
      const Wrench exact = rotating_triangle(a, b, c, omega, 1.0, share), sum = brute(a, b, c, omega, share, 60);
      const double size = sum.force.norm() + sum.torque.norm();
      CHECK((exact.force - sum.force).norm() < 1e-4 * size);  // sub-triangles along the kink: (1/60)^2 of their strip, 1/60 wide
      CHECK((exact.torque - sum.torque).norm() < 1e-4 * size);
    }
  }
}

TEST_CASE("spin about the normal and no spin are free of singularities", "[rotation][hard]") {
  const Vector3d a(0, 0, 0), b(1, 0, 0), c(0, 1, 0);
  CHECK(rotating_triangle(a, b, c, Vector3d(0, 0, 3), 1.0, 1.0).torque.isZero(0.0));
  CHECK(rotating_triangle(a, b, c, Vector3d::Zero(), 1.0, 1.0).torque.isZero(0.0));
  // An edge along the axis: two corners at the same v_n.
  CHECK(rotating_triangle(a, b, c, Vector3d(1, 0, 0), 1.0, 0.0).torque.allFinite());
}

TEST_CASE("printed, the note's own example feels nothing; mended, a fine mesh brakes as it should", "[rotation][regression]") {
  const Motion motion{.angular_velocity = Vector3d(0, 0, 1)};
  const Surface coarse = zoo::surface(Box{1, 1, 1}, 1), fine = zoo::surface(Box{1, 1, 1}, 24);
  // E14: nothing but the motion of the centroids is left, which one point per triangle gives too.
  const double centroids_only = wrench(coarse, motion, {.density = 1.0}, {.quadrature = Quadrature::one}).total().torque.z();
  CHECK_THAT(rotation_split_wrench(coarse, motion, {.density = 1.0}, {RotationSplit::Formulas::printed, 1.0}).total().torque.z(),
             WithinRel(centroids_only, 1e-12));
  // With small triangles the centroid's own motion is everything and the split converges to the local law.
  CHECK_THAT(rotation_split_wrench(fine, motion, {.density = 1.0}, {}).total().torque.z(), WithinRel(-0.04328, 0.02));
}

TEST_CASE("without spin the split is the linear law", "[rotation][limit]") {
  const Surface cone = zoo::surface(Cone{}, 3);
  const Motion motion{.wind = Vector3d(1, 0.3, -0.2)};
  const Wrench split = rotation_split_wrench(cone, motion, {}, {}).total(), plain = wrench(cone, motion, {}, {}).total();
  CHECK((split.force - plain.force).norm() < 1e-14);
  CHECK((split.torque - plain.torque).norm() < 1e-14);
}
