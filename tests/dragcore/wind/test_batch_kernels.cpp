// Gusts and followers in batches against the same one by one, on every instruction set that this machine has.

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <dragcore/follower.hpp>
#include <dragcore/gust.hpp>
#include <limits>

#include "tests/dragcore/kernels/targets.hpp"
#include "tests/support/zoo.hpp"

using namespace dragcore;
using Catch::Contains;
using Eigen::Vector3d;

namespace {

/// Every profile, exponents from the limit of none to a gust without a beginning.
std::vector<Gust> gusts() {
  std::vector<Gust> list;
  for (const GustProfile profile : {GustProfile::note, GustProfile::smooth_ended, GustProfile::one_minus_cosine})
    for (const double exponent : {1e-200, 1e-9, 0.3, 1.0, 2.5, 100.0})
      list.push_back({.profile = profile, .start = 0.7, .duration = 1.9, .amplitude = -3.0, .rest = 0.25, .exponent = exponent});
  return list;
}

/// Before, during and after; at both ends and one step beside them; beyond all numbers.
std::vector<double> times_of(const Gust& gust) {
  std::vector<double> times{gust.start,
                            gust.start + gust.duration,
                            -1e308,
                            1e308,
                            -std::numeric_limits<double>::infinity(),
                            std::numeric_limits<double>::infinity()};
  for (const double end : {gust.start, gust.start + gust.duration})
    for (const double far : {-10.0, 10.0}) times.push_back(std::nextafter(end, far));
  for (int i = -100; i < 1101; ++i) times.push_back(gust.start + gust.duration * i / 1000.0);
  return times;
}

std::vector<Follower> followers(zoo::Random& random) {
  std::vector<Follower> list;
  for (const FollowerLag lag : {FollowerLag::none, FollowerLag::linear, FollowerLag::quadratic})
    for (const Facing facing : {Facing::keep, Facing::into_wind, Facing::away_from_wind})
      for (const int locks : {0, 1, 2, 3})
        list.push_back({.gain = random.uniform(-1.0, 1.5),
                        .lag = lag,
                        .mass = locks == 3 ? 0.0 : std::exp(random.uniform(-10.0, 5.0)),
                        .linear_drag = std::exp(random.uniform(-3.0, 3.0)),
                        .drag_area = std::exp(random.uniform(-3.0, 3.0)),
                        .facing = facing,
                        .inertia = locks == 1 ? Vector3d(1.0, 0.0, 2.0) : Vector3d(random.vector(3.0).cwiseAbs()),
                        .angular_drag = random.uniform(0.1, 3.0),
                        .position_locked = {locks == 1, locks == 2, false},
                        .turn_locked = {locks == 1 || locks == 3, locks == 2 || locks == 3}});
  return list;
}

struct Crowd {
  std::vector<FollowerState> states;
  std::vector<Vector3d> winds;
};

/// Any heading and speed; among them winds from ahead, from behind and beside that by a step, and none.
Crowd crowd(zoo::Random& random, int count) {
  Crowd result;
  for (int i = 0; i < count; ++i) {
    result.states.push_back({.position = random.vector(10.0), .velocity = random.vector(5.0), .rotation = random.rotation()});
    result.winds.push_back(random.vector(std::exp(random.uniform(-5.0, 4.0))));
    if (i % 7 == 3) result.states.back() = {};
    if (i % 7 == 3) result.winds.back() = Vector3d(i % 2 ? -1.0 : 1.0, i % 3 ? 0.0 : 5e-324, i % 5 ? 0.0 : 1e-16);
    if (i % 11 == 5) result.winds.back().setZero();
  }
  return result;
}

std::vector<FollowerState> stepped(const Follower& follower, Crowd crowd, double dt) {
  step(follower, crowd.states, crowd.winds, dt);
  return crowd.states;
}

bool same_bits(const FollowerState& a, const FollowerState& b) {
  return a.position == b.position && a.velocity == b.velocity && a.rotation == b.rotation;
}

}  // namespace

TEST_CASE("gust factors in a batch are those one by one, and exact at the ends", "[gust][kernels][backend]") {
  for (const Gust& gust : gusts()) {
    INFO("profile " << static_cast<int>(gust.profile) << ", exponent " << gust.exponent);
    const std::vector<double> times = times_of(gust);
    const auto factors = [&] {
      std::vector<double> list(times.size());
      gust_factors(gust, times, list);
      return list;
    };
    kernels::on_every_target([&] {
      const std::vector<double> list = factors();
      for (std::size_t i = 0; i < times.size(); ++i) {
        INFO("time " << times[i]);
        const double x = (times[i] - gust.start) / gust.duration;
        if (!(x > 0.0 && x < 1.0)) CHECK(list[i] == gust.rest);
        // Two sines and a power, a few units of the last place each; steep powers magnify theirs where the wind changes fastest.
        CHECK(std::abs(list[i] - gust_factor(gust, times[i])) <= 1e-14 * std::abs(gust.amplitude));
      }
    });
    kernels::on_equal_targets(factors, [](const auto& wide, const auto& narrow) { CHECK(wide == narrow); });
    // Any split, and in place.
    std::vector<double> parts = times;
    for (std::size_t first = 0, count = 1; first < parts.size(); first += count, count = std::min(count + 3, parts.size() - first)) {
      const std::span<double> part(parts.data() + first, count);
      gust_factors(gust, part, part);
    }
    CHECK(parts == factors());
  }
}

TEST_CASE("a batch of times that cannot be is refused, and nothing is written", "[gust][kernels][hard]") {
  std::vector<double> times{0.1, 0.2, std::numeric_limits<double>::quiet_NaN()}, factors(3, 42.0), two(2);
  CHECK_THROWS_WITH(gust_factors({}, times, factors), Contains("time 2"));
  CHECK(factors == std::vector<double>(3, 42.0));
  CHECK_THROWS_WITH(gust_factors({}, times, two), Contains("number of factors = 2, but there are 3 times"));
  CHECK_THROWS_WITH(gust_factors({.duration = 0.0}, {}, {}), Contains("duration"));
  CHECK_NOTHROW(gust_factors({}, {}, {}));
}

TEST_CASE("followers in a batch go where each goes by itself", "[follower][kernels][backend]") {
  zoo::Random random(11);
  for (const Follower& follower : followers(random))
    for (const double dt : {0.0, 1e-6, 1.0 / 60, 3.0}) {
      INFO("lag " << static_cast<int>(follower.lag) << ", facing " << static_cast<int>(follower.facing) << ", dt " << dt);
      const Crowd many = crowd(random, 77);
      kernels::on_every_target([&] {
        const std::vector<FollowerState> batch = stepped(follower, many, dt);
        for (std::size_t i = 0; i < batch.size(); ++i) {
          const FollowerState one = step(follower, many.states[i], many.winds[i], dt);
          const double speed = many.winds[i].norm() + many.states[i].velocity.norm();
          INFO("follower " << i);
          // A dozen roundings of 1e-16, of numbers of the size of speed, way and 1.
          CHECK((batch[i].velocity - one.velocity).norm() <= 1e-13 * speed);
          CHECK((batch[i].position - one.position).norm() <= 1e-13 * (many.states[i].position.norm() + speed * dt));
          CHECK((batch[i].rotation - one.rotation).norm() <= 1e-13);
        }
      });
      kernels::on_equal_targets([&] { return stepped(follower, many, dt); },
                                [](const auto& wide, const auto& narrow) {
                                  for (std::size_t i = 0; i < wide.size(); ++i) CHECK(same_bits(wide[i], narrow[i]));
                                });
      Crowd parts = many;
      for (std::size_t first = 0, count = 1; first < parts.states.size();
           first += count, count = std::min(count + 1, parts.states.size() - first))
        step(follower, std::span(parts.states).subspan(first, count), std::span<const Vector3d>(parts.winds).subspan(first, count), dt);
      const std::vector<FollowerState> whole = stepped(follower, many, dt);
      for (std::size_t i = 0; i < whole.size(); ++i) CHECK(same_bits(parts.states[i], whole[i]));
    }
}

TEST_CASE("followers in a batch stay sound: extreme winds, a million steps", "[follower][kernels][hard]") {
  const Follower vane{.lag = FollowerLag::quadratic, .facing = Facing::into_wind, .inertia = {1.0, 1.0, 1.0}};
  kernels::on_every_target([&] {
    for (const double speed : {5e-324, 1e-300, 1e-12, 1e4, 1e150}) {
      std::vector<FollowerState> states(9, {.rotation = Eigen::AngleAxisd(0.3, Vector3d::UnitX()).toRotationMatrix()});
      const std::vector<Vector3d> winds(9, speed * Vector3d(1, 1, 0).normalized());
      step(vane, states, winds, 1.0 / 60);
      for (const FollowerState& state : states)
        CHECK((state.position.allFinite() && state.velocity.allFinite() && state.rotation.allFinite()));
    }
  });
  std::vector<FollowerState> states(8);
  std::vector<Vector3d> winds(8);
  for (int i = 0; i < 125'000; ++i) {
    for (std::size_t k = 0; k < 8; ++k)
      winds[k] = Vector3d(std::cos(0.01 * i), std::sin(0.01 * i), 0.3 * std::sin(0.003 * i + static_cast<double>(k)));
    step(vane, states, winds, 1.0 / 60);
  }
  for (const FollowerState& state : states) {
    CHECK((state.rotation.transpose() * state.rotation - Eigen::Matrix3d::Identity()).norm() < 1e-14);  // the correction's own rounding
    CHECK(state.velocity.norm() < 1.1);
  }
}

TEST_CASE("a batch with one follower that cannot be is refused as a whole, and the message says which", "[follower][kernels][hard]") {
  zoo::Random random(12);
  const Crowd sound = crowd(random, 40);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto refused = [&](const auto& change, const std::string& what) {
    Crowd many = sound;
    change(many);
    const std::vector<FollowerState> before = many.states;
    CHECK_THROWS_WITH(step({}, many.states, many.winds, 0.1), Contains(what));
    for (std::size_t i = 0; i < 10; ++i) CHECK(same_bits(many.states[i], before[i]));
  };
  refused([&](Crowd& many) { many.winds[33][1] = nan; }, "follower 33: wind");
  refused([&](Crowd& many) { many.states[33].position[0] = nan; }, "follower 33: position");
  refused([&](Crowd& many) { many.states[39].velocity[2] = std::numeric_limits<double>::infinity(); }, "follower 39: velocity");
  refused([&](Crowd& many) { many.states[20].rotation *= 1.0 + 1e-6; }, "follower 20: determinant of the rotation");
  refused([&](Crowd& many) { many.states[21].rotation.col(1) *= -1.0; }, "follower 21: determinant of the rotation");
  refused([&](Crowd& many) { many.winds.pop_back(); }, "number of winds = 39, but there are 40 states");
  Crowd many = sound;
  CHECK_THROWS_WITH(step({.mass = -1.0}, many.states, many.winds, 0.1), Contains("mass"));
  CHECK_THROWS_WITH(step({}, many.states, many.winds, -0.1), Contains("dt"));
  CHECK_NOTHROW(step({}, std::span<FollowerState>{}, std::span<const Vector3d>{}, 0.1));
  // A rotation that is one to less than a millionth is taken, though the kernel alone would not be sure of it.
  many.states[5].rotation.col(0) *= 1.0 + 0.996e-6 / 2.0;
  CHECK_NOTHROW(step({}, many.states, many.winds, 0.1));
}
