// What a baked body costs, in bytes, error and time, against wrench() of the same model: a Markdown table on stdout. Times are of one
// thread, the best of nine runs on the machine at hand; errors are the same on every run.

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <dragcore/bake.hpp>
#include <dragcore/shapes.hpp>
#include <random>
#include <vector>

using namespace dragcore;

namespace {

double sink = 0.0;  // so that nothing is optimised away; printed

template <class Run>
double nanoseconds(int calls, const Run& run) {
  double best = 1e300;
  for (int k = 0; k < 9; ++k) {
    const auto start = std::chrono::steady_clock::now();
    run();
    best = std::min(best, std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - start).count() / calls);
  }
  return best;
}

/// Random directions, so that neither caches nor guesses of branches know what comes.
std::vector<Motion> motions(const Surface& surface, bool spins, int count) {
  std::mt19937 engine(1);
  std::normal_distribution<double> normal;
  const auto random = [&] { return Eigen::Vector3d(normal(engine), normal(engine), normal(engine)); };
  std::vector<Motion> list;
  for (int k = 0; k < count; ++k) {
    list.push_back({.wind = random(), .reference_point = surface.centre});
    if (spins) list.back().angular_velocity = random() / surface.radius;
  }
  return list;
}

}  // namespace

int main() {
  struct Body {
    const char* name;
    Shape shape;
    int divisions;
  };
  const Body bodies[] = {{"cube", Box{}, 1},
                         {"box 2 : 1 : 0.6", Box{2.0, 1.0, 0.6}, 4},
                         {"prism", Prism{1.0, 0.8, 0.7}, 8},
                         {"sheet", Plate{1.0, 1.0, 0.0}, 8},
                         {"cone", Cone{}, 10},
                         {"ball", Sphere{}, 16},
                         {"teardrop", Teardrop{}, 12}};
  std::printf(
      "| body, triangles | wanted | KiB | force, rms | worst | torque, rms | worst | at spin 0.1, rms | 0.3 | 1 | call, ns | batch | with "
      "spin "
      "| `wrench()`, ns | with spin |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (const Body& one : bodies) {
    const Surface surface(triangulate(one.shape, one.divisions));
    const Model model = model_for(surface);
    const std::vector<Motion> straight = motions(surface, false, 1000), spinning = motions(surface, true, 1000);
    std::vector<Wrench> results(straight.size());
    const int few = std::max(20, static_cast<int>(20000 / surface.size()));
    double truth[2];
    for (const bool spins : {false, true})
      truth[spins] = nanoseconds(few, [&] {
        for (int k = 0; k < few; ++k)
          sink += wrench(surface, (spins ? spinning : straight)[static_cast<std::size_t>(k % 1000)], {}, model).total().force.x();
      });
    for (const double wanted : {0.05, 0.02, 0.01, 0.003}) {
      const BakedBody body = bake(surface, model, {.rms_error = wanted, .most_bytes = 4u << 20});
      const double call = nanoseconds(20000,
                                      [&] {
                                        for (int k = 0; k < 20; ++k)
                                          for (const Motion& motion : straight) sink += wrench(body, motion, {}).force.x();
                                      }),
                   batch = nanoseconds(20000,
                                       [&] {
                                         for (int k = 0; k < 20; ++k) wrenches(body, straight, {}, results);
                                         sink += results[7].force.x();
                                       }),
                   turning = nanoseconds(20000, [&] {
                     for (int k = 0; k < 20; ++k) wrenches(body, spinning, {}, results);
                     sink += results[7].force.x();
                   });
      std::printf(
          "| %s, %td | %g %% | %.0f | %.2f %% | %.2f %% | %.2f %% | %.2f %% | %.1f %% | %.1f %% | %.1f %% | %.1f | %.1f | %.1f | %.0f | "
          "%.0f |\n",
          one.name, surface.size(), 100 * wanted, static_cast<double>(body.bytes()) / 1024, 100 * body.error.rms_force,
          100 * body.error.worst_force, 100 * body.error.rms_torque, 100 * body.error.worst_torque, 100 * body.spin_error[0].rms(),
          100 * body.spin_error[1].rms(), 100 * body.spin_error[2].rms(), call, batch, turning, truth[0], truth[1]);
    }
  }
  std::printf("\nsum of all forces along x, for comparison: %.6g\n", sink);
}
