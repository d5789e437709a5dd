// What is off is not evaluated, what is on is. This program has the core of the library compiled in, with DRAGCORE_COUNT_EFFECTS
// (dragcore/src/drag/instrument.hpp).

#include <catch2/catch.hpp>
#include <dragcore/stepping.hpp>
#include <functional>
#include <numeric>

#include "dragcore/src/drag/instrument.hpp"
#include "tests/dragcore/drag/effects_cases.hpp"

using namespace dragcore;
using effects_cases::effect;
using effects_cases::take_away;
using effects_cases::whole_model;
using effects_cases::whole_motion;
using Eigen::Vector3d;

namespace {

using Counts = std::array<std::uint64_t, effect_count>;

Counts counted(const std::function<void()>& run) {
  instrument::evaluations.fill(0);
  run();
  return instrument::evaluations;
}

/// Of every function that walks over a surface.
std::vector<Counts> counts_of(const Surface& surface, const Motion& motion, const Model& model, const Medium& medium = {}) {
  return {counted([&] { wrench(surface, motion, medium, model); }), counted([&] { triangle_forces(surface, motion, medium, model); }),
          counted([&] { resistance(surface, motion, medium, model); }), counted([&] { force_jacobian(surface, motion, medium, model); })};
}

}  // namespace

TEST_CASE("what is on is evaluated, by every function", "[effects][limit]") {
  const Surface ball = zoo::surface(Sphere{}, 2);
  for (const Medium& medium : {Medium{}, effects_cases::viscous_medium}) {
    // The viscous terms take the place of friction.
    const Effect absent = medium.viscosity > 0.0 ? Effect::friction : Effect::viscous;
    for (const Counts& counts : counts_of(ball, whole_motion, whole_model(), medium))
      for (unsigned i = 0; i < effect_count; ++i) {
        INFO(to_string(effect(i)));
        CHECK((counts[i] > 0) == (effect(i) != absent));
      }
  }
  // Every source of wind variation, every form of pillow.
  Motion motion = whole_motion;
  const std::vector<Vector3d> winds(static_cast<std::size_t>(ball.size()), Vector3d(1, 2, 3));
  motion.wind_gradient.setZero();
  motion.triangle_wind = winds;
  for (const Pillow& pillow : hostile::pillows()) {
    Model model = whole_model();
    model.pillow = pillow;
    for (const Counts& counts : counts_of(ball, motion, model)) {
      CHECK(counts[8] > 0);
      CHECK((counts[6] > 0) == (pillow.form != PillowForm::none));
    }
  }
}

TEST_CASE("what the mask, the law, the pillow or the motion leaves out is not evaluated once, and all else still is", "[effects][limit]") {
  for (const Surface& body : {zoo::surface(Sphere{}, 2), zoo::surface(Box{}, 1), zoo::surface(Plate{1, 1, 0}, 1)})
    for (unsigned i = 0; i < effect_count; ++i) {
      const Medium medium = effect(i) == Effect::viscous ? effects_cases::viscous_medium : Medium{};
      Model masked = whole_model();
      if (effect(i) == Effect::viscous) masked.law.friction = 0.0;  // comes back when they go
      Model without = masked;
      const std::vector<Counts> all = counts_of(body, whole_motion, masked, medium);
      Motion motion = whole_motion;
      masked.effects = Effects::all().without(effect(i));
      take_away(i, without, motion);
      const std::vector<Counts> by_mask = counts_of(body, whole_motion, masked, medium),
                                by_cause = counts_of(body, motion, without, medium);
      for (std::size_t function = 0; function < all.size(); ++function)
        for (unsigned j = 0; j < effect_count; ++j) {
          INFO("without " << to_string(effect(i)) << ", count of " << to_string(effect(j)) << ", function " << function);
          CHECK((by_mask[function][j] > 0) == (j != i && all[function][j] > 0));
          // Recovery is a share of the base suction: a law without the one has not the other. The mask takes either alone.
          const bool goes_too = effect(i) == Effect::base_suction && effect(j) == Effect::recovery;
          CHECK((by_cause[function][j] > 0) == (j != i && !goes_too && all[function][j] > 0));
        }
    }
}

TEST_CASE("the note's law in a uniform wind evaluates no effect at all, and neither does any model with all of them off",
          "[effects][limit]") {
  const auto sum = [](const Counts& counts) { return std::accumulate(counts.begin(), counts.end(), std::uint64_t{0}); };
  const Surface ball = zoo::surface(Sphere{}, 2);
  for (const Counts& counts : counts_of(ball, {.wind = {5, 1, 2}}, {})) CHECK(sum(counts) == 0);
  Model off = whole_model();
  off.effects = Effects{};
  for (const Counts& counts : counts_of(ball, whole_motion, off)) CHECK(sum(counts) == 0);
  Model no_factor{.pillow = {PillowForm::patch, 0.0}};
  for (const Counts& counts : counts_of(ball, {.wind = {5, 1, 2}}, no_factor)) CHECK(sum(counts) == 0);
}

TEST_CASE("masks do not touch each other: 400 random cases, any subset of effects, count for count", "[effects][invariance]") {
  for (unsigned seed = 0; seed < 400; ++seed) {
    zoo::Random random(seed);
    const Surface surface = hostile::body(random, false).surface();
    Model model = whole_model();
    model.effects = Effects{};
    for (unsigned i = 0; i < effect_count; ++i)
      if (random.uniform(0.0, 1.0) < 0.5) model.effects = model.effects | effect(i);
    for (const Counts& counts : counts_of(surface, whole_motion, model, seed % 2 ? effects_cases::viscous_medium : Medium{}))
      for (unsigned i = 0; i < effect_count; ++i)
        if (!model.effects.has(effect(i))) REQUIRE(counts[i] == 0);
  }
}
