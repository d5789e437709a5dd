#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <dragcore/animation.hpp>
#include <limits>
#include <numbers>
#include <random>

using namespace dragcore;
using Catch::Contains;
using Catch::Matchers::WithinAbs;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using std::numbers::pi;

namespace {

Matrix3d about_z(double angle) { return Eigen::AngleAxisd(angle, Vector3d::UnitZ()).toRotationMatrix(); }

WindSource breeze(const std::string& name, const Vector3d& position = Vector3d::Zero()) {
  return {.name = name, .field = UniformField{{1.0, 0.0, 0.0}}, .placement = {.position = position}, .fade_radius = 10.0};
}

/// Everything at once: a looped group of a ping-pong turn, a displacement and a gust, on two sources that share a name and one that does
/// not.
WindController busy_controller() {
  Animation sway;
  sway.rotation =
      Track<Matrix3d>({{.time = 0.0, .value = about_z(0.0), .easing = Easing::smoothstep}, {.time = 2.0, .value = about_z(1.0)}});
  sway.pivot = Vector3d(1.0, 0.0, 0.0);
  sway.scale = Track<Vector3d>({{.time = 0.0, .value = {1.0, 1.0, 1.0}, .easing = Easing::cubic_in_out},
                                {.time = 1.5, .value = {2.0, 1.0, -0.5}, .easing = Easing::cubic_out},
                                {.time = 2.0, .value = {1.0, 1.0, -0.5}}});
  Animation drift;
  drift.position =
      Track<Vector3d>({{.time = 0.0, .value = {0.0, 0.0, 0.0}, .easing = Easing::cubic_in}, {.time = 3.0, .value = {4.0, 0.0, 1.0}}});
  drift.intensity = Gust{.start = 0.5, .duration = 2.0, .amplitude = 3.0};
  return WindController({breeze("trees"), breeze("trees", {3.0, 0.0, 0.0}), breeze("roof", {0.0, 2.0, 0.0})},
                        {{.cues = {{.source = "trees", .animation = sway, .playback = {.repeat = Repeat::ping_pong}},
                                   {.source = "roof", .animation = drift, .playback = {.start = 0.3, .rate = 1.5}}},
                          .playback = {.start = 1.0, .repeat = Repeat::loop, .duration = 7.0}},
                         {.cues = {{.source = "trees", .animation = drift}}}});
}

}  // namespace

TEST_CASE("every easing goes from 0 to 1, and never back", "[dragcore][animation][limit]") {
  for (const Easing easing :
       {Easing::step, Easing::linear, Easing::smoothstep, Easing::cubic_in, Easing::cubic_out, Easing::cubic_in_out}) {
    CHECK(ease(easing, 0.0) == 0.0);
    CHECK(ease(easing, 1.0) == 1.0);
    CHECK(ease(easing, -1e9) == 0.0);
    CHECK(ease(easing, 1e9) == 1.0);
    double before = 0.0;
    for (int i = 1; i <= 1000; ++i) {
      const double now = ease(easing, i / 1000.0);
      CHECK(now >= before);
      before = now;
    }
  }
  CHECK(ease(Easing::smoothstep, 0.5) == 0.5);
  CHECK(ease(Easing::cubic_in, 0.5) == 0.125);
  CHECK(ease(Easing::cubic_out, 0.5) == 0.875);
  CHECK(ease(Easing::cubic_in_out, 0.25) == 0.0625);
  CHECK(ease(Easing::cubic_in_out, 0.75) == 0.9375);
  CHECK(ease(Easing::step, std::nextafter(1.0, 0.0)) == 0.0);
}

TEST_CASE("a track passes through its keyframes and holds its ends", "[dragcore][animation][analytic]") {
  const Track<double> track(
      {{.time = 1.0, .value = 10.0}, {.time = 3.0, .value = 20.0, .easing = Easing::step}, {.time = 4.0, .value = -5.0}});
  CHECK(track.at(-1e9) == 10.0);
  CHECK(track.at(1.0) == 10.0);
  CHECK(track.at(2.0) == 15.0);
  CHECK(track.at(3.0) == 20.0);
  CHECK(track.at(std::nextafter(4.0, 0.0)) == 20.0);
  CHECK(track.at(4.0) == -5.0);
  CHECK(track.at(1e9) == -5.0);
  CHECK(track.duration() == 4.0);

  // Rotations go along the shortest arc at constant rate; 1e-15 is rounding.
  const Track<Matrix3d> turn({{.time = 0.0, .value = about_z(-0.2)}, {.time = 1.0, .value = about_z(1.0)}});
  CHECK((turn.at(0.25) - about_z(0.1)).norm() < 1e-15);
  CHECK((Track<Matrix3d>({{.time = 0.0, .value = about_z(3.0)}, {.time = 1.0, .value = about_z(-3.0)}}).at(0.5) - about_z(pi)).norm() <
        1e-14);

  const auto numbers = [](std::vector<Keyframe<double>> keys) { return Track<double>(std::move(keys)); };
  CHECK_THROWS_WITH(numbers({}), Contains("at least 1"));
  CHECK_THROWS_WITH(numbers({{.time = 1.0}, {.time = 1.0}}), Contains("keyframe 1") && Contains("Easing::step"));
  CHECK_THROWS_WITH(numbers({{.time = -1.0}}), Contains("not negative"));
  CHECK_THROWS_WITH(numbers({{.time = 0.0, .value = std::nan("")}}), Contains("finite"));
  const auto rotation = [](const Matrix3d& value) {
    return Track<Matrix3d>(std::vector<Keyframe<Matrix3d>>{{.time = 0.0, .value = value}});
  };
  CHECK_THROWS_WITH(rotation(2.0 * Matrix3d::Identity()), Contains("rotation"));
  CHECK_THROWS_WITH(rotation(Vector3d(1, 1, -1).asDiagonal()), Contains("rotation"));
}

TEST_CASE("playback maps the clock to one pass, to loops, to and fro, and backwards", "[dragcore][animation][analytic]") {
  const auto at = [](Repeat repeat, double rate, double time) {
    return playback_time({.start = 10.0, .rate = rate, .repeat = repeat}, 4.0, time);
  };
  CHECK(at(Repeat::once, 1.0, 9.0) == 0.0);
  CHECK(at(Repeat::once, 2.0, 11.0) == 2.0);
  CHECK(at(Repeat::once, 2.0, 1e9) == 4.0);
  CHECK(at(Repeat::loop, 1.0, 15.0) == 1.0);
  CHECK(at(Repeat::loop, 1.0, 14.0) == 0.0);
  CHECK(at(Repeat::ping_pong, 1.0, 13.0) == 3.0);
  CHECK(at(Repeat::ping_pong, 1.0, 15.0) == 3.0);
  CHECK(at(Repeat::ping_pong, 1.0, 18.0) == 0.0);
  CHECK(at(Repeat::once, -1.0, 9.0) == 4.0);
  CHECK(at(Repeat::once, -1.0, 11.0) == 3.0);
  CHECK(at(Repeat::loop, -1.0, 15.0) == 3.0);
  CHECK(at(Repeat::loop, 1.0, 10.0 + 4.0 * 123'456'789 + 1.5) == 1.5);  // 123,456,789 loops on: the remainder is exact
  CHECK(playback_time({.repeat = Repeat::loop}, 0.0, 5.0) == 0.0);
}

TEST_CASE("an animation moves every source of its name, and no other", "[dragcore][animation][analytic]") {
  Animation turn;
  turn.rotation = Track<Matrix3d>(std::vector<Keyframe<Matrix3d>>{{.time = 0.0, .value = about_z(pi / 2)}});
  turn.pivot = Vector3d(1.0, 0.0, 0.0);
  Animation strengthen;
  strengthen.intensity = Track<double>({{.time = 0.0, .value = 1.0}, {.time = 2.0, .value = 3.0}});
  const WindController controller(
      {breeze("trees", {2.0, 0.0, 0.0}), breeze("roof")},
      {{.cues = {{.source = "trees", .animation = turn}, {.source = "trees", .animation = strengthen, .playback = {.start = 1.0}}}}});
  const std::vector<WindSource> moved = controller.sources_at(2.0);
  CHECK((moved[0].placement.position - Vector3d(1.0, 1.0, 0.0)).norm() < 1e-15);  // a quarter turn about the pivot
  CHECK((moved[0].placement.rotation - about_z(pi / 2)).norm() < 1e-15);
  CHECK(moved[0].intensity == 2.0);
  CHECK(moved[1].placement.position == Vector3d::Zero());
  CHECK(moved[1].intensity == 1.0);
  // The animation turns the source as it stands in the world, after its own rotation.
  WindSource upright = breeze("trees");
  upright.placement.rotation = Eigen::AngleAxisd(-pi / 2, Vector3d::UnitY()).toRotationMatrix();  // its x axis looks up
  const WindController turned({upright}, {{.cues = {{.source = "trees", .animation = turn}}}});
  CHECK((turned.sources_at(0.0)[0].placement.rotation.col(0) - Vector3d::UnitZ()).norm() < 1e-15);
  // The wind of "trees" now blows along y, twice as strong, where its fade is 1.
  CHECK((Wind({moved[0]}).velocity(Vector3d(1.0, 1.0, 0.0)) - Vector3d(0.0, 2.0, 0.0)).norm() < 1e-15);
}

TEST_CASE("a wind controller is a pure function of time: scrubbed, reversed and rebuilt it gives the same bits",
          "[dragcore][animation][invariance]") {
  const WindController controller = busy_controller();
  const Vector3d point(1.0, 1.0, 0.3);
  std::vector<double> times;
  for (int i = -100; i < 400; ++i) times.push_back(i * 0.0731);
  std::vector<WindSample> forward;
  for (const double t : times) forward.push_back(controller.sample(point, t));
  std::vector<std::size_t> order(times.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = order.size() - 1 - i;
  const auto replay = [&](const WindController& again) {
    for (const std::size_t i : order) {
      const WindSample sample = again.sample(point, times[i]);
      CHECK(sample.velocity == forward[i].velocity);
      CHECK(sample.gradient == forward[i].gradient);
    }
  };
  replay(controller);
  std::shuffle(order.begin(), order.end(), std::mt19937(1));
  replay(busy_controller());
  // It does move, and the group's loop of 7 s from t = 1 s returns. The other group has ended by 3 s. 1e-12: the clock's rounding times the
  // speed of change.
  CHECK((forward[150].velocity - forward[200].velocity).norm() > 0.01);
  CHECK((controller.sample(point, 4.0).velocity - controller.sample(point, 4.0 + 7.0 * 3).velocity).norm() < 1e-12);
}

TEST_CASE("a group's clock starts, speeds up and repeats all its cues together", "[dragcore][animation][invariance]") {
  Animation rise;
  rise.intensity = Track<double>({{.time = 0.0, .value = 0.0}, {.time = 4.0, .value = 8.0}});
  const auto intensity = [&](const Playback& group, const Playback& cue, double time) {
    return WindController({breeze("a")}, {{.cues = {{.source = "a", .animation = rise, .playback = cue}}, .playback = group}})
        .sources_at(time)[0]
        .intensity;
  };
  CHECK(intensity({.start = 10.0, .rate = 2.0}, {.start = 1.0}, 11.0) == 2.0);        // group clock 2 s, cue clock 1 s
  CHECK(intensity({.repeat = Repeat::loop}, {.start = 1.0}, 5.0 + 3.0) == 4.0);       // the group lasts 5 s
  CHECK(intensity({.repeat = Repeat::ping_pong}, {.start = 1.0}, 5.0 + 1.0) == 6.0);  // and comes back
  CHECK(intensity({}, {.repeat = Repeat::loop}, 4e8 + 1.0) == 2.0);                   // a cue may loop on in a group that plays once
}

TEST_CASE("animations stay finite from -1e9 to 1e9 s", "[dragcore][animation][hard]") {
  const WindController controller = busy_controller();
  for (const double t : {-1e9, -1e-300, 0.0, 5e-324, 1e9, 1e15}) {
    const WindSample sample = controller.sample(Vector3d(0.5, 0.5, 0.1), t);
    CHECK(sample.velocity.allFinite());
    CHECK(sample.gradient.allFinite());
    CHECK(sample.velocity.norm() < 20.0);  // three sources of 1 m/s, gusts of 3
  }
  CHECK_THROWS_WITH(controller.at(std::numeric_limits<double>::infinity()), Contains("time"));
  CHECK_THROWS_WITH(controller.at(std::nan("")), Contains("time"));
}

TEST_CASE("a wrong animation is refused when the controller is made, and the message says what is there", "[dragcore][animation][hard]") {
  Animation one;
  one.intensity = Track<double>(std::vector<Keyframe<double>>{{.time = 1.0, .value = 1.0}});
  const auto make = [&](const Cue& cue, const Playback& playback = {}) {
    return WindController({breeze("trees"), breeze("roof")}, {{.cues = {cue}, .playback = playback}});
  };
  CHECK_NOTHROW(make({.source = "trees", .animation = one}));
  CHECK_THROWS_WITH(make({.source = "tree", .animation = one}), Contains("'trees', 'roof'"));
  CHECK_THROWS_WITH(make({.source = "trees", .animation = one, .playback = {.rate = 0.0}}), Contains("rate"));
  CHECK_THROWS_WITH(make({.source = "trees", .animation = one, .playback = {.start = std::nan("")}}), Contains("start"));
  CHECK_THROWS_WITH(make({.source = "trees", .animation = one, .playback = {.repeat = Repeat::loop}}, {.repeat = Repeat::loop}),
                    Contains("never ends"));
  Animation gust;
  gust.intensity = Gust{.duration = -1.0};
  CHECK_THROWS_WITH(make({.source = "trees", .animation = gust}), Contains("duration"));
  // A scale that passes through 0 is found when it happens, by name.
  Animation flat;
  flat.scale = Track<Vector3d>({{.time = 0.0, .value = {1.0, 1.0, 1.0}}, {.time = 2.0, .value = {-1.0, 1.0, 1.0}}});
  CHECK_THROWS_WITH(make({.source = "roof", .animation = flat}).at(1.0), Contains("'roof'") && Contains("scale"));
}
