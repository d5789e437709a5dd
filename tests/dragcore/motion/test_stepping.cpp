#include <Eigen/Dense>
#include <catch2/catch.hpp>
#include <cmath>
#include <dragcore/fluid_terms.hpp>
#include <dragcore/stepping.hpp>

#include "tests/support/zoo.hpp"

using namespace dragcore;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;
using Eigen::Vector3d;

namespace {

struct Light {
  Shape shape;
  MassProperties body;
};

/// Paper of 80 g/m^2, a leaf, foam, steel.
std::vector<Light> bodies() {
  const auto flat = [](double mass, double a) {
    return MassProperties{mass, Vector3d(mass * a * a / 12, mass * a * a / 12, mass * a * a / 6).asDiagonal()};
  };
  return {{Plate{0.1, 0.1, 0.0}, flat(8e-4, 0.1)},
          {Plate{0.055, 0.055, 0.0}, flat(2e-4, 0.055)},
          {Box{0.1, 0.1, 0.1}, {0.02, 0.02 * 0.01 / 6 * Eigen::Matrix3d::Identity()}},
          {Box{0.1, 0.1, 0.1}, {7.8, 7.8 * 0.01 / 6 * Eigen::Matrix3d::Identity()}}};
}

double energy(const MassProperties& body, const Vector6d& v) { return 0.5 * v.dot(body.matrix() * v); }
Vector6d six(const Vector3d& linear, const Vector3d& angular) { return (Vector6d() << linear, angular).finished(); }
Vector6d air(const Motion& m) { return six(m.wind, Vector3d::Zero()); }
Vector6d of(const Motion& m) { return six(m.velocity, m.angular_velocity); }

}  // namespace

TEST_CASE("the secant matrix times the velocity relative to the air is the wrench, and is symmetric and not negative",
          "[stepping][analytic]") {
  zoo::Random random(31);
  for (const Shape& shape : zoo::shapes())
    for (const Model& model : zoo::models()) {
      const Surface surface = zoo::surface(shape, 2);
      const Motion motion = random.motion(2.0, 3.0);
      const Matrix6d s = resistance(surface, motion, {}, model);
      const Wrench total = wrench(surface, motion, {}, model).total();
      CHECK((s * (air(motion) - of(motion)) - six(total.force, total.torque)).norm() <
            1e-12 * (1.0 + s.norm() * of(motion).norm()));  // rounding
      CHECK((s - s.transpose()).norm() == 0.0);
      CHECK(Eigen::SelfAdjointEigenSolver<Matrix6d>(s).eigenvalues().minCoeff() > -1e-14 * s.norm());
    }
}

TEST_CASE("the Jacobian is the derivative of the wrench", "[stepping][analytic]") {
  zoo::Random random(32);
  for (const Shape& shape : zoo::shapes())
    for (const Law& law : {note_law(), consistent_law(), scaled_law(0.8, 0.3)}) {
      const Surface surface = zoo::surface(shape, 2);
      const Motion motion = random.motion(2.0, 1.0);
      const Model model{.law = law};
      const Matrix6d jacobian = force_jacobian(surface, motion, {}, model);
      constexpr double step = 1e-6;  // central difference: error 1e-12 of curvature, 1e-10 of rounding; faces that cross edge-on add more
      for (int k = 0; k < 6; ++k) {
        const auto moved = [&](double by) {
          Motion m = motion;
          (k < 3 ? m.velocity[k] : m.angular_velocity[k - 3]) += by;
          const Wrench w = wrench(surface, m, {}, model).total();
          return six(w.force, w.torque);
        };
        CHECK(((moved(step) - moved(-step)) / (2 * step) - jacobian.col(k)).norm() < 1e-6 * (1.0 + jacobian.norm()));
      }
    }
}

TEST_CASE("energy relative to the wind never grows, whatever the time step", "[stepping][hard]") {
  zoo::Random random(33);
  for (const Light& light : bodies())
    for (const double dt : {1.0 / 240, 1.0 / 60, 1.0 / 15, 1.0, 100.0})
      for (int update = 0; update < 3; ++update) {
        const Surface surface = zoo::surface(light.shape, 2);
        Motion motion{.wind = random.vector(5.0), .velocity = random.vector(15.0), .angular_velocity = random.vector(40.0)};
        const Model model{.pillow = {PillowForm::tilt, 0.8}};
        double before = energy(light.body, of(motion) - air(motion));
        for (int step = 0; step < 60; ++step) {
          Vector6d v;
          if (update < 2) {
            const Matrix6d s = resistance(surface, motion, {}, model);
            v = update == 0 ? step_secant_implicit(s, light.body, motion, Vector6d::Zero(), dt)
                            : step_scalar_implicit(s, light.body, motion, Vector6d::Zero(), dt);
          } else {
            const Wrench w = wrench(surface, motion, {}, model).total();
            v = of(motion) + impulse_share(w, light.body, motion, dt) * dt * light.body.matrix().llt().solve(six(w.force, w.torque));
          }
          motion.velocity = v.head<3>();
          motion.angular_velocity = v.tail<3>();
          const double after = energy(light.body, v - air(motion));
          REQUIRE(after <= before * (1.0 + 1e-12) + 1e-300);  // rounding of the solve
          before = after;
        }
      }
}

TEST_CASE("explicit steps of paper explode where the implicit ones stand", "[stepping][regression]") {
  const Light paper = bodies()[0];
  const Surface surface = zoo::surface(paper.shape, 2);
  Motion motion{.velocity = Vector3d(0, 0, 15)};
  const double before = energy(paper.body, of(motion));
  for (int step = 0; step < 5; ++step) {
    const Wrench w = wrench(surface, motion, {}, {}).total();
    motion.velocity += w.force / paper.body.mass / 30.0;  // z = k v dt = 3.8: beyond 2 every step gains energy
  }
  CHECK_FALSE(energy(paper.body, of(motion)) < before);
}

TEST_CASE("terminal velocity is an exact fixed point of every implicit update", "[stepping][analytic]") {
  for (const Light& light : bodies()) {
    const Surface surface = zoo::surface(light.shape, 2);
    // Face-on the note's law has C_N = 1: m g = rho A v^2 / 2.
    const double area = surface.patches[0].area, g = 9.81, v = std::sqrt(2 * light.body.mass * g / (1.225 * area));
    const Motion motion{.velocity = Vector3d(0, 0, -v)};
    const Vector6d weight = six(Vector3d(0, 0, -light.body.mass * g), Vector3d::Zero());
    const Matrix6d s = resistance(surface, motion, {}, {});
    for (const double dt : {1.0 / 240, 1.0, 100.0}) {
      CHECK((step_secant_implicit(s, light.body, motion, weight, dt) - of(motion)).norm() <
            1e-9 * v);  // conditioning of M + dt S: 1e5 at 100 s
      CHECK((step_scalar_implicit(s, light.body, motion, weight, dt) - of(motion)).norm() < 1e-9 * v);
    }
  }
}

TEST_CASE("the secant step solves straight fall along the flow exactly", "[stepping][analytic]") {
  // 1-D: v' = v / (1 + k v dt) is the exact solution of dv/dt = -k v^2.
  const Light foam = bodies()[2];
  const Motion motion{.velocity = Vector3d(8, 0, 0)};
  const double k = 0.5 * 1.225 * 0.01 / foam.body.mass;
  const Vector6d v =
      step_secant_implicit(resistance(zoo::surface(foam.shape, 1), motion, {}, {}), foam.body, motion, Vector6d::Zero(), 0.5);
  CHECK_THAT(v[0], WithinRel(8.0 / (1 + k * 8.0 * 0.5), 1e-12));
}

TEST_CASE("spin by inertia alone keeps its energy at any time step, the size of its momentum at short ones, and follows Euler's equations",
          "[stepping][energy][analytic]") {
  zoo::Random random(53);
  const MassProperties bar{.mass = 0.3, .inertia = Vector3d(4.25e-5, 2.27e-3, 2.31e-3).asDiagonal()};  // 30 x 5 x 4 cm
  for (const double dt : {1e-3, 1.0 / 60, 0.5, 100.0})
    for (int i = 0; i < 50; ++i) {
      Vector3d spin = random.vector(40.0);
      const double energy_before = spin.dot(bar.inertia * spin), momentum_before = (bar.inertia * spin).norm();
      for (int step = 0; step < 200; ++step) spin = gyroscopic_spin(bar, spin, dt);
      CHECK(spin.dot(bar.inertia * spin) == Approx(energy_before).epsilon(1e-10));  // rounding of 200 solves
      if (dt == 1e-3)
        CHECK((bar.inertia * spin).norm() ==
              Approx(momentum_before).epsilon(1e-5));  // four iterations, each gains a factor of about spin dt / 2
    }
  // Regression: the midpoint rule solved as a linear system lost its digits above 1e12 radians a step, and was no number at 1e18.
  const Eigen::Matrix3d turned = random.rotation();
  MassProperties oblique = bar, needle = bar;
  oblique.inertia = turned * bar.inertia * turned.transpose();
  needle.inertia = turned * Vector3d(1e-14, 1.0, 1.0).asDiagonal() * turned.transpose();
  for (const MassProperties& body : {bar, oblique, needle})
    for (const double size : {1e-150, 1e-3, 1e6, 1e12, 1e18, 1e100})
      for (const double dt : {1e-30, 1.0 / 60, 1e30}) {
        const Vector3d spin = size * random.vector(1.0), after = gyroscopic_spin(body, spin, dt);
        INFO("spin " << size << " rad/s, dt " << dt << " s");
        CHECK(
            (after / size).dot(body.inertia * (after / size)) ==
            Approx((spin / size).dot(body.inertia * (spin / size))).epsilon(1e-14));  // rounding of a rotation and of the roots of inertia
        if (size * dt < 1e-20) CHECK(after == spin);
      }
  // A symmetric top precesses in body axes at (I_3 - I_1)/I_1 omega_3, exactly.
  const MassProperties top{.mass = 1.0, .inertia = Vector3d(2.0, 2.0, 3.0).asDiagonal()};
  Vector3d spin(0.3, 0.0, 4.0);
  const int steps = 1000;
  for (int step = 0; step < steps; ++step) spin = gyroscopic_spin(top, spin, 1.0 / steps);
  const double phase = 0.5 * 4.0;
  CHECK(spin.x() == Approx(0.3 * std::cos(phase)).margin(1e-6));
  CHECK(spin.y() == Approx(0.3 * std::sin(phase)).margin(1e-6));
  CHECK(spin.z() == Approx(4.0).epsilon(1e-12));
  CHECK(gyroscopic_spin(top, {0, 0, 4}, 1.0) == Vector3d(0, 0, 4));  // about a principal axis nothing happens
}

TEST_CASE("a tumbling bar never gains energy in the loop of gyroscopic_spin and the secant step", "[stepping][energy]") {
  zoo::Random random(54);
  const Surface surface = zoo::surface(Box{0.3, 0.05, 0.03}, 1);
  const MassProperties bar{
      .mass = 0.3,
      .inertia =
          0.3 / 12 * Vector3d(0.05 * 0.05 + 0.03 * 0.03, 0.3 * 0.3 + 0.03 * 0.03, 0.3 * 0.3 + 0.05 * 0.05).asDiagonal().toDenseMatrix()};
  const Model model = model_for(surface);
  for (const double dt : {1.0 / 240, 1.0 / 60, 0.1})
    for (int i = 0; i < 20; ++i) {
      Motion motion{.velocity = random.vector(3.0), .angular_velocity = 30.0 * random.vector(1.0).normalized()};
      Eigen::Quaterniond rotation(random.rotation());
      for (int step = 0; step < 180; ++step) {
        const double before = energy(bar, of(motion));
        motion.angular_velocity = gyroscopic_spin(bar, motion.angular_velocity, dt);
        const Vector6d v = step_secant_implicit(resistance(surface, motion, {}, model), bar, motion, Vector6d::Zero(), dt);
        REQUIRE(energy(bar, v) <= before * (1 + 1e-12));
        // To the world and back into the turned frame, as an engine does.
        const Vector3d velocity = rotation * v.head<3>(), spin = rotation * v.tail<3>();
        rotation = (Eigen::AngleAxisd(spin.norm() * dt, spin.normalized()) * rotation).normalized();
        motion.velocity = rotation.inverse() * velocity, motion.angular_velocity = rotation.inverse() * spin;
        REQUIRE(energy(bar, of(motion)) <= before * (1 + 1e-12));
      }
    }
}

TEST_CASE("air carried along slows a light body's start, changes no terminal velocity and keeps the bound of energy",
          "[stepping][analytic]") {
  // A balloon of 0.3 m: its air weighs 17 g, half of which it carries along.
  const double a = 0.15, rho = 1.225, m = 0.005, carried = rho * 2.0 / 3.0 * std::numbers::pi * a * a * a;
  MassProperties balloon{m, 0.4 * m * a * a * Eigen::Matrix3d::Identity()};
  balloon.added = added_mass({.shape = {a, a, a}}, Vector3d::Zero(), {.density = rho});
  CHECK_THAT(balloon.matrix()(2, 2), WithinRel(m + carried, 1e-12));
  const Surface surface = zoo::surface(Sphere{.diameter = 2 * a}, 6);
  const Model model = zoo::exactly(model_for(surface));
  const Vector6d lift = six({0, 0, (2.0 * carried - m) * 9.81}, Vector3d::Zero());
  const double dt = 1e-6;  // drag of the start is of order dt^2
  const Vector6d started = step_secant_implicit(resistance(surface, {}, {rho}, model), balloon, {}, lift, dt);
  CHECK_THAT(started[2] / dt, WithinRel(lift[2] / (m + carried), 1e-9));
  MassProperties bare = balloon;
  bare.added.setZero();
  Motion with, without;
  const auto step = [&](Motion& motion, const MassProperties& body) {
    const Vector6d v = step_secant_implicit(resistance(surface, motion, {rho}, model), body, motion, lift, 0.05);
    motion.velocity = v.head<3>(), motion.angular_velocity = v.tail<3>();
  };
  for (int i = 0; i < 2000; ++i) step(with, balloon), step(without, bare);
  CHECK_THAT(with.velocity.z(), WithinRel(without.velocity.z(), 1e-9));  // both have come to rest on their fixed point
  // Of body and carried air, with any symmetric added mass.
  zoo::Random random(47);
  for (const Light& light : bodies())
    for (const double dt_long : {1.0 / 240, 1.0 / 15, 1.0, 100.0}) {
      MassProperties body = light.body;
      body.added = added_mass({.shape = {0.05, 0.05, 0.002}, .axes = random.rotation()}, random.vector(0.02), {});
      const Motion motion = random.motion(8.0, 20.0);
      const Surface there = zoo::surface(light.shape, 2);
      Motion here = motion;
      here.reference_point.setZero();
      const Vector6d before = of(here) - air(here),
                     v = step_secant_implicit(resistance(there, here, {}, model), body, here, Vector6d::Zero(), dt_long) - air(here);
      CHECK(energy(body, v) <= energy(body, before) * (1 + 1e-12));  // rounding
    }
  balloon.added(0, 0) = -1.0;
  CHECK_THROWS_WITH(balloon.matrix(), Catch::Contains("added mass") && Catch::Contains("positive semidefinite"));
}

TEST_CASE("mass properties and time steps out of range are refused", "[stepping][hard]") {
  CHECK_THROWS_WITH((MassProperties{.mass = 0.0}.matrix()), Catch::Contains("mass = 0"));
  CHECK_THROWS_WITH((MassProperties{.mass = 1.0}.matrix()), Catch::Contains("must be set") && Catch::Contains("positive definite"));
  CHECK_THROWS_WITH((MassProperties{.mass = 1.0, .inertia = Vector3d(1, 1, 2.1).asDiagonal()}.matrix()),
                    Catch::Contains("larger than the sum"));
  CHECK_THROWS_WITH(step_secant_implicit(Matrix6d::Zero(), {}, {}, Vector6d::Zero(), -1.0), Catch::Contains("dt = -1"));
  const Vector6d poisoned = Vector6d::Constant(std::nan(""));
  CHECK_THROWS_WITH(step_secant_implicit(Matrix6d::Zero(), {}, {}, poisoned, 1.0), Catch::Contains("must be finite"));
  CHECK_THROWS_WITH(step_scalar_implicit(Matrix6d::Zero(), {}, {}, poisoned, 1.0), Catch::Contains("must be finite"));
  CHECK_THROWS_WITH(impulse_share({.force = poisoned.head<3>()}, {}, {}, 1.0), Catch::Contains("must be finite"));
}

TEST_CASE("a cube that spins about its vertical axis slows down for ever and never gains energy", "[stepping][limit]") {
  const Surface cube = zoo::surface(Box{}, 1);
  const MassProperties body{.mass = 0.1, .inertia = 0.1 / 6 * Eigen::Matrix3d::Identity()};
  for (const Law& law : {note_law(), closed_law()}) {
    Motion motion{.angular_velocity = {0.0, 0.0, 40.0}};
    double energy = 1e9;
    for (int i = 0; i < 20000; ++i) {
      const Vector6d next = step_secant_implicit(resistance(cube, motion, {}, {.law = law}), body, motion, Vector6d::Zero(), 1.0 / 60);
      motion.velocity = next.head<3>();
      motion.angular_velocity = next.tail<3>();
      const double now = 0.5 * next.dot(body.matrix() * next);
      REQUIRE(now < energy);
      energy = now;
    }
    // d omega/dt = -k omega^2: 1/omega grows linearly. k = |M_z| / (I omega^2) at unit spin, by the same rule.
    const double k = -wrench(cube, {.angular_velocity = {0.0, 0.0, 1.0}}, {}, {.law = law}).total().torque.z() / body.inertia(2, 2);
    CHECK(motion.velocity.norm() < 1e-12);
    CHECK_THAT(1.0 / motion.angular_velocity.z(),
               Catch::Matchers::WithinRel(1.0 / 40 + k * 20000.0 / 60,
                                          0.05));  // the diagonals of 12 triangles tilt the torque by 5 %, and the spin with it
  }
}
