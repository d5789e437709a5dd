#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <dragcore/follower.hpp>
#include <limits>
#include <numbers>
#include <random>

using namespace dragcore;
using Catch::Contains;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using std::numbers::pi;

namespace {

FollowerState after(const Follower& follower, FollowerState state, const Vector3d& wind, double dt, int steps) {
  for (int i = 0; i < steps; ++i) state = step(follower, state, wind, dt / steps);
  return state;
}

/// Angle between the nose, at -x of the body, and a direction.
double nose_angle(const FollowerState& state, const Vector3d& direction) {
  const Vector3d nose = -state.rotation.col(0);
  return std::atan2(nose.cross(direction).norm(), nose.dot(direction));
}

Follower weather_vane(const Vector3d& inertia) { return {.facing = Facing::into_wind, .inertia = inertia, .angular_drag = 2.0}; }

}  // namespace

TEST_CASE("without lag a follower moves as the note says, by gain times wind times time", "[dragcore][follower][errata]") {
  const Vector3d wind(3.0, -1.0, 0.5);
  const FollowerState start{.position = {1.0, 2.0, 3.0}, .velocity = {9.0, 9.0, 9.0}};
  const Vector3d expected = start.position + 0.7 * wind * 0.25;
  CHECK((step({.gain = 0.7, .lag = FollowerLag::none}, start, wind, 0.25).position - expected).norm() < 1e-15);
  for (const FollowerLag lag : {FollowerLag::linear, FollowerLag::quadratic}) {
    CHECK((step({.gain = 0.7, .lag = lag, .mass = 0.0}, start, wind, 0.25).position - expected).norm() < 1e-15);
    // tau -> 0: what is left of the old velocity moves it by tau times 10 m/s (quadratic: log(z)/k).
    double before = 1.0;
    for (const double mass : {1e-3, 1e-6, 1e-9, 1e-12}) {
      const double gap = (step({.gain = 0.7, .lag = lag, .mass = mass}, start, wind, 0.25).position - expected).norm();
      CHECK(gap < 100.0 * mass);
      CHECK(gap < before);
      before = gap;
    }
  }
}

TEST_CASE("one step of a second ends where 240 steps do", "[dragcore][follower][invariance]") {
  const Vector3d wind(6.0, -2.0, 1.0);
  const FollowerState start{.position = {1.0, 2.0, 3.0},
                            .velocity = {-4.0, 5.0, 0.0},
                            .rotation = Eigen::AngleAxisd(1.1, Vector3d(1, 2, -1).normalized()).toRotationMatrix()};
  for (const FollowerLag lag : {FollowerLag::none, FollowerLag::linear, FollowerLag::quadratic})
    for (const double mass : {1e-6, 0.01, 1.0, 100.0}) {
      const Follower follower{
          .gain = 0.8, .lag = lag, .mass = mass, .facing = Facing::into_wind, .inertia = {1.0, 0.3, 2.5}, .angular_drag = 2.0};
      const FollowerState once = step(follower, start, wind, 1.0), often = after(follower, start, wind, 1.0, 240);
      INFO("lag " << static_cast<int>(lag) << ", mass " << mass);
      // 240 roundings of numbers below 20: 240 * 20 * 1e-16 = 5e-13.
      CHECK((once.position - often.position).norm() < 1e-12);
      CHECK((once.velocity - often.velocity).norm() < 1e-12);
      CHECK((once.rotation - often.rotation).norm() < 1e-12);
    }
}

TEST_CASE("the lags are the exact solutions of their equations of motion", "[dragcore][follower][analytic]") {
  // Fourth-order Runge-Kutta with 4,000 steps: its error of order (1/4000)^4 is below rounding.
  const Vector3d wind(5.0, 1.0, -2.0);
  const FollowerState start{.velocity = {-3.0, 2.0, 4.0}};
  for (const FollowerLag lag : {FollowerLag::linear, FollowerLag::quadratic}) {
    const Follower follower{.gain = 0.9, .lag = lag, .mass = 0.5, .linear_drag = 0.8, .drag_area = 0.3};
    const auto acceleration = [&](const Vector3d& v) -> Vector3d {
      const Vector3d e = 0.9 * wind - v;
      return lag == FollowerLag::linear ? Vector3d(0.8 / 0.5 * e) : Vector3d(0.5 * 1.225 * 0.3 / 0.5 * e.norm() * e);
    };
    Vector3d v = start.velocity, r = Vector3d::Zero();
    const int steps = 4000;
    const double h = 2.0 / steps;
    for (int i = 0; i < steps; ++i) {
      const Vector3d a1 = acceleration(v), a2 = acceleration(v + 0.5 * h * a1), a3 = acceleration(v + 0.5 * h * a2),
                     a4 = acceleration(v + h * a3);
      r += h * v + h * h / 6.0 * (a1 + a2 + a3);
      v += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
    }
    const FollowerState end = step(follower, start, wind, 2.0);
    CHECK((end.velocity - v).norm() < 1e-12);
    CHECK((end.position - r).norm() < 1e-12);
  }
}

TEST_CASE("a follower never overtakes the wind, however long the step", "[dragcore][follower][invariance]") {
  const Vector3d wind(8.0, 0.0, 0.0);
  for (const FollowerLag lag : {FollowerLag::linear, FollowerLag::quadratic})
    for (const double dt : {1e-300, 1.0 / 240, 1.0, 100.0, 1e9})
      for (const double mass : {1e-300, 1e-6, 1.0, 1e6, 1e300}) {
        const FollowerState end = step({.lag = lag, .mass = mass}, {}, wind, dt);
        INFO("lag " << static_cast<int>(lag) << ", dt " << dt << ", mass " << mass);
        CHECK(end.velocity[0] >= 0.0);
        CHECK(end.velocity[0] <= 8.0);
        CHECK(end.position[0] >= -1e-15 * dt);
        CHECK(end.position[0] <= 8.0 * dt * (1 + 1e-15));
      }
}

TEST_CASE("a follower turns its nose into or away from the wind, by the shortest arc", "[dragcore][follower][sign]") {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 200; ++i) {
    const Vector3d wind = Vector3d(normal(random), normal(random), normal(random));
    const Vector3d upwind = -wind.normalized();
    const FollowerState start{
        .rotation = Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random)).normalized().toRotationMatrix()};
    Follower follower = weather_vane(Vector3d::Constant(3.0));  // time constant 1.5 s
    // Equal inertias: the angle itself shrinks by exp(-dt/tau) and the path is a great circle, so start, middle and end add up.
    const double angle = nose_angle(start, upwind);
    const FollowerState middle = step(follower, start, wind, 0.6);
    CHECK_THAT(nose_angle(middle, upwind), WithinAbs(angle * std::exp(-0.6 / 1.5), 1e-12));
    CHECK_THAT(nose_angle(middle, -start.rotation.col(0)) + nose_angle(middle, upwind),
               WithinAbs(angle, 1e-7));  // acos of almost parallel vectors at worst
    CHECK((middle.rotation.transpose() * middle.rotation - Matrix3d::Identity()).norm() < 1e-14);
    follower.facing = Facing::away_from_wind;
    CHECK_THAT(nose_angle(step(follower, start, wind, 0.6), -upwind), WithinAbs((pi - angle) * std::exp(-0.6 / 1.5), 1e-12));
    follower.inertia.setZero();
    CHECK(nose_angle(step(follower, start, wind, 1e-3), -upwind) < 1e-12);
  }
}

TEST_CASE("each axis of the body has its own time constant", "[dragcore][follower][analytic]") {
  // Yawed from the wind: turns about z with tau_z = 4/2 s; pitched: about y with tau_y = 1/2 s.
  const Vector3d wind(5.0, 0.0, 0.0);
  const Follower follower = weather_vane({9.0, 1.0, 4.0});
  const FollowerState yawed{.rotation = Eigen::AngleAxisd(0.8, Vector3d::UnitZ()).toRotationMatrix()};
  const FollowerState pitched{.rotation = Eigen::AngleAxisd(0.8, Vector3d::UnitY()).toRotationMatrix()};
  CHECK((step(follower, yawed, wind, 1.0).rotation - Eigen::AngleAxisd(0.8 * std::exp(-1.0 / 2.0), Vector3d::UnitZ()).toRotationMatrix())
            .norm() < 1e-14);
  CHECK((step(follower, pitched, wind, 1.0).rotation - Eigen::AngleAxisd(0.8 * std::exp(-1.0 / 0.5), Vector3d::UnitY()).toRotationMatrix())
            .norm() < 1e-14);
  // A very large inertia about one axis alone: it hardly turns about it.
  CHECK(nose_angle(step(weather_vane({1.0, 1.0, 1e12}), yawed, wind, 1.0), -wind.normalized()) > 0.79);
}

TEST_CASE("what is locked does not move", "[dragcore][follower][invariance]") {
  const Vector3d wind(3.0, 4.0, 5.0);
  for (const FollowerLag lag : {FollowerLag::none, FollowerLag::linear, FollowerLag::quadratic}) {
    Follower follower{.lag = lag, .facing = Facing::into_wind, .position_locked = {false, true, true}};
    FollowerState end = step(follower, {}, wind, 1.0);
    CHECK(end.position[0] > 0.5);
    CHECK(end.position.tail<2>().isZero(0.0));
    CHECK(end.velocity.tail<2>().isZero(0.0));
    // Turning about z alone: the nose ends in the vertical plane of the wind, the body stays upright. About nothing: stays.
    follower.position_locked = {true, true, true};
    follower.turn_locked = {true, false};
    end = step(follower, {.rotation = Eigen::AngleAxisd(2.5, Vector3d::UnitZ()).toRotationMatrix()}, wind, 1.0);
    CHECK(end.position.isZero(0.0));
    CHECK((end.rotation - Eigen::AngleAxisd(std::atan2(4.0, 3.0), Vector3d::UnitZ()).toRotationMatrix()).norm() < 1e-14);
    follower.turn_locked = {true, true};
    CHECK(step(follower, {}, wind, 1.0).rotation == Matrix3d::Identity());
    // Turning about y alone in a wind across: nothing to gain.
    follower.turn_locked = {false, true};
    CHECK(step(follower, {}, Vector3d(0.0, 2.0, 0.0), 1.0).rotation == Matrix3d::Identity());
  }
}

TEST_CASE("calm air, a wind from exactly behind and extreme speeds leave a follower sound", "[dragcore][follower][hard]") {
  const Follower follower{.lag = FollowerLag::quadratic, .facing = Facing::into_wind, .inertia = {1.0, 1.0, 1.0}};
  const FollowerState turned{.rotation = Eigen::AngleAxisd(0.3, Vector3d::UnitX()).toRotationMatrix()};
  CHECK(step(follower, turned, Vector3d::Zero(), 1.0).rotation == turned.rotation);
  CHECK(step(follower, turned, Vector3d(1, 2, 3), 0.0).rotation == turned.rotation);
  // Nose straight downwind: it must start to turn, about its z axis. One ulp beside, either way, it turns by the same angle.
  const double left = pi * std::exp(-1.0);
  for (const double beside : {0.0, 5e-324, -5e-324, 1e-16, -1e-16}) {
    const FollowerState end = step(follower, {}, Vector3d(-1.0, beside, 0.0), 1.0);
    CHECK_THAT(nose_angle(end, Vector3d(1.0, 0.0, 0.0)), WithinAbs(left, 1e-14));
    CHECK((end.rotation.col(2) - Vector3d::UnitZ()).norm() < 1e-14);
  }
  for (const double speed : {5e-324, 1e-300, 1e-12, 1e4, 1e150})
    for (const FollowerLag lag : {FollowerLag::linear, FollowerLag::quadratic}) {
      Follower fast = follower;
      fast.lag = lag;
      const FollowerState end = step(fast, turned, speed * Vector3d(1, 1, 0).normalized(), 1.0 / 60);
      CHECK(end.position.allFinite());
      CHECK(end.velocity.allFinite());
      CHECK(end.rotation.allFinite());
    }
  // A million steps in a veering wind: still a rotation, to rounding.
  FollowerState state;
  for (int i = 0; i < 1'000'000; ++i)
    state = step(follower, state, Vector3d(std::cos(0.01 * i), std::sin(0.01 * i), 0.3 * std::sin(0.003 * i)), 1.0 / 60);
  CHECK((state.rotation.transpose() * state.rotation - Matrix3d::Identity()).norm() < 1e-14);
  CHECK(state.velocity.norm() < 1.1);
}

TEST_CASE("a follower with impossible settings is refused, and the message says which", "[dragcore][follower][hard]") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto refused = [](const Follower& follower, const std::string& what) {
    CHECK_THROWS_WITH(step(follower, {}, Vector3d::UnitX(), 0.1), Contains(what));
  };
  refused({.gain = nan}, "gain");
  refused({.mass = -1.0}, "mass = -1");
  refused({.linear_drag = 0.0}, "linear_drag");
  refused({.lag = FollowerLag::quadratic, .drag_area = -1.0}, "drag_area");
  refused({.lag = FollowerLag::quadratic, .density = 0.0}, "density");
  refused({.inertia = {0.0, -1.0, 0.0}}, "inertia");
  refused({.angular_drag = 0.0}, "angular_drag");
  CHECK_THROWS_WITH(step({}, {}, Vector3d(nan, 0, 0), 0.1), Contains("wind"));
  CHECK_THROWS_WITH(step({}, {.velocity = {0, nan, 0}}, Vector3d::Zero(), 0.1), Contains("velocity"));
  CHECK_THROWS_WITH(step({}, {.rotation = Matrix3d::Zero()}, Vector3d::Zero(), 0.1), Contains("rotation"));
  CHECK_THROWS_WITH(step({}, {}, Vector3d::Zero(), -0.1), Contains("dt"));
}
