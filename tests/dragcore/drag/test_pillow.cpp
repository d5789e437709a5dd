#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <numbers>

#include "tests/support/zoo.hpp"

using namespace dragcore;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;
using Eigen::Vector3d;
using std::numbers::pi;

namespace {

/// int_a^b f by the double exponential rule: endpoints may have roots. The step 2^-6 resolves these integrands to rounding.
double integrate(double a, double b, const std::function<double(double)>& f) {
  double sum = 0.0;
  const double step = 1.0 / 64;
  for (int k = -64 * 4; k <= 64 * 4; ++k) {
    const double t = k * step, sinh = 0.5 * pi * std::sinh(t), x = 0.5 * (a + b) + 0.5 * (b - a) * std::tanh(sinh);
    const double weight = 0.5 * pi * std::cosh(t) / (std::cosh(sinh) * std::cosh(sinh));
    if (x > a && x < b) sum += weight * f(x);
  }
  return 0.5 * (b - a) * step * sum;
}

/// Force point of a triangle with vertices at (0, 0), (beta, h_b), (1, h_c) in (s, h), by one-dimensional integrals over slices.
Eigen::Vector2d sliced_force_point(double beta, double h_b, double h_c, double alpha) {
  const double H = h_b - beta * h_c;  // signed thickness at s = beta
  const auto f = [alpha](double s) { return alpha * std::sqrt(1 - s * s) + 1 - alpha; };
  const auto thickness = [&](double s) { return s < beta ? H * s / beta : H * (1 - s) / (1 - beta); };
  const auto middle = [&](double s) { return s * h_c + 0.5 * thickness(s); };
  const auto both = [&](const std::function<double(double)>& g) { return integrate(0, beta, g) + integrate(beta, 1, g); };
  const double area = both([&](double s) { return f(s) * thickness(s); });
  return {both([&](double s) { return f(s) * thickness(s) * s; }) / area,
          both([&](double s) { return f(s) * thickness(s) * middle(s); }) / area};
}

Surface square_sheet(int divisions) { return Surface(triangulate(Plate{1.0, 1.0, 0.0}, divisions), Surface::Sides::two); }

}  // namespace

TEST_CASE("the barycentric pillow weights agree with integration over slices", "[pillow][analytic]") {
  for (const double alpha : {0.0, 0.3, 1.0})
    for (const double beta : {1e-3, 0.1, 0.37, 0.5, 0.8, 0.99, 0.999}) {
      const double h_b = 0.8, h_c = -0.35;
      const Vector3d weights = triangle_pillow_weights(beta, alpha);
      const Eigen::Vector2d exact = sliced_force_point(beta, h_b, h_c, alpha);
      INFO("alpha " << alpha << ", beta " << beta);
      CHECK_THAT(weights[1] * beta + weights[2], WithinAbs(exact[0], 1e-12));
      CHECK_THAT(weights[1] * h_b + weights[2] * h_c, WithinAbs(exact[1], 1e-12));
      CHECK_THAT(weights.sum(), WithinAbs(1.0, 1e-15));
      CHECK(weights.minCoeff() > 0.0);
    }
}

TEST_CASE("the pillow weights are exact where the note's closed form divides by zero", "[pillow][limit]") {
  // beta = 0: D, N, P = pi/4 - 1/3, 1/3 - pi/16, 5 pi/16 - 2/3; beta = 1: 1/3, pi/16, pi/16 (erratum E10).
  const auto check = [](double beta, double d, double n, double p) {
    const Vector3d weights = triangle_pillow_weights(beta, 1.0);
    CHECK_THAT(weights[1], WithinAbs(0.5 * p / d, 1e-14));
    CHECK_THAT(weights[1] * beta + weights[2], WithinAbs(n / d, 1e-14));
  };
  check(0.0, pi / 4 - 1.0 / 3, 1.0 / 3 - pi / 16, 5 * pi / 16 - 2.0 / 3);
  check(1.0, 1.0 / 3, pi / 16, pi / 16);
  // Factor 0 is the centroid.
  CHECK((triangle_pillow_weights(0.4, 0.0) - Vector3d::Constant(1.0 / 3)).norm() < 1e-15);
  // Near both ends the weights go smoothly into the limits: sqrt(1 - beta) is the rate at beta = 1.
  CHECK((triangle_pillow_weights(1e-13, 1.0) - triangle_pillow_weights(0.0, 1.0)).norm() < 1e-12);
  CHECK((triangle_pillow_weights(1.0 - 1e-14, 1.0) - triangle_pillow_weights(1.0, 1.0)).norm() < 1e-12);
}

TEST_CASE("the note's closed form for the distance along the flow agrees, the one across it does not", "[pillow][regression]") {
  // l_Avg as printed in the note, sec. 2.1.1, with L = 1 (right); h_2m as printed (wrong, erratum E6), integrated over slices.
  for (const double b : {0.2, 0.5, 0.7})
    for (const double p : {0.4, 1.0}) {
      const double S = std::sqrt(1 - b * b);
      const double printed =
          (2 * b * b * b * (p * (S - 2) + 2) + b * (p * (4 - 5 * S) - 4) + 3 * p * (b - 1) * std::asin(b) + 3 * b * p * std::acos(b)) /
          (4 * (b * b * (p * (S - 3) + 3) + b * (5 * p - 3) - 3 * b * p * std::acos(b) + 2 * p * (S - 1)));
      const Vector3d weights = triangle_pillow_weights(b, p);
      CHECK_THAT(weights[1] * b + weights[2], WithinAbs(printed, 1e-12));
    }
  const double b = 0.5, c = 0.8, d = -0.35, H = c - b * d;
  const auto h_2m_printed = [&](double l) { return d + (l - b) / (1 - b) * (d - c + H / 2); };
  CHECK(std::abs(h_2m_printed(b) - (c - H / 2)) > 0.5);  // it should join the first half there
  CHECK(std::abs(h_2m_printed(1.0) - d) > 0.5);          // and end at the last vertex
}

TEST_CASE("the eccentricity short-cut of the note does not even know the factor", "[pillow][regression]") {
  // h_Avg ~ h.(incentre - centroid) (erratum E12): without pillow the force acts at the centroid, the short-cut moves it all the same.
  const Vector3d a(0, 0, 0), b(0.3, 0.6, 0), c(1, -0.2, 0);
  const double la = (b - c).norm(), lb = (c - a).norm(), lc = (a - b).norm();
  const Vector3d eccentricity = (la * a + lb * b + lc * c) / (la + lb + lc) - (a + b + c) / 3.0;
  CHECK(std::abs(eccentricity.y()) > 0.01);
  CHECK(triangle_pillow_shift(a, b, c, Vector3d(1, 0, -1), 0.0).norm() == 0.0);
}

TEST_CASE("the circular falloff on a square patch puts the centre of pressure at 4/(3 pi) of the chord", "[pillow][analytic]") {
  const Patch patch = square_sheet(1).patches.at(0);
  const Vector3d shift = patch_pillow_shift(patch, Vector3d(1, 0, 0.5), 1.0);
  CHECK_THAT(shift.x(), WithinAbs(4.0 / (3 * pi) - 0.5, 1e-14));
  CHECK_THAT(shift.y(), WithinAbs(0.0, 1e-15));
  // Along the diagonal, by slices: thickness 2 s up to the middle.
  const Vector3d diagonal = patch_pillow_shift(patch, Vector3d(1, 1, 0.3), 0.7);
  const auto f = [](double s) { return 0.7 * std::sqrt(1 - s * s) + 0.3; };
  const auto width = [](double s) { return s < 0.5 ? s : 1 - s; };
  const auto both = [](const std::function<double(double)>& g) { return integrate(0, 0.5, g) + integrate(0.5, 1, g); };
  const double mean = both([&](double s) { return f(s) * width(s) * s; }) / both([&](double s) { return f(s) * width(s); });
  CHECK_THAT(diagonal.norm(), WithinAbs((0.5 - mean) * std::sqrt(2.0), 1e-13));
  CHECK_THAT(diagonal.x(), WithinAbs(diagonal.y(), 1e-15));
}

TEST_CASE("the tilt form moves the centre of pressure of a rectangle by factor t L / 6", "[pillow][analytic]") {
  const Surface sheet(triangulate(Plate{2.0, 0.5, 0.0}, 3), Surface::Sides::two);
  for (int incidence = 5; incidence <= 90; incidence += 5) {
    const double angle = incidence * pi / 180;
    const Vector3d shift = tilt_pillow_shift(sheet.patches.at(0).normal, sheet.patches.at(0).second_moment, Vector3d(std::cos(angle), 0, std::sin(angle)), 0.8);
    CHECK_THAT(shift.x(), WithinAbs(-0.8 * std::cos(angle) * 2.0 / 6.0, 1e-14));
  }
}

TEST_CASE("the centre of pressure of the patch forms does not know the triangulation", "[pillow][invariance]") {
  const Motion motion{.wind = Vector3d(1.0, 0.2, -0.7)};
  for (const PillowForm form : {PillowForm::patch, PillowForm::tilt}) {
    const Model model{.pillow = {form, 0.9}};
    const Wrench coarse = wrench(square_sheet(1), motion, {}, model).total();
    for (const int divisions : {2, 10, 100}) {  // 8, 200, 20,000 triangles
      const Wrench fine = wrench(square_sheet(divisions), motion, {}, model).total();
      CHECK((fine.force - coarse.force).norm() < 1e-12 * coarse.force.norm());
      CHECK((fine.torque - coarse.torque).norm() < 1e-6 * coarse.force.norm());   // asked for: 1e-6 of the chord, which is 1
      CHECK((fine.torque - coarse.torque).norm() < 1e-11 * coarse.force.norm());  // reached: rounding of sums over 20,000 triangles
    }
  }
}

TEST_CASE("the note's form on triangles fades with refinement", "[pillow][regression]") {
  // Erratum E13: -0.0540, -0.0270, -0.0135 of the chord for 2, 8, 32 triangles, and a sideways shift of half that.
  const Motion motion{.wind = Vector3d(1.0, 0.0, -0.2)};
  const Model model{.pillow = {PillowForm::triangle, 1.0}};
  double offset[3];
  for (int level = 0; level < 3; ++level) {
    const Wrench total = wrench(square_sheet(1 << level), motion, {}, model).total();
    offset[level] = -total.torque.y() / total.force.z();  // M_y = -x F_z
  }
  CHECK_THAT(offset[0], WithinAbs(-0.0540, 5e-5));  // the quoted digits
  CHECK_THAT(offset[1] / offset[0], WithinAbs(0.5, 1e-12));
  CHECK_THAT(offset[2] / offset[0], WithinAbs(0.25, 1e-12));
}

TEST_CASE("the pillow never changes the force of a body that does not spin", "[pillow][invariance]") {
  zoo::Random random(7);
  for (const Shape& shape : zoo::shapes()) {
    const Surface surface = zoo::surface(shape, 4);
    Motion motion = random.motion(3.0, 0.0);
    const Wrench plain = wrench(surface, motion, {}, {}).total();
    for (const PillowForm form : {PillowForm::triangle, PillowForm::patch, PillowForm::tilt})
      CHECK((wrench(surface, motion, {}, {.pillow = {form, 1.0}}).total().force - plain.force).norm() <= 1e-13 * plain.force.norm());
  }
}

TEST_CASE("the torque goes smoothly through normal incidence", "[pillow][limit]") {
  // Erratum E11: with a constant factor the torque jumps by 0.15 of force times chord as the flow passes the normal.
  for (const PillowForm form : {PillowForm::triangle, PillowForm::patch, PillowForm::tilt}) {
    const Surface sheet = square_sheet(2);
    double previous = 0.0;
    for (int step = -200; step <= 200; ++step) {
      const double angle = step * 1e-4;
      const Wrench total =
          wrench(sheet, {.wind = Vector3d(std::sin(angle), 0, -std::cos(angle))}, {.density = 2.0}, {.pillow = {form, 1.0}}).total();
      if (step > -200) CHECK(std::abs(total.torque.y() - previous) < 1e-4);  // slope at most 1 per radian: kappa / 6 and less
      previous = total.torque.y();
      if (step == 0) CHECK(std::abs(total.torque.y()) < 1e-15);
    }
  }
}

TEST_CASE("nose-up torque on a plate at small incidence: the force acts ahead of the middle", "[pillow][sign]") {
  const Pose pose{.incidence = 20 * pi / 180};
  for (const PillowForm form : {PillowForm::triangle, PillowForm::patch, PillowForm::tilt}) {
    const Wrench total =
        wrench(square_sheet(2), {.wind = pose.rotation().transpose() * Vector3d(1, 0, 0)}, {}, {.pillow = {form, 0.8}}).total();
    CHECK(total.torque.y() > 0.0);
  }
}

TEST_CASE("pillow forms go by their names", "[pillow]") {
  for (const PillowForm form : {PillowForm::none, PillowForm::triangle, PillowForm::patch, PillowForm::tilt})
    CHECK(pillow_form_from(to_string(form)) == form);
  CHECK_THROWS_WITH(pillow_form_from("cushion"), Catch::Contains("unknown pillow form 'cushion'") && Catch::Contains("tilt"));
}

TEST_CASE("the linear falloff has its exact moments on triangles and patches, and reaches a third of the chord", "[pillow][analytic]") {
  const auto linear = [](double alpha) { return [alpha](double s) { return 1.0 - alpha * s; }; };
  for (const double alpha : {0.0, 0.4, 1.0})
    for (const double beta : {0.0, 0.2, 0.5, 0.9, 1.0}) {
      const auto f = linear(alpha);
      // Slices of thickness s/beta and (1 - s)/(1 - beta).
      const auto along = [&](const std::function<double(double)>& g) {
        return (beta > 0 ? integrate(0, beta, [&](double s) { return f(s) * s / beta * g(s); }) : 0.0) +
               (beta < 1 ? integrate(beta, 1, [&](double s) { return f(s) * (1 - s) / (1 - beta) * g(s); }) : 0.0);
      };
      const Vector3d weights = triangle_pillow_weights(beta, alpha, Falloff::linear);
      CHECK_THAT(weights.sum(), WithinAbs(1.0, 1e-14));
      CHECK_THAT(weights[1] * beta + weights[2], WithinAbs(along([](double s) { return s; }) / along([](double) { return 1.0; }), 1e-12));
    }
  // A square plate: int (1 - s) s / int (1 - s) = 1/3 of the chord from the leading edge, against 0.4244 of the circular form.
  for (const int divisions : {1, 7}) {
    const Patch patch = square_sheet(divisions).patches[0];
    CHECK_THAT(patch_pillow_shift(patch, {1.0, 0.0, 0.2}, 1.0, Falloff::linear).x(), WithinAbs(1.0 / 3 - 0.5, 1e-13));
    CHECK_THAT(patch_pillow_shift(patch, {1.0, 0.0, 0.2}, 1.0, Falloff::circular).x(), WithinAbs(4 / (3 * pi) - 0.5, 1e-13));
  }
}

TEST_CASE("the eccentricity variant moves the force sideways whatever its factor, as the note has it", "[pillow][regression]") {
  const Vector3d a(0, 0, 0), b(0.3, 0.8, 0), c(1, -0.1, 0), u(1, 0, -1);
  const Vector3d none = eccentricity_pillow_shift(a, b, c, u, 0.0), full = eccentricity_pillow_shift(a, b, c, u, 1.0),
                 exact = triangle_pillow_shift(a, b, c, u, 1.0);
  CHECK(none.x() == 0.0);
  CHECK(std::abs(none.y()) > 0.005);
  CHECK(full.y() == none.y());
  CHECK_THAT(full.x(), WithinAbs(exact.x(), 1e-15));
  CHECK_THAT(full.z(), WithinAbs(0.0, 1e-15));
}

TEST_CASE("across the flow the eccentricity short-cut is further off than no shift at all", "[pillow][regression]") {
  zoo::Random random(21);
  double shortcut = 0.0, nothing = 0.0;
  for (int i = 0; i < 20000; ++i) {
    const Vector3d a = random.vector(1.0), b = random.vector(1.0), c = random.vector(1.0), u = random.vector(1.0);
    const Vector3d normal = (b - a).cross(c - a).normalized(), across = normal.cross(u).normalized();
    const double longest = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
    const double exact = across.dot(triangle_pillow_shift(a, b, c, u, 1.0)) / longest;
    shortcut += std::pow(across.dot(eccentricity_pillow_shift(a, b, c, u, 1.0)) / longest - exact, 2);
    nothing += exact * exact;
  }
  // rms over 20,000 random triangles and flows; the statistical error is below 0.1.
  CHECK(std::sqrt(shortcut / nothing) > 4.0);
  CHECK(std::sqrt(shortcut / nothing) < 6.0);
}
