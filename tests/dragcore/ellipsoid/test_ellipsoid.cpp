#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <dragcore/ellipsoid.hpp>
#include <limits>
#include <numbers>

#include "dragcore/src/support/ellipsoid_integrals.hpp"
#include "tests/support/zoo.hpp"

using namespace dragcore;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using std::numbers::pi;

namespace {

/// Every power of c on both sides, constants too.
const Law everything{.name = "everything", .windward = {0.1, 0.2, 2.0, -1.0, 0.3}, .leeward = {0.05, 0.4, -0.2, 0.1, 0.03}};
const Law base_suction = scaled_law(0.76, 0.4);

/// Difference of force and torque relative to the second, torque over the ellipsoid's size.
double difference(const Wrench& a, const Wrench& b, double size) {
  const double scale = b.force.norm() + b.torque.norm() / size;
  return ((a.force - b.force).norm() + (a.torque - b.torque).norm() / size) / (scale > 0.0 ? scale : 1.0);
}
double difference(const WrenchByTerm& a, const WrenchByTerm& b, double size) { return difference(a.total(), b.total(), size); }

/// Composite Gauss with five points, here so that the test does not lean on the rules it tests.
template <class F>
void gauss_panels(double from, double to, int panels, F visit) {
  constexpr double x1 = 0.5384693101056831, x2 = 0.9061798459386640, w0 = 0.5688888888888889, w1 = 0.4786286704993665,
                   w2 = 0.2369268850561891;
  const double half = 0.5 * (to - from) / panels;
  for (int i = 0; i < panels; ++i) {
    const double middle = from + (2 * i + 1) * half;
    for (const auto& [x, w] : {std::pair{-x2, w2}, {-x1, w1}, {0.0, w0}, {x1, w1}, {x2, w2}}) visit(middle + half * x, half * w);
  }
}

/// The law integrated point by point over both halves of the surface, split where the normal is across the flow. Slow, and nothing but its
/// definition.
WrenchByTerm brute_force(const Vector3d& semi, const Vector3d& u, const Law& law) {
  WrenchByTerm sum;
  const Vector3d pole = -u.cwiseQuotient(semi).normalized(), e1 = pole.unitOrthogonal(), e2 = pole.cross(e1);
  for (const bool windward : {true, false})
    gauss_panels(0.0, 1.0, 48, [&](double mu, double d_mu) {
      constexpr int turns = 320;
      for (int j = 0; j < turns; ++j) {
        const double phi = 2.0 * pi * j / turns, side = std::sqrt(1.0 - mu * mu);
        const Vector3d unit = (windward ? mu : -mu) * pole + side * (std::cos(phi) * e1 + std::sin(phi) * e2);
        const Vector3d area = semi.prod() * unit.cwiseQuotient(semi) * d_mu * 2.0 * pi / turns;
        const double c = std::abs(u.dot(area)) / (u.norm() * area.norm());
        const Vector3d force =
            (windward ? -1.0 : 1.0) * 0.5 * 1.225 * u.squaredNorm() * evaluate(windward ? law.windward : law.leeward, c) * area;
        sum[windward ? Term::windward_pressure : Term::leeward_suction] += {force, semi.cwiseProduct(unit).cross(force)};
      }
    });
  return sum;
}

Motion flow(const Vector3d& u) { return {.wind = u}; }
Law power_law(int k) {
  Law law{.name = "power"};
  law.windward[static_cast<std::size_t>(k)] = 1.0;
  return law;
}

/// Random in shape, place, motion and spin.
struct Case {
  PlacedEllipsoid body;
  Motion motion;
};
Case random_case(zoo::Random& random, double aspect, double spin) {
  const auto axis = [&] { return std::pow(aspect, -random.uniform(0.0, 1.0)); };
  return {{{axis(), axis(), axis()}, random.vector(0.3), random.rotation()}, random.motion(2.0, spin)};
}

}  // namespace

TEST_CASE("a sphere feels 3/5 of dynamic pressure times frontal area, and no torque", "[ellipsoid][analytic]") {
  const EllipsoidSurface sphere({.shape = {0.3, 0.3, 0.3}});
  const Wrench w = wrench(sphere, flow({2.0, -1.0, 0.5}), {}, note_law()).total();
  const Vector3d u(2.0, -1.0, 0.5);
  CHECK((w.force - 0.6 * 0.5 * 1.225 * u.norm() * u * pi * 0.09).norm() < 1e-13);  // rounding
  CHECK(w.torque.norm() < 1e-15);
  // Powers of c one by one: C_D = 2 / (k + 2).
  for (int k = 0; k <= 4; ++k)
    CHECK_THAT(wrench(sphere, flow({1, 0, 0}), {}, power_law(k)).total().force.x() / (0.5 * 1.225 * pi * 0.09),
               WithinRel(2.0 / (k + 2), 1e-12));  // the rule's own error, 4e-13 for c^4
}

TEST_CASE("spheroids along their axis feel the closed forms, from discs of 1:10000 to needles of 10000:1", "[ellipsoid][analytic][hard]") {
  for (const double aspect : {1e-4, 1e-2, 0.1, 0.5, 2.0, 10.0, 100.0, 1e4}) {
    const EllipsoidSurface body({.shape = {aspect, 1.0, 1.0}});
    const auto drag_coefficient = [&](int k) {
      return wrench(body, flow({1, 0, 0}), {}, power_law(k)).total().force.x() / (0.5 * 1.225 * pi);
    };
    // c^2 = (1 - t) / (1 + (m - 1) t) at t = (r/b)^2, m = (a/b)^2: C_D = int c^k dt.
    const double m = aspect * aspect, d = m - 1.0;
    INFO("aspect ratio " << aspect);
    CHECK_THAT(drag_coefficient(0), WithinRel(1.0, 1e-12));
    CHECK_THAT(drag_coefficient(2), WithinRel((m * std::log(m) - d) / (d * d), 1e-12));
    CHECK_THAT(drag_coefficient(4), WithinRel(((m * m - 1.0) - 2.0 * m * std::log(m)) / (d * d * d), 1e-12));
  }
}

TEST_CASE("prolate ellipsoids of 2:1 and 4:1 have the drag known from numerical integration", "[ellipsoid][regression]") {
  for (const auto& [length, drag] : {std::pair{2.0, 0.372}, {4.0, 0.187}})
    CHECK_THAT(
        wrench(EllipsoidSurface({.shape = {length, 1.0, 1.0}}), flow({1, 0, 0}), {}, note_law()).total().force.x() / (0.5 * 1.225 * pi),
        WithinAbs(drag, 5e-4));  // as printed
}

TEST_CASE("force and torque are the surface integral, term by term, at any incidence", "[ellipsoid][analytic]") {
  zoo::Random random(61);
  for (const Vector3d& semi : {Vector3d(0.8, 0.5, 0.3), Vector3d(1.0, 0.4, 0.4), Vector3d(0.3, 1.0, 1.0), Vector3d(0.3, 0.9, 0.5)})
    for (int i = 0; i < 5; ++i) {
      const Vector3d u = i < 3 ? Vector3d::Unit(i) : random.vector(2.0);
      const WrenchByTerm exact = brute_force(semi, u, everything);
      const WrenchByTerm fast = wrench(EllipsoidSurface({.shape = {semi[0], semi[1], semi[2]}}), flow(u), {}, everything);
      for (std::size_t term = 0; term < fast.terms.size(); ++term)
        CHECK(difference(fast.terms[term], exact.terms[term], 1.0) < 1e-11);  // the brute-force rule is good to about that at aspect 3
    }
}

TEST_CASE("twelve points per panel are exact to 1e-12 at every aspect ratio, and errors fall geometrically with points",
          "[ellipsoid][convergence]") {
  // int tau^(1/2) shrink_i root dtau a b c: Lamb's integrals, which sum to 2 for every ellipsoid.
  const auto error = [](const Vector3d& scaled, auto points) {
    double sum = 0.0;
    for_each_ellipsoid_node<decltype(points)::value>(scaled, [&](double tau, double d_tau, const Vector3d& shrink, double root) {
      sum += scaled.prod() * std::sqrt(tau) * root * shrink.sum() * d_tau;
    });
    return std::abs(sum / 2.0 - 1.0);
  };
  for (const double aspect : {1.0, 2.0, 10.0, 100.0, 1e4, 1e6})
    for (const Vector3d& scaled :
         {Vector3d(1, 1 / aspect, 1 / aspect), Vector3d(1, 1, 1 / aspect), Vector3d(1, 1 / std::sqrt(aspect), 1 / aspect)}) {
      INFO("semi-axes " << scaled.transpose());
      CHECK(error(scaled, std::integral_constant<int, 12>{}) < 1e-12);
      // Bernstein ellipses of radius 3.4 (middle panels) and 4.6 (ends): error of N points about 3.4^-2N; the factor 10 covers the height
      // of the integrand.
      CHECK(error(scaled, std::integral_constant<int, 4>{}) < 10 * std::pow(3.4, -8));
      CHECK(error(scaled, std::integral_constant<int, 6>{}) < 10 * std::pow(3.4, -12));
      CHECK(error(scaled, std::integral_constant<int, 8>{}) < 10 * std::pow(3.4, -16));
    }
}

TEST_CASE("triangles converge to the ellipsoid with second order, with and without spin", "[ellipsoid][convergence]") {
  zoo::Random random(62);
  for (const double spin : {0.0, 3.0})
    for (int i = 0; i < 4; ++i) {
      const Case c = random_case(random, 4.0, spin);
      const Law law = i % 2 ? note_law() : base_suction;
      // A fine rule, so that what is left is the error of the triangles.
      const WrenchByTerm exact = wrench(EllipsoidSurface(c.body, 12), c.motion, {}, law);
      double error[2];
      for (const int level : {0, 1}) {
        const TriangleMesh mesh = transformed(triangulate(c.body.shape, level ? 40 : 10), c.body.axes, c.body.centre);
        error[level] = difference(wrench(Surface(mesh), c.motion, {}, {.law = law, .quadrature = Quadrature::six}), exact, 1.0);
      }
      INFO("spin " << spin << ", errors " << error[0] << ' ' << error[1]);
      CHECK(error[1] < 2e-3);
      const double order = std::log2(error[0] / error[1]) / 2.0;
      CHECK(order > 1.6);  // second order, with scatter from where the edge of the windward side cuts the triangles
      CHECK(order < 2.5);
    }
}

TEST_CASE("with spin the default rule is within 1e-3, for needles and discs up to 1:1000 and for any ratio of spin to translation",
          "[ellipsoid][convergence]") {
  zoo::Random random(63);
  double worst = 0.0;
  for (const double aspect : {1.0, 10.0, 1000.0})
    for (const double spin : {0.1, 2.0, 100.0})
      for (int i = 0; i < 6; ++i) {
        Case c = random_case(random, aspect, spin);
        if (i == 0)
          c.motion = {.wind = {1e-3, 2e-3, 1.0}, .angular_velocity = c.body.axes.col(1) * spin};  // along an axis, where little is felt
        const Law law = i % 2 ? note_law() : base_suction;
        const double size = std::max({c.body.shape.semi_x, c.body.shape.semi_y, c.body.shape.semi_z});
        c.motion.reference_point = c.body.centre;
        worst = std::max(worst, difference(wrench(EllipsoidSurface(c.body), c.motion, {}, law),
                                           wrench(EllipsoidSurface(c.body, 14), c.motion, {}, law), size));
      }
  CHECK(worst < 1e-3);
  CHECK(worst > 1e-6);  // or the comparison compares a rule with itself
}

TEST_CASE("the rule for spin converges with second order or better", "[ellipsoid][convergence]") {
  // The edge of the windward side cuts through the panels: a kink in the pressure, second order; the sum over cuts makes it a little
  // better.
  zoo::Random random(64);
  double coarse = 0.0, fine = 0.0;
  for (int i = 0; i < 20; ++i) {
    Case c = random_case(random, 5.0, 3.0);
    c.motion.reference_point = c.body.centre;
    const WrenchByTerm exact = wrench(EllipsoidSurface(c.body, 20), c.motion, {}, base_suction);
    coarse += std::pow(difference(wrench(EllipsoidSurface(c.body, 2), c.motion, {}, base_suction), exact, 1.0), 2);
    fine += std::pow(difference(wrench(EllipsoidSurface(c.body, 6), c.motion, {}, base_suction), exact, 1.0), 2);
  }
  const double order = 0.5 * std::log(coarse / fine) / std::log(3.0);
  CHECK(order > 1.9);
  CHECK(order < 4.0);
}

TEST_CASE("spin that fades leaves the force of steady flow", "[ellipsoid][limit]") {
  zoo::Random random(65);
  for (int i = 0; i < 10; ++i) {
    Case c = random_case(random, 10.0, 0.0);
    const EllipsoidSurface surface(c.body);
    const WrenchByTerm still = wrench(surface, c.motion, {}, base_suction);
    c.motion.angular_velocity = random.vector(1e-9);
    CHECK(difference(wrench(surface, c.motion, {}, base_suction), still, 1.0) <
          1e-3);  // the error of the rule for spin: the seam between the two
  }
}

TEST_CASE("turning the ellipsoid and everything with it turns the wrench", "[ellipsoid][invariance]") {
  zoo::Random random(66);
  for (const double spin : {0.0, 3.0}) {
    const Case c = random_case(random, 10.0, spin);
    const Matrix3d R = random.rotation();
    const Wrench before = wrench(EllipsoidSurface(c.body), c.motion, {}, everything).total();
    const Case t{{c.body.shape, R * c.body.centre, R * c.body.axes},
                 {R * c.motion.wind, R * c.motion.velocity, R * c.motion.angular_velocity, R * c.motion.reference_point}};
    const Wrench after = wrench(EllipsoidSurface(t.body), t.motion, {}, everything).total();
    // Rounding; a point within it of the windward edge may change sides, which moves a constant pressure (not a continuous law) by its
    // share.
    CHECK(difference({R * before.force, R * before.torque}, after, 1.0) < 1e-11);
  }
}

TEST_CASE("naming the axes of an ellipsoid in another order changes nothing", "[ellipsoid][invariance]") {
  zoo::Random random(67);
  for (const double spin : {0.0, 3.0}) {
    const Case c = random_case(random, 10.0, spin);
    PlacedEllipsoid renamed = c.body;
    renamed.shape = {c.body.shape.semi_y, c.body.shape.semi_z, c.body.shape.semi_x};
    renamed.axes << c.body.axes.col(1), c.body.axes.col(2), c.body.axes.col(0);
    CHECK(difference(wrench(EllipsoidSurface(renamed), c.motion, {}, note_law()),
                     wrench(EllipsoidSurface(c.body), c.motion, {}, note_law()), 1.0) < 1e-12);
  }
}

TEST_CASE("mirroring the motion mirrors force, and torque as an axial vector", "[ellipsoid][invariance]") {
  zoo::Random random(68);
  const Matrix3d mirror = Vector3d(1, -1, 1).asDiagonal();  // a symmetry of the ellipsoid
  for (const double spin : {0.0, 3.0}) {
    const EllipsoidSurface surface({.shape = {0.8, 0.5, 0.3}});
    Motion m = random.motion(2.0, spin);
    m.reference_point.setZero();
    const Motion mirrored{mirror * m.wind, mirror * m.velocity, -(mirror * m.angular_velocity), Vector3d::Zero()};
    const Wrench before = wrench(surface, m, {}, base_suction).total(), after = wrench(surface, mirrored, {}, base_suction).total();
    CHECK(difference({mirror * before.force, -(mirror * before.torque)}, after, 1.0) < 1e-13);
  }
}

TEST_CASE("force goes with the square of size and speed, torque with the cube of size, over twelve decades",
          "[ellipsoid][invariance][hard]") {
  zoo::Random random(69);
  for (const double spin : {0.0, 3.0}) {
    const Case c = random_case(random, 10.0, spin);
    const Wrench base = wrench(EllipsoidSurface(c.body), c.motion, {}, base_suction).total();
    for (const double s : {1e-6, 1e6})
      for (const double k : {1e-12, 1e4}) {
        const PlacedEllipsoid body{
            {s * c.body.shape.semi_x, s * c.body.shape.semi_y, s * c.body.shape.semi_z}, s * c.body.centre, c.body.axes};
        const Motion m{k * c.motion.wind, k * c.motion.velocity, k / s * c.motion.angular_velocity, s * c.motion.reference_point};
        const Wrench w = wrench(EllipsoidSurface(body), m, {}, base_suction).total();
        CHECK(difference({w.force / (s * s * k * k), w.torque / (s * s * s * k * k)}, base, 1.0) < 1e-12);
      }
  }
}

TEST_CASE("only velocity relative to the air matters", "[ellipsoid][invariance]") {
  zoo::Random random(70);
  const Case c = random_case(random, 10.0, 2.0);
  Motion moved = c.motion;
  const Vector3d boost = random.vector(5.0);
  moved.wind += boost;
  moved.velocity += boost;
  const EllipsoidSurface surface(c.body);
  CHECK(difference(wrench(surface, moved, {}, note_law()), wrench(surface, c.motion, {}, note_law()), 1.0) < 1e-12);
}

TEST_CASE("moving the reference point moves the torque by the arm, when the motion stays the same", "[ellipsoid][invariance]") {
  zoo::Random random(71);
  for (const double spin : {0.0, 3.0}) {
    const Case c = random_case(random, 10.0, spin);
    const EllipsoidSurface surface(c.body);
    const Wrench here = wrench(surface, c.motion, {}, note_law()).total();
    const Vector3d step = random.vector(1.0);
    Motion m = c.motion;
    m.reference_point += step;
    m.velocity += m.angular_velocity.cross(step);
    const Wrench there = wrench(surface, m, {}, note_law()).total();
    CHECK(difference({here.force, here.torque - step.cross(here.force)}, there, 1.0) < 1e-12);
  }
}

TEST_CASE("a wind from ahead drives back, and a long ellipsoid with its nose up is lifted and turned nose up", "[ellipsoid][sign]") {
  const Matrix3d nose_up = Pose{.incidence = 0.3}.rotation();
  const Wrench w = wrench(EllipsoidSurface({.shape = {2.0, 0.5, 0.5}, .axes = nose_up}), flow({1, 0, 0}), {}, note_law()).total();
  CHECK(w.force.x() > 0.0);
  CHECK(w.force.z() > 0.0);
  // Windward pressure is highest on the part of the belly near the nose, where the normal meets the flow best.
  CHECK(w.torque.y() > 0.0);
}

TEST_CASE("in still air an ellipsoid never gains energy, however it moves", "[ellipsoid][invariance]") {
  zoo::Random random(72);
  for (const double spin : {0.0, 0.3, 30.0})
    for (int i = 0; i < 60; ++i) {
      Case c = random_case(random, 100.0, spin);
      c.motion.wind.setZero();
      const Wrench w = wrench(EllipsoidSurface(c.body, 1), c.motion, {}, base_suction).total();
      const double power = w.force.dot(c.motion.velocity) + w.torque.dot(c.motion.angular_velocity);
      // Rounding of the sum, to the size of its parts.
      CHECK(power <= 1e-14 * (w.force.norm() * c.motion.velocity.norm() + w.torque.norm() * c.motion.angular_velocity.norm()));
    }
}

TEST_CASE("a spinning sphere feels no torque from pressure, and a body spun about its axis of revolution feels none either",
          "[ellipsoid][limit]") {
  const EllipsoidSurface sphere({.shape = {0.5, 0.5, 0.5}}), egg({.shape = {1.0, 0.5, 0.5}});
  CHECK(wrench(sphere, {.velocity = {1, 2, 3}, .angular_velocity = {30, -20, 10}}, {}, note_law()).total().torque.norm() < 1e-12);
  // Symmetric in z: what pressure does about x cancels to the bit of the sum.
  CHECK(std::abs(wrench(egg, {.velocity = {1, 0, 0.5}, .angular_velocity = {30, 0, 0}}, {}, note_law()).total().torque.x()) < 1e-12);
}

TEST_CASE("extreme sizes, aspect ratios, speeds and spins stay finite and right", "[ellipsoid][hard]") {
  for (const double size : {1e-6, 1.0, 1e6})
    for (const Vector3d& ratio : {Vector3d(1, 1, 1), Vector3d(1, 1e-4, 1e-4), Vector3d(1, 1, 1e-4), Vector3d(1e-4, 1, 1e-2)})
      for (const double speed : {0.0, 5e-324, 1e-300, 1e-12, 1e4})
        for (const double spin : {0.0, 1e-300, 1.0, 1e6}) {
          const EllipsoidSurface body({.shape = {size * ratio[0], size * ratio[1], size * ratio[2]}}, 1);
          const Wrench w =
              wrench(body, {.wind = Vector3d(0.6, 0.0, 0.8) * speed, .angular_velocity = Vector3d(1, 1, 1) * spin}, {}, base_suction)
                  .total();
          INFO("size " << size << " ratio " << ratio.transpose() << " speed " << speed << " spin " << spin);
          CHECK(w.force.allFinite());
          CHECK(w.torque.allFinite());
          // No more than the whole surface (area below that of the sphere around it) under its highest pressure, W + L <= 1.16 with this
          // law.
          const double fastest = speed + spin * 2.0 * size;
          CHECK(w.force.norm() <= 1.2 * 0.5 * 1.225 * fastest * fastest * 4 * pi * size * size);
        }
  // One ulp of flow beside an axis.
  const EllipsoidSurface needle({.shape = {1.0, 1e-4, 1e-4}});
  const Wrench on = wrench(needle, flow({1, 0, 0}), {}, note_law()).total(),
               beside = wrench(needle, flow({1, 1e-16, 0}), {}, note_law()).total();
  CHECK(difference(on, beside, 1.0) < 1e-7);  // the lateral force of a needle of 1:10000 is 1e8 times steeper than its drag
}

TEST_CASE("an infinitely thin disc face-on becomes a sheet with pressure on its windward side", "[ellipsoid][limit]") {
  const double thin = 1e-5;
  const Wrench w = wrench(EllipsoidSurface({.shape = {thin, 1.0, 1.0}}), flow({1, 0, 0}), {}, note_law()).total();
  // 1 - C_D = O(m ln m) with m = thin^2
  CHECK_THAT(w.force.x() / (0.5 * 1.225 * pi), WithinAbs(1.0, 1e-8));
}

TEST_CASE("an ellipsoid or motion out of range is refused with the value and what is needed", "[ellipsoid][hard]") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_WITH(EllipsoidSurface({.shape = {1.0, 0.0, 1.0}}), Catch::Contains("semi_y") && Catch::Contains("0"));
  CHECK_THROWS_WITH(EllipsoidSurface({.shape = {nan, 1.0, 1.0}}), Catch::Contains("semi_x"));
  CHECK_THROWS_WITH(EllipsoidSurface({.centre = {nan, 0, 0}}), Catch::Contains("centre") && Catch::Contains("finite"));
  CHECK_THROWS_WITH(EllipsoidSurface({.axes = 2.0 * Matrix3d::Identity()}), Catch::Contains("rotation"));
  CHECK_THROWS_WITH(EllipsoidSurface({.axes = Vector3d(1, 1, -1).asDiagonal()}), Catch::Contains("determinant +1"));
  CHECK_THROWS_WITH(EllipsoidSurface({}, 0), Catch::Contains("panels_per_quarter = 0"));
  const EllipsoidSurface sphere(PlacedEllipsoid{});
  CHECK_THROWS_WITH(wrench(sphere, flow({nan, 0, 0}), {}, note_law()), Catch::Contains("motion.wind") && Catch::Contains("finite"));
  CHECK_THROWS_WITH(wrench(sphere, flow({1, 0, 0}), {.density = -1.0}, note_law()), Catch::Contains("density = -1"));
}
