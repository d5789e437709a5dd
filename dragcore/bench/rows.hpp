#pragma once

// What all rows of the benchmarks have in common: the least of the repetitions among their statistics, what a triangle costs, and a hash of
// the result. A row whose result is wrong ends with an error instead of being fast.

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdio>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "bodies.hpp"

namespace dragcore::bench {

using Row = std::function<void(benchmark::State&)>;

/// Processor time counts; rows of several threads say UseRealTime().
inline benchmark::internal::Benchmark* add_row(const std::string& name, const Row& row) {
  return benchmark::RegisterBenchmark(name.c_str(), row)->ComputeStatistics("least", [](const std::vector<double>& runs) {
    return *std::min_element(runs.begin(), runs.end());
  });
}

/// Seconds of each of `items`, as the counter `per_item`.
inline void count(benchmark::State& state, double items, const char* per_item = "per_triangle") {
  using benchmark::Counter;
  state.counters[per_item] = Counter(items, Counter::kIsIterationInvariantRate | Counter::kInvert);
}

/// Whether a row was wrong: the program's exit code.
inline bool any_wrong = false;

inline void wrong(benchmark::State& state, const std::string& what) {
  any_wrong = true;
  state.SkipWithError(("wrong: " + what).c_str());
}

/// Of what gives a wrench: its hash, and its error against what `exact` gives, which is asked once for each `name`.
inline void judge(benchmark::State& state, const std::string& name, const Wrench& found, const Surface& surface, const Motion& motion,
                  double tolerance, const std::function<Wrench()>& exact) {
  static std::map<std::string, Wrench> known;
  if (!known.count(name)) known[name] = exact();
  const double off = error(found, known[name], surface, motion, {});
  state.SetLabel(Hash().add(found).text());
  state.counters["error"] = off;
  char text[120];
  std::snprintf(text, sizeof text, "its error is %.2g, at most %.0e is allowed", off, tolerance);
  if (!(off <= tolerance)) wrong(state, text);
}

/// What an evaluation of wrench() is measured with.
struct Kind {
  std::string name;
  std::vector<std::string> bodies;
  std::function<void(Model&)> adjust;  ///< chooses a precision
  double tolerance;                    ///< that it promises, see error()
  std::function<Wrench(const Body&, const Motion&, const Model&)> exact;
};

/// Every body, motion and model.
inline void add_wrench_rows(const Kind& kind) {
  for (const std::string& body_name : kind.bodies)
    for (const std::string way : {"straight", "spinning"})
      for (const std::string law : {"note", "class", "class+pillow"}) {
        const std::string name = "wrench/" + kind.name + "/" + body_name + "/" + way + "/" + law;
        add_row(name, [=](benchmark::State& state) {
          const Body& b = body(body_name);
          const Motion going = motion(way);
          Model chosen = model(law, b.surface);
          kind.adjust(chosen);
          Wrench found;
          for (auto _ : state) benchmark::DoNotOptimize(found = wrench(b.surface, going, {}, chosen).total());
          count(state, static_cast<double>(b.surface.size()));
          judge(state, name, found, b.surface, going, kind.tolerance, [&] { return kind.exact(b, going, chosen); });
        });
      }
}

/// resistance() of bodies, and a step of the README's loop.
inline void add_step_rows(const std::string& kind) {
  for (const std::string body_name : {"cube-12", "ball-2048"})
    for (const std::string way : {"straight", "spinning"}) {
      const std::string name = "resistance/" + kind + "/" + body_name + "/" + way;
      add_row(name, [=](benchmark::State& state) {
        const Body& b = body(body_name);
        const Motion going = motion(way);
        const Model chosen = model_for(b.surface);
        Matrix6d S = Matrix6d::Zero();
        for (auto _ : state) benchmark::DoNotOptimize(S = resistance(b.surface, going, {}, chosen));
        count(state, static_cast<double>(b.surface.size()));
        Vector6d slip;  // S (V_air - V) is the wrench
        slip << going.wind - going.velocity, -going.angular_velocity;
        const Vector6d felt = S * slip;
        judge(state, name, {felt.head<3>(), felt.tail<3>()}, b.surface, going, 1e-6,
              [&] { return reference::wrench(b.mesh, b.surface.sides, going, {}, chosen).total(); });
      });
    }
  add_row("step/" + kind + "/box-12", [](benchmark::State& state) {
    const FreeBox box;
    FreeFlight flight;
    for (auto _ : state) flight.step(box);
    FreeFlight again;  // as many steps whatever the machine
    for (int k = 0; k < 60; ++k) again.step(box);
    state.SetLabel(Hash().add(again.position).add(again.velocity).text());
    if (!(again.position.x() > 0.5 && again.position.x() < 12.0)) wrong(state, "the box is not blown downwind");
  });
}

}  // namespace dragcore::bench
