// What an exact ellipsoid costs, and how exact it is: three Markdown tables on stdout. Errors are seeded and the same on every run; CPU
// times are of this machine, the median of seven runs.

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <dragcore/ellipsoid.hpp>
#include <numbers>
#include <random>
#include <vector>

#include "support/ellipsoid_integrals.hpp"

using namespace dragcore;
using Eigen::Vector3d;

namespace {

struct Body {
  const char* name;
  Ellipsoid shape;
};
const std::vector<Body> bodies = {{"sphere", {1, 1, 1}},
                                  {"1 : 0.7 : 0.4", {1, 0.7, 0.4}},
                                  {"needle 10:1", {1, 0.1, 0.1}},
                                  {"disc 10:1", {1, 1, 0.1}},
                                  {"needle 100:1", {1, 0.01, 0.01}},
                                  {"disc 100:1", {1, 1, 0.01}},
                                  {"blade 1 : 0.1 : 0.01", {1, 0.1, 0.01}}};
const Law law = scaled_law(0.76, 0.4);  // both sides feel the air

double difference(const Wrench& a, const Wrench& b) {
  return ((a.force - b.force).norm() + (a.torque - b.torque).norm()) / (b.force.norm() + b.torque.norm());
}

/// Random directions of flow and spin, and those along the axes, where thin bodies feel little and errors count most.
std::vector<Motion> motions(double spin) {
  std::mt19937 engine(1);
  std::normal_distribution<double> normal;
  const auto direction = [&] { return Vector3d(normal(engine), normal(engine), normal(engine)).normalized(); };
  std::vector<Motion> list;
  for (int i = 0; i < 10; ++i) list.push_back({.wind = direction(), .angular_velocity = spin * direction()});
  for (int i = 0; i < 9; ++i)
    list.push_back({.wind = Vector3d::Unit(i % 3) + 1e-3 * direction(), .angular_velocity = spin * Vector3d::Unit(i / 3)});
  return list;
}

template <class F>
double microseconds(F evaluate_once) {
  std::vector<double> runs;
  for (int run = 0; run < 7; ++run) {
    int count = 0;
    const std::clock_t start = std::clock();  // CPU time: does not count what the machine does besides
    double elapsed = 0.0;
    do {
      for (int i = 0; i < 10; ++i) evaluate_once();  // the clock costs as much as the cheapest evaluation
      count += 10;
      elapsed = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    } while (elapsed < 0.02);
    runs.push_back(1e6 * elapsed / count);
  }
  std::nth_element(runs.begin(), runs.begin() + 3, runs.end());
  return runs[3];
}

/// Largest relative error of the drag of pressure c^4 on spheroids along their axis against the closed form, with N points per panel.
template <int N>
double rule_error(double length) {
  const double size = std::max(length, 1.0);
  const Vector3d scaled = Vector3d(length, 1, 1) / size;
  double sum = 0.0;
  for_each_ellipsoid_node<N>(scaled, [&](double tau, double d_tau, const Vector3d& shrink, double root) {
    sum += 2.0 * scaled.prod() * scaled.prod() * tau * root * std::pow(shrink[0], 2.5) * d_tau * size * size;
  });
  const double m = length * length, d = m - 1.0;
  return std::abs(sum / (length == 1.0 ? 1.0 / 3.0 : ((m * m - 1.0) - 2.0 * m * std::log(m)) / (d * d * d)) - 1.0);
}

}  // namespace

int main() {
  std::printf(
      "Without spin: relative error against the closed form, by points per panel (12 are used).\n\n| length : diameter | 4 | 6 | 8 | 12 | "
      "16 |\n|---|---|---|---|---|---|\n");
  for (const double length : {1e-4, 0.01, 0.1, 1.0, 10.0, 100.0, 1e4})
    std::printf("| %g | %.0e | %.0e | %.0e | %.0e | %.0e |\n", length, rule_error<4>(length), rule_error<6>(length), rule_error<8>(length),
                rule_error<12>(length), rule_error<16>(length));

  std::printf(
      "\nWith spin: worst relative error of force and torque over 57 motions (ωa/u = 0.1, 1, 10), by panels per quarter (3 is the "
      "default), and points.\n\n");
  std::printf("| semi-axes | 1 | 2 | 3 | 4 | 6 |\n|---|---|---|---|---|---|\n");
  for (const Body& body : bodies) {
    const EllipsoidSurface fine({.shape = body.shape}, 14);
    std::printf("| %s |", body.name);
    for (const int panels : {1, 2, 3, 4, 6}) {
      const EllipsoidSurface coarse({.shape = body.shape}, panels);
      double worst = 0.0;
      for (const double spin : {0.1, 1.0, 10.0})
        for (const Motion& motion : motions(spin))
          worst = std::max(worst, difference(wrench(coarse, motion, {}, law).total(), wrench(fine, motion, {}, law).total()));
      std::printf(" %.0e (%zu) |", worst, coarse.surface_points.size());
    }
    std::printf("\n");
  }

  std::printf(
      "\nCost of one evaluation against triangles with the same error: rms over ten random motions within 1e-3. Without spin, and at ωa/u "
      "= 1.\n\n");
  std::printf(
      "| semi-axes | ellipsoid, still | triangles | mesh | ellipsoid, spinning | triangles | mesh |\n|---|---|---|---|---|---|---|\n");
  for (const Body& body : bodies) {
    const EllipsoidSurface exact({.shape = body.shape}), fine({.shape = body.shape}, 14);
    std::printf("| %s |", body.name);
    for (const double spin : {0.0, 1.0}) {
      std::vector<Motion> list = motions(spin);
      list.resize(10);
      const Model model{.law = law};
      double sink = 0.0;
      std::size_t next = 0;
      const double ours = microseconds([&] { sink += wrench(exact, list[next++ % list.size()], {}, law).total().force.x(); });
      for (int divisions = 4;; divisions = divisions * 5 / 4 + 1) {
        const Surface mesh(triangulate(body.shape, divisions));
        double squares = 0.0;
        for (const Motion& motion : list)
          squares += std::pow(difference(wrench(mesh, motion, {}, model).total(), wrench(fine, motion, {}, law).total()), 2);
        if (std::sqrt(squares / static_cast<double>(list.size())) > 1e-3) continue;
        const double theirs = microseconds([&] { sink += wrench(mesh, list[next++ % list.size()], {}, model).total().force.x(); });
        std::printf(" %.2f µs | %td | %.0f µs (%.0f ×) |", ours, mesh.size(), theirs, theirs / ours);
        break;
      }
      if (!std::isfinite(sink)) return 1;
    }
    std::printf("\n");
  }
}
