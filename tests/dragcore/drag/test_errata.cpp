// The faults of the note that no other test shows, each by its number in docs/model.md: the printed formula, evaluated, against what it
// should give.

#include <Eigen/Dense>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <dragcore/wind.hpp>
#include <numbers>

#include "tests/support/zoo.hpp"

using namespace dragcore;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;
using Eigen::Vector3d;
using std::numbers::pi;

namespace {

/// Midpoint rule, fine enough for the digits compared below.
template <class F>
double integrate(double a, double b, F f, int n = 200000) {
  double sum = 0.0;
  for (int i = 0; i < n; ++i) sum += f(a + (b - a) * (i + 0.5) / n);
  return sum * (b - a) / n;
}

/// The note's triangle in its own letters: vertices at l = 0, b, L; c and d are the heights of the second and third; H the thickness at b.
struct NoteTriangle {
  double b, c, d, p;
  double H() const { return c - d * b; }  // L = 1
  double f(double l) const { return p * std::sqrt(1 - l * l) + 1 - p; }
  double thickness(double l) const { return l < b ? H() * l / b : H() * (1 - (l - b) / (1 - b)); }
  /// Mean height, with the middle line of the second part as given.
  template <class Middle>
  double h_average(Middle second) const {
    const auto weight = [&](double l) { return f(l) * thickness(l); };
    const double moment = integrate(0, b, [&](double l) { return l / b * (c - H() / 2) * weight(l); }) +
                          integrate(b, 1, [&](double l) { return second(l) * weight(l); });
    return moment / (integrate(0, b, weight) + integrate(b, 1, weight));
  }
  double h_exact() const {
    return h_average([this](double l) { return (c - H() / 2) + (l - b) / (1 - b) * (d - c + H() / 2); });
  }
  double h_with_printed_middle() const {
    return h_average([this](double l) { return d + (l - b) / (1 - b) * (d - c + H() / 2); });
  }
  /// The printed numerator with its brackets closed where they belong (E8), `sign` in front of the term with the arc sine.
  double h_closed_form(double sign) const {
    const double S = std::sqrt(1 - b * b), b2 = b * b, b3 = b2 * b, b4 = b3 * b, h = H();
    const double brackets =
        6 * p * S * (h - 2 * c) +
        4 * b2 * (c * (-2 * p * (S + 10) + 6 * pi * p + 20) + d * (p * (S - 12 * pi + 48) - 48) + h * (p * (S - 3 * pi + 10) - 10)) +
        8 * b3 * (12 * d * (p * (S - 2) + 2) - 2 * c * (p * (4 * S - 7) + 7) + h * (p * (4 * S - 7) + 7)) +
        8 * b4 * (d * (-5 * p * S + 8 * p - 8) + h * (-2 * p * S + 3 * p - 3) + c * (p * (4 * S - 6) + 6)) +
        b * (2 * c * (p * (-4 * S + 3 * pi + 8) - 8) + 2 * d * ((9 * pi - 32) * p + 32) + h * (p * (4 * S - 3 * pi - 8) + 8));
    const double arc = 6 * p * std::asin(b) * (4 * b3 * (2 * c - 4 * d - h) + 6 * b2 * d + 2 * b * (2 * c - h) + (h - 2 * c));
    const double denominator = 16 * b * (b - 1) * (b2 * (p * (S - 3) + 3) + b * (5 * p - 3) - 3 * b * p * std::acos(b) + 2 * p * (S - 1));
    return (b * brackets + sign * arc) / denominator;
  }
};

constexpr NoteTriangle triangle{.b = 0.4, .c = 0.8, .d = -0.35, .p = 0.7};

}  // namespace

TEST_CASE("E1, E2: the note's force does c times the work that its own balance asks for", "[errata][analytic]") {
  for (const double c : {0.1, 0.4, 0.8, 1.0}) {
    const double energy = c * (1 - (1 - c) * (1 - c));  // mass flow c, slowed from 1 to 1 - c; in rho A v^3 / 2
    CHECK_THAT(evaluate(note_law().windward, c) * c,
               WithinAbs(c * energy, 1e-15));  // force along -n: its part along the flow is c times it
    CHECK_THAT(evaluate(consistent_law().windward, c) * c, WithinAbs(energy, 1e-15));
  }
}

TEST_CASE("E3: without the guard leeward faces get c^2 (2 + c)", "[errata][sign]") {
  const auto printed = [](double cosine) {
    return 2 * std::abs(cosine) * cosine * (1 + cosine / 2);
  };                                                  // C_N along N, with A_P = A |cos phi|
  CHECK_THAT(printed(-1.0), WithinAbs(-1.0, 1e-15));  // windward: pushed, as wanted
  CHECK_THAT(printed(1.0), WithinAbs(3.0, 1e-15));    // leeward: pulled three times as hard
}

TEST_CASE("E4: the tangential velocity needs the normal after the dot product", "[errata][analytic]") {
  // Printed: a vector minus a number. What the library takes for the direction of flow over a face must lie in the face, upstream.
  const Eigen::Matrix3d turn = Pose{.incidence = 0.4, .yaw = 0.7, .roll = -0.3}.rotation();
  const Surface sheet(transformed(triangulate(Plate{1.0, 1.0, 0.0}, 1), turn, Vector3d::Zero()), Surface::Sides::two);
  const Vector3d v(1, 2, 3), n = sheet.patches[0].normal;
  for (const Vector3d& shift : {tilt_pillow_shift(n, sheet.patches[0].second_moment, v, 0.8), patch_pillow_shift(sheet.patches[0], v, 0.8)}) {
    CHECK(shift.norm() > 0.01);
    CHECK_THAT(shift.dot(n), WithinAbs(0.0, 1e-15));
    CHECK(shift.dot(v) < 0.0);
  }
}

TEST_CASE("E5: the first integral of the mean height lost a thickness", "[errata][analytic]") {
  // With every length doubled the mean height must double; without H in one of two terms it does not.
  const auto first_form = [](double size, bool with_thickness) {
    const double b = 0.4 * size, L = size, H = 0.9 * size, c = 0.8 * size, d = -0.35 * size;
    const double one = integrate(
        0, b, [&](double l) { return l / b * (c - H / 2) * H * l / b; }, 2000);
    const double two = integrate(
        b, L, [&](double l) { return (d + (l - b) / (L - b) * (d - c + H / 2)) * (with_thickness ? H : 1.0) * (1 - (l - b) / (L - b)); },
        2000);
    return (one + two) / (H * L / 2);
  };
  CHECK_THAT(first_form(2.0, true), WithinRel(2 * first_form(1.0, true), 1e-12));
  CHECK(std::abs(first_form(2.0, false) / first_form(1.0, false) - 2.0) > 0.1);
}

TEST_CASE("E6, E8, E9: the printed mean height, regrouped and with the right sign, is exact for the wrong middle line",
          "[errata][analytic]") {
  CHECK_THAT(triangle.h_closed_form(-1.0),
             WithinAbs(triangle.h_with_printed_middle(), 1e-8));  // midpoint rule of 2e5 slices with a root at the end
  CHECK(std::abs(triangle.h_closed_form(+1.0) - triangle.h_with_printed_middle()) > 0.05);  // as printed
  CHECK(std::abs(triangle.h_with_printed_middle() - triangle.h_exact()) > 0.05);
  const Vector3d weights = triangle_pillow_weights(triangle.b, triangle.p);
  CHECK_THAT(weights[1] * triangle.c + weights[2] * triangle.d, WithinAbs(triangle.h_exact(), 1e-8));
}

TEST_CASE("E10: the closed forms divide zero by zero where an edge is square to the flow", "[errata][limit]") {
  NoteTriangle square_on = triangle;
  square_on.b = 0.0;
  CHECK(std::isnan(square_on.h_closed_form(-1.0)));
  CHECK(triangle_pillow_weights(0.0, triangle.p).allFinite());
}

TEST_CASE("E11: a constant factor makes the torque jump where the flow passes the normal", "[errata][limit]") {
  const Patch patch = Surface(triangulate(Plate{1, 1, 0}, 1), Surface::Sides::two).patches[0];
  const Vector3d left = patch_pillow_shift(patch, Vector3d(1e-9, 0, -1), 1.0),
                 right = patch_pillow_shift(patch, Vector3d(-1e-9, 0, -1), 1.0);
  CHECK_THAT((left - right).norm(), WithinAbs(2 * 0.0756, 1e-4));
  CHECK(faded_pillow_factor(1.0, 1.0) == 0.0);
}

TEST_CASE("E14: the angle between air and normal is not that between spin axis and normal", "[errata][analytic]") {
  zoo::Random random(14);
  for (int i = 0; i < 100; ++i) {
    const Vector3d omega = random.vector(1.0), n = random.vector(1.0).normalized(), x = n.cross(omega).normalized();
    const Vector3d v = omega.cross(x);
    const double sine = omega.cross(n).norm() / omega.norm();
    CHECK_THAT(std::abs(v.normalized().dot(n)), WithinAbs(sine, 1e-12));  // the cosine wanted is a sine of the other angle
  }
  // Side faces of a cube spinning about z have omega.N = 0: with the printed claim its torque would be nothing.
  CHECK(wrench(zoo::surface(Box{1, 1, 1}, 4), {.angular_velocity = Vector3d(0, 0, 1)}, {}, {}).total().torque.z() < -0.04);
}

TEST_CASE("E15, E16: the rotational element has sin^2, and its axis must be turned round", "[errata][sign]") {
  zoo::Random random(15);
  for (int i = 0; i < 100; ++i) {
    const Vector3d omega = random.vector(1.0), n = random.vector(1.0).normalized();
    const Vector3d printed = omega.cross(n), mended = n.cross(omega).normalized();
    CHECK(omega.cross(printed).dot(n) <= 0.0);  // the side said to meet the air moves away from it
    const double x = 0.3, sine = omega.cross(n).norm() / omega.norm();
    const Vector3d u = -omega.cross(x * mended);
    const double w = -u.dot(n), c = w / u.norm();
    REQUIRE(w > 0.0);
    // dF of the local law per width and rho: w^2 (1 - c/2) = x^2 omega^2 sin^2 (1 - sin/2); the note has one sine.
    CHECK_THAT(0.5 * u.squaredNorm() * evaluate(note_law().windward, c),
               WithinRel(x * x * omega.squaredNorm() * sine * sine * (1 - sine / 2), 1e-12));
  }
}

TEST_CASE("E17, E19: the printed torque has the order reversed and its tilt the wrong parity and unit", "[errata][sign]") {
  // A push along -z on a plate that lies at +x of the reference point turns it from x to -z: about +y. F x r would turn it the other way.
  const WrenchByTerm pushed = wrench(Surface(triangulate(Plate{1.0, 1.0, 0.0}, 1), Surface::Sides::two),
                                     {.wind = {0, 0, -1}, .reference_point = {-1, 0, 0}}, {.density = 2.0}, {});
  CHECK_THAT(pushed.total().force.z(), WithinAbs(-1.0, 1e-15));
  CHECK_THAT(pushed.total().torque.y(), WithinAbs(1.0, 1e-15));
  // A triangle and its mirror image in h must tilt in opposite ways: int x^2 h h_m does, the printed int x^3 h_m^2 cannot.
  const auto tilt = [](double sign, bool printed) {
    return integrate(
        0, 0.5,
        [&](double x) {
          const double h = 1 - x, middle = sign * 0.3 * x;
          return printed ? x * x * x * middle * middle : x * x * h * middle;
        },
        2000);
  };
  CHECK_THAT(tilt(-1, false), WithinRel(-tilt(1, false), 1e-12));
  CHECK_THAT(tilt(-1, true), WithinRel(tilt(1, true), 1e-12));
}

TEST_CASE("E18, E20, E21: shares outside 0 to 1, a middle line that misses the first vertex, damping that turns into drive",
          "[errata][sign]") {
  zoo::Random random(18);
  int outside = 0;
  for (int i = 0; i < 1000; ++i) {
    Vector3d p[3] = {random.vector(1.0), random.vector(1.0), random.vector(1.0)};  // a triangle in x and y about its centroid
    const Vector3d centroid = (p[0] + p[1] + p[2]) / 3;
    std::sort(p, p + 3, [](const Vector3d& a, const Vector3d& b) { return a.x() < b.x(); });
    const auto edge = [&](int from, int to, double x) {
      return p[from].y() + (p[to].y() - p[from].y()) * (x - p[from].x()) / (p[to].x() - p[from].x()) - centroid.y();
    };
    const double x = random.uniform(p[0].x(), p[2].x()), one = edge(0, 2, x), two = x < p[1].x() ? edge(0, 1, x) : edge(1, 2, x);
    const double share = 0.5 * (one + two) / std::abs(one - two);  // h_m / h
    outside += share < 0.0 || share > 1.0;
  }
  CHECK(outside > 500);  // a share is outside half of the time by symmetry, and beyond 1 now and then
  // E20: with the origin at the centroid the first vertex has a height; the printed line starts at 0.
  const Vector3d a(-0.5, 0.4, 0), b(0.1, 0.5, 0), c(0.4, -0.9, 0);
  CHECK(std::abs(a.y() - (a + b + c).y() / 3) > 0.1);
  // E21: int |x|^3 h is the same read from either side; the leading minus makes a brake a motor.
  const auto h = [](double x) { return 1 - 0.8 * x; };
  const auto there = integrate(-0.5, 0.7, [&](double x) { return std::abs(x * x * x) * h(x); }),
             back = integrate(-0.7, 0.5, [&](double x) { return std::abs(x * x * x) * h(-x); });
  CHECK_THAT(back, WithinRel(there, 1e-9));
}

TEST_CASE("E22: a one-sided triangle that spins about its centroid also feels a net force", "[errata][analytic]") {
  const TriangleMesh single{{Vector3d(0, 0, 0), Vector3d(1, 0, 0), Vector3d(0, 1, 0)}, {Eigen::Vector3i(0, 1, 2)}};
  const Motion motion{.angular_velocity = Vector3d(1, 0.5, 0), .reference_point = Vector3d(1, 1, 0) / 3};
  CHECK(wrench(Surface(single, Surface::Sides::one), motion, {}, {}).total().force.norm() > 1e-2);
}

TEST_CASE("E23: full suction on the side that turns away brakes a spinning cube twice", "[errata][analytic]") {
  Model both{.law = note_law()};
  both.law.leeward = both.law.windward;
  const Motion motion{.angular_velocity = Vector3d(0, 0, 1)};
  const Surface cube = zoo::surface(Box{1, 1, 1}, 6);
  CHECK_THAT(wrench(cube, motion, {}, both).total().torque.z(), WithinRel(2 * wrench(cube, motion, {}, {}).total().torque.z(), 1e-12));
}

TEST_CASE("E24, E25: linear and rotational forces apart miss the cross term, which is most of the damping", "[errata][analytic]") {
  zoo::Random random(25);
  const Surface coarse = zoo::surface(Box{1, 1, 1}, 1), fine = zoo::surface(Box{1, 1, 1}, 12);
  double split_error = 0.0, quadrature_error = 0.0, size = 0.0;
  for (int i = 0; i < 30; ++i) {
    const Vector3d v = random.vector(1.0), omega = random.vector(1.0).normalized() * 0.3 * v.norm();
    const auto torque = [&](const Surface& surface, const Vector3d& velocity, const Vector3d& spin) {
      return wrench(surface, {.velocity = velocity, .angular_velocity = spin}, {}, {}).total().torque;
    };
    const Vector3d exact = torque(fine, v, omega);
    split_error += (torque(fine, v, Vector3d::Zero()) + torque(fine, Vector3d::Zero(), omega) - exact).squaredNorm();
    quadrature_error += (torque(coarse, v, omega) - exact).squaredNorm();
    size += exact.squaredNorm();
  }
  CHECK(std::sqrt(split_error / size) > 0.5);        // even with exact integrals in both parts
  CHECK(std::sqrt(quadrature_error / size) < 0.01);  // three points on 12 triangles
}

TEST_CASE("E26: the trilinear formulas reproduce every trilinear function, and read outside the grid without a guard",
          "[errata][analytic]") {
  constexpr int n = 4;
  const auto field = [](double x, double y, double z) { return 1 + 2 * x - y + 3 * z + 4 * x * y - 5 * y * z + 6 * z * x - 7 * x * y * z; };
  const auto printed = [&](double x, double y, double z) {
    const auto at = [&field](int i, int j, int k) { return field(i / 3.0, j / 3.0, k / 3.0); };
    const auto low = [](double s) { return static_cast<int>(std::floor(s * (n - 1))); };
    const auto high = [&](double s) { return std::min(low(s) + 1, n - 1); };
    const double xd = x * (n - 1) - low(x), yd = y * (n - 1) - low(y), zd = z * (n - 1) - low(z);
    const auto line = [&](int j, int k) { return at(low(x), j, k) * (1 - xd) + at(high(x), j, k) * xd; };
    const double near = (1 - yd) * line(low(y), low(z)) + yd * line(high(y), low(z)),
                 far = (1 - yd) * line(low(y), high(z)) + yd * line(high(y), high(z));
    return (1 - zd) * near + zd * far;
  };
  for (const double x : {0.0, 0.1, 0.5, 0.99, 1.0})
    for (const double z : {0.0, 0.3, 1.0}) CHECK_THAT(printed(x, 0.7, z), WithinAbs(field(x, 0.7, z), 1e-13));
  CHECK(std::floor(-0.01 * (n - 1)) == -1.0);  // the index it would read; the library looks first
  const Grid grid{.points = {2, 1, 1}, .values = (Eigen::Matrix3Xd(3, 2) << 1, 3, 0, 0, 0, 0).finished()};
  CHECK(GridField(grid).velocity({-0.01, 0.5, 0.5}).isZero(0.0));
  CHECK(GridField({grid.points, grid.lower, grid.upper, grid.values, Outside::clamp}).velocity({-0.01, 0.5, 0.5}).x() == 1.0);
}

TEST_CASE("E27: the gust ends with a jump of its slope, and blows backwards on average for p above 1.68", "[errata][analytic]") {
  const auto gust = [](double p) { return [p](double x) { return -std::sin(2 * pi * std::pow(x, p)) * std::sin(pi * x / 2); }; };
  for (const double p : {0.5, 1.0, 2.0}) {
    CHECK_THAT(gust(p)(1.0), WithinAbs(0.0, 1e-14));
    CHECK_THAT(-gust(p)(1.0 - 1e-7) / 1e-7, WithinRel(-2 * pi * p, 1e-5));
  }
  CHECK(integrate(0, 1, gust(1.67)) > 0.0);
  CHECK(integrate(0, 1, gust(1.69)) < 0.0);
}
