// What the wind costs. Grids: nanoseconds per sample (a point and a field that reaches it), at points beside each other and at random ones,
// in double precision one by one, in scalar float as textbooks have it, and by the kernels. One thread, best of nine runs. Markdown on
// stdout. `wind_cost TARGET` forces an instruction set: AVX3 (AVX-512), AVX2, SSE4.

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <dragcore/wind.hpp>
#include <functional>
#include <random>
#include <string>
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

/// Trilinear interpolation as one writes it down first, in single precision: three floats a point, no placement, no sum.
struct TextbookGrid {
  int points;
  float lower, cells_per_metre;
  std::vector<Vector3f> values;

  Vector3f operator()(const Vector3f& point) const {
    const Vector3f t = (point.array() - lower) * cells_per_metre;
    if ((t.array() < 0.0f).any() || (t.array() > static_cast<float>(points - 1)).any()) return Vector3f::Zero();
    std::array<int, 3> cell;
    std::array<float, 3> part;
    for (int a = 0; a < 3; ++a) {
      cell[static_cast<std::size_t>(a)] = std::min(static_cast<int>(t[a]), points - 2);
      part[static_cast<std::size_t>(a)] = t[a] - static_cast<float>(cell[static_cast<std::size_t>(a)]);
    }
    const auto value = [&](int i, int j, int k) -> const Vector3f& {
      return values[(static_cast<std::size_t>(cell[2] + k) * static_cast<std::size_t>(points) + static_cast<std::size_t>(cell[1] + j)) *
                        static_cast<std::size_t>(points) +
                    static_cast<std::size_t>(cell[0] + i)];
    };
    const auto between = [](const Vector3f& a, const Vector3f& b, float f) -> Vector3f { return (1.0f - f) * a + f * b; };
    return between(between(between(value(0, 0, 0), value(1, 0, 0), part[0]), between(value(0, 1, 0), value(1, 1, 0), part[0]), part[1]),
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
      // Turned by little, so that every field reaches every point of both kinds but few corners.
      for (int i = 0; i < fields; ++i)
        sources.push_back({.field = field, .placement = {.rotation = Eigen::AngleAxisd(0.01 * i, Vector3d::UnitZ()).toRotationMatrix()}});
      const Wind wind(sources);
      for (const bool coherent : {true, false}) {
        const Eigen::Matrix3Xd points = points_on_box(coherent, coherent ? 2048 : 100'000);
        std::vector<Vector3f> placed;
        for (const auto& point : points.colwise()) placed.push_back(point.cast<float>());
        const double samples = static_cast<double>(points.cols()) * fields;
        const double loop = nanoseconds(samples, [&] {
          for (const Vector3f& point : placed) {
            Vector3f sum = Vector3f::Zero();
            for (int i = 0; i < fields; ++i) sum += textbook(point);
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

}  // namespace

int main(int count, char** words) {
  if (count > 1) kernels::force_target(words[1]);
  std::printf("Kernels for %s.\n", count > 1 ? words[1] : kernels::targets().front().c_str());
  grids();
  if (sink == 42.0) std::printf("\n");
}
