// What asking required_effects() costs, and what it saves: CPU time in units of one wrench() with everything on. Markdown table on stdout;
// medians of fifteen runs of this machine.

#include <algorithm>
#include <array>
#include <cstdio>
#include <ctime>
#include <dragcore/required_effects.hpp>
#include <dragcore/shapes.hpp>
#include <functional>

using namespace dragcore;

namespace {

double seconds(const std::function<void()>& work) {
  int calls = 0;
  const std::clock_t began = std::clock();
  do {
    work(), ++calls;
  } while (std::clock() - began < CLOCKS_PER_SEC / 50);
  return static_cast<double>(std::clock() - began) / CLOCKS_PER_SEC / calls;
}

/// Of runs that take turns, so that what else the machine does falls on both.
double ratio(const std::function<void()>& work, const std::function<void()>& unit) {
  std::array<double, 15> runs;
  for (double& run : runs) run = seconds(work) / seconds(unit);
  std::nth_element(runs.begin(), runs.begin() + 7, runs.end());
  return runs[7];
}

}  // namespace

int main() {
  std::printf("| body | motion | needed | asking | wrench() with what is needed |\n|---|---|---|---|---|\n");
  for (const auto& [name, shape] : {std::pair<const char*, Shape>("sheet, 8 triangles", Plate{1.0, 1.0, 0.0}),
                                    {"cube, 48 triangles", Box{}},
                                    {"ball, 768 triangles", Sphere{}}})
    for (const bool free : {true, false}) {
      const Surface surface(triangulate(shape, std::holds_alternative<Sphere>(shape) ? 8 : 2));
      const Motion motion = free ? Motion{.velocity = {5, 1, 2}, .angular_velocity = {3, 2, 1}} : Motion{.velocity = {5, 1, 2}};
      Model whole = model_for(surface), reduced = whole;
      reduced.effects = required_effects({.surface = surface, .motion = motion, .free = free, .model = whole}).effects;
      double sum = 0.0;  // so that nothing is optimised away
      const auto all = [&] { sum += wrench(surface, motion, {}, whole).total().force.x(); };
      const auto some = [&] { sum += wrench(surface, motion, {}, reduced).total().force.x(); };
      const auto asking = [&] {
        sum += required_effects({.surface = surface, .motion = motion, .free = free, .model = whole}).force_scale;
      };
      std::string needed;
      for (unsigned bit = 1; bit < Effects::all().bits(); bit <<= 1)
        if (reduced.effects.has(static_cast<Effect>(bit))) needed += (needed.empty() ? "" : ", ") + to_string(static_cast<Effect>(bit));
      std::printf("| %s | %s | %s | %.1f | %.2f |\n", name, free ? "free, spins" : "held, no spin", needed.c_str(), ratio(asking, all),
                  ratio(some, all));
      if (sum == 42.0) std::printf("\n");
    }
}
