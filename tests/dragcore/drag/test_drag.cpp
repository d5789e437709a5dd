#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>

#include "tests/support/zoo.hpp"

using namespace dragcore;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// Largest difference of two wrenches relative to the size of the first, length 1.
double difference(const Wrench& a, const Wrench& b) {
  const double size = a.force.norm() + a.torque.norm();
  return ((a.force - b.force).norm() + (a.torque - b.torque).norm()) / (size > 0.0 ? size : 1.0);
}

Motion rotated(const Matrix3d& R, const Motion& m) { return {R * m.wind, R * m.velocity, R * m.angular_velocity, R * m.reference_point}; }

}  // namespace

TEST_CASE("the prepared surface gives the wrench of the reference, term by term", "[drag][backend]") {
  zoo::Random random(1);
  for (const Shape& shape : zoo::shapes()) {
    const TriangleMesh mesh = triangulate(shape, 3);
    const Surface surface(mesh, zoo::sides_of(shape));
    for (const Model& model : zoo::models())
      for (const double spin : {0.0, 4.0}) {
        const Motion motion = random.motion(2.0, spin);
        const WrenchByTerm fast = wrench(surface, motion, {}, model),
                           plain = reference::wrench(mesh, zoo::sides_of(shape), motion, {}, model);
        INFO(kind(shape) << ", law " << model.law.name << ", pillow " << to_string(model.pillow.form) << ", spin " << spin);
        // Rounding of about 100 terms that partly cancel; the reference samples more points than the fast path where there is no spin.
        CHECK(difference(plain.total(), fast.total()) < 1e-12);
        for (std::size_t term = 0; term < fast.terms.size(); ++term)
          CHECK((fast.terms[term].force - plain.terms[term].force).norm() < 1e-12 * (1.0 + plain.total().force.norm()));
      }
  }
}

TEST_CASE("turning everything turns the wrench", "[drag][invariance]") {
  zoo::Random random(2);
  for (const Shape& shape : zoo::shapes())
    for (const Model& model : zoo::models()) {
      const TriangleMesh mesh = triangulate(shape, 2);
      const Matrix3d R = random.rotation();
      const Motion motion = random.motion(2.0, 3.0);
      const Wrench before = wrench(Surface(mesh, zoo::sides_of(shape)), motion, {}, model).total();
      const Wrench after =
          wrench(Surface(transformed(mesh, R, Vector3d::Zero()), zoo::sides_of(shape)), rotated(R, motion), {}, model).total();
      CHECK(difference({R * before.force, R * before.torque}, after) <
            1e-11);  // rounding of the rotation, amplified where faces are nearly edge-on
    }
}

TEST_CASE("mirroring everything mirrors force and reverses torque as an axial vector", "[drag][invariance]") {
  zoo::Random random(3);
  const Matrix3d mirror = Vector3d(1, -1, 1).asDiagonal();
  for (const Shape& shape : zoo::shapes())
    for (const Model& model : zoo::models()) {
      const TriangleMesh mesh = triangulate(shape, 2);
      const Motion motion = random.motion(2.0, 3.0);
      Motion image = rotated(mirror, motion);
      image.angular_velocity = -image.angular_velocity;  // axial
      const Wrench before = wrench(Surface(mesh, zoo::sides_of(shape)), motion, {}, model).total();
      const Wrench after = wrench(Surface(transformed(mesh, mirror, Vector3d::Zero()), zoo::sides_of(shape)), image, {}, model).total();
      CHECK(difference({mirror * before.force, -(mirror * before.torque)}, after) < 1e-11);
    }
}

TEST_CASE("moving the body and its reference point leaves the wrench alone", "[drag][invariance]") {
  zoo::Random random(4);
  for (const Model& model : zoo::models()) {
    const TriangleMesh mesh = triangulate(Cone{}, 3);
    Motion motion = random.motion(2.0, 3.0);
    const Wrench before = wrench(Surface(mesh), motion, {}, model).total();
    const Vector3d shift(3.0, -2.0, 5.0);
    motion.reference_point += shift;
    CHECK(difference(before, wrench(Surface(transformed(mesh, Matrix3d::Identity(), shift)), motion, {}, model).total()) < 1e-11);
  }
}

TEST_CASE("another torque point changes the torque by the lever and nothing else", "[drag][invariance]") {
  zoo::Random random(5);
  const Surface surface = zoo::surface(Box{2.0, 1.0, 0.6}, 2);
  for (const Model& model : zoo::models()) {
    const Motion motion = random.motion(2.0, 3.0);
    Motion moved = motion;
    const Vector3d lever(0.4, 0.1, -0.7);
    moved.reference_point += lever;
    moved.velocity += motion.angular_velocity.cross(lever);  // the same rigid motion
    const Wrench a = wrench(surface, motion, {}, model).total(), b = wrench(surface, moved, {}, model).total();
    CHECK(difference({a.force, a.torque - lever.cross(a.force)}, b) < 1e-12);
  }
}

TEST_CASE("only the velocity relative to the air matters", "[drag][invariance]") {
  zoo::Random random(6);
  const Surface surface = zoo::surface(Teardrop{}, 3);
  for (const Model& model : zoo::models()) {
    Motion motion = random.motion(2.0, 3.0);
    const Wrench before = wrench(surface, motion, {}, model).total();
    motion.wind += Vector3d(8, -4, 16);  // powers of two: hardly any rounding
    motion.velocity += Vector3d(8, -4, 16);
    CHECK(difference(before, wrench(surface, motion, {}, model).total()) < 1e-13);
  }
}

TEST_CASE("splitting triangles leaves the wrench of a body that does not spin alone", "[drag][invariance]") {
  zoo::Random random(8);
  for (const Law& law : {note_law(), scaled_law(0.76, 0.4)})
    for (const PillowForm form : {PillowForm::none, PillowForm::patch, PillowForm::tilt}) {
      const Motion motion = random.motion(2.0, 0.0);
      const Model model{.law = law, .pillow = {form, form == PillowForm::none ? 0.0 : 0.8}};
      CHECK(difference(wrench(zoo::surface(Box{2, 1, 0.5}, 1), motion, {}, model).total(),
                       wrench(zoo::surface(Box{2, 1, 0.5}, 24), motion, {}, model).total()) < 1e-12);
    }
}

TEST_CASE("a body s times larger feels s^2 the force and s^3 the torque, a wind v times faster v^2 of both", "[drag][limit]") {
  zoo::Random random(9);
  for (const Shape& shape : {Shape(Cone{}), Shape(Plate{1, 1, 0}), Shape(Box{2, 1, 0.5})})
    for (const Model& model : zoo::models()) {
      const TriangleMesh mesh = triangulate(shape, 2);
      const Motion motion = random.motion(1.0, 1.0);
      const Wrench unit = wrench(Surface(mesh, zoo::sides_of(shape)), motion, {}, model).total();
      for (const double s : {1e-6, 1e-3, 1.0, 1e3, 1e6})
        for (const double v : {1e-6, 1e-3, 1.0, 1e3, 1e6}) {
          const Motion scaled{v * motion.wind, v * motion.velocity, v / s * motion.angular_velocity, s * motion.reference_point};
          const Wrench found =
              wrench(Surface(transformed(mesh, s * Matrix3d::Identity(), Vector3d::Zero()), zoo::sides_of(shape)), scaled, {}, model)
                  .total();
          CHECK(difference(unit, {found.force / (s * s * v * v), found.torque / (s * s * s * v * v)}) < 1e-11);
        }
    }
}

TEST_CASE("in still air the power of the air on a body is never positive", "[drag][invariance]") {
  zoo::Random random(10);
  for (const Shape& shape : zoo::shapes()) {
    const Surface surface = zoo::surface(shape, 2);
    for (const Model& model : zoo::models())
      for (int trial = 0; trial < 20; ++trial) {
        Motion motion = random.motion(1.0, trial % 2 ? 1.0 : 30.0);
        motion.wind.setZero();
        const Wrench total = wrench(surface, motion, {}, model).total();
        const double power = total.force.dot(motion.velocity) + total.torque.dot(motion.angular_velocity);
        // Each point's power is -p w <= 0; only the rounding of their sum may be positive.
        CHECK(power <= 1e-13 * (total.force.norm() * motion.velocity.norm() + total.torque.norm() * motion.angular_velocity.norm()));
      }
  }
}

TEST_CASE("a cube spinning about its axis is braked: the note's own example", "[drag][analytic]") {
  // Windward half of each of four faces: M = -4 rho omega^2 int_0^{1/2} x^3 (1 - x / (2 sqrt(x^2 + 1/4))) dx for side 1.
  double exact = 0.0;
  const int n = 20000;
  for (int i = 0; i < n; ++i) {
    const double x = 0.5 * (i + 0.5) / n;
    exact -= 4.0 * x * x * x * (1.0 - x / (2.0 * std::hypot(x, 0.5))) * 0.5 / n;
  }
  CHECK_THAT(exact, WithinAbs(-0.04328, 1e-5));
  const auto torque = [](int divisions, Quadrature order) {
    return wrench(zoo::surface(Box{1, 1, 1}, divisions), {.angular_velocity = Vector3d(0, 0, 1)}, {.density = 1.0}, {.quadrature = order})
        .total();
  };
  CHECK_THAT(torque(1, Quadrature::one).torque.z(), WithinAbs(-0.00780, 1e-4));   // what 12 triangles give by each rule: model.md, to the
  CHECK_THAT(torque(1, Quadrature::three).torque.z(), WithinAbs(-0.0383, 1e-4));  // digits quoted there
  CHECK_THAT(torque(1, Quadrature::six).torque.z(), WithinAbs(-0.0443, 1e-4));
  CHECK_THAT(torque(32, Quadrature::three).torque.z(), WithinRel(exact, 1e-3));  // (1/64)^2 of the pressure's curvature, and less
  CHECK(torque(4, Quadrature::three).force.norm() < 1e-15);
}

TEST_CASE("what has no size gives nothing, and nothing breaks", "[drag][hard]") {
  const Surface cube = zoo::surface(Box{1, 1, 1}, 2);
  const double denormal = std::numeric_limits<double>::denorm_min();
  for (const Model& model : zoo::models()) {
    CHECK(wrench(cube, {}, {}, model).total().force.isZero(0.0));
    CHECK(wrench(cube, {.wind = Vector3d(denormal, 0, 0)}, {}, model).total().force.allFinite());
    CHECK(wrench(cube, {.wind = Vector3d(1e-160, 1e-162, 0)}, {}, model).total().torque.allFinite());
    CHECK(wrench(cube, {.wind = Vector3d(0, 0, 1)}, {}, model).total().torque.allFinite());
    CHECK(wrench(cube, {.wind = Vector3d(0, std::nextafter(0.0, 1.0), 1)}, {}, model).total().torque.allFinite());
    CHECK(wrench(cube, {.angular_velocity = Vector3d(0, 0, 1e6)}, {}, model).total().torque.allFinite());
    CHECK(wrench(cube, {.wind = Vector3d(1, 0, 0)}, {.density = 0.0}, model).total().force.isZero(0.0));
  }
}

TEST_CASE("a force changes continuously as a face turns edge-on", "[drag][limit]") {
  const Surface sheet = zoo::surface(Plate{1, 1, 0}, 2);
  for (const Model& model : zoo::models()) {
    const auto force = [&](double angle) {
      return wrench(sheet, {.wind = Vector3d(std::cos(angle), 0, std::sin(angle))}, {.density = 2.0}, model).total().force.z();
    };
    CHECK(force(0.0) == 0.0);
    CHECK(std::abs(force(1e-9)) < 3e-9);  // at most 2 c (1 + suction) for the steepest law
    CHECK_THAT(force(1e-3), WithinAbs(-force(-1e-3), 1e-15));
  }
}

TEST_CASE("bad input is refused with the value found and the value needed", "[drag][hard]") {
  const Surface cube = zoo::surface(Box{1, 1, 1}, 1);
  CHECK_THROWS_WITH(wrench(cube, {}, {.density = -1.0}, {}), Catch::Contains("density = -1") && Catch::Contains("not negative"));
  CHECK_THROWS_WITH(wrench(cube, {.wind = Vector3d(0, std::nan(""), 0)}, {}, {}), Catch::Contains("motion.wind"));
  CHECK_THROWS_WITH(wrench(cube, {}, {}, {.pillow = {PillowForm::patch, 1.2}}), Catch::Contains("1.2") && Catch::Contains("0 to 1"));
  CHECK_THROWS_WITH(wrench(cube, {.wind = Vector3d(1e200, 0, 0)}, {}, {}), Catch::Contains("1e100"));
  CHECK_THROWS_WITH(wrench(cube, {}, {}, {.quadrature = static_cast<Quadrature>(2)}), Catch::Contains("= 2, but it must be 1, 3 or 6"));
  Model broken;
  broken.law.windward[2] = std::numeric_limits<double>::infinity();
  CHECK_THROWS_WITH(wrench(cube, {}, {}, broken), Catch::Contains("coefficient"));
}
