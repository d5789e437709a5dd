// What the wind costs. Grids: nanoseconds per sample (a point and a field that reaches it), at points beside each other and at random ones,
// in double precision one by one, in scalar float as textbooks have it, and by the kernels. One thread, best of nine runs. Markdown on
// stdout. `wind_cost TARGET` forces an instruction set: AVX3 (AVX-512), AVX2, SSE4.

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <dragcore/body_wind.hpp>
#include <dragcore/follower.hpp>
#include <dragcore/gust.hpp>
#include <dragcore/shapes.hpp>
#include <dragcore/turbulence.hpp>
#include <functional>
#include <random>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "kernels/wrench_kernel.hpp"

using namespace dragcore;
using Eigen::Vector3d;
using Eigen::Vector3f;

namespace {

double nanoseconds(double per, const std::function<void()>& work) {
  using Clock = std::chrono::steady_clock;
  double best = 1e9;
  for (int run = 0; run < 9; ++run) {
    int calls = 0;
    double seconds = 0.0;
    for (const Clock::time_point began = Clock::now(); seconds < 0.02; ++calls) {
      work();
      seconds = std::chrono::duration<double>(Clock::now() - began).count();
    }
    best = std::min(best, seconds / calls);
  }
  return 1e9 * best / per;
}

/// A placed grid as one writes it down first, in single precision: three floats a point, sampled point by point.
struct TextbookGrid {
  int points;
  float lower, cells_per_metre;
  std::vector<Vector3f> values;

  Vector3f velocity(const Eigen::Matrix3f& rotation, const Vector3f& point) const {
    const Vector3f t = ((rotation.transpose() * point).array() - lower) * cells_per_metre;
    if ((t.array() < 0.0f).any() || (t.array() > static_cast<float>(points - 1)).any()) return Vector3f::Zero();
    const Eigen::Vector3i cell = t.cast<int>().cwiseMin(points - 2);
    const Vector3f part = t - cell.cast<float>();
    const auto value = [&](int i, int j, int k) -> const Vector3f& {
      return values[static_cast<std::size_t>(((cell[2] + k) * points + cell[1] + j) * points + cell[0] + i)];
    };
    const auto between = [](const Vector3f& a, const Vector3f& b, float f) -> Vector3f { return (1.0f - f) * a + f * b; };
    return rotation *
           between(between(between(value(0, 0, 0), value(1, 0, 0), part[0]), between(value(0, 1, 0), value(1, 1, 0), part[0]), part[1]),
                   between(between(value(0, 0, 1), value(1, 0, 1), part[0]), between(value(0, 1, 1), value(1, 1, 1), part[0]), part[1]),
                   part[2]);
  }
};

/// On a box of 20 m: along a spiral on a ball, as the triangles of a body lie, or anywhere.
Eigen::Matrix3Xd points_on_box(bool coherent, Eigen::Index count) {
  Eigen::Matrix3Xd points(3, count);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> anywhere(-9.9, 9.9);
  for (Eigen::Index i = 0; i < count; ++i) {
    const double z = 1.0 - 2.0 * (static_cast<double>(i) + 0.5) / static_cast<double>(count), turn = 0.12 * static_cast<double>(i);
    const double across = std::sqrt(1.0 - z * z);
    if (coherent)
      points.col(i) = Vector3d(1.0, -2.0, 0.5) + Vector3d(across * std::cos(turn), across * std::sin(turn), z);
    else
      points.col(i) = Vector3d(anywhere(random), anywhere(random), anywhere(random));
  }
  return points;
}

Grid noisy(int side) {
  Grid grid{.points = Eigen::Vector3i::Constant(side),
            .lower = Vector3d::Constant(-10.0),
            .upper = Vector3d::Constant(10.0),
            .values = Eigen::Matrix3Xd(3, Eigen::Index{side} * side * side)};
  std::mt19937 random(2);
  std::uniform_real_distribution<double> speed(-5.0, 5.0);
  for (double& value : grid.values.reshaped()) value = speed(random);
  return grid;
}

double sink = 0.0;  // so that nothing is optimised away

void grids() {
  std::printf(
      "\n| grid | fields | points | float, textbook | double | single | textbook / single | double / single |\n"
      "|---|---|---|---|---|---|---|---|\n");
  for (const int side : {32, 64, 128, 256}) {
    const auto field = std::make_shared<const GridField>(noisy(side));
    TextbookGrid textbook{side, -10.0f, static_cast<float>(field->cells_per_metre()[0]), {}};
    for (const auto& value : field->grid().values.colwise()) textbook.values.push_back(value.cast<float>());
    for (const int fields : {1, 5, 20}) {
      std::vector<WindSource> sources;
      std::vector<Eigen::Matrix3f> rotations;
      // Turned by little, so that every field reaches every point of both kinds but few corners.
      for (int i = 0; i < fields; ++i) {
        const Eigen::Matrix3d rotation = Eigen::AngleAxisd(0.01 * i, Vector3d::UnitZ()).toRotationMatrix();
        sources.push_back({.field = field, .placement = {.rotation = rotation}});
        rotations.push_back(rotation.cast<float>());
      }
      const Wind wind(sources);
      for (const bool coherent : {true, false}) {
        const Eigen::Matrix3Xd points = points_on_box(coherent, coherent ? 2048 : 100'000);
        std::vector<Vector3f> placed;
        for (const auto& point : points.colwise()) placed.push_back(point.cast<float>());
        const double samples = static_cast<double>(points.cols()) * fields;
        const double loop = nanoseconds(samples, [&] {
          for (const Vector3f& point : placed) {
            Vector3f sum = Vector3f::Zero();
            for (const Eigen::Matrix3f& rotation : rotations) sum += textbook.velocity(rotation, point);
            sink += static_cast<double>(sum.x());
          }
        });
        const double full = nanoseconds(samples, [&] { sink += wind.velocities(points, Precision::full)(0, 0); });
        const double single = nanoseconds(samples, [&] { sink += wind.velocities(points, Precision::single)(0, 0); });
        std::printf("| %d³ | %d | %s | %.1f | %.1f | %.2f | %.1f | %.1f |\n", side, fields,
                    coherent ? "2,048 of a body" : "100,000 at random", loop, full, single, loop / single, full / single);
        std::fflush(stdout);
      }
    }
  }
}

Wind five_fields() {
  std::vector<WindSource> sources;
  const auto field = std::make_shared<const GridField>(noisy(32));
  for (int i = 0; i < 5; ++i)
    sources.push_back({.field = field, .placement = {.rotation = Eigen::AngleAxisd(0.01 * i, Vector3d::UnitZ()).toRotationMatrix()}});
  return Wind(sources);
}

/// Per triangle of a ball that is sampled triangle by triangle among five fields; per body for the cube.
void bodies() {
  const Wind windy = five_fields(), calm({});
  std::printf("\n| body, wind by triangles | fields | double | single | double / single |\n|---|---|---|---|---|\n");
  for (const auto& [name, shape, divisions] :
       {std::tuple<const char*, Shape, int>{"ball of 2,048, a triangle", Sphere{}, 16}, {"cube of 12, a call", Box{}, 1}}) {
    const Surface surface(triangulate(shape, divisions));
    for (const Wind* wind : {&windy, &calm}) {
      const auto cost = [&](Precision precision) {
        return nanoseconds(surface.size() < 100 ? 1.0 : static_cast<double>(surface.size()), [&] {
          Motion motion;
          const BodyWind here(*wind, surface, {}, Vector3d::Zero(), WindSampling::per_triangle, precision);
          here.apply_to(motion);
          sink += motion.triangle_wind[0].x();
        });
      };
      const double full = cost(Precision::full), single = cost(Precision::single);
      std::printf("| %s | %d | %.1f | %.1f | %.1f |\n", name, wind == &windy ? 5 : 0, full, single, full / single);
    }
  }
}

void batches() {
  constexpr std::size_t count = 100'000;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::normal_distribution<double> normal;
  std::vector<double> times(count), factors(count);
  for (double& time : times) time = uniform(random);
  std::printf("\n| batch | one by one, ms | batch, ms | ratio |\n|---|---|---|---|\n");
  const auto row = [&](const char* name, const std::function<void()>& one_by_one, const std::function<void()>& batch) {
    const double slow = 1e-6 * nanoseconds(1.0, one_by_one), fast = 1e-6 * nanoseconds(1.0, batch);
    std::printf("| %s | %.2f | %.2f | %.1f |\n", name, slow, fast, slow / fast);
  };
  for (const auto& [name, gust] : {std::pair<const char*, Gust>{"100,000 gusts, note's, p = 1", {}},
                                   {"100,000 gusts, note's, p = 0.7", {.exponent = 0.7}},
                                   {"100,000 gusts, 1 − cos", {.profile = GustProfile::one_minus_cosine}}})
    row(
        name,
        [&, &gust = gust] {
          for (std::size_t i = 0; i < count; ++i) factors[i] = gust_factor(gust, times[i]);
        },
        [&, &gust = gust] { gust_factors(gust, times, factors); });
  std::vector<FollowerState> states(count);
  std::vector<Vector3d> winds(count);
  for (Vector3d& wind : winds) wind = 5.0 * Vector3d(normal(random), normal(random), normal(random));
  for (const auto& [name, follower] : {std::pair<const char*, Follower>{"100,000 followers, linear lag", {}},
                                       {"100,000 followers, quadratic lag", {.lag = FollowerLag::quadratic}},
                                       {"100,000 followers, quadratic lag, turning into the wind",
                                        {.lag = FollowerLag::quadratic, .facing = Facing::into_wind, .inertia = Vector3d(1, 2, 3)}}})
    row(
        name,
        [&, &follower = follower] {
          for (std::size_t i = 0; i < count; ++i) states[i] = step(follower, states[i], winds[i], 1e-3);
        },
        [&, &follower = follower] { step(follower, states, winds, 1e-3); });
  const Wind wind = five_fields();
  const Eigen::Matrix3Xd places = points_on_box(true, 2048);
  std::vector<WindSample> samples;
  row(
      "2,048 samples with gradients, 5 fields of 32³", [&] { samples = wind.samples(places, Precision::full); },
      [&] { samples = wind.samples(places, Precision::single); });
  const Turbulence alike({}), apart({.length = Vector3d(600, 600, 150)});
  Eigen::Matrix3Xd points(3, count / 100), velocities(3, count / 100);
  for (auto point : points.colwise()) point = 100.0 * Vector3d(normal(random), normal(random), normal(random));
  for (const auto& [name, turbulence] :
       {std::pair<const char*, const Turbulence*>{"1,000 points in turbulence, one length, 192 waves", &alike},
        {"1,000 points in turbulence, three lengths, 192 waves", &apart}})
    row(
        name,
        [&, &turbulence = *turbulence] {
          for (Eigen::Index i = 0; i < points.cols(); ++i) velocities.col(i) = turbulence.velocity(points.col(i), 1.0);
        },
        [&, &turbulence = *turbulence] { velocities = turbulence.velocities(points, 1.0); });
  sink += factors[0] + states[0].position.x() + velocities(0, 0) + samples[0].velocity.x();
}

}  // namespace

int main(int count, char** words) {
  if (count > 1) kernels::force_target(words[1]);
  std::printf("Kernels for %s.\n", count > 1 ? words[1] : kernels::targets().front().c_str());
  grids();
  bodies();
  batches();
  if (sink == 42.0) std::printf("\n");
}
