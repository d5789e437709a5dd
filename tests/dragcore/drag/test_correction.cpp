#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <dragcore/bake.hpp>
#include <dragcore/batch.hpp>
#include <dragcore/required_effects.hpp>
#include <dragcore/stepping.hpp>
#include <dragcore/validity.hpp>

#include "tests/support/meshes.hpp"
#include "tests/support/zoo.hpp"

using namespace dragcore;
using Catch::Contains;
using Catch::Matchers::WithinRel;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// Force along, against and across the flow, and a torque: smooth over direction, `size` of order of the law's own coefficients.
std::shared_ptr<const Correction> correction_of(double size, const Matrix3d& turned = Matrix3d::Identity()) {
  Correction made{.map = DirectionMap::zero(6, 1), .origin = "a test"};
  for (int node = 0; node < made.map.nodes(); ++node) {
    const Vector3d d = turned.transpose() * made.map.direction(node);
    const Vector3d force = size * (Vector3d(0.3, -0.5, 0.4).cwiseProduct(d) + 0.5 * Vector3d(d.y() * d.z(), 0.3, d.x() * d.x()));
    made.map.set(node, 0, turned * force, turned * (size * Vector3d(0.2 * d.z(), -0.3 * d.x() * d.y(), 0.1)));
  }
  return std::make_shared<const Correction>(made);
}

Model corrected(const Surface& surface, double size) {
  Model model = zoo::exactly(model_for(surface));
  model.correction = correction_of(size);
  return model;
}

Vector6d six(const Wrench& w) { return (Vector6d() << w.force, w.torque).finished(); }

/// Taken from the motion of the body through a uniform air [W].
double power(const Wrench& w, const Motion& m) { return w.force.dot(m.wind - m.velocity) - w.torque.dot(m.angular_velocity); }

}  // namespace

TEST_CASE("at a node a correction is its row times density/2 speed^2 area, about the centre; and goes with them",
          "[correction][analytic]") {
  const TriangleMesh box = triangulate(Box{2.0, 1.0, 0.6}, 2);
  const Surface surface(box, Surface::Sides::one);
  const Model model = corrected(surface, 0.05);
  for (const int node : {3, 40, 84, 120}) {
    const Vector3d u = 7.0 * model.correction->map.direction(node), point(0.3, -0.2, 0.5);
    const Motion motion{.wind = u, .reference_point = point};
    const Wrench found = wrench(surface, motion, {.density = 1.3}, model)[Term::correction];
    const float* row = model.correction->map.row(node, 0);
    const double q_area = 0.5 * 1.3 * 49.0 * surface.total_area;
    const Vector3d force = q_area * Vector3d(row[0], row[1], row[2]), torque = q_area * surface.radius * Vector3d(row[4], row[5], row[6]);
    // 1e-6: the floats of the map, and its weights; the drag of these rows is far from where the share is below 1.
    CHECK((found.force - force).norm() < 1e-6 * force.norm());
    CHECK((found.torque - torque - (surface.centre - point).cross(force)).norm() < 1e-6 * (torque.norm() + force.norm()));

    const Surface twice(support::scaled(box, 2.0), Surface::Sides::one);
    const Wrench larger = wrench(twice, {.wind = 3.0 * u, .reference_point = 2.0 * point}, {.density = 2.6}, model)[Term::correction];
    CHECK((larger.force - 2.0 * 9.0 * 4.0 * found.force).norm() < 1e-9 * larger.force.norm());
    CHECK((larger.torque - 2.0 * 9.0 * 8.0 * found.torque).norm() < 1e-9 * larger.torque.norm());
  }
}

TEST_CASE("turned with its body, a correction turns; masked off it is not there, and the rest of the wrench is as without",
          "[correction][invariance]") {
  // A quarter turn about z maps the octahedron of the map onto itself, so that nothing is interpolated anew.
  const Matrix3d quarter = Eigen::AngleAxisd(0.5 * std::numbers::pi, Vector3d::UnitZ()).toRotationMatrix();
  const TriangleMesh box = triangulate(Box{2.0, 1.0, 0.6}, 2);
  const Surface surface(box, Surface::Sides::one), turned(transformed(box, quarter, Vector3d::Zero()), Surface::Sides::one);
  Model model = corrected(surface, 0.1), model_turned = model;
  model_turned.correction = correction_of(0.1, quarter);
  zoo::Random random(5);
  for (int k = 0; k < 50; ++k) {
    const Motion motion = random.motion(5.0, 2.0);
    const Motion motion_turned{quarter * motion.wind, quarter * motion.velocity, quarter * motion.angular_velocity,
                               quarter * motion.reference_point, quarter * motion.wind_gradient * quarter.transpose()};
    const Wrench a = wrench(surface, motion, {}, model).total(), b = wrench(turned, motion_turned, {}, model_turned).total();
    CHECK((quarter * a.force - b.force).norm() < 1e-6 * a.force.norm());  // floats in the map
    CHECK((quarter * a.torque - b.torque).norm() < 1e-6 * (a.torque.norm() + a.force.norm()));
    Model masked = model, without = model;
    masked.effects = masked.effects.without(Effect::correction);
    without.correction.reset();
    CHECK(six(wrench(surface, motion, {}, masked).total()) == six(wrench(surface, motion, {}, without).total()));
    CHECK(resistance(surface, motion, {}, masked) == resistance(surface, motion, {}, without));
    WrenchByTerm split = wrench(surface, motion, {}, model);
    split[Term::correction] = {};
    CHECK(six(split.total()) == six(wrench(surface, motion, {}, without).total()));
  }
}

TEST_CASE("the slow reference, the triangles and a batch have the same correction", "[correction][backend]") {
  zoo::Random random(6);
  for (const Shape& shape : {Shape(Box{2.0, 1.0, 0.6}), Shape(Plate{1.0, 1.0, 0.0}), Shape(Cone{})}) {
    const TriangleMesh mesh = triangulate(shape, 2);
    const Surface surface(mesh, zoo::sides_of(shape));
    for (const double size : {0.05, 0.5, 5.0}) {  // the last mostly held back
      const Model model = corrected(surface, size);
      std::vector<BodyInFlow> bodies;
      for (int k = 0; k < 20; ++k) bodies.push_back({&surface, &model, random.motion(5.0, k % 2 ? 3.0 : 0.0)});
      std::vector<Wrench> together(bodies.size());
      wrenches(bodies, {}, together);
      for (std::size_t k = 0; k < bodies.size(); ++k) {
        const Motion& motion = bodies[k].motion;
        const Vector6d found = six(wrench(surface, motion, {}, model).total());
        CHECK((six(together[k]) - found).norm() == 0.0);
        // 1e-6: weights of the map are floats.
        CHECK((six(reference::wrench(mesh, zoo::sides_of(shape), motion, {}, model).total()) - found).norm() < 1e-5 * found.norm());
        const TriangleForces parts = triangle_forces(surface, motion, {}, model);
        const Vector6d sum = (Vector6d() << parts.force.rowwise().sum(), parts.torque.rowwise().sum()).finished();
        CHECK((sum - found).norm() < 1e-10 * found.norm());
      }
    }
  }
}

TEST_CASE("however large, a correction leaves the air taking a twentieth of what the law takes, at any spin", "[correction][limit]") {
  zoo::Random random(7);
  for (const Shape& shape : zoo::shapes()) {
    const Surface surface = zoo::surface(shape, 2);
    for (const double size : {0.1, 1.0, 100.0})
      for (int k = 0; k < 60; ++k) {
        Model model = corrected(surface, size), law = model;
        law.correction.reset();
        Motion motion = random.motion(5.0, 4.0 * (k % 3));
        motion.wind_gradient.setZero();
        const double without = power(wrench(surface, motion, {}, law).total(), motion),
                     with = power(wrench(surface, motion, {}, model).total(), motion);
        CHECK(with >= (1.0 - largest_gain) * without * (1 - 1e-9));  // rounding
        const Matrix6d s = resistance(surface, motion, {}, model);
        const Vector6d v = (Vector6d() << motion.wind - motion.velocity, -motion.angular_velocity).finished();
        const Vector6d found = six(wrench(surface, motion, {}, model).total());
        CHECK((s * v - found).norm() < 1e-9 * (found.norm() + s.norm() * v.norm()));
        CHECK((s - s.transpose()).norm() == 0.0);
        CHECK(Eigen::SelfAdjointEigenSolver<Matrix6d>(s).eigenvalues().minCoeff() > -1e-13 * s.norm());
      }
  }
}

TEST_CASE("in free flight with spin, a corrected body never gains energy relative to a uniform wind", "[correction][stepping]") {
  for (const Shape& shape : {Shape(Plate{0.1, 0.1, 0.0}), Shape(Box{0.2, 0.1, 0.05}), Shape(Cone{})}) {
    const Surface surface = zoo::surface(shape, 1);
    const MassProperties body{0.01, Vector3d(2e-5, 1.5e-5, 3e-5).asDiagonal()};
    for (const double size : {0.3, 30.0})
      for (const double dt : {1e-3, 1.0 / 60}) {
        const Model model = corrected(surface, size);
        const Vector3d wind(4, 1, -2);
        Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();
        Vector3d velocity(0, 3, 9), spin(5, -30, 20);
        const auto energy = [&] { return 0.5 * body.mass * (velocity - wind).squaredNorm() + 0.5 * spin.dot(body.inertia * spin); };
        double before = energy(), first = before;  // spin in the body's frame
        for (int step = 0; step < 3000; ++step) {
          const Matrix3d to_body = turn.toRotationMatrix().transpose();
          Motion motion{.wind = to_body * wind, .velocity = to_body * velocity};
          motion.angular_velocity = gyroscopic_spin(body, spin, dt);
          const Vector6d next = step_secant_implicit(resistance(surface, motion, {}, model), body, motion, Vector6d::Zero(), dt);
          velocity = to_body.transpose() * next.head<3>(), spin = next.tail<3>();
          turn = (turn * Eigen::AngleAxisd(dt * spin.norm(), spin.stableNormalized())).normalized();
          const double now = energy();
          REQUIRE(now <= before + 1e-12 * first);  // rounding of the rotations
          before = now;
        }
        CHECK(before < 0.5 * first);  // and what is left does brake: 3 s at least
      }
  }
}

TEST_CASE("a correction is continuous over direction and fades with spin", "[correction][limit]") {
  const Surface surface = zoo::surface(Box{2.0, 1.0, 0.6}, 2);
  const Model model = corrected(surface, 3.0);  // held back in places
  const auto felt = [&](const Vector3d& u, const Vector3d& spin) {
    return six(wrench(surface, {.wind = u, .angular_velocity = spin}, {}, model)[Term::correction]);
  };
  const double size = felt({1, 0, 0}, Vector3d::Zero()).norm() + felt({0, 1, 1}, Vector3d::Zero()).norm();
  for (int k = 0; k < 4000; ++k) {
    const auto at = [](int i) {
      const double angle = 2.0 * std::numbers::pi * i / 4000;
      return Vector3d(std::cos(angle), 0.7 * std::sin(angle), 0.5 * std::sin(2.0 * angle)).normalized();
    };
    // A step of 1.6e-3 rad; slopes are of order 1, and ten of it is the share's where the law's power is small.
    REQUIRE((felt(at(k + 1), Vector3d::Zero()) - felt(at(k), Vector3d::Zero())).norm() < 0.05 * size);
  }
  const double straight = felt({1, 0.2, 0.1}, Vector3d::Zero()).norm();
  CHECK(felt({1, 0.2, 0.1}, Vector3d(0, 0, 1) * 10.0 / surface.radius).norm() < 0.03 * straight);  // 1/(1 + 100)
  CHECK(felt(Vector3d::Zero(), Vector3d(0, 0, 3)).norm() < 1e-20);                                 // the centre is at rest but for rounding
}

TEST_CASE("the Jacobian has the correction's slope", "[correction][analytic]") {
  const Surface surface = zoo::surface(Box{2.0, 1.0, 0.6}, 2);
  Model model = corrected(surface, 0.03);  // so small that the share is 1
  model.law = note_law(), model.pillow = {};
  Model law = model;
  law.correction.reset();
  zoo::Random random(9);
  for (int k = 0; k < 20; ++k) {
    Motion motion = random.motion(5.0, 0.5);
    motion.wind_gradient.setZero();
    const Matrix6d slopes = force_jacobian(surface, motion, {}, model) - force_jacobian(surface, motion, {}, law);
    for (Eigen::Index c = 0; c < 6; ++c) {
      constexpr double step = 1e-5;
      const auto at = [&](double change) {
        Motion moved = motion;
        (c < 3 ? moved.velocity : moved.angular_velocity)[c % 3] += change;
        return six(wrench(surface, moved, {}, model)[Term::correction]);
      };
      // The map is linear by pieces, and the two steps differ: a piece may begin between them.
      CHECK((slopes.col(c) - (at(step) - at(-step)) / (2 * step)).norm() < 0.02 * slopes.norm());
    }
  }
}

TEST_CASE("another body, another medium, a map that is not whole are refused; size, place and triangles are not looked at",
          "[correction][limit]") {
  const TriangleMesh mesh = triangulate(Cone{}, 8);
  const Surface surface(mesh, Surface::Sides::one);
  Correction known = *correction_of(0.1);
  known.body = surface.shape_moments;
  Model model = model_for(surface);
  model.correction = std::make_shared<const Correction>(known);
  const Motion motion{.wind = {3, 1, 0}};
  CHECK_NOTHROW(wrench(surface, motion, {}, model));
  const TriangleMesh elsewhere = transformed(mesh, 0.02 * Matrix3d::Identity(), Vector3d(5, 0, 1));
  CHECK_NOTHROW(wrench(Surface(elsewhere, Surface::Sides::one), motion, {}, model));
  // Flat faces cut finer are the same body.
  Correction of_box = known;
  of_box.body = zoo::surface(Box{2, 1, 1}, 1).shape_moments;
  Model box_model = model;
  box_model.correction = std::make_shared<const Correction>(of_box);
  CHECK_NOTHROW(wrench(zoo::surface(Box{2, 1, 1}, 3), motion, {}, box_model));
  for (const Matrix3d& other : {Matrix3d(Eigen::AngleAxisd(0.1, Vector3d::UnitY()).toRotationMatrix()),
                                Matrix3d(Eigen::AngleAxisd(std::numbers::pi, Vector3d::UnitZ()).toRotationMatrix()),  // the third moments
                                Matrix3d(Vector3d(1.01, 1, 1).asDiagonal())})
    CHECK_THROWS_WITH(wrench(Surface(transformed(mesh, other, Vector3d::Zero()), Surface::Sides::one), motion, {}, model),
                      Contains("shape moments") && Contains("calibrate this one"));
  Correction viscous = known;
  viscous.viscous = true;
  model.correction = std::make_shared<const Correction>(viscous);
  CHECK_THROWS_WITH(wrench(surface, motion, {}, model), Contains("set Medium::viscosity"));
  CHECK_NOTHROW(wrench(surface, motion, {.viscosity = 1e-3}, model));
  Correction torn = known;
  torn.map.values.pop_back();
  model.correction = std::make_shared<const Correction>(torn);
  CHECK_THROWS_WITH(wrench(surface, motion, {}, model), Contains("numbers of its map"));
  CHECK_THROWS_AS(validate(torn), std::invalid_argument);
}

TEST_CASE("a correction is baked, bounded by required_effects, and its range of Re is known to validity", "[correction][analytic]") {
  const Surface surface = zoo::surface(Box{2.0, 1.0, 0.6}, 2);
  Correction ranged = *correction_of(0.1);
  ranged.least_reynolds = ranged.most_reynolds = 1e5;
  Model model = zoo::exactly(model_for(surface));
  const BakedBody before = bake(surface, model, {.rms_error = 0.03});
  model.correction = std::make_shared<const Correction>(ranged);
  const BakedBody body = bake(surface, model, {.rms_error = 0.03});
  CHECK(body.matches(surface, model));
  CHECK_FALSE(before.matches(surface, model));
  CHECK_THAT(body.model, Contains("correction of a test"));
  zoo::Random random(11);
  double worst = 0.0;
  for (int k = 0; k < 200; ++k) {
    const Motion motion{.wind = random.vector(5.0)};
    const Wrench truth = wrench(surface, motion, {}, model).total(), found = wrench(body, motion, {});
    worst = std::max(worst, (truth.force - found.force).norm() / (0.5 * 1.225 * motion.wind.squaredNorm() * body.area * body.rms_force));
    RequiredEffects effects = required_effects({.surface = surface, .motion = motion, .model = model});
    CHECK(effects.effects.has(Effect::correction));
    const EffectNeed need = effects.needs[effect_count - 1];
    CHECK(need.name == "correction");
    CHECK(wrench(surface, motion, {}, model)[Term::correction].force.norm() <= need.force);
  }
  CHECK(worst < 0.15);  // 3 % rms; kinks of the law are several times that
  const double at_1e5 = 1e5 * 1.8e-5 / 1.225 / (2.0 * surface.radius);
  CHECK_FALSE(validity(surface, {.wind = {at_1e5, 0, 0}}, {}, model).has(Doubt::not_calibrated));
  CHECK(validity(surface, {.wind = {0.1 * at_1e5, 0, 0}}, {}, model).has(Doubt::not_calibrated));
  CHECK(validity(surface, {.wind = {10 * at_1e5, 0, 0}}, {}, model).has(Doubt::not_calibrated));
}
