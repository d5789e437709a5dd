// Properties that hold for every body, motion and law, tried on random ones: 100,000 in double, and as many by the kernels. Each case has a
// seed of its own, which a failure names.

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <dragcore/descriptors.hpp>
#include <dragcore/stepping.hpp>
#include <numbers>

#include "tests/dragcore/drag/hostile.hpp"

using namespace dragcore;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using std::numbers::pi;

namespace {

/// Fails with the seed, once: CHECK for each of millions of numbers would cost more than what it checks.
class Worst {
 public:
  void see(double value, unsigned seed) {
    if (!(value <= value_)) value_ = std::isnan(value) ? INFINITY : value, seed_ = seed;  // NaN is worst
  }
  double value() const { return value_; }
  unsigned seed() const { return seed_; }

 private:
  double value_ = 0.0;
  unsigned seed_ = 0;
};

#define CHECK_WORST(worst, bound)                                                        \
  do {                                                                                   \
    INFO("largest " << #worst << ' ' << (worst).value() << ", seed " << (worst).seed()); \
    CHECK((worst).value() <= (bound));                                                   \
  } while (false)

Vector6d six(const Wrench& w) { return (Vector6d() << w.force, w.torque).finished(); }
Vector6d through_air(const Motion& m) { return (Vector6d() << m.wind - m.velocity, -m.angular_velocity).finished(); }

/// Largest of the law's coefficients, to scale rounding errors by. What single precision promises of known laws has no such factor.
double strength(const Law& law, Precision precision = Precision::full) {
  if (precision == Precision::single && law.name != "wild") return 1.0;
  double sum = 1.0 + law.friction + 2.0 * law.base_suction * (1.0 + law.aspect_gain) + law.base_suction + law.curvature;
  for (const double c : law.windward) sum += std::abs(c);
  for (const double c : law.leeward) sum += std::abs(c);
  return sum;
}

Motion rotated(const Matrix3d& R, const Motion& m) {
  return {R * m.wind, R * m.velocity, R * m.angular_velocity, R * m.reference_point, R * m.wind_gradient * R.transpose()};
}

}  // namespace

TEST_CASE("on random bodies the fast wrench is the reference, the parts are the whole, and no law gains energy", "[property][backend]") {
  const Precision precision = GENERATE(Precision::full, Precision::single);
  INFO((precision == Precision::single ? "single" : "full") << " precision");
  Worst unlike_reference, unlike_parts, gain, gain_of_parts, secant, negative;
  for (unsigned seed = 0; seed < 60'000 / hostile::sanitizer_divisor; ++seed) {
    zoo::Random random(seed);
    const hostile::Body body = hostile::body(random, seed % 2 == 0);
    const Surface surface = body.surface();
    const bool varying = seed % 4 == 3;
    const Model model = hostile::in(precision, hostile::model(random, seed % 3 == 0, varying));
    Motion motion = hostile::motion(random);
    std::vector<Vector3d> winds;
    if (varying && seed % 8 == 3) motion.wind_gradient = random.uniform(0.0, 5.0) * random.rotation();
    if (varying && seed % 8 == 7) {
      for (Eigen::Index i = 0; i < surface.size(); ++i) winds.push_back(random.vector(10.0));
      motion.triangle_wind = winds;
    }
    const double force = hostile::force_scale(surface, motion, 1.225) * strength(model.law, precision) + 1e-300,
                 arm = hostile::arm_scale(surface, motion);
    const auto distance = [&](const Wrench& a, const Wrench& b) {
      return (a.force - b.force).norm() / force + (a.torque - b.torque).norm() / (force * arm);
    };

    const WrenchByTerm fast = wrench(surface, motion, {}, model), plain = reference::wrench(body.mesh, body.sides, motion, {}, model);
    const Wrench total = fast.total();
    const TriangleForces parts = triangle_forces(surface, motion, {}, model);
    const Wrench sum{parts.force.rowwise().sum(), parts.torque.rowwise().sum()};
    double forces = 1e-300, torques = 1e-300;  // sums of magnitudes
    for (const Wrench& term : fast.terms) forces += term.force.norm(), torques += term.torque.norm();
    forces += parts.force.colwise().norm().sum(), torques += parts.torque.colwise().norm().sum() + arm * forces;
    if (precision == Precision::single) forces = force, torques = force * arm;  // what it promises
    for (std::size_t term = 0; term < fast.terms.size(); ++term) {
      unlike_reference.see((fast.terms[term].force - plain.terms[term].force).norm() / forces, seed);
      unlike_reference.see((fast.terms[term].torque - plain.terms[term].torque).norm() / torques, seed);
    }
    unlike_parts.see(distance(sum, total), seed);

    if (varying) continue;  // relative to which air would energy grow?
    const Vector6d velocity = through_air(motion);
    const double speed = velocity.head<3>().norm() + velocity.tail<3>().norm() * arm + 1e-300;
    gain.see(-six(total).dot(velocity) / (force * speed), seed);
    gain_of_parts.see(-six(sum).dot(velocity) / (force * speed), seed);
    const Matrix6d S = resistance(surface, motion, {}, model);
    // In lengths of the arm, so that one norm fits forces and torques.
    const Vector6d unit = (Vector6d() << 1, 1, 1, 1 / arm, 1 / arm, 1 / arm).finished();
    const Matrix6d scaled = unit.asDiagonal() * S * unit.asDiagonal();
    secant.see((unit.asDiagonal() * (S * velocity - six(total))).norm() / (force + scaled.norm() * speed), seed);
    REQUIRE((S - S.transpose()).cwiseAbs().maxCoeff() <= 1e-12 * S.cwiseAbs().maxCoeff());
    negative.see(-Eigen::SelfAdjointEigenSolver<Matrix6d>(scaled, Eigen::EigenvaluesOnly).eigenvalues()[0] / (scaled.norm() + 1e-300),
                 seed);
  }
  CHECK_WORST(unlike_reference, hostile::rounding(precision, 1e-11));
  CHECK_WORST(unlike_parts, hostile::rounding(precision, 1e-13));
  CHECK_WORST(gain, precision == Precision::single ? 1e-7 : 1e-14);  // a last bit or two; observed none in either
  CHECK_WORST(gain_of_parts, 1e-14);
  CHECK_WORST(secant, hostile::rounding(precision, 1e-12));
  CHECK_WORST(negative, 1e-13);
}

TEST_CASE("turning or mirroring a random body and its motion turns or mirrors the wrench, and another torque point adds the lever",
          "[property][invariance]") {
  const Precision precision = GENERATE(Precision::full, Precision::single);
  INFO((precision == Precision::single ? "single" : "full") << " precision");
  Worst turned, mirrored, moved;
  const Matrix3d mirror = Vector3d(1, -1, 1).asDiagonal();
  for (unsigned seed = 100'000; seed < 100'000 + 10'000 / hostile::sanitizer_divisor; ++seed) {
    zoo::Random random(seed);
    const hostile::Body body = hostile::body(random, false);
    const Surface surface = body.surface();
    const Model model = hostile::in(precision, hostile::model(random, seed % 3 == 0, true));
    Motion motion = hostile::motion(random);
    if (seed % 4 == 0) motion.wind_gradient = random.uniform(0.0, 5.0) * random.rotation();
    // A needle's normal has the rounding error of its edges, times length over width; ten near-cancelling sums of that.
    double needle = 1.0;
    for (Eigen::Index i = 0; i < surface.size(); ++i)
      needle = std::max(
          needle, std::max(surface.edge_ab.row(i).matrix().squaredNorm(), surface.edge_ac.row(i).matrix().squaredNorm()) / surface.area[i]);
    const double force = needle * (hostile::force_scale(surface, motion, 1.225) * strength(model.law, precision) + 1e-300),
                 arm = hostile::arm_scale(surface, motion);
    const auto distance = [&](const Wrench& a, const Wrench& b) {
      return (a.force - b.force).norm() / force + (a.torque - b.torque).norm() / (force * arm);
    };
    const Wrench before = wrench(surface, motion, {}, model).total();

    const Matrix3d R = random.rotation();
    const Wrench after = wrench(Surface(transformed(body.mesh, R, Vector3d::Zero()), body.sides), rotated(R, motion), {}, model).total();
    turned.see(distance({R * before.force, R * before.torque}, after), seed);

    Motion image = rotated(mirror, motion);
    image.angular_velocity = -image.angular_velocity;  // axial
    const Wrench reflected = wrench(Surface(transformed(body.mesh, mirror, Vector3d::Zero()), body.sides), image, {}, model).total();
    mirrored.see(distance({mirror * before.force, -(mirror * before.torque)}, reflected), seed);

    Motion elsewhere = motion;
    const Vector3d lever = random.vector(1.0);
    elsewhere.reference_point += lever;
    elsewhere.wind += motion.wind_gradient * lever;
    if (model.effects.has(Effect::spin)) elsewhere.velocity += motion.angular_velocity.cross(lever);
    if (!model.effects.has(Effect::wind_variation)) elsewhere.wind = motion.wind;
    const Wrench there = wrench(surface, elsewhere, {}, model).total();
    moved.see(distance({before.force, before.torque - lever.cross(before.force)}, there), seed);
  }
  CHECK_WORST(turned, hostile::rounding(precision, 1e-13));
  CHECK_WORST(mirrored, hostile::rounding(precision, 1e-13));
  CHECK_WORST(moved, hostile::rounding(precision, 1e-12));  // the lever's own rounding, where spin is 1000 times the rest
}

TEST_CASE("a sheet has no outside: the winding of any of its triangles does not matter", "[property][invariance]") {
  const Precision precision = GENERATE(Precision::full, Precision::single);
  INFO((precision == Precision::single ? "single" : "full") << " precision");
  Worst flipped;
  for (unsigned seed = 200'000; seed < 200'000 + 6'000 / hostile::sanitizer_divisor; ++seed) {
    zoo::Random random(seed);
    hostile::Body body = hostile::soup(random, false);
    if (seed % 2 == 0) {  // a flat, bent or hollow sheet: patches of several triangles, edges that count as curved
      body.mesh = triangulate(Plate{1.0, 0.7, 0.0}, 2);
      const double bend = seed % 4 == 0 ? 0.0 : random.uniform(-0.4, 0.4);
      for (Vector3d& v : body.mesh.vertices) v.z() += bend * v.squaredNorm();
    }
    const Model model = hostile::in(precision, hostile::model(random, seed % 3 == 0, false));
    const Motion motion = hostile::motion(random);
    const Surface surface = body.surface();
    hostile::Body other = body;
    for (Eigen::Vector3i& t : other.mesh.triangles)
      if (random.uniform(0.0, 1.0) < 0.5) std::swap(t[1], t[2]);
    const double force = hostile::force_scale(surface, motion, 1.225) * strength(model.law, precision),
                 arm = hostile::arm_scale(surface, motion);
    const Wrench a = wrench(surface, motion, {}, model).total(), b = wrench(other.surface(), motion, {}, model).total();
    flipped.see((a.force - b.force).norm() / force + (a.torque - b.torque).norm() / (force * arm), seed);
  }
  CHECK_WORST(flipped, hostile::rounding(precision, 1e-11));  // rounding, times the needles among the triangles
}

TEST_CASE("splitting the triangles of a random body that does not spin leaves the wrench alone", "[property][invariance]") {
  const Precision precision = GENERATE(Precision::full, Precision::single);
  INFO((precision == Precision::single ? "single" : "full") << " precision");
  Worst split;
  for (unsigned seed = 300'000; seed < 300'000 + 4'000 / hostile::sanitizer_divisor; ++seed) {
    zoo::Random random(seed);
    const hostile::Body body = hostile::body(random, false);
    Model model = hostile::in(precision, hostile::model(random, seed % 3 == 0, true));
    model.effects = model.effects.without(Effect::curvature);  // known per triangle: a triangle inside a facet has none
    if (model.pillow.form == PillowForm::triangle || model.pillow.form == PillowForm::eccentricity)
      model.pillow = {};  // fade with refinement: erratum E13
    Motion motion = hostile::motion(random);
    motion.angular_velocity.setZero();
    hostile::Body fine{.sides = body.sides};
    fine.mesh.vertices = body.mesh.vertices;
    for (const Eigen::Vector3i& t : body.mesh.triangles) {
      const auto add = [&](const Vector3d& v) { return fine.mesh.vertices.push_back(v), static_cast<int>(fine.mesh.vertices.size()) - 1; };
      const Vector3d a = body.mesh.vertices[t[0]], b = body.mesh.vertices[t[1]], c = body.mesh.vertices[t[2]];
      const int ab = add(0.5 * (a + b)), bc = add(0.5 * (b + c)), ca = add(0.5 * (c + a));
      fine.mesh.triangles.insert(fine.mesh.triangles.end(), {{t[0], ab, ca}, {ab, t[1], bc}, {ca, bc, t[2]}, {ab, bc, ca}});
    }
    const Surface surface = body.surface();
    const double force = hostile::force_scale(surface, motion, 1.225) * strength(model.law, precision),
                 arm = hostile::arm_scale(surface, motion);
    const Wrench a = wrench(surface, motion, {}, model).total(), b = wrench(fine.surface(), motion, {}, model).total();
    split.see((a.force - b.force).norm() / force + (a.torque - b.torque).norm() / (force * arm), seed);
  }
  CHECK_WORST(split, hostile::rounding(precision, 1e-11));  // rounding, times the needles among the triangles
}

TEST_CASE("under a law without descriptors a triangle feels the same alone as among others", "[property][invariance]") {
  const Precision precision = GENERATE(Precision::full, Precision::single);
  INFO((precision == Precision::single ? "single" : "full") << " precision");
  Worst alone;
  for (unsigned seed = 400'000; seed < 400'000 + 4'000 / hostile::sanitizer_divisor; ++seed) {
    zoo::Random random(seed);
    const hostile::Body body = hostile::soup(random, false);
    const Surface surface = body.surface();
    Model model{.law = seed % 2 ? sheet_law() : scaled_law(0.9, 0.3),
                .pillow = {PillowForm::triangle, 0.9},
                .quadrature = Quadrature::six,
                .precision = precision};
    if (precision == Precision::single) model.pillow = {};  // the kernels' own form belongs to the patch
    // How far the pillow fades in a flow that turns depends on the size of the whole.
    Motion motion = hostile::motion(random);
    motion.angular_velocity.setZero();
    motion.wind_gradient.setZero();
    const TriangleForces parts = triangle_forces(surface, motion, {}, model);  // in double
    const auto pick = static_cast<std::size_t>(random.uniform(0.0, static_cast<double>(body.mesh.triangles.size()) - 1e-9));
    const Surface single({body.mesh.vertices, {body.mesh.triangles[pick]}}, Surface::Sides::two);
    const Wrench one = wrench(single, motion, {}, model).total();
    const auto column = static_cast<Eigen::Index>(pick);
    double force = one.force.norm(), torque = one.torque.norm();
    if (precision == Precision::single)  // what it promises
      force = hostile::force_scale(single, motion, 1.225), torque = force * hostile::arm_scale(single, motion);
    alone.see((one.force - parts.force.col(column)).norm() / (1e-300 + force), seed);
    alone.see((one.torque - parts.torque.col(column)).norm() / (1e-300 + torque), seed);
  }
  CHECK_WORST(alone, hostile::rounding(precision, 1e-13));
}

TEST_CASE("air that turns with a body is air at rest about it, and air that turns alone is a body that turns back",
          "[property][invariance]") {
  const Precision precision = GENERATE(Precision::full, Precision::single);
  INFO((precision == Precision::single ? "single" : "full") << " precision");
  Worst carried, turned;
  for (unsigned seed = 450'000; seed < 450'000 + 3'000 / hostile::sanitizer_divisor; ++seed) {
    zoo::Random random(seed);
    const Surface surface = hostile::body(random, false).surface();
    const Model model = hostile::in(precision, hostile::model(random, seed % 3 == 0, false));
    const Vector3d spin = std::pow(10.0, random.uniform(-2.0, 1.0)) * random.vector(1.0);
    const Matrix3d turning = (Matrix3d() << 0, -spin.z(), spin.y(), spin.z(), 0, -spin.x(), -spin.y(), spin.x(), 0).finished();
    const Motion still{.wind = random.vector(10.0), .reference_point = random.vector(1.0)};
    Motion both = still, air = still, body = still;
    both.angular_velocity = spin, both.wind_gradient = turning;
    air.wind_gradient = turning;
    body.angular_velocity = -spin;
    const double force = hostile::force_scale(surface, both, 1.225) * strength(model.law, precision),
                 arm = hostile::arm_scale(surface, both);
    const auto distance = [&](const Motion& m, const Motion& n) {
      const Wrench a = wrench(surface, m, {}, model).total(), b = wrench(surface, n, {}, model).total();
      return (a.force - b.force).norm() / force + (a.torque - b.torque).norm() / (force * arm);
    };
    turned.see(distance(air, body), seed);
    carried.see(distance(both, still), seed);
  }
  CHECK_WORST(turned, hostile::rounding(precision, 1e-13));
  CHECK_WORST(carried, hostile::rounding(precision, 1e-13));
}

TEST_CASE("adaptive quadrature keeps to six points and never jumps", "[property][convergence]") {
  const Precision precision = GENERATE(Precision::full, Precision::single);
  INFO((precision == Precision::single ? "single" : "full") << " precision");
  // How far beside a threshold: as near as rounding leaves a difference.
  const double beside = precision == Precision::single ? 1e-4 : 1e-9, rounding = hostile::rounding(precision, 0.0);
  Worst coarse, jump;
  for (unsigned seed = 500'000; seed < 500'000 + 6'000 / hostile::sanitizer_divisor; ++seed) {
    zoo::Random random(seed);
    const hostile::Body body = hostile::body(random, false);
    const Surface surface = body.surface();
    Model model{.law = hostile::laws()[seed % 5], .quadrature = Quadrature::adaptive, .precision = precision};
    if (seed % 2) model.pillow = {PillowForm::tilt, 0.8};
    Motion motion = hostile::motion(random);
    motion.angular_velocity = std::pow(10.0, random.uniform(-3.0, 2.0)) * random.vector(1.0);
    if (seed % 4 == 0) motion.wind_gradient = random.uniform(0.0, 10.0) * random.rotation();
    const double force = hostile::force_scale(surface, motion, 1.225), arm = hostile::arm_scale(surface, motion);
    const auto evaluate_with = [&](Quadrature rule, const Motion& m) {
      model.quadrature = rule;
      return wrench(surface, m, {}, model).total();
    };
    const auto distance = [&](const Wrench& a, const Wrench& b) {
      return (a.force - b.force).norm() / force + (a.torque - b.torque).norm() / (force * arm);
    };
    const Wrench adaptive = evaluate_with(Quadrature::adaptive, motion);
    coarse.see(distance(adaptive, evaluate_with(Quadrature::six, motion)), seed);
    // At one triangle's centroid, so that its spin can be put on a threshold of the rule: just below it and above.
    const auto t = static_cast<Eigen::Index>(random.uniform(0.0, static_cast<double>(surface.size()) - 1e-9));
    const Vector3d ab = surface.edge_ab.row(t).matrix(), ac = surface.edge_ac.row(t).matrix();
    const double radius = std::max({(ab + ac).norm(), (2.0 * ab - ac).norm(), (2.0 * ac - ab).norm()}) / 3.0,
                 threshold[] = {0.002, 0.004, 0.5, 1.0};
    Motion below{.wind = random.vector(10.0), .reference_point = surface.centroid.row(t).matrix()};
    below.angular_velocity = threshold[seed % 4] * below.wind.norm() / radius * (1.0 - beside) * random.vector(1.0).normalized();
    Motion above = below;
    above.angular_velocity *= (1.0 + beside) / (1.0 - beside);
    const Wrench a = evaluate_with(Quadrature::adaptive, below), b = evaluate_with(Quadrature::adaptive, above);
    const double here = hostile::force_scale(surface, below, 1.225), lever = hostile::arm_scale(surface, below);
    jump.see(((a.force - b.force).norm() / here + (a.torque - b.torque).norm() / (here * lever) - 4.0 * rounding) / (2.0 * beside), seed);
  }
  CHECK_WORST(coarse, 0.005);  // of the largest force that the speeds could make; observed 0.0027, where three points meet a face that
                               // turns through edge-on
  CHECK_WORST(jump, 2.0);      // per relative change of the spin: a force is square in it. Observed 0.5
}

namespace {

/// Largest change of C(c) n with the angle of the flow, over all c: |C'(c)| sqrt(1 - c^2), as |dc/d angle| <= sqrt(1 - c^2). And the
/// largest |C|.
struct Steepness {
  double slope = 0.0, value = 0.0;
};

Steepness steepness(const Law::Polynomial& p) {
  Steepness found;
  for (int i = 0; i <= 1000; ++i) {
    const double c = i / 1000.0;
    found.slope = std::max(found.slope, std::abs(derivative(p, c)) * std::sqrt(1.0 - c * c));
    found.value = std::max(found.value, std::abs(evaluate(p, c)));
  }
  found.slope *= 1.001;  // between the samples
  return found;
}

/// A direction and another `angle` away from it; every other one starts exactly edge-on or normal to a triangle.
std::pair<Vector3d, Vector3d> neighbours(zoo::Random& random, const Surface& surface, double angle) {
  Vector3d u = random.vector(1.0).normalized();
  const Vector3d n =
      surface.normal.row(static_cast<Eigen::Index>(random.uniform(0.0, static_cast<double>(surface.size()) - 1e-9))).matrix();
  const double kind = random.uniform(0.0, 1.0);
  if (kind < 0.25)
    u = -n;
  else if (kind < 0.5)
    u = n.cross(u).normalized();
  const Vector3d axis = u.cross(random.vector(1.0)).normalized();
  return {u, Eigen::AngleAxisd(angle, axis) * u};
}

}  // namespace

TEST_CASE("force and torque change with the angle of the flow no faster than the law's polynomials allow", "[property][limit]") {
  // Uniform flow, no spin, W(0) = L(0) = 0, q = 1. Every triangle's force is A C(c) n, so that |dF/d angle| <= A (K_W + K_L + f), two-sided
  // with both sides at once. The tilt form moves it by D = -kappa (2/l) M t e: |D| <= kappa sqrt(m), m the largest eigenvalue of M, because
  // the variance along the chord l is at most l^2/4; and |dD/d angle| <= kappa (2 m + d sqrt(m))/l, d the patch's diameter, because t e is
  // the projection of a unit vector, e turns by 1/t and the chord changes by at most d per radian. The patch's area is at most l d.
  const Precision precision = GENERATE(Precision::full, Precision::single);
  INFO((precision == Precision::single ? "single" : "full") << " precision");
  Worst force_over_bound, torque_over_bound;
  for (unsigned seed = 600'000; seed < 600'000 + 10'000 / hostile::sanitizer_divisor; ++seed) {
    zoo::Random random(seed);
    const Surface surface = hostile::body(random, false).surface();
    Law law = hostile::laws()[seed % 3];  // note, consistent, sheet
    if (seed % 3 == 0) {
      law = hostile::wild_law(random, false);
      for (double& k : law.windward) k = std::abs(k);  // nothing pushes
      for (double& k : law.leeward) k = std::abs(k);
    }
    const Model model{.law = law,
                      .pillow = {PillowForm::tilt, 1.5},
                      .effects = Effect::leeward_suction | Effect::friction | Effect::pillow,
                      .precision = precision};
    const double angle = std::pow(10.0, random.uniform(-6.0, -1.0));
    const auto [u, v] = neighbours(random, surface, angle);
    const Wrench a = wrench(surface, {.wind = u, .reference_point = surface.centre}, {.density = 2.0}, model).total();
    const Wrench b = wrench(surface, {.wind = v, .reference_point = surface.centre}, {.density = 2.0}, model).total();

    const Steepness W = steepness(law.windward), L = steepness(law.leeward);
    const double sides = surface.two_sided() ? 2.0 : 1.0, friction = sides * law.friction;
    const double slope = surface.two_sided() ? W.slope + L.slope : std::max(W.slope, L.slope);
    double torque = surface.radius * (slope + friction) * surface.total_area;
    for (const Patch& patch : surface.patches) {
      const double m = Eigen::SelfAdjointEigenSolver<Matrix3d>(patch.second_moment, Eigen::EigenvaluesOnly).eigenvalues()[2];
      double d = 0.0;
      for (const auto& from : patch.outline)
        for (const auto& to : patch.outline) d = std::max(d, (from.first - to.first).norm());
      const double moved = 1.5 * std::sqrt(m), moves = 1.5 * d * (2.0 * m + d * std::sqrt(m)) / patch.area;
      torque += patch.area * (W.slope * moved + W.value * moves);
    }
    // Differences of rounded sums over an angle of 1e-6.
    const double rounding = precision == Precision::full ? 1e-15 : 2e-6 * sides * surface.total_area * strength(law, precision);
    force_over_bound.see(((a.force - b.force).norm() - rounding) / (angle * (slope + friction) * surface.total_area), seed);
    torque_over_bound.see(((a.torque - b.torque).norm() - rounding * 2.0 * surface.radius) / (angle * torque), seed);
  }
  CHECK_WORST(force_over_bound, 1.0);
  CHECK_WORST(torque_over_bound, 1.0);
  CHECK(force_over_bound.value() > 0.9);  // the bound is not idle
}

TEST_CASE("the closed law is continuous in angle on every closed body, as steep as measured and no steeper", "[property][limit]") {
  // Its descriptors turn with the flow too, and so does the share of what pushes. The steepest of 10,000 cases were 2.9 q A and 0.72 q A
  // radius per radian; asserted with a margin of 40 %.
  const Precision precision = GENERATE(Precision::full, Precision::single);
  INFO((precision == Precision::single ? "single" : "full") << " precision");
  const double rounding = 2.0 * hostile::rounding(precision, 0.0);
  Worst force_slope, torque_slope;
  for (unsigned seed = 700'000; seed < 700'000 + 10'000 / hostile::sanitizer_divisor; ++seed) {
    zoo::Random random(seed);
    const Surface surface = hostile::closed(random).surface();
    const Model model{.law = closed_law(), .pillow = {PillowForm::tilt, 0.78}, .precision = precision};
    const double angle = std::pow(10.0, random.uniform(-6.0, -2.0));
    const auto [u, v] = neighbours(random, surface, angle);
    const Wrench a = wrench(surface, {.wind = u, .reference_point = surface.centre}, {.density = 2.0}, model).total();
    const Wrench b = wrench(surface, {.wind = v, .reference_point = surface.centre}, {.density = 2.0}, model).total();
    force_slope.see(((a.force - b.force).norm() / surface.total_area - rounding) / angle, seed);
    torque_slope.see(((a.torque - b.torque).norm() / (surface.total_area * surface.radius) - 2.0 * rounding) / angle, seed);
  }
  CHECK_WORST(force_slope, 4.0);
  CHECK_WORST(torque_slope, 1.0);
}
