#include <bit>
#include <catch2/catch.hpp>
#include <dragcore/required_effects.hpp>

#include "tests/support/zoo.hpp"

using namespace dragcore;
using Eigen::Vector3d;

namespace {

const EffectNeed& need(const RequiredEffects& found, Effect effect) {
  for (const EffectNeed& candidate : found.needs)
    if (candidate.effect == effect) return candidate;
  throw std::out_of_range("effect not judged");
}

std::vector<Effect> every_effect() {
  std::vector<Effect> list;
  for (unsigned i = 0; i < effect_count; ++i) list.push_back(static_cast<Effect>(1u << i));
  return list;
}

}  // namespace

TEST_CASE("a scene without an effect's cause does not call for it, and says why", "[effects][limit]") {
  const Surface cube = zoo::surface(Box{}, 2);
  const auto found = required_effects({.surface = cube, .motion = {.wind = {10.0, 0.0, 0.0}}, .free = false, .model = {.law = note_law()}});
  CHECK(found.effects.empty());  // the note's law in a uniform wind without spin: windward pressure alone
  for (const Effect effect : every_effect()) {
    CHECK(need(found, effect).force == 0.0);
    CHECK(need(found, effect).torque == 0.0);
    CHECK_FALSE(need(found, effect).why.empty());
  }
  CHECK(need(found, Effect::spin).why == "the body does not spin");
  CHECK(need(found, Effect::wind_variation).why == "the wind is uniform over the body");
}

TEST_CASE("spin, pillow, a vortex and a law with many terms are called for", "[effects][sign]") {
  const Surface cube = zoo::surface(Box{}, 2);
  const Wind vortex({{.name = "v", .field = VortexField{.circulation = 30.0, .core_radius = 1.0}}});
  const auto found = required_effects({.surface = cube,
                                       .motion = {.wind = {3.0, 0.0, 0.0}, .angular_velocity = {0.0, 0.0, 5.0}},
                                       .model = model_for(cube),
                                       .wind = &vortex,
                                       .place = {1.5, 0.0, 0.0}});
  for (const Effect effect :
       {Effect::base_suction, Effect::recovery, Effect::shelter, Effect::pillow, Effect::spin, Effect::wind_variation})
    CHECK(found.effects.has(effect));
  CHECK_FALSE(found.effects.has(Effect::curvature));  // a cube has no curved face
  CHECK(found.wind_sampling != WindSampling::constant);

  // A slow spin costs less than the tolerance: not called for.
  const auto slow =
      required_effects({.surface = cube, .motion = {.wind = {3.0, 0.0, 0.0}, .angular_velocity = {0.0, 0.0, 1e-4}}, .free = false});
  CHECK_FALSE(slow.effects.has(Effect::spin));
  CHECK(need(slow, Effect::spin).force > 0.0);
}

TEST_CASE("a free body keeps what brakes the motions it may come to", "[effects][limit]") {
  const Surface paper(triangulate(Plate{0.2, 0.2, 0.0}, 2)), cube = zoo::surface(Box{}, 2);
  // Broadside without spin, now. It may turn and glide edge-on next.
  const Motion falling{.velocity = {0.0, 0.0, -3.0}};
  const auto held = required_effects({.surface = paper, .motion = falling, .free = false, .model = model_for(paper), .tolerance = 0.1});
  CHECK_FALSE(held.effects.has(Effect::spin));
  CHECK_FALSE(held.effects.has(Effect::friction));
  const auto free = required_effects({.surface = paper, .motion = falling, .model = model_for(paper), .tolerance = 0.1});
  CHECK(free.effects.has(Effect::spin));
  CHECK(free.effects.has(Effect::friction));
  CHECK(need(free, Effect::spin).why.find("a free body") != std::string::npos);
  CHECK(need(free, Effect::friction).why.find("0 m^2") != std::string::npos);
  // A cube has a front of one face however it turns: its friction can be too small to count.
  CHECK_FALSE(required_effects({.surface = cube, .motion = falling, .model = {.law = sheet_law()}, .tolerance = 0.2})
                  .effects.has(Effect::friction));
  // Nor does it stay where the wind is even.
  const Wind far(
      {{.name = "v", .field = VortexField{.circulation = 30.0}, .placement = {.position = {200.0, 0.0, 0.0}}, .fade_radius = 50.0}});
  CHECK(required_effects({.surface = cube, .motion = falling, .wind = &far}).effects.has(Effect::wind_variation));
  CHECK_FALSE(required_effects({.surface = cube, .motion = falling, .free = false, .wind = &far}).effects.has(Effect::wind_variation));
  // What the model has switched off stays so.
  Model without = model_for(paper);
  without.effects = Effects::all().without(Effect::spin | Effect::friction);
  CHECK((required_effects({.surface = paper, .motion = falling, .model = without}).effects & (Effect::spin | Effect::friction)).empty());
}

TEST_CASE("small triangles make the note's pillow not worth its cost", "[effects][limit]") {
  const Model model{.law = note_law(), .pillow = {PillowForm::triangle, 1.0}};
  const auto asked = [&](int divisions) {
    return required_effects(
        {.surface = zoo::surface(Box{}, divisions), .motion = {.wind = {1.0, 0.0, 0.0}}, .model = model, .tolerance = 0.05});
  };
  CHECK(asked(1).effects.has(Effect::pillow));
  CHECK_FALSE(asked(80).effects.has(Effect::pillow));  // bound: 4 areas/frontal area * 1.5 * edge/sqrt(12)
}

TEST_CASE("leaving effects out never costs more than the sum of their bounds", "[effects][invariance]") {
  zoo::Random random(11);
  int informative = 0;
  for (int i = 0; i < 3000; ++i) {
    const auto shapes = zoo::shapes();
    const Shape& shape = shapes[static_cast<std::size_t>(random.uniform(0.0, static_cast<double>(shapes.size()) - 1e-9))];
    const Surface surface = zoo::surface(shape, 4);
    Motion motion = random.motion(5.0, random.uniform(0.0, 3.0));
    motion.wind_gradient = 0.3 * random.rotation();
    Model model{.law = i % 2 ? closed_law() : sheet_law(),
                .pillow = {i % 3 ? PillowForm::tilt : PillowForm::patch, 0.8},
                .quadrature = Quadrature::six};
    if (i % 5 == 0) model.law = scaled_law(0.9, 0.3);
    const auto found = required_effects({.surface = surface, .motion = motion, .model = model});
    const Wrench whole = wrench(surface, motion, {}, model).total();

    Effects dropped;
    double force = 0.0, torque = 0.0;
    for (const Effect effect : every_effect())
      if (random.uniform(0.0, 1.0) < 0.3)
        dropped = dropped | effect, force += need(found, effect).force, torque += need(found, effect).torque;
    Model reduced = model;
    reduced.effects = Effects::all().without(dropped);
    const Wrench rest = wrench(surface, motion, {}, reduced).total();
    REQUIRE((whole.force - rest.force).norm() <= force + 1e-12);
    REQUIRE((whole.torque - rest.torque).norm() <= torque + 1e-12);
    informative += (whole.force - rest.force).norm() > 0.02 * force;
  }
  CHECK(informative > 300);  // the bounds are wide, but not empty
}

TEST_CASE("what the scene calls for is within the tolerance of the whole model", "[effects][analytic]") {
  // The point of it all: a scene evaluated with `effects` alone.
  zoo::Random random(5);
  for (const Shape& shape : zoo::shapes()) {
    const Surface surface = zoo::surface(shape, 4);
    const Motion motion = random.motion(8.0, 0.02);
    const Model model{.law = law_for(surface.body_class), .pillow = {PillowForm::tilt, 0.78}};
    const double tolerance = 0.02;
    const auto found = required_effects({.surface = surface, .motion = motion, .model = model, .tolerance = tolerance});
    Model reduced = model;
    reduced.effects = found.effects;
    const Wrench whole = wrench(surface, motion, {}, model).total(), rest = wrench(surface, motion, {}, reduced).total();
    const double left_out = effect_count - std::popcount(found.effects.bits());
    CHECK((whole.force - rest.force).norm() <= left_out * tolerance * found.force_scale);
    CHECK((whole.torque - rest.torque).norm() <= left_out * tolerance * found.torque_scale);
  }
}

TEST_CASE("air carried along, lift of spinning balls and low Reynolds numbers are judged too", "[effects][sign]") {
  const Surface ball = zoo::surface(Sphere{.diameter = 0.2}, 8);
  const auto find = [](const RequiredEffects& found, const std::string& name) {
    for (const EffectNeed& candidate : found.needs)
      if (candidate.name == name) return candidate;
    throw std::out_of_range(name);
  };
  const MassProperties balloon{.mass = 0.004, .inertia = 1e-5 * Eigen::Matrix3d::Identity()},
      iron{.mass = 33.0, .inertia = 0.1 * Eigen::Matrix3d::Identity()};
  const Motion spinning{.wind = {5.0, 0.0, 0.0}, .angular_velocity = {0.0, 0.0, 40.0}};
  CHECK(find(required_effects({.surface = ball, .motion = spinning, .body = balloon}), "added mass").needed);
  CHECK_FALSE(find(required_effects({.surface = ball, .motion = spinning, .body = iron}), "added mass").needed);
  CHECK(find(required_effects({.surface = ball, .motion = spinning}), "Magnus lift").needed);
  CHECK_FALSE(find(required_effects({.surface = zoo::surface(Box{}, 2), .motion = spinning}), "Magnus lift").needed);
  CHECK_FALSE(find(required_effects({.surface = ball, .motion = spinning}), "low Reynolds number").needed);
  CHECK(find(required_effects({.surface = ball, .motion = {.wind = {1e-4, 0.0, 0.0}}}), "low Reynolds number").needed);
}

TEST_CASE("a question that makes no sense is refused", "[effects][hard]") {
  const Surface cube = zoo::surface(Box{}, 2);
  CHECK_THROWS_WITH(required_effects({.surface = cube}), Catch::Contains("speed") && Catch::Contains("largest"));
  CHECK_THROWS_WITH(required_effects({.surface = cube, .tolerance = 0.0}), Catch::Contains("tolerance = 0"));
  CHECK_THROWS_WITH(required_effects({.surface = cube, .viscosity = -1.0}), Catch::Contains("viscosity = -1"));
  CHECK_NOTHROW(required_effects({.surface = Surface(TriangleMesh{})}));
}
