// Viscosity: from creeping flow to Re 1e5 by one law.

#include <Eigen/Eigenvalues>
#include <catch2/catch.hpp>
#include <dragcore/deforming.hpp>
#include <dragcore/bake.hpp>
#include <dragcore/fluid_terms.hpp>
#include <dragcore/stepping.hpp>
#include <dragcore/validity.hpp>
#include <numbers>

#include "tests/dragcore/drag/hostile.hpp"

using namespace dragcore;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using std::numbers::pi;

namespace {

Medium medium_of(double viscosity) { return {.density = 1.0, .viscosity = viscosity}; }

/// What model_for() gives, in double.
Model model_of(const Surface& surface) { return zoo::exactly(model_for(surface)); }

Vector6d six(const Wrench& w) { return (Vector6d() << w.force, w.torque).finished(); }

/// A scale of the viscous forces, beside hostile::force_scale().
double creeping_scale(const Surface& surface, const Motion& motion, const Medium& medium) {
  double drag = 0.0;
  for (const Part& part : surface.parts) drag += part.creeping.drag.norm() + part.creeping.turning.norm() / std::max(1e-3, part.radius);
  return medium.viscosity * drag * ((motion.wind - motion.velocity).norm() + motion.angular_velocity.norm() * hostile::arm_scale(surface, motion));
}

}  // namespace

TEST_CASE("as Re falls to 0 a ball has Stokes' force and torque, and the force is linear in the speed", "[viscous][limit][analytic]") {
  const Surface ball = zoo::surface(Sphere{.diameter = 1.0}, 24);
  const Model model = model_of(ball);
  const double speed = 1e-9;
  const Motion motion{.wind = {speed, 0, 0}, .angular_velocity = {0, 0, speed}};
  const Wrench w = wrench(ball, motion, medium_of(1.0), model).total();
  // Facets: 0.1 % in the radius, three times that in the torque.
  CHECK(w.force.x() == Approx(6.0 * pi * 0.5 * speed).epsilon(2e-3));
  CHECK(w.torque.z() == Approx(-8.0 * pi * 0.125 * speed).epsilon(6e-3));
  CHECK(std::abs(w.torque.x()) < 1e-12 * speed);
  // Twice as fast, twice the force: what is not linear is of order sqrt(Re).
  const Wrench twice = wrench(ball, {.wind = {2.0 * speed, 0, 0}, .angular_velocity = {0, 0, 2.0 * speed}}, medium_of(1.0), model).total();
  CHECK((twice.force - 2.0 * w.force).norm() < 1e-4 * w.force.norm());
  // And on the ellipsoid it is what Oberbeck and Jeffery found, in any direction.
  const Ellipsoid shape{0.8, 0.5, 0.3};
  const Surface ellipsoid = zoo::surface(shape, 24);
  const Vector6d flow = (Vector6d() << Vector3d(1, 2, -1) * speed, Vector3d(0.5, -1, 2) * speed).finished();
  const Vector6d exact = stokes_resistance({shape}, Vector3d::Zero(), 1.0) * flow;
  const Wrench found =
      wrench(ellipsoid, {.wind = flow.head<3>(), .angular_velocity = -flow.tail<3>()}, medium_of(1.0), model_of(ellipsoid)).total();
  CHECK((six(found) - exact).norm() < 6e-3 * exact.norm());
}

TEST_CASE("creeping traction on a ball is 3 mu/l u everywhere, and twice that of its rotation", "[viscous][analytic]") {
  const Surface ball = zoo::surface(Sphere{.diameter = 1.0}, 16);
  const Model model = model_of(ball);
  const Vector3d u(1e-9, 2e-9, 0), omega(0, 1e-9, 3e-9);
  const TriangleForces parts = triangle_forces(ball, {.wind = u, .angular_velocity = omega}, medium_of(1.0), model);
  const double l = std::sqrt(ball.total_area / pi);
  for (Eigen::Index i = 0; i < ball.size(); ++i) {
    const Vector3d r = ball.centroid.row(i).matrix();
    const Vector3d exact = 3.0 / l * (u - 2.0 * omega.cross(r));
    CHECK((parts.force.col(i) / ball.area[i] - exact).norm() < 0.01 * 3.0 / l * 1e-8);  // facets of 1/64 turn; sizes of 1e-8
  }
}

TEST_CASE("the force is continuous over eight decades of Re, and its coefficient falls all the way", "[viscous][limit]") {
  for (const Shape& shape : {Shape(Sphere{}), Shape(Box{}), Shape(Plate{1, 1, 0})}) {
    const Surface surface = zoo::surface(shape, 4);
    const Model model = model_of(surface);
    const auto coefficient = [&](double log_re) {
      return wrench(surface, {.wind = Vector3d(1.0, 0.4, 0.2)}, medium_of(std::pow(10.0, -log_re)), model).total().force.norm();
    };
    double last = coefficient(-3.0);
    for (int k = 1; k <= 800; ++k) {
      const double here = coefficient(-3.0 + 0.01 * k);
      CHECK(here < last);
      CHECK(here > last * 0.976);  // a step of 0.01 in the logarithm of a force that goes at most with 1/Re: 2.3 %
      last = here;
    }
  }
}

TEST_CASE("at Re 1e5 the boundary layer stands in place of the constant friction", "[viscous][limit]") {
  // 0.75/sqrt(Re_l) is 0.0024 on a ball's diameter, times at most 1.8 where the flow comes head-on and 2.3 where it curves.
  for (const Shape& shape : {Shape(Box{}), Shape(Plate{1, 1, 0}), Shape(Sphere{})}) {
    const Surface surface = zoo::surface(shape, 4);
    const Motion motion{.wind = Vector3d(1.0, 0.3, 0.1)};
    const Model model = model_of(surface);
    const WrenchByTerm without = wrench(surface, motion, medium_of(0.0), model), with = wrench(surface, motion, medium_of(1e-5), model);
    CHECK(with[Term::friction].force.norm() < 3.0 * without[Term::friction].force.norm());
    CHECK(with[Term::friction].force.norm() > 0.3 * without[Term::friction].force.norm());
    CHECK((with.total().force - without.total().force).norm() < 0.02 * without.total().force.norm());
  }
}

TEST_CASE("without viscosity, without viscous terms or with the effect off nothing changes by a bit", "[viscous][regression]") {
  for (unsigned seed = 0; seed < 200; ++seed) {
    zoo::Random random(seed);
    const Surface surface = hostile::body(random, false).surface();
    const Motion motion = hostile::motion(random);
    Model model = seed % 2 ? model_of(surface) : hostile::model(random, false, false), bare = model, masked = model;
    const auto strip = [](Law& law) { law.stokes = law.layer = law.layer_curvature = 0.0; };
    strip(bare.law), bare.pillow.viscous_gain = 0.0;
    if (bare.sheets) strip(bare.sheets->law), bare.sheets->pillow.viscous_gain = 0.0;
    masked.effects = Effects::all().without(Effect::viscous);
    const Vector6d today = six(wrench(surface, motion, {}, bare).total());
    CHECK(six(wrench(surface, motion, {}, model).total()) == today);
    CHECK(six(wrench(surface, motion, {.viscosity = 0.1}, bare).total()) == today);
    CHECK(six(wrench(surface, motion, {.viscosity = 0.1}, masked).total()) == today);
    CHECK(resistance(surface, motion, {.viscosity = 0.1}, masked) == resistance(surface, motion, {}, bare));
  }
}

TEST_CASE("every function agrees with the equations at any Re, and no motion gains energy", "[viscous][property]") {
  for (unsigned seed = 1; seed <= 1000 / hostile::sanitizer_divisor; ++seed) {
    zoo::Random random(seed);
    INFO("seed " << seed);
    const hostile::Body body = hostile::body(random, false);
    const Surface surface = body.surface();
    if (surface.size() == 0) continue;
    Model model = hostile::model(random, false, false);
    if (!model.law.viscous()) model.law.stokes = 1.0, model.law.layer = 0.75, model.law.layer_curvature = 1.4;
    if (model.pillow.form == PillowForm::tilt) model.pillow = {PillowForm::tilt, 0.5, Falloff::circular, 5.9};
    const Medium medium{.density = 1.2, .viscosity = std::pow(10.0, random.uniform(-5.0, 3.0))};
    const Motion motion = hostile::motion(random);
    const WrenchByTerm exact = reference::wrench(body.mesh, body.sides, motion, medium, model), found = wrench(surface, motion, medium, model);
    const double force = hostile::force_scale(surface, motion, medium.density) + creeping_scale(surface, motion, medium),
                 arm = hostile::arm_scale(surface, motion);
    for (std::size_t term = 0; term < exact.terms.size(); ++term) {
      CHECK((found.terms[term].force - exact.terms[term].force).norm() <= 1e-11 * force);
      CHECK((found.terms[term].torque - exact.terms[term].torque).norm() <= 1e-11 * force * arm);
    }
    const Vector6d total = six(found.total());
    const TriangleForces parts = triangle_forces(surface, motion, medium, model);
    CHECK((parts.force.rowwise().sum() - total.head<3>()).norm() <= 1e-10 * force);
    CHECK((parts.torque.rowwise().sum() - total.tail<3>()).norm() <= 1e-10 * force * arm);
    const Vector6d y = (Vector6d() << motion.wind - motion.velocity, -motion.angular_velocity).finished();
    const double speed = y.head<3>().norm() + y.tail<3>().norm() * arm;
    CHECK(total.dot(y) >= -1e-11 * force * speed);  // relative to the air
    const Matrix6d s = resistance(surface, motion, medium, model);
    CHECK((s * y - total).head<3>().norm() <= 1e-9 * force);
    CHECK((s * y - total).tail<3>().norm() <= 1e-9 * force * arm);
    CHECK(s == s.transpose());
    Vector6d eigen = Eigen::SelfAdjointEigenSolver<Matrix6d>(s).eigenvalues();
    CHECK(eigen[0] >= -1e-9 * eigen[5]);
  }
}

TEST_CASE("the split of creeping flow takes what its two parts take: the cross term of travel and spin is none", "[viscous][analytic]") {
  zoo::Random random(3);
  for (const Shape& shape : zoo::shapes()) {
    const Surface surface = zoo::surface(shape, 3);
    const Model model{.law = {.name = "creeping", .stokes = 1.0}};
    const Vector3d u = random.vector(1.0), omega = random.vector(1.0), centre = surface.parts[0].creeping.centre;
    const auto power = [&](const Vector3d& flow, const Vector3d& spin) {
      // Summed triangle by triangle, about the centre.
      const TriangleForces parts = triangle_forces(surface, {.wind = flow, .angular_velocity = spin, .reference_point = centre}, medium_of(2.0), model);
      return Vector3d(parts.force.rowwise().sum()).dot(flow) - Vector3d(parts.torque.rowwise().sum()).dot(spin);
    };
    const Vector3d zero = Vector3d::Zero();
    INFO(kind(shape));
    CHECK(power(u, zero) > 0.0);
    CHECK(power(zero, omega) > 0.0);
    CHECK(power(u, omega) == Approx(power(u, zero) + power(zero, omega)).epsilon(1e-9));
  }
}

TEST_CASE("the Jacobian is the derivative, with viscosity", "[viscous][analytic]") {
  // Flat faces and no pillow, shelter or recovery: what is held still in the Jacobian, chi and the descriptors, does not change here.
  for (const Shape& shape : {Shape(Box{}), Shape(Plate{1, 1, 0})}) {
    const Surface surface = zoo::surface(shape, 1);
    const Model model{.law = sheet_law(), .quadrature = Quadrature::six};
    const Medium medium = medium_of(0.05);
    const Motion motion{.wind = {1.0, 0.4, -0.3}, .velocity = {0.1, 0, 0}, .angular_velocity = {0.05, 0.1, -0.08}};
    const Matrix6d found = force_jacobian(surface, motion, medium, model);
    for (Eigen::Index k = 0; k < 6; ++k) {
      const double step = 1e-5;
      const auto at = [&](double change) {
        Motion moved = motion;
        (k < 3 ? moved.velocity : moved.angular_velocity)[k % 3] += change;
        return six(wrench(surface, moved, medium, model).total());
      };
      const Vector6d slope = (at(step) - at(-step)) / (2.0 * step);
      CHECK((found.col(k) - slope).norm() <= 1e-6 * slope.norm());
    }
  }
}

TEST_CASE("viscous forces turn with the frame and do not know the units", "[viscous][invariance]") {
  zoo::Random random(11);
  for (const Shape& shape : zoo::shapes()) {
    const Surface surface = zoo::surface(shape, 2);
    const Model model = model_of(surface);
    const Motion motion = random.motion(3.0, 2.0);
    const Vector6d plain = six(wrench(surface, motion, {.density = 1.2, .viscosity = 0.2}, model).total());
    const Matrix3d turn = random.rotation();
    TriangleMesh mesh = triangulate(shape, 2);
    for (Vector3d& v : mesh.vertices) v = turn * v;
    const Surface turned(mesh, zoo::sides_of(shape));
    const Motion in_frame{turn * motion.wind, turn * motion.velocity, turn * motion.angular_velocity, turn * motion.reference_point};
    const Vector6d other = six(wrench(turned, in_frame, {.density = 1.2, .viscosity = 0.2}, model).total());
    INFO(kind(shape));
    CHECK((other.head<3>() - turn * plain.head<3>()).norm() <= 1e-8 * plain.head<3>().norm());
    // In millimetres: lengths and speeds times 1000, density over 1e9, viscosity over 1e3; the force in N is then 1e3 of what it was.
    for (Vector3d& v : mesh.vertices) v *= 1000.0;
    const Surface large(mesh, zoo::sides_of(shape));
    const Motion scaled{1000.0 * in_frame.wind, 1000.0 * in_frame.velocity, in_frame.angular_velocity, 1000.0 * in_frame.reference_point};
    const Vector6d scaled_force = six(wrench(large, scaled, {.density = 1.2e-9, .viscosity = 0.2e-3}, model).total());
    CHECK((scaled_force.head<3>() - 1e3 * other.head<3>()).norm() <= 1e-8 * 1e3 * other.head<3>().norm());
  }
}

TEST_CASE("a ball keeps to the drag curve up to Re 200, and validity() says where it does not", "[viscous][hard]") {
  const Surface ball = zoo::surface(Sphere{}, 16);
  const Model model = model_of(ball);
  for (const double re : {0.1, 1.0, 10.0, 30.0, 100.0, 300.0, 1e3, 3e3, 1e4, 1e5, 3e5}) {
    const Motion motion{.wind = {1, 0, 0}};
    const Medium medium = medium_of(1.0 / re);
    const double ratio = wrench(ball, motion, medium, model).total().force.x() / (pi / 8.0) / sphere_drag_coefficient(re);
    INFO("Re " << re << ": the law is " << 100.0 * (ratio - 1.0) << " % off the correlation of Clift and Gauvin");
    if (re <= 200.0) CHECK(ratio == Approx(1.0).epsilon(0.06));
    CHECK(ratio == Approx(1.0).epsilon(0.35));
    const Validity valid = validity(ball, motion, medium, model);
    CHECK(valid.has(Doubt::low_reynolds) == (re > 200.0 && re < 9e3));  // the radius of a faceted ball is its own
    CHECK(valid.has(Doubt::drag_crisis) == (re > 2e5));
    // As it was, without the medium's viscosity.
    const Validity before = validity(ball, motion, medium_of(0.0), model, 1.0 / re);
    CHECK(before.has(Doubt::low_reynolds) == (re < 9e3));
    CHECK_FALSE(before.has(Doubt::drag_crisis));
  }
}

TEST_CASE("where viscosity has no meaning it is refused with the reason", "[viscous][hard]") {
  const Surface cube = zoo::surface(Box{}, 1);
  CHECK_THROWS_WITH(wrench(cube, {}, {.viscosity = -1.0}, {}), Catch::Contains("viscosity = -1"));
  CHECK_THROWS_WITH(wrench(cube, {}, {.viscosity = std::nan("")}, {}), Catch::Contains("viscosity = nan"));
  Model model{.law = closed_law()};
  model.law.layer = -0.5;
  CHECK_THROWS_WITH(wrench(cube, {.wind = {1, 0, 0}}, {}, model), Catch::Contains("layer = -0.5"));
  const BakedBody baked = bake(cube, {.law = note_law()}, {.rms_error = 0.5});
  CHECK_THROWS_WITH(wrench(baked, {.wind = {1, 0, 0}}, medium_of(1.0)), Catch::Contains("viscosity = 1"));
  const std::vector<Eigen::Vector3i> triangles{{0, 1, 2}};
  const std::vector<Vector3d> place{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, still(3, Vector3d::Zero());
  CHECK_THROWS_WITH(reference::vertex_forces(triangles, Surface::Sides::two, place, still, {0, 0, 1}, medium_of(1.0), sheet_law()),
                    Catch::Contains("viscosity = 1"));
}
