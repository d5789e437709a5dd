// Evaluations one by one under callgrind, each with its own count of instructions: instructions.py runs this and judges. Whether an effect
// that is off costs anything is seen from balls of two sizes: their difference has nothing of what a call costs.

#include <valgrind/callgrind.h>

#include <cstdio>
#include <functional>
#include <string>

#include "dragcore/bench/bodies.hpp"
#include "kernels/wrench_kernel.hpp"
#include "tests/dragcore/drag/effects_cases.hpp"

using namespace dragcore;

namespace {

/// The second of two runs: the first one binds functions and chooses kernels.
void count(const std::string& name, const std::function<void()>& work) {
  work();
  CALLGRIND_ZERO_STATS;
  CALLGRIND_TOGGLE_COLLECT;
  work();
  CALLGRIND_TOGGLE_COLLECT;
  CALLGRIND_DUMP_STATS_AT(name.c_str());
}

volatile double sink = 0.0;  // so that nothing is optimised away

void count_wrench(const std::string& name, const Surface& surface, const Motion& motion, const Model& model, const Medium& medium = {}) {
  count(name, [&] { sink = wrench(surface, motion, medium, model).total().force.x(); });
}

void count_evaluations() {
  const bench::Body &ball = bench::body("ball-2048"), &cube = bench::body("cube-12");
  for (const std::string name : {"cube-12", "ball-2048"})
    for (const std::string way : {"straight", "spinning"})
      for (const std::string law : {"note", "class", "class+pillow"}) {
        const Surface& surface = bench::body(name).surface;
        Model model = bench::model(law, surface);
        model.precision = Precision::single;
        count_wrench("wrench/single/" + name + "/" + way + "/" + law, surface, bench::motion(way), model);
        if (law == "class+pillow")
          count_wrench("wrench/single/" + name + "/" + way + "/" + law + "+viscous", surface, bench::motion(way), model, {.viscosity = 1.8e-5});
      }
  count("resistance/now/cube-12/spinning",
        [&] { sink = resistance(cube.surface, bench::motion("spinning"), {}, model_for(cube.surface))(0, 0); });
  count("triangle_forces/ball-2048", [&] {
    sink = triangle_forces(ball.surface, bench::motion("spinning"), {}, bench::model("class+pillow", ball.surface)).force(0, 0);
  });
  const bench::FreeBox box;
  bench::FreeFlight flight;
  count("step/now/box-12", [&] { flight.step(box); });
  // The control: no line of the library is in it.
  const bench::IndexedMesh indexed(ball.mesh);
  count("textbook/ball-2048/straight", [&] { sink = bench::textbook(indexed, bench::motion("straight"), {}).force.x(); });
}

/// "effect/SCENE/EFFECT/VARIANT/TRIANGLES": the effect felt; masked off; and not in the law, the pillow or the motion at all. Once with all
/// other effects, once with none of them.
void count_effects() {
  const auto scene = [](unsigned i, bool others) {
    Model model = effects_cases::whole_model();
    Motion motion = effects_cases::whole_motion;
    const bool moving = i >= 7;  // spin and wind_variation: either alone makes the flow vary
    for (unsigned j = 0; j < effect_count; ++j) {
      const bool needed = effects_cases::effect(i) == Effect::recovery && effects_cases::effect(j) == Effect::base_suction;
      if (j != i && !needed && (j >= 7 ? moving : !others)) effects_cases::take_away(j, model, motion);
    }
    return std::pair(model, motion);
  };
  for (const auto& [precision, word] : {std::pair(Precision::single, "single"), {Precision::full, "full"}})
    for (const bool others : {true, false})
      for (unsigned i = 0; i < effect_count; ++i)
        for (const std::string body : {"ball-2048", "ball-4608"}) {
          if (effects_cases::effect(i) == Effect::correction) continue;  // costs nothing by triangle, on or off
          const Surface& surface = bench::body(body).surface;
          auto [model, motion] = scene(i, others);
          const bool is_viscous = effects_cases::effect(i) == Effect::viscous;
          if (is_viscous) model.law.friction = 0.0;  // comes back when they go
          const Medium medium = is_viscous ? effects_cases::viscous_medium : Medium{};
          model.precision = precision;
          const std::string name =
              std::string("effect/") + word + (others ? "-with-all/" : "-alone/") + to_string(effects_cases::effect(i));
          count_wrench(name + "/felt/" + body, surface, motion, model, medium);
          Model masked = model;
          masked.effects = Effects::all().without(effects_cases::effect(i));
          // Recovery is a share of the base suction: a law without the one has not the other, a mask may have.
          if (effects_cases::effect(i) == Effect::base_suction) masked.effects = masked.effects.without(Effect::recovery);
          count_wrench(name + "/masked/" + body, surface, motion, masked, medium);
          effects_cases::take_away(i, model, motion);
          count_wrench(name + "/lacking/" + body, surface, motion, model, medium);
        }
}

}  // namespace

int main() {
  if (!RUNNING_ON_VALGRIND) {
    std::fprintf(stderr, "this program counts nothing by itself; run it by tests/dragcore/kernels/instructions.py\n");
    return 2;
  }
  try {
    kernels::force_target("AVX2");  // callgrind has no AVX-512
  } catch (const std::exception&) {
    std::fprintf(stderr, "this machine has no AVX2: instruction counts are of the kernels for it\n");
    return 77;  // as ctest's SKIP_RETURN_CODE
  }
  bench::body("ball-2048"), bench::body("ball-4608"), bench::body("cube-12");  // before counting: preparation is slow when watched
  CALLGRIND_START_INSTRUMENTATION;
  count_evaluations();
  count_effects();
  return 0;
}
