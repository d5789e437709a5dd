#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "tests/support/zoo.hpp"

using namespace dragcore;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;
using Eigen::Vector3d;
using std::numbers::pi;

namespace {

/// Force coefficient, wind frame, of a shape at a pose on a stated area.
Vector3d coefficient(const Shape& shape, int divisions, const Pose& pose, double area, const Law& law = note_law()) {
  const Eigen::Matrix3d to_wind = pose.rotation();
  const Motion motion{.wind = to_wind.transpose() * Vector3d(1, 0, 0)};
  const Wrench total = wrench(zoo::surface(shape, divisions), motion, {.density = 2.0}, {.law = law}).total();
  return to_wind * total.force / area;  // rho = 2, U = 1: q = 1
}

constexpr double degree = pi / 180;

}  // namespace

TEST_CASE("the note's law on flat shapes has its closed-form drag coefficients", "[law][analytic]") {
  const Shape cube = Box{1, 1, 1};
  CHECK_THAT(coefficient(cube, 3, {}, 1.0).x(), WithinAbs(1.0, 1e-12));
  CHECK_THAT(coefficient(cube, 3, {.yaw = 45 * degree}, std::sqrt(2.0)).x(), WithinAbs(1.0 - std::sqrt(2.0) / 4.0, 1e-12));
  // Corner first: the space diagonal along the wind, c = 1/sqrt 3 on three faces, hexagonal frontal area sqrt 3.
  const Pose corner{.incidence = std::acos(1.0 / std::sqrt(3.0)), .roll = 45 * degree};
  CHECK_THAT(coefficient(cube, 2, corner, std::sqrt(3.0)).x(), WithinAbs(2.0 / 3.0 - std::sqrt(3.0) / 9.0, 1e-12));
  const double base_of_20_sides = 10 * 0.25 * std::sin(18 * degree);
  CHECK_THAT(coefficient(Cone{}, 5, {.incidence = pi}, base_of_20_sides).x(), WithinAbs(1.0, 1e-12));
}

TEST_CASE("a sheet's normal force follows s^2 (2 - s), the consistent law s (2 - s), from either side", "[law][analytic]") {
  const Shape sheet = Plate{1.0, 1.0, 0.0};
  for (int incidence = -180; incidence <= 180; incidence += 15) {
    const Pose pose{.incidence = incidence * degree};
    const double s = std::abs(std::sin(incidence * degree));
    const Vector3d note = coefficient(sheet, 2, pose, 1.0), consistent = coefficient(sheet, 2, pose, 1.0, consistent_law());
    INFO(incidence);
    CHECK_THAT(note.norm(), WithinAbs(s * s * (2 - s), 1e-12));
    CHECK_THAT(note.x(), WithinAbs(s * s * s * (2 - s), 1e-12));
    CHECK_THAT(consistent.norm(), WithinAbs(s * (2 - s), 1e-12));
    if (incidence == 30) CHECK(note.z() > 0.0);  // nose up lifts
  }
}

TEST_CASE("drag of round shapes converges to its exact value with second order", "[law][convergence]") {
  struct Case {
    Shape shape;
    Pose pose;
    double area, exact;
  };
  // Sphere: 2 int c^3 (2 - c) c dc ... = 3/5. Cone of 60 degrees: c = sin 30 on the whole side. Cylinder across the flow: int c^4... = 4/3
  // - 3 pi/16.
  const Case cases[] = {{Sphere{1.0}, {}, pi / 4, 0.6},
                        {Cone{1.0, pi / 3}, {}, pi / 4, 0.375},
                        {Cone{1.0, pi / 3}, {.incidence = pi}, pi / 4, 1.0},
                        {Cylinder{1.0, 2.0}, {.incidence = pi / 2}, 2.0, 4.0 / 3.0 - 3 * pi / 16},
                        {Ellipsoid{0.5, 0.5, 0.5}, {.incidence = 0.3, .yaw = 0.2}, pi / 4, 0.6}};
  for (const Case& test : cases) {
    double error[2];
    for (int level = 0; level < 2; ++level)
      error[level] = std::abs(coefficient(test.shape, 16 << level, test.pose, test.area).x() - test.exact);
    INFO(kind(test.shape) << ": errors " << error[0] << ", " << error[1]);
    CHECK(error[1] < 2e-3);
    CHECK_THAT(std::log2(error[0] / error[1]), WithinAbs(2.0, 0.15));  // the next term is smaller by 1/16^2 times a constant of order 10
  }
}

TEST_CASE("leeward faces feel no windward pressure, so that winding matters", "[law][sign]") {
  // Without the guard (erratum E3) the note's formula gives a closed plate 4 instead of 1.
  CHECK_THAT(coefficient(Box{0.01, 1, 1}, 2, {}, 1.0).x(), WithinAbs(1.0, 1e-12));
  // One-sided triangles turned away from the wind are not there.
  TriangleMesh sheet = triangulate(Plate{1.0, 1.0, 0.0}, 2);
  CHECK(wrench(Surface(sheet, Surface::Sides::one), {.wind = Vector3d(0, 0, 1)}, {}, {}).total().force.isZero(0.0));
  CHECK(wrench(Surface(sheet, Surface::Sides::one), {.wind = Vector3d(0, 0, -1)}, {.density = 2.0}, {})
            .total()
            .force.isApprox(Vector3d(0, 0, -1), 1e-14));
}

TEST_CASE("base suction pulls leeward faces downstream and is kept apart", "[law][sign]") {
  const WrenchByTerm parts =
      wrench(zoo::surface(Box{1, 1, 1}, 2), {.wind = Vector3d(1, 0, 0)}, {.density = 2.0}, {.law = scaled_law(0.75, 0.3)});
  CHECK_THAT(parts[Term::windward_pressure].force.x(), WithinAbs(0.75, 1e-14));
  CHECK_THAT(parts[Term::leeward_suction].force.x(), WithinAbs(0.3, 1e-14));
  CHECK_THAT(parts.total().force.x(), WithinAbs(1.05, 1e-14));
}

TEST_CASE("laws are non-negative, so that they are passive", "[law][limit]") {
  for (const Law& law : {note_law(), consistent_law(), scaled_law(1.0, 0.1)})
    for (int i = 0; i <= 1000; ++i) {
      CHECK(evaluate(law.windward, i / 1000.0) >= 0.0);
      CHECK(evaluate(law.leeward, i / 1000.0) >= 0.0);
    }
  CHECK(evaluate(note_law().windward, 0.0) == 0.0);
  CHECK(named_law("consistent").windward == consistent_law().windward);
  CHECK_THROWS_WITH(named_law("newton"), Catch::Contains("unknown law 'newton'; known: note, consistent"));
  CHECK_THROWS_WITH(named_law("consistant"), Catch::Contains("did you mean consistent? Known: note, consistent"));
}

namespace {

/// Force over q on a unit cube in a wind along (cos yaw, sin yaw, 0).
Eigen::Vector3d cube_force(const Law& law, double yaw, Term term) {
  const Motion motion{.wind = {std::cos(yaw), std::sin(yaw), 0.0}};
  return wrench(zoo::surface(Box{1, 1, 1}, 2), motion, {.density = 2.0}, {.law = law})[term].force;
}

}  // namespace

TEST_CASE("each term of the laws by class is its formula on a cube", "[law][analytic]") {
  Law law{.name = "terms",
          .windward = {0.0, 0.0, 2.0, -1.0, 0.0},
          .friction = 0.01,
          .base_suction = 0.4,
          .base_edge = 0.25,
          .recovery = 0.5,
          .recovery_depth = 2.0,
          .recovery_edge = 0.2,
          .shelter = 1.5};
  const double yaw = 0.4, c = std::cos(yaw), s = std::sin(yaw);
  // Descriptors by hand: two windward faces of unit area with cosines c and s.
  const double frontal = c + s, depth = std::pow(frontal, -1.5), M = (std::pow(c, 5) + std::pow(s, 5)) / frontal, k = std::pow(M, 0.25);
  const auto shelter = [&](double cosine) {
    const double x = std::max(0.0, 1.0 - cosine / k);
    return std::exp(-1.5 * M * x * x / (x + 0.1));
  };
  const auto saturating = [](double cosine, double edge) { return cosine * (1 + edge) / (cosine + edge); };
  const auto note = [](double cosine) { return cosine * cosine * (2 - cosine); };
  const auto base = [&](double cosine) { return 0.4 * saturating(cosine, 0.25) * (2 - cosine); };
  // Few operations of order one.
  constexpr double rounding = 1e-14;
  CHECK_THAT(cube_force(law, yaw, Term::windward_pressure).x(), WithinAbs(shelter(c) * note(c), rounding));
  CHECK_THAT(cube_force(law, yaw, Term::windward_pressure).y(), WithinAbs(shelter(s) * note(s), rounding));
  CHECK_THAT(cube_force(law, yaw, Term::base_suction).x(), WithinAbs(shelter(c) * base(c), rounding));
  CHECK_THAT(cube_force(law, yaw, Term::base_suction).y(), WithinAbs(shelter(s) * base(s), rounding));
  const double push = 0.4 * 0.5 * depth / (depth + 2.0);
  CHECK_THAT(cube_force(law, yaw, Term::rear_recovery).x(),
             WithinAbs(-push * saturating(c, 0.2), 1e-3 * push));  // the energy guard takes its 1e-3 at most here
  CHECK_THAT(cube_force(law, yaw, Term::rear_recovery).y(), WithinAbs(-push * saturating(s, 0.2), 1e-3 * push));
  // Friction along the flow: f t^2 on every face, t the tangential fraction: 2 s^2 + 2 c^2 + 2 faces.
  const Eigen::Vector3d friction = cube_force(law, yaw, Term::friction);
  CHECK_THAT(friction.dot(Eigen::Vector3d(c, s, 0.0)), WithinAbs(0.01 * 4.0, rounding));
  // A cube has no curved face.
  law.curvature = 1.0;
  CHECK(cube_force(law, yaw, Term::curvature).isZero(0.0));
}

TEST_CASE("curvature sucks on the windward side of a ball and leaves flat faces alone", "[law][sign]") {
  const Law law{.name = "curved", .windward = note_law().windward, .curvature = 0.5};
  const WrenchByTerm ball = wrench(zoo::surface(Sphere{}, 16), {.wind = {1.0, 0.0, 0.0}}, {.density = 2.0}, {.law = law});
  CHECK(ball[Term::curvature].force.x() < -0.05);
  CHECK(ball.total().force.x() > 0.0);
  const WrenchByTerm cone = wrench(zoo::surface(Cone{}, 16), {.wind = {1.0, 0.0, 0.0}}, {.density = 2.0}, {.law = law});
  CHECK(std::abs(cone[Term::curvature].force.x()) <
        1e-4);  // along the generators, which are straight, but for half a facet of 1/64 turn, squared twice
}

TEST_CASE("what pushes a body through the air is held below what the air takes", "[law][limit]") {
  // All of the base suction recovered by a body much deeper than wide, and nothing else but a little pressure: drag stays positive.
  const Surface rod = zoo::surface(Box{20.0, 1.0, 1.0}, 1);
  for (const double suction : {0.1, 1.0, 100.0}) {
    Law law{.name = "eager", .windward = {0.0, 0.0, 0.02, -0.01, 0.0}, .base_suction = suction, .recovery = 1.0, .recovery_depth = 1e-3};
    const WrenchByTerm parts = wrench(rod, {.wind = {1.0, 0.0, 0.0}}, {.density = 2.0}, {.law = law});
    const double taken = parts[Term::windward_pressure].force.x() + parts[Term::base_suction].force.x();
    CHECK(parts[Term::rear_recovery].force.x() < 0.0);
    CHECK(-parts[Term::rear_recovery].force.x() <= largest_gain * taken);
    CHECK(parts.total().force.x() > 0.0);
  }
  // Ordinary laws do not notice the guard: 1e-3 of the recovery of a cube.
  const double recovered = -cube_force(closed_law(), 0.0, Term::rear_recovery).x(),
               full = closed_law().base_suction / (1.0 + closed_law().recovery_depth);
  CHECK_THAT(recovered, WithinRel(full, 1e-3));
}

TEST_CASE("the law by class is the sheet's for sheets and the closed one for the rest", "[law][analytic]") {
  CHECK(law_for(BodyClass::sheet) == sheet_law());
  CHECK(law_for(BodyClass::sharp) == closed_law());
  CHECK(law_for(BodyClass::smooth) == closed_law());
  CHECK(model_for(zoo::surface(Sphere{}, 8)).law == closed_law());
  for (const std::string& name : law_names()) CHECK(named_law(name).name == name);
}

TEST_CASE("a law out of range is refused by name and number", "[law][hard]") {
  const auto refused = [](auto change, const char* words) {
    Law law = closed_law();
    change(law);
    CHECK_THROWS_WITH(validate(law), Catch::Contains("law 'closed'") && Catch::Contains(words));
  };
  refused([](Law& l) { l.friction = -0.1; }, "friction = -0.1");
  refused([](Law& l) { l.recovery = 1.5; }, "recovery = 1.5");
  refused([](Law& l) { l.base_edge = 0.0; }, "base_edge = 0");
  refused([](Law& l) { l.recovery_depth = std::nan(""); }, "recovery_depth");
  refused([](Law& l) { l.windward[2] = INFINITY; }, "windward coefficient");
}
