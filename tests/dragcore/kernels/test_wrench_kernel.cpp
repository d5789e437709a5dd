// The kernels of Precision::single against the same sums in double precision, on every instruction set that this machine has.

#include <dragcore/expose.hpp>

#include "tests/dragcore/drag/hostile.hpp"
#include "tests/dragcore/kernels/targets.hpp"
#include "tests/support/meshes.hpp"

using namespace dragcore;
using Eigen::Vector3d;

namespace {

/// Float numbers are rounded to 6e-8, and between a velocity and a force lie some fifteen roundings, most of which fall on small parts.
constexpr double tolerance = 1e-6;

Model in(Precision precision, Model model) {
  model.precision = precision;
  return model;
}

/// Every law with what the kernels know of pillows.
std::vector<Model> models() {
  std::vector<Model> list;
  for (const Law& law : hostile::laws())
    for (const Pillow& pillow : {Pillow{}, Pillow{PillowForm::tilt, 0.9}})
      for (const Quadrature order : {Quadrature::one, Quadrature::three, Quadrature::six, Quadrature::adaptive})
        list.push_back({.law = law, .pillow = pillow, .quadrature = order});
  return list;
}

/// Straight, spinning, in wind that varies smoothly, and in winds triangle by triangle: `winds` is where those are kept.
std::vector<Motion> motions(zoo::Random& random, const Surface& surface, std::vector<Vector3d>& winds) {
  Motion straight{.wind = random.vector(5.0), .velocity = random.vector(5.0), .reference_point = random.vector(0.5)};
  Motion spinning = straight, varied = straight, gusty = straight;
  spinning.angular_velocity = random.vector(std::exp(random.uniform(-5.0, 4.0)));
  varied.wind_gradient = random.rotation() * random.uniform(-3.0, 3.0);
  winds.clear();
  for (Eigen::Index i = 0; i < surface.size(); ++i) winds.push_back(random.vector(4.0));
  gusty.triangle_wind = winds;
  Motion all = gusty;
  all.angular_velocity = random.vector(3.0);
  return {straight, spinning, varied, gusty, all};
}

void check_against_double(const Surface& surface, const Motion& motion, const Model& model) {
  const WrenchByTerm exact = wrench(surface, motion, {}, in(Precision::full, model)),
                     fast = wrench(surface, motion, {}, in(Precision::single, model));
  const double force = hostile::force_scale(surface, motion, Medium{}.density), torque = force * hostile::arm_scale(surface, motion);
  for (std::size_t term = 0; term < exact.terms.size(); ++term) {
    INFO("law " << model.law.name << ", pillow " << to_string(model.pillow.form) << ", points " << static_cast<int>(model.quadrature)
                << ", " << to_string(static_cast<Term>(term)));
    CHECK((fast.terms[term].force - exact.terms[term].force).norm() <= tolerance * force);
    CHECK((fast.terms[term].torque - exact.terms[term].torque).norm() <= tolerance * torque);
  }
}

/// A box, a cone and a sheet apart: three parts, two laws.
Surface three_parts() {
  const TriangleMesh box = triangulate(Box{.length = 1.0, .width = 0.7, .height = 0.5}, 3), cone = triangulate(Cone{}, 2),
                     sheet = triangulate(Plate{.chord = 0.5, .span = 2.0, .thickness = 0.0}, 3);
  return Surface(support::together({box, support::moved(cone, {0, 3, 0}), support::moved(sheet, {3, 0, 0})}));
}

/// A box in the lee of another, at an angle: rays say what the wind reaches.
Surface sheltered(zoo::Random& random) {
  const TriangleMesh front = triangulate(Box{.length = 1.0, .width = 0.8, .height = 0.6}, 3);
  return Surface(expose(prepare(support::together({front, transformed(front, random.rotation(), {1.4, 0.2, 0.1})}))));
}

}  // namespace

TEST_CASE("the kernels give every term of the wrench within single precision", "[kernels][backend]") {
  zoo::Random random(31);
  std::vector<Surface> surfaces{three_parts(), sheltered(random)};
  for (const Shape& shape : zoo::shapes()) surfaces.push_back(zoo::surface(shape, 3));
  surfaces.push_back(zoo::surface(Sphere{}, 12));  // more than one block of triangles
  std::vector<Vector3d> winds;
  const std::vector<Model> all_models = models();
  kernels::on_every_target([&] {
    for (const Surface& surface : surfaces) {
      const std::vector<Motion> all_motions = motions(random, surface, winds);
      for (std::size_t k = 0; k < all_motions.size(); ++k) {
        INFO("motion " << k << ", " << surface.size() << " triangles, " << surface.parts.size() << " parts");
        // A third of the models for each motion: every pair comes up on one body or another.
        for (std::size_t m = k; m < all_models.size(); m += 3) check_against_double(surface, all_motions[k], all_models[m]);
        check_against_double(surface, all_motions[k], model_for(surface));
      }
    }
  });
}

TEST_CASE("the width of the vectors does not change a bit", "[kernels][backend]") {
  kernels::same_bits([] {
    zoo::Random random(32);
    std::vector<double> all;
    std::vector<Vector3d> winds;
    for (const Surface& surface : {three_parts(), sheltered(random), zoo::surface(Sphere{}, 12), zoo::surface(Plate{.thickness = 0.0}, 4)})
      for (const Motion& motion : motions(random, surface, winds))
        for (const Model& model : models())
          for (const Wrench& term : wrench(surface, motion, {}, in(Precision::single, model)).terms)
            for (const Vector3d& v : {term.force, term.torque}) all.insert(all.end(), v.data(), v.data() + 3);
    return all;
  });
}

TEST_CASE("what the kernels do not know is summed in double precision", "[kernels]") {
  const Surface surface = zoo::surface(Box{}, 2);
  const Motion motion{.velocity = {-10, 1, 2}, .angular_velocity = {1, 2, 3}};
  Law changing = note_law();
  changing.windward = {0.0, 1.0, -1.5, 0.0, 0.0};  // below zero from c = 2/3
  for (const Model& model :
       {Model{.pillow = {PillowForm::patch, 0.9}}, Model{.pillow = {PillowForm::triangle, 0.9}}, Model{.law = changing}}) {
    const Wrench exact = wrench(surface, motion, {}, in(Precision::full, model)).total(),
                 asked = wrench(surface, motion, {}, in(Precision::single, model)).total();
    CHECK(asked.force == exact.force);
    CHECK(asked.torque == exact.torque);
  }
}

TEST_CASE("a surface that was changed after it was packed is summed in double precision", "[kernels]") {
  zoo::Random random(33);
  const Motion motion{.velocity = {-10, 1, 2}};
  Surface exposed_later(prepare(triangulate(Box{}, 3))), with_a_part_more = three_parts();
  exposed_later.exposure = sheltered(random).exposure;
  with_a_part_more.parts.push_back(with_a_part_more.parts.back());
  for (const Surface& surface : {exposed_later, with_a_part_more}) {
    const Model model = model_for(surface);
    CHECK(wrench(surface, motion, {}, model).total().force == wrench(surface, motion, {}, in(Precision::full, model)).total().force);
  }
}

TEST_CASE("the kernels stand every hard case: finite, no power gained, as in double precision", "[kernels][hard][property]") {
  for (unsigned seed = 1; seed <= 4000 / hostile::sanitizer_divisor; ++seed) {
    INFO("seed " << seed);
    zoo::Random random(seed);
    const hostile::Body body = hostile::body(random, true);
    const Surface surface = body.surface();
    const Motion motion = hostile::motion(random);
    Model model = hostile::model(random, false, true);
    model.pillow = seed % 2 == 0 ? Pillow{} : Pillow{PillowForm::tilt, 1.4};
    if (seed % 3 == 0) model = model_for(surface);
    const Wrench fast = wrench(surface, motion, {}, in(Precision::single, model)).total(),
                 exact = wrench(surface, motion, {}, in(Precision::full, model)).total();
    const double force = hostile::force_scale(surface, motion, Medium{}.density), torque = force * hostile::arm_scale(surface, motion);
    REQUIRE(fast.force.allFinite());
    REQUIRE(fast.torque.allFinite());
    // Slivers turn their normals by rounding, and a triangle edge-on may fall on either side: ten times the tolerance of well shaped
    // bodies.
    CHECK((fast.force - exact.force).norm() <= 10.0 * tolerance * force);
    CHECK((fast.torque - exact.torque).norm() <= 10.0 * tolerance * torque);
    const double power = fast.force.dot(motion.velocity - motion.wind) + fast.torque.dot(motion.angular_velocity);
    if (model.effects.has(Effect::spin))  // without it the points move as if the body did not turn
      CHECK(power <= tolerance * force *
                         ((motion.velocity - motion.wind).norm() + motion.angular_velocity.norm() * hostile::arm_scale(surface, motion)));
  }
}

TEST_CASE("the kernels work at any size and speed", "[kernels][hard]") {
  const Model model = model_for(zoo::surface(Box{}, 2));
  const Motion motion{.velocity = {-10, 1, 2}, .angular_velocity = {1, 2, 3}};
  const Wrench one = wrench(zoo::surface(Box{}, 2), motion, {}, in(Precision::single, model)).total();
  for (const double size : {1e-9, 1e9})
    for (const double speed : {1e-30, 1e30}) {
      Motion scaled{.velocity = speed * motion.velocity, .angular_velocity = speed / size * motion.angular_velocity};
      const Surface surface = zoo::surface(Box{.length = size, .width = size, .height = size}, 2);
      const Wrench other = wrench(surface, scaled, {}, in(Precision::single, model)).total();
      const double scale = speed * speed * size * size;
      CHECK((other.force / scale - one.force).norm() <= tolerance * one.force.norm());
      CHECK((other.torque / (scale * size) - one.torque).norm() <= tolerance * one.force.norm());
    }
  // At rest in still air, and with nothing there.
  CHECK(wrench(zoo::surface(Box{}, 2), {}, {}, in(Precision::single, model)).total().force == Vector3d::Zero());
  CHECK(wrench(Surface(TriangleMesh{}), motion, {}, in(Precision::single, model)).total().force == Vector3d::Zero());
  CHECK_THROWS_AS(wrench(zoo::surface(Box{}, 2), Motion{.velocity = {std::nan(""), 0, 0}}, {}, in(Precision::single, model)),
                  std::invalid_argument);
}

TEST_CASE("a small part far from a large one has its own units", "[kernels][hard]") {
  // In units of the sheet a box of 1 m has no size to speak of.
  const TriangleMesh box = triangulate(Box{}, 2), sheet = triangulate(Plate{.chord = 1e6, .span = 1e6, .thickness = 0.0}, 1);
  const Surface surface(support::together({box, support::moved(sheet, {0, 0, -3})})), alone(box);
  // Edge-on to the sheet, whose friction is off: what is left is the box.
  Model model = model_for(surface);
  model.sheets->law.friction = 0.0;
  const Motion motion{.velocity = {-10, 3, 0}};
  const Wrench with = wrench(surface, motion, {}, in(Precision::single, model)).total(),
               without = wrench(alone, motion, {}, in(Precision::full, model_for(alone))).total();
  CHECK((with.force - without.force).norm() <= tolerance * without.force.norm());
  CHECK((with.torque - without.torque).norm() <= tolerance * without.force.norm());
}
