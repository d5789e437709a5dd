// Every hard case of the evaluation core, in double and by the kernels: finite, bounded, and right in the limit that the name states.

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <dragcore/batch.hpp>
#include <dragcore/body_wind.hpp>
#include <dragcore/descriptors.hpp>
#include <dragcore/stepping.hpp>
#include <functional>
#include <limits>
#include <numbers>
#include <thread>

#include "tests/dragcore/drag/hostile.hpp"

using namespace dragcore;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::Vector3i;
using std::numbers::pi;

namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
constexpr double denormal = std::numeric_limits<double>::denorm_min(), ulp = std::numeric_limits<double>::epsilon();

/// Every known law with every pillow, and in single precision with every pillow that the kernels know: what each hard case must stand.
std::vector<Model> models() {
  std::vector<Model> list;
  for (const Precision precision : hostile::precisions)
    for (const Law& law : hostile::laws())
      for (const Pillow& pillow : hostile::pillows())
        if (precision == Precision::full || hostile::known_to_kernels(pillow))
          list.push_back({.law = law, .pillow = pillow, .precision = precision});
  return list;
}

std::string name(const Model& model) {
  return "law " + model.law.name + ", pillow " + to_string(model.pillow.form) + " " + to_string(model.pillow.falloff) +
         (model.precision == Precision::single ? ", single" : "");
}

/// Largest difference of two wrenches, about 1 in size.
double distance(const Wrench& a, const Wrench& b) { return (a.force - b.force).norm() + (a.torque - b.torque).norm(); }

/// How far two results of a model may be apart by their rounding: in double as given; in single what each is promised to be within, of the
/// largest force and torque that the motion could make.
double apart(const Model& model, double in_double, const Surface& surface, const Motion& motion, double density = Medium{}.density) {
  if (model.precision == Precision::full) return in_double;
  return 2.0 * hostile::rounding(model.precision, 0.0) * hostile::force_scale(surface, motion, density) *
         (1.0 + hostile::arm_scale(surface, motion));
}

bool same_bits(const Wrench& a, const Wrench& b) { return a.force == b.force && a.torque == b.torque; }

Surface sheet(const TriangleMesh& mesh) { return Surface(mesh, Surface::Sides::two); }

const Motion oblique{
    .wind = {0.8, 0.3, -0.5}, .velocity = {0.1, -0.2, 0.3}, .angular_velocity = {0.7, -0.4, 1.1}, .reference_point = {0.1, 0.05, -0.2}};
const Motion oblique_straight{.wind = {0.8, 0.3, -0.5}, .velocity = {0.1, -0.2, 0.3}, .reference_point = {0.1, 0.05, -0.2}};

}  // namespace

TEST_CASE("a seam closed by a triangle without area is a seam: the wrench of a cube", "[hard][mesh]") {
  // One edge of a cube is halved on one of its two faces only; the gap is filled by a triangle without area.
  TriangleMesh seam = welded(triangulate(Box{}, 1));
  Vector3i first = seam.triangles[0];
  // An edge of the cube, not a diagonal of its face.
  if ((seam.vertices[first[0]] - seam.vertices[first[1]]).norm() > 1.1) first = {first[1], first[2], first[0]};
  REQUIRE((seam.vertices[first[0]] - seam.vertices[first[1]]).norm() < 1.1);
  seam.vertices.push_back(0.5 * (seam.vertices[first[0]] + seam.vertices[first[1]]));
  const int middle = static_cast<int>(seam.vertices.size()) - 1;
  seam.triangles[0] = {first[0], middle, first[2]};
  seam.triangles.emplace_back(middle, first[1], first[2]);
  seam.triangles.emplace_back(first[0], first[1], middle);
  seam.triangles.emplace_back(first[0], first[0], first[1]);  // and one that repeats a corner
  const Surface cube(triangulate(Box{}, 1)), patched(seam);
  CHECK(patched.size() == 13);
  CHECK_THAT(patched.volume, WithinRel(1.0, 1e-14));
  CHECK(patched.body_class == BodyClass::sharp);
  for (const Model& model : models()) {
    if (model.pillow.form == PillowForm::triangle || model.pillow.form == PillowForm::eccentricity)
      continue;  // know the triangulation: erratum E13
    INFO(name(model));
    CHECK(distance(wrench(cube, oblique_straight, {}, model).total(), wrench(patched, oblique_straight, {}, model).total()) <
          apart(model, 1e-13, cube, oblique_straight));
  }
}

TEST_CASE("a sheet cut into needles of 1 : 1e6 to 1 : 1e11 is the same sheet", "[hard][mesh]") {
  const TriangleMesh whole{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 3}}};
  for (const double width : {1e-6, 1e-9, 1e-11}) {
    const double x = 0.3 + width;
    const TriangleMesh cut{{{0, 0, 0}, {0.3, 0, 0}, {x, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.3, 1, 0}, {x, 1, 0}, {1, 1, 0}},
                           {{0, 1, 5}, {0, 5, 4}, {1, 2, 6}, {1, 6, 5}, {2, 3, 7}, {2, 7, 6}}};
    const Surface needles = sheet(cut);
    REQUIRE(needles.size() == 6);
    CHECK(needles.patches.size() == 1);
    CHECK((needles.curvature.abs() == 0.0).all());
    for (const Model& model : models()) {
      if (model.pillow.form == PillowForm::triangle || model.pillow.form == PillowForm::eccentricity) continue;
      INFO(name(model) << ", width " << width);
      CHECK(distance(wrench(sheet(whole), oblique_straight, {}, model).total(), wrench(needles, oblique_straight, {}, model).total()) <
            apart(model, 1e-13, needles, oblique_straight));
    }
  }
  // A needle by itself: straight but for 1e-10, so that its outline has no corner to turn at. The pillow moves the force along it by less
  // than its length.
  const Surface needle = sheet({{{0, 0, 0}, {1, 0, 0}, {0.4, 1e-10, 0}}, {{0, 1, 2}}});
  REQUIRE(needle.size() == 1);
  for (const Model& model : models()) {
    const Wrench felt = wrench(needle, {.wind = {0.7, 0.1, -0.7}}, {}, model).total();
    CHECK(felt.force.norm() < 1e-10);
    CHECK(felt.torque.norm() <= 2.0 * felt.force.norm());
  }
}

TEST_CASE("a sheet given twice feels everything twice, and the pillow moves it as once", "[hard][mesh]") {
  TriangleMesh mesh = triangulate(Plate{1.0, 0.6, 0.0}, 2);
  const Surface once = sheet(mesh);
  const std::vector<Vector3i> triangles = mesh.triangles;
  const auto check = [&](const Surface& twice, double factor) {
    for (const Model& model : models()) {
      INFO(name(model));
      const Wrench a = wrench(once, oblique, {}, model).total(), b = wrench(twice, oblique, {}, model).total();
      CHECK(distance({factor * a.force, factor * a.torque}, b) < apart(model, 1e-13, twice, oblique));
    }
  };
  mesh.triangles.insert(mesh.triangles.end(), triangles.begin(), triangles.end());
  check(sheet(mesh), 2.0);
  mesh.triangles.insert(mesh.triangles.begin(), triangles.begin(), triangles.end());
  check(sheet(mesh), 3.0);
  // Vertices repeated, as in STL files.
  TriangleMesh apart;
  for (const Vector3i& t : triangles)
    for (int k = 0; k < 3; ++k) {
      if (k == 0) apart.triangles.emplace_back(Vector3i(0, 1, 2).array() + static_cast<int>(apart.vertices.size()));
      apart.vertices.push_back(mesh.vertices[t[k]]);
    }
  check(sheet(apart), 1.0);
}

TEST_CASE("two skins at one place are a body without volume, whatever the rounding of their volume says", "[hard][mesh]") {
  zoo::Random random(1);
  for (int i = 0; i < 50; ++i) {
    const TriangleMesh skins{{random.vector(1), random.vector(1), random.vector(1), random.vector(1e-20)}, {{0, 1, 2}, {2, 1, 0}}};
    for (const Surface::Sides sides : {Surface::Sides::one, Surface::Sides::two}) {
      const Surface surface(skins, sides);
      CHECK(surface.volume < 1e-15);
      CHECK(surface.volume >= 0.0);
      CHECK(surface.body_class == BodyClass::sheet);
      for (const Model& model : {model_for(surface), zoo::exactly(model_for(surface))})
        CHECK(wrench(surface, oblique, {}, model).total().force.allFinite());
    }
  }
  const TriangleMesh box = triangulate(Box{}, 1);
  TriangleMesh inside_out = box;
  for (Vector3i& t : inside_out.triangles) std::swap(t[0], t[1]);
  CHECK_THROWS_WITH(Surface(inside_out, Surface::Sides::one), Catch::Contains("inside out"));
  const Motion motion{.wind = {1.0, 0.4, 0.2}};
  for (const Precision precision : hostile::precisions) {
    const Model note{.precision = precision};
    CHECK(distance(wrench(sheet(inside_out), motion, {}, note).total(), wrench(sheet(box), motion, {}, note).total()) <
          apart(note, 1e-14, sheet(box), motion));
  }
  // A closed needle all of whose triangles are too thin to have a normal.
  const Surface nothing({{{0, 0, 0}, {1e-14, 0, 0}, {0, 1e-14, 0}, {0, 0, 1}}, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}});
  for (const Model& model : {model_for(nothing), zoo::exactly(model_for(nothing))})
    CHECK(wrench(nothing, oblique, {}, model).total().force.allFinite());
}

TEST_CASE("what is not a number is refused by name; without checks it passes through, and nothing breaks", "[hard]") {
  const Surface cube = zoo::surface(Box{}, 1), flat = zoo::surface(Plate{1, 1, 0}, 1);
  const std::vector<Vector3d> winds(12, Vector3d(1, 0, 0));
  struct Poisoned {
    const char* word;
    std::function<void(Motion&, Medium&, Model&, std::vector<Vector3d>&, double)> poison;
  };
  const Poisoned cases[] = {
      {"motion.wind", [](Motion& m, Medium&, Model&, auto&, double bad) { m.wind[1] = bad; }},
      {"motion.velocity", [](Motion& m, Medium&, Model&, auto&, double bad) { m.velocity[0] = bad; }},
      {"motion.angular_velocity", [](Motion& m, Medium&, Model&, auto&, double bad) { m.angular_velocity[2] = bad; }},
      {"motion.reference_point", [](Motion& m, Medium&, Model&, auto&, double bad) { m.reference_point[1] = bad; }},
      {"motion.wind_gradient", [](Motion& m, Medium&, Model&, auto&, double bad) { m.wind_gradient(2, 1) = bad; }},
      {"motion.triangle_wind", [](Motion& m, Medium&, Model&, auto& list, double bad) { list[1][1] = bad, m.triangle_wind = list; }},
      {"density", [](Motion&, Medium& m, Model&, auto&, double bad) { m.density = bad; }},
      {"pillow factor", [](Motion&, Medium&, Model& m, auto&, double bad) { m.pillow.factor = bad; }},
      {"windward coefficient", [](Motion&, Medium&, Model& m, auto&, double bad) { m.law.windward[3] = bad; }},
      {"leeward coefficient", [](Motion&, Medium&, Model& m, auto&, double bad) { m.law.leeward[0] = bad; }},
      {"friction", [](Motion&, Medium&, Model& m, auto&, double bad) { m.law.friction = bad; }},
      {"base_suction", [](Motion&, Medium&, Model& m, auto&, double bad) { m.law.base_suction = bad; }},
      {"base_edge", [](Motion&, Medium&, Model& m, auto&, double bad) { m.law.base_edge = bad; }},
      {"aspect_gain", [](Motion&, Medium&, Model& m, auto&, double bad) { m.law.aspect_gain = bad; }},
      {"aspect_scale", [](Motion&, Medium&, Model& m, auto&, double bad) { m.law.aspect_scale = bad; }},
      {"recovery", [](Motion&, Medium&, Model& m, auto&, double bad) { m.law.recovery = bad; }},
      {"recovery_depth", [](Motion&, Medium&, Model& m, auto&, double bad) { m.law.recovery_depth = bad; }},
      {"recovery_edge", [](Motion&, Medium&, Model& m, auto&, double bad) { m.law.recovery_edge = bad; }},
      {"shelter", [](Motion&, Medium&, Model& m, auto&, double bad) { m.law.shelter = bad; }},
      {"curvature", [](Motion&, Medium&, Model& m, auto&, double bad) { m.law.curvature = bad; }}};
  for (const Poisoned& test : cases)
    for (const double bad : {not_a_number, infinity, -infinity})
      for (const Pillow& pillow : hostile::pillows())
        for (const auto& [order, precision] : {std::pair(Quadrature::adaptive, Precision::full),
                                               {Quadrature::three, Precision::full},
                                               {Quadrature::adaptive, Precision::single},
                                               {Quadrature::three, Precision::single}})
          for (const Surface* surface : {&cube, &flat}) {
            Motion motion = oblique;
            Medium medium;
            Model model{.law = closed_law(), .pillow = pillow, .quadrature = order, .precision = precision};
            std::vector<Vector3d> list(winds.begin(), winds.begin() + surface->size());
            test.poison(motion, medium, model, list, bad);
            INFO(test.word << " = " << bad << ", " << name(model));
            if (order == Quadrature::three && pillow.form == PillowForm::none) {
              CHECK_THROWS_WITH(wrench(*surface, motion, medium, model), Catch::Contains(test.word));
              CHECK_THROWS_WITH(triangle_forces(*surface, motion, medium, model), Catch::Contains(test.word));
              CHECK_THROWS_WITH(resistance(*surface, motion, medium, model), Catch::Contains(test.word));
              CHECK_THROWS_WITH(force_jacobian(*surface, motion, medium, model), Catch::Contains(test.word));
            }
            model.check = false;
            CHECK_NOTHROW(wrench(*surface, motion, medium, model));
            CHECK_NOTHROW(triangle_forces(*surface, motion, medium, model));
            CHECK_NOTHROW(resistance(*surface, motion, medium, model));
            CHECK_NOTHROW(force_jacobian(*surface, motion, medium, model));
          }
  // It does pass through, and a sound input gives the bits it gives with checks.
  for (const Precision precision : hostile::precisions) {
    CHECK_FALSE(
        wrench(cube, {.wind = {1, 0, 0}}, {.density = not_a_number}, {.check = false, .precision = precision}).total().force.allFinite());
    CHECK(same_bits(wrench(cube, oblique, {}, {.law = closed_law(), .precision = precision}).total(),
                    wrench(cube, oblique, {}, {.law = closed_law(), .check = false, .precision = precision}).total()));
  }
  // The wrong number of winds would read beyond their end: refused even without checks.
  Motion motion = oblique;
  motion.triangle_wind = {winds.data(), 5};
  for (const Precision precision : hostile::precisions)
    CHECK_THROWS_WITH(wrench(cube, motion, {}, {.check = false, .precision = precision}),
                      Catch::Contains("triangle_wind") && Catch::Contains("12 triangles"));
  for (const double bad : {not_a_number, infinity}) {
    TriangleMesh mesh = triangulate(Box{}, 1);
    mesh.vertices[3][1] = bad;
    CHECK_THROWS_WITH(Surface(mesh), Catch::Contains("vertex 3") && Catch::Contains("finite"));
    CHECK_THROWS_WITH(transformed(triangulate(Box{}, 1), Matrix3d::Identity(), Vector3d(0, bad, 0)), Catch::Contains("finite"));
  }
  TriangleMesh mesh = triangulate(Box{}, 1);
  mesh.triangles[2][1] = 99;
  CHECK_THROWS_WITH(Surface(mesh), Catch::Contains("triangle 2") && Catch::Contains("99"));
}

TEST_CASE("a surface without triangles feels nothing, of any kind", "[hard][limit]") {
  for (const Surface::Sides sides : {Surface::Sides::one, Surface::Sides::two})
    for (const Model& model : models()) {
      const Surface empty(TriangleMesh{}, sides);
      Motion motion = oblique;
      motion.wind_gradient.setConstant(0.3);
      CHECK(same_bits(wrench(empty, motion, {}, model).total(), {}));
      CHECK(triangle_forces(empty, motion, {}, model).force.cols() == 0);
      CHECK(resistance(empty, motion, {}, model).isZero(0.0));
      CHECK(force_jacobian(empty, motion, {}, model).isZero(0.0));
      CHECK_FALSE(line_of_action(wrench(empty, motion, {}, model).total(), {}).has_value());
    }
}

TEST_CASE("one triangle has its closed-form force from every side, and none from behind if it has one side", "[hard][analytic]") {
  const TriangleMesh mesh{{{0, 0, 0}, {2, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}};  // area 1, normal +z, centroid (2/3, 1/3, 0)
  for (const Precision precision : hostile::precisions)
    for (const double angle : {0.0, 0.3, 1.2, pi / 2, 2.0, pi, -0.4, -1.5}) {
      const Vector3d wind(std::cos(angle), 0, -std::sin(angle));  // onto the front for angles in (0, pi)
      const double c = std::abs(std::sin(angle)), note = c * c * (2 - c), front = std::sin(angle) > 0 ? note : 0.0,
                   within = 2.0 * hostile::rounding(precision, 0.5e-15);  // both sides of 1 m^2, q = 1
      INFO("angle " << angle << (precision == Precision::single ? ", single" : ""));
      const Model plain{.precision = precision}, rubbing{.law = sheet_law(), .precision = precision};
      const Wrench two = wrench(sheet(mesh), {.wind = wind}, {.density = 2.0}, plain).total();
      const Wrench one = wrench(Surface(mesh, Surface::Sides::one), {.wind = wind}, {.density = 2.0}, plain).total();
      CHECK_THAT(two.force.z(), WithinAbs(std::sin(angle) > 0 ? -note : note, within));
      CHECK_THAT(one.force.z(), WithinAbs(-front, within));
      CHECK((two.torque - Vector3d(2.0 / 3, 1.0 / 3, 0).cross(two.force)).norm() < 1e-15 + within * 1e-3);  // the same rounding in both
      // Sheet law: both sides rub along the tangential flow.
      const Wrench rubbed = wrench(sheet(mesh), {.wind = wind}, {.density = 2.0}, rubbing).total();
      CHECK_THAT(rubbed.force.x(), WithinAbs(2 * sheet_law().friction * std::cos(angle), within));
    }
  for (const Model& model : models()) {
    const Surface triangle = sheet(mesh);
    const Vector3d centroid(2.0 / 3, 1.0 / 3, 0);  // it spins about itself: the air stands still at its centroid, to the bit
    const Wrench spun = wrench(triangle, {.angular_velocity = {1, 2, 3}, .reference_point = centroid}, {}, model).total();
    const Wrench plain =
        reference::wrench(mesh, Surface::Sides::two, {.angular_velocity = {1, 2, 3}, .reference_point = centroid}, {}, model).total();
    INFO(name(model));
    CHECK(distance(spun, plain) < apart(model, 1e-13, triangle, {.angular_velocity = {1, 2, 3}, .reference_point = centroid}));
    CHECK(spun.torque.dot(Vector3d(1, 2, 3)) < 0.0);
  }
}

TEST_CASE("spin about the centroid of one of many triangles: fast and plain agree where the air stands still", "[hard][backend]") {
  const TriangleMesh mesh = triangulate(Plate{1.0, 0.6, 0.0}, 2);
  const Surface surface = sheet(mesh);
  for (const Model& model : models()) {
    const Vector3d centroid = surface.centroid.row(2).matrix();
    const Motion motion{.angular_velocity = {1, 2, 3}, .reference_point = centroid};
    INFO(name(model));
    CHECK(distance(wrench(surface, motion, {}, model).total(), reference::wrench(mesh, Surface::Sides::two, motion, {}, model).total()) <
          apart(model, 1e-13, surface, motion));
  }
}

TEST_CASE("no force or torque jumps where a face is edge-on or normal to the flow to the last bit, or one bit beside it", "[hard][limit]") {
  const Surface bodies[] = {sheet({{{0, 0, 0}, {2, 0, 0}, {0.3, 1, 0}}, {{0, 1, 2}}}), zoo::surface(Plate{1.3, 0.7, 0.05}, 1),
                            zoo::surface(Box{}, 2), zoo::surface(Cylinder{0.8, 1.5}, 2), zoo::surface(Plate{1, 1, 0}, 2)};
  double eccentric_jump = 0.0;
  for (const Surface& body : bodies)
    for (const Model& model : models())
      for (int axis = 0; axis < 3; ++axis)
        for (const double sign : {1.0, -1.0})
          for (int other = 0; other < 3; ++other)
            for (const double beside : {denormal, -denormal, 1e-200, ulp, -ulp, 1e-15}) {
              if (other == axis) continue;
              const Vector3d exact = sign * Vector3d::Unit(axis), near = exact + beside * Vector3d::Unit(other),
                             nearer(exact * std::nextafter(1.0, 0.0));
              const Wrench at = wrench(body, {.wind = exact}, {}, model).total(), next = wrench(body, {.wind = near}, {}, model).total();
              INFO(name(model) << ", axis " << axis << ", beside by " << beside << " along " << other);
              // At most 25 q A per radian, of the steepest law (test_property.cpp), times 1e-15; the rest is rounding.
              const double rounding = apart(model, 1e-13, body, {.wind = exact});
              CHECK((at.force - next.force).norm() < rounding);
              CHECK((at.torque - next.torque).norm() < rounding);
              if (beside == ulp) CHECK(distance(at, wrench(body, {.wind = nearer}, {}, model).total()) < rounding);
              // The eccentricity form has a direction from 1e-14 on: documented to jump, and all others not to.
              const double step = distance(at, wrench(body, {.wind = exact + 1e-12 * Vector3d::Unit(other)}, {}, model).total());
              if (model.pillow.form == PillowForm::eccentricity)
                eccentric_jump = std::max(eccentric_jump, step);
              else
                CHECK(step < apart(model, 1e-10, body, {.wind = exact}));
            }
  CHECK(eccentric_jump > 0.01);
}

TEST_CASE("a law whose force jumps edge-on has a secant matrix that is one however near to edge-on", "[hard][limit]") {
  // Regression: pressure over a normal velocity of 1e-310 was no number, and so was the step after a few long ones.
  Law jumps = note_law();
  jumps.windward[0] = 1.0;
  for (const Precision precision : hostile::precisions)
    for (const double beside : {1e-20, 1e-100, 1e-300, 1e-310, denormal}) {
      const Model model{.law = jumps, .precision = precision};
      const Matrix6d S = resistance(zoo::surface(Plate{1, 1, 0}, 1), {.wind = {1, 0, beside}}, {}, model);
      INFO("beside by " << beside << (precision == Precision::single ? ", single" : ""));
      CHECK(S.allFinite());
      CHECK(S(2, 2) >= 0.0);
    }
}

TEST_CASE("air at rest relative to the body, or slower than the square root of the least number, is no force and no trouble",
          "[hard][limit]") {
  const Surface bodies[] = {zoo::surface(Box{}, 1), zoo::surface(Sphere{}, 2), zoo::surface(Plate{1, 1, 0}, 1)};
  for (const Surface& body : bodies)
    for (Model model : models())
      for (const Quadrature order : {Quadrature::adaptive, Quadrature::three}) {
        model.quadrature = order;
        INFO(name(model));
        const Vector3d drift(3, -4, 5);
        CHECK(same_bits(wrench(body, {.wind = drift, .velocity = drift}, {}, model).total(), {}));
        CHECK(resistance(body, {.wind = drift, .velocity = drift}, {}, model).isZero(0.0));
        CHECK(force_jacobian(body, {.wind = drift, .velocity = drift}, {}, model).isZero(0.0));
        for (const double slow : {denormal, 1e-310, 1e-200, 1e-160, 1e-155}) {
          const Motion motion{.wind = {slow, -slow, 0}, .angular_velocity = {0, slow, slow}};
          const Wrench felt = wrench(body, motion, {}, model).total();
          CHECK(felt.force.norm() + felt.torque.norm() < 1e-300);
          CHECK(resistance(body, motion, {}, model).norm() < 1e-150);
          CHECK(force_jacobian(body, motion, {}, model).norm() < 1e-150);
        }
      }
}

TEST_CASE("size, speed and density by powers of two scale force by rho L^2 U^2 and torque by rho L^3 U^2 to the bit", "[hard][limit]") {
  // 1e-6 to 1e6 m, 1e-12 to 1e4 m/s, 1e-3 to 1e4 kg/m^3: no number of the core has a dimension.
  zoo::Random random(20);
  const Shape shapes[] = {Box{2, 1, 0.5}, Sphere{}, Plate{1, 0.7, 0.0}, Cone{}};
  for (const Shape& shape : shapes) {
    const TriangleMesh mesh = triangulate(shape, 2);
    const Surface unit(mesh, zoo::sides_of(shape));
    for (Model model : models()) {
      const auto exponent = [&](double low, double high) { return std::ldexp(1.0, static_cast<int>(random.uniform(low, high))); };
      const double L = exponent(-20, 20), U = exponent(-40, 13), rho = exponent(-10, 13);
      model.quadrature = random.uniform(0, 1) < 0.5 ? Quadrature::adaptive : Quadrature::six;
      Motion motion = random.motion(1.0, 1.0);
      motion.wind_gradient = 0.3 * random.rotation();
      Motion scaled{U * motion.wind, U * motion.velocity, U / L * motion.angular_velocity, L * motion.reference_point,
                    U / L * motion.wind_gradient};
      const Surface large(transformed(mesh, L * Matrix3d::Identity(), Vector3d::Zero()), zoo::sides_of(shape));
      const Wrench one = wrench(unit, motion, {.density = 1.0}, model).total(),
                   other = wrench(large, scaled, {.density = rho}, model).total();
      INFO(name(model) << ", L " << L << ", U " << U << ", rho " << rho);
      CHECK(same_bits({one.force * (rho * L * L * U * U), one.torque * (rho * L * L * L * U * U)}, other));
      CHECK(large.body_class == unit.body_class);
    }
  }
}

TEST_CASE("a spin a million times faster than the travel is a spin, and brakes", "[hard][limit]") {
  zoo::Random random(21);
  for (const Shape& shape : zoo::shapes()) {
    const Surface body = zoo::surface(shape, 1);
    for (const Model& model : models()) {
      const Vector3d spin = 1e6 * random.vector(1.0).normalized(), travel = random.vector(1.0);
      const Wrench felt = wrench(body, {.velocity = travel, .angular_velocity = spin}, {}, model).total();
      const Wrench pure = wrench(body, {.angular_velocity = spin}, {}, model).total();
      INFO(kind(shape) << ", " << name(model));
      const double scale = hostile::force_scale(body, {.angular_velocity = spin}, 1.225);
      // Linear in the ratio of speeds, 1e-6, with the slopes of the law.
      CHECK((felt.force - pure.force).norm() < 1e-5 * scale);
      CHECK((felt.torque - pure.torque).norm() < 1e-5 * scale * hostile::arm_scale(body, {}));
      CHECK(felt.torque.dot(spin) + felt.force.dot(travel) <= 0.0);
      CHECK(resistance(body, {.velocity = travel, .angular_velocity = spin}, {}, model).allFinite());
    }
  }
}

TEST_CASE("a plate that spins about its normal feels friction and nothing else", "[hard][limit]") {
  const Surface flat = zoo::surface(Plate{1, 1, 0}, 16);
  double integral = 0.0;  // of r^3 over the unit square
  for (int i = 0; i < 400; ++i)
    for (int j = 0; j < 400; ++j) integral += std::pow(std::hypot((i + 0.5) / 400 - 0.5, (j + 0.5) / 400 - 0.5), 3) / 160'000;
  for (const Model& model : models()) {
    const Wrench felt = wrench(flat, {.angular_velocity = {0, 0, 7}}, {.density = 2.0}, model).total();
    INFO(name(model));
    const double rounding = apart(model, 1e-15, flat, {.angular_velocity = {0, 0, 7}}, 2.0);
    CHECK(felt.force.norm() < rounding);
    CHECK(felt.torque.head<2>().norm() < rounding);
    CHECK_THAT(felt.torque.z(),
               WithinRel(-2.0 * model.law.friction * 49.0 * integral, 1e-4));  // 1/1024 of curvature at three points a triangle
    if (model.law.friction == 0.0) CHECK(felt.torque.z() == 0.0);
  }
  for (const double thickness : {1e-2, 1e-4, 1e-6})
    for (const Precision precision : hostile::precisions) {
      Model smooth{.law = closed_law(), .precision = precision};
      smooth.law.friction = 0.0;
      const Wrench felt = wrench(zoo::surface(Plate{1, 1, thickness}, 2), {.angular_velocity = {0, 0, 7}}, {}, smooth).total();
      INFO("thickness " << thickness << (precision == Precision::single ? ", single" : ""));
      CHECK(felt.torque.z() < 0.0);
      CHECK(felt.torque.z() > -100.0 * thickness);  // the rims alone
    }
}

TEST_CASE("ten kilometres from the origin a body is what it is at the origin", "[hard][invariance]") {
  const Vector3d away(10'000, -9'000, 8'000);
  for (const Shape& shape : {Shape(Box{1, 1, 1}), Shape(Cone{}), Shape(Plate{1.0, 0.7, 0.0}), Shape(Plate{1.0, 0.7, 0.05})}) {
    const TriangleMesh mesh = triangulate(shape, 2), far = transformed(mesh, Matrix3d::Identity(), away);
    TriangleMesh single = far;
    for (Vector3d& v : single.vertices) v = v.cast<float>().cast<double>();
    const Surface here(mesh, zoo::sides_of(shape)), there(far, zoo::sides_of(shape)), coarse(single, zoo::sides_of(shape));
    Motion motion = oblique, moved = oblique;
    moved.reference_point += away;
    for (const Model& model : models()) {
      INFO(kind(shape) << ", " << name(model));
      const Wrench a = wrench(here, motion, {}, model).total(), b = wrench(there, moved, {}, model).total();
      CHECK(distance(a, b) <
            apart(model, 1e-9, here,
                  motion));  // double: 2e-12 m of rounding, times 1/width of the narrowest triangle, 20, times the law's slopes

      // Single: 2^-11 m of rounding per coordinate, d = sqrt(3) 2^-11 m per corner. An area vector A n changes by at most (|AB| + |AC|) d,
      // and the force of its triangle by (C + |C'|) times that: at most 8 for the laws without pushing terms (consistent: 1 + 2; both
      // sides; pillow and spin add arms).
      const Wrench c = wrench(coarse, moved, {}, model).total();
      double edges = 0.0;
      for (Eigen::Index i = 0; i < here.size(); ++i) edges += here.edge_ab.row(i).matrix().norm() + here.edge_ac.row(i).matrix().norm();
      const double bound = 0.5 * 1.225 * 4.0 * 8.0 * edges * std::sqrt(3.0) * std::ldexp(1.0, -11);
      CHECK((a.force - c.force).norm() < bound);
      CHECK((a.torque - c.torque).norm() <
            2.0 * bound + 0.1 * a.force.norm());  // faces fall apart into patches of one triangle each: the pillow is shorter
    }
  }
}

TEST_CASE("a plate thinner and thinner becomes the sheet", "[hard][limit]") {
  const TriangleMesh mesh = triangulate(Plate{1.3, 0.7, 0.0}, 2);
  const Surface flat = sheet(mesh);
  for (const Model& model : models()) {
    // The descriptors of closed bodies tend to those of a sheet as well: depth goes to 0 with the thickness.
    double previous = infinity;
    if (model.pillow.form == PillowForm::triangle || model.pillow.form == PillowForm::eccentricity) continue;  // triangulated otherwise
    for (const double thickness : {1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-12, 1e-13, 1e-15}) {
      const TriangleMesh plate = triangulate(Plate{1.3, 0.7, thickness}, 2);
      const Surface body(plate);
      const double error = distance(wrench(body, oblique_straight, {}, model).total(), wrench(flat, oblique_straight, {}, model).total());
      INFO(name(model) << ", thickness " << thickness);
      const double rounding = apart(model, 1e-13, flat, oblique_straight);
      CHECK(error < 10.0 * thickness + rounding);  // rims of 4 m, q = 0.6, C up to 2; arms; the loss of volume
      CHECK(error <= previous + rounding);
      previous = error;
      for (const Vector3d& wind : {Vector3d(1, 0, 0), Vector3d(1, 0, 1e-300), Vector3d(1, 0, 1e-16), Vector3d(0, 0, 1)}) {
        const Wrench edge = wrench(body, {.wind = wind}, {}, model).total();
        CHECK(distance(edge, reference::wrench(plate, Surface::Sides::one, {.wind = wind}, {}, model).total()) <
              apart(model, 1e-14, body, {.wind = wind}));
        CHECK(std::isfinite(describe(body, wind).depth));
      }
    }
  }
}

TEST_CASE("a cone as slender as a hair or as flat as a disc has the force of its limit", "[hard][limit]") {
  for (const Model& model : models())
    for (const double half : {1e-6, 1e-3, pi / 2 - 1e-3, pi / 2 - 1e-6}) {
      const TriangleMesh mesh = triangulate(Cone{.diameter = 1.0, .apex_angle = 2.0 * half}, 4);
      const Surface cone(mesh);
      INFO(name(model) << ", half angle " << half);
      double base = 0.0;
      for (Eigen::Index i = 0; i < cone.size(); ++i) base += cone.normal(i, 0) > 0.999 && cone.centroid(i, 0) > 0.0 ? cone.area[i] : 0.0;
      for (const Vector3d& wind : {Vector3d(1, 0, 0), Vector3d(-1, 0, 0), Vector3d(0, 1, 0), Vector3d(0.6, 0, 0.8)}) {
        const Wrench felt = wrench(cone, {.wind = wind}, {.density = 2.0}, model).total();
        CHECK(felt.force.norm() <= 4.0 * cone.total_area);
        CHECK(felt.force.dot(wind) > 0.0);
      }
      if (model.law.name != "note") continue;
      const double front = wrench(cone, {.wind = {1, 0, 0}}, {.density = 2.0}, model).total().force.x();
      const double back = wrench(cone, {.wind = {-1, 0, 0}}, {.density = 2.0}, model).total().force.x();
      const double rounding = hostile::rounding(model.precision, 0.0) * cone.total_area;
      CHECK_THAT(back, WithinAbs(-base, 1e-12 * base + rounding));                      // a disc
      if (half < 0.1) CHECK_THAT(front, WithinAbs(0.0, 2.0 * half * half + rounding));  // sin^2 (2 - sin)
      if (half > 1.5) CHECK_THAT(front, WithinRel(base, 3e-6));  // d/dc of c^2 (2 - c) is 1 at c = 1, and c is 1 - 5e-7
    }
}

TEST_CASE("mirrored and negative scales through transformed() are the bodies they describe, under every law", "[hard][invariance]") {
  const TriangleMesh unit = triangulate(Box{}, 2);
  for (const Vector3d& scale : {Vector3d(-2, 1, 0.5), Vector3d(2, -1, 0.5), Vector3d(-2, -1, -0.5), Vector3d(2, 1, 0.5)})
    for (const Model& model : models()) {
      if (model.pillow.form == PillowForm::triangle || model.pillow.form == PillowForm::eccentricity)
        continue;  // diagonals run the other way
      const Surface scaled(transformed(unit, scale.asDiagonal(), Vector3d::Zero())), box = zoo::surface(Box{2, 1, 0.5}, 2);
      INFO(name(model));
      CHECK_THAT(scaled.volume, WithinRel(1.0, 1e-13));
      CHECK(distance(wrench(scaled, oblique_straight, {}, model).total(), wrench(box, oblique_straight, {}, model).total()) <
            apart(model, 1e-13, box, oblique_straight));
    }
}

TEST_CASE("a body inside one cell of a grid, larger than it and on its edge feels the wind of its own place", "[hard][wind]") {
  const Surface body = zoo::surface(Box{0.2, 0.2, 0.2}, 2);
  for (const Outside outside : {Outside::zero, Outside::clamp})
    for (const Vector3i& points : {Vector3i(2, 2, 2), Vector3i(2, 1, 1), Vector3i(1, 1, 1)}) {
      Grid grid{.points = points,
                .lower = {-0.5, -0.5, -0.5},
                .upper = {0.5, 0.5, 0.5},
                .values = Eigen::Matrix3Xd(3, points.prod()),
                .outside = outside};
      for (int i = 0; i < points.prod(); ++i) grid.values.col(i) = Vector3d(3.0, 0.1 * i, -0.2 * i);
      const Wind wind({{.name = "cell", .field = std::make_shared<const GridField>(grid)}});
      for (const Vector3d& place : {Vector3d(0, 0, 0), Vector3d(0.5, 0, 0), Vector3d(0.5, 0.5, 0.5), Vector3d(9, 0, 0)})
        for (const WindSampling sampling : {WindSampling::constant, WindSampling::affine, WindSampling::per_triangle}) {
          const BodyWind sample(wind, body, {.position = place}, Vector3d::Zero(), sampling);
          Motion motion;
          sample.apply_to(motion);
          for (const Model& model : {model_for(body), zoo::exactly(model_for(body))}) {
            const Wrench felt = wrench(body, motion, {}, model).total();
            CHECK(felt.force.allFinite());
            CHECK(felt.force.norm() <= 0.5 * 1.225 * 14.0 * body.total_area);  // no wind of the grid is faster than sqrt(9 + 0.49 + 1.96)
            if (place.x() > 1.0 && outside == Outside::zero) CHECK(felt.force.isZero(0.0));
            if (place.isZero() && points == Vector3i(2, 2, 2)) CHECK(felt.force.x() > 0.1);
          }
        }
    }
}

TEST_CASE("a line of action makes the wrench it was made of, however small or large", "[hard][analytic]") {
  zoo::Random random(22);
  for (const double size : {1e-200, 1e-12, 1.0, 1e12, 1e200})
    for (int i = 0; i < 50; ++i) {
      const Wrench felt{size * random.vector(1.0), size * random.vector(1.0)};
      const Vector3d reference = random.vector(2.0);
      const auto line = line_of_action(felt, reference);
      REQUIRE(line.has_value());
      const Vector3d torque = (line->point - reference).cross(felt.force) + line->couple * line->direction;
      CHECK(((torque - felt.torque) / size).norm() < 1e-13 * (1.0 + (line->point - reference).norm()));
      CHECK_THAT((line->point - reference).dot(line->direction), WithinAbs(0.0, 1e-13 * (1.0 + line->point.norm())));
      const Vector3d normal = random.vector(1.0);
      for (const double length : {1e-200, 1.0, 1e200})  // of the normal: does not matter
        if (const auto centre = centre_of_pressure(*line, reference, length * normal)) {
          CHECK_THAT((*centre - reference).dot(normal.normalized()), WithinAbs(0.0, 1e-12 * (1.0 + centre->norm())));
          CHECK((*centre - line->point).cross(line->direction).norm() < 1e-12 * (1.0 + centre->norm()));
        } else {
          CHECK(std::abs(line->direction.dot(normal.normalized())) <= 0.0501);
        }
    }
  CHECK_FALSE(line_of_action({}, {}).has_value());
  CHECK_FALSE(line_of_action({.force = {not_a_number, 0, 0}}, {}).has_value());
  const LineOfAction line{.point = {0, 0, 0}, .direction = {1, 0, 0}, .couple = 0.0};
  CHECK_FALSE(centre_of_pressure(line, {0, 0, 1}, {0, 0, 1}).has_value());
  CHECK_FALSE(centre_of_pressure(line, {0, 0, 1}, {0, 0, 0}).has_value());
  CHECK_FALSE(centre_of_pressure(line, {0, 0, 1}, {not_a_number, 0, 0}).has_value());
}

namespace {

struct Light {
  const char* name;
  Shape shape;
  MassProperties body;
};

/// Mass from size and density: paper of 80 g/m^2, a dry leaf, a foam cube of 20 kg/m^3, a steel plate of 5 mm.
std::vector<Light> light_bodies() {
  const auto plate = [](double a, double b, double thickness, double density) {
    const double m = a * b * thickness * density, a2 = a * a, b2 = b * b, t2 = thickness * thickness;
    return MassProperties{m, Vector3d(m * (b2 + t2) / 12, m * (a2 + t2) / 12, m * (a2 + b2) / 12).asDiagonal()};
  };
  return {{"paper", Plate{0.297, 0.21, 0.0}, plate(0.297, 0.21, 1e-4, 800)},
          {"leaf", Plate{0.07, 0.04, 0.0}, plate(0.07, 0.04, 2e-4, 350)},
          {"foam cube", Box{0.1, 0.1, 0.1}, plate(0.1, 0.1, 0.1, 20)},
          {"steel plate", Plate{0.3, 0.2, 0.005}, plate(0.3, 0.2, 0.005, 7850)}};
}

Vector6d six(const Vector3d& linear, const Vector3d& angular) { return (Vector6d() << linear, angular).finished(); }

/// The three updates of stepping.hpp, and the step of batch.hpp.
constexpr int updates = 4;

/// One step of one of them.
Vector6d stepped(int update, const Surface& surface, const MassProperties& body, const Motion& motion, const Model& model,
                 const Vector6d& external, double dt) {
  if (update == 0) return step_secant_implicit(resistance(surface, motion, {}, model), body, motion, external, dt);
  if (update == 1) return step_scalar_implicit(resistance(surface, motion, {}, model), body, motion, external, dt);
  if (update == 3) {
    // Two of them, as it takes to go side by side.
    const std::vector<FreeBody> bodies(2, {.surface = &surface, .model = &model, .mass = &body, .motion = motion, .external = external});
    std::vector<Vector6d> velocities(2);
    step_free_bodies(bodies, {}, dt, velocities);
    return velocities[1];
  }
  const Wrench air = wrench(surface, motion, {}, model).total();
  const Vector6d wrench6 = six(air.force, air.torque);
  Vector6d change = impulse_share(air, body, motion, dt) * dt * wrench6;
  change.head<3>() /= body.mass;
  change.tail<3>() = (body.inertia.diagonal().cwiseInverse().asDiagonal() * change.tail<3>()).eval();  // all of them are diagonal here
  return six(motion.velocity, motion.angular_velocity) + change;
}

/// In single precision as in double: a step is as safe as its secant matrix is not negative, and that is exact in both.
void never_gain_energy(unsigned steps_per_body) {
  for (const Light& light : light_bodies()) {
    const Surface surface = zoo::surface(light.shape, 1);
    unsigned seed = 0, steps = 0;
    std::vector<Law> laws = hostile::laws();
    zoo::Random wild(3);
    for (int i = 0; i < 2; ++i) laws.push_back(hostile::wild_law(wild, i == 0));
    while (steps < steps_per_body)
      for (const Law& law : laws)
        for (const Pillow& pillow : hostile::pillows())
          for (const double dt : {1.0 / 240, 1.0 / 60, 0.1, 1.0, 10.0, 100.0})
            for (int update = 0; update < updates; ++update) {
              zoo::Random random(++seed);
              const Quadrature order[] = {Quadrature::one, Quadrature::adaptive, Quadrature::one, Quadrature::three};
              const Model model =
                  hostile::in(hostile::precisions[seed / 4 % 2], {.law = law, .pillow = pillow, .quadrature = order[seed % 4]});
              Motion motion{.wind = random.vector(5.0), .velocity = random.vector(20.0), .angular_velocity = random.vector(60.0)};
              const Vector3d moments = light.body.inertia.diagonal();
              const auto energy = [&] {
                return 0.5 * light.body.mass * (motion.velocity - motion.wind).squaredNorm() +
                       0.5 * motion.angular_velocity.cwiseAbs2().dot(moments);
              };
              // Rounding: of the solve, 1e-16 times 1e4 of stiffness and its terms; and of V = wind + what is left, one bit of the wind in
              // each component.
              const double wind_bit = light.body.mass * (motion.wind.norm() + 1.0) * 1e-15;
              double before = energy();
              for (int step = 0; step < 20; ++step, ++steps) {
                const Vector6d v = stepped(update, surface, light.body, motion, model, Vector6d::Zero(), dt);
                motion.velocity = v.head<3>();
                motion.angular_velocity = v.tail<3>();
                const double after = energy();
                if (!(after <= before * (1.0 + 1e-11) + wind_bit * std::sqrt(2.0 * before / light.body.mass) + wind_bit * 1e-15)) {
                  INFO(light.name << ", " << name(model) << ", dt " << dt << ", update " << update << ", step " << step << ", seed "
                                  << seed);
                  REQUIRE(after <= before);
                }
                before = after;
              }
            }
    CHECK(steps >= steps_per_body);
  }
}

}  // namespace

TEST_CASE("paper, leaf, foam and steel never gain energy from a uniform wind, under every law, pillow, update and step: a million steps",
          "[hard][energy]") {
  never_gain_energy(250'000 / (hostile::sanitizer_divisor * hostile::sanitizer_divisor));
}

TEST_CASE("the same over a million steps of each body", "[.long][energy]") { never_gain_energy(1'000'000); }

TEST_CASE("terminal velocity under gravity is a fixed point of the implicit updates to rounding, under every law and step",
          "[hard][energy]") {
  for (const Light& light : light_bodies()) {
    const Surface surface = zoo::surface(light.shape, 2);
    for (const Model& model : models()) {
      if (model.pillow.form == PillowForm::eccentricity) continue;  // its across part is a torque even face-on: not an equilibrium
      // Face-on, where forces are square in speed whatever the law.
      const double drag = -wrench(surface, {.velocity = {0, 0, 1}}, {}, model).total().force.z(), g = 9.81,
                   v = std::sqrt(light.body.mass * g / drag);
      const Motion motion{.wind = {3, -1, 2}, .velocity = Vector3d(3, -1, 2 - v)};
      const Vector6d weight = six({0, 0, -light.body.mass * g}, Vector3d::Zero());
      const Matrix6d S = resistance(surface, motion, {}, model);
      for (const double dt : {1.0 / 240, 1.0 / 60, 0.1, 1.0, 10.0, 100.0}) {
        INFO(light.name << ", " << name(model) << ", dt " << dt);
        // Rounding times the ratio of angular and linear parts of M + dt S in SI units, up to 1e3.
        const double rounding = hostile::rounding(model.precision, 1e-12) * (v + 4.0);
        CHECK((step_secant_implicit(S, light.body, motion, weight, dt) - six(motion.velocity, Vector3d::Zero())).norm() < rounding);
        CHECK((step_scalar_implicit(S, light.body, motion, weight, dt) - six(motion.velocity, Vector3d::Zero())).norm() < rounding);
      }
    }
  }
}

TEST_CASE("steps tried on copies, on another thread and among other calls, are the bits that stepping gives", "[hard][energy]") {
  const Light paper = light_bodies()[0];
  const Surface surface = zoo::surface(paper.shape, 2), other = zoo::surface(Box{}, 2);
  const Vector6d weight = six({0, 0, -9.81 * paper.body.mass}, Vector3d::Zero());
  for (int update = 0; update < updates; ++update)
    for (const Model& model : models()) {
      const Motion start{.wind = {4, 1, 0}, .velocity = {1, -2, 3}, .angular_velocity = {5, -6, 7}};
      const auto advance = [&](Motion motion, int steps, bool disturbed) {
        std::vector<Vector6d> path;
        for (int i = 0; i < steps; ++i) {
          const Vector6d v = stepped(update, surface, paper.body, motion, model, weight, 1.0 / 60);
          if (disturbed) (void)wrench(other, oblique, {}, model);
          motion.velocity = v.head<3>();
          motion.angular_velocity = v.tail<3>();
          path.push_back(v);
        }
        return path;
      };
      std::vector<Vector6d> predicted;
      std::thread([&] { predicted = advance(start, 20, true); }).join();
      const std::vector<Vector6d> stepped_through = advance(start, 20, false);
      for (std::size_t i = 0; i < predicted.size(); ++i) CHECK(predicted[i] == stepped_through[i]);
    }
}

TEST_CASE("the Jacobian is the derivative by spin where there is no spin yet, and nothing where spin is not felt", "[hard][analytic]") {
  zoo::Random random(30);
  for (const Shape& shape : zoo::shapes())
    for (const Law& law : {note_law(), consistent_law(), sheet_law()})
      for (const Quadrature order : {Quadrature::one, Quadrature::three, Quadrature::six, Quadrature::adaptive}) {
        const Surface surface = zoo::surface(shape, 1);
        Model model{.law = law, .quadrature = order};
        const Motion motion{.wind = random.vector(3.0), .reference_point = {0.1, 0.2, 0.0}};
        // In double alone, as force_jacobian() always is: a difference of 1e-6 of the speed is what single precision rounds off.
        const Matrix6d jacobian = force_jacobian(surface, motion, {}, model);
        constexpr double step = 1e-6;
        for (int k = 0; k < 3; ++k) {
          const auto turned = [&](double by) {
            Motion m = motion;
            m.angular_velocity[k] = by;
            const Wrench w = wrench(surface, m, {}, model).total();
            return six(w.force, w.torque);
          };
          INFO(kind(shape) << ", " << law.name << ", points " << static_cast<int>(order));
          CHECK(((turned(step) - turned(-step)) / (2 * step) - jacobian.col(3 + k)).norm() <
                1e-6 * (1.0 + jacobian.norm()));  // as in test_stepping.cpp
        }
        // The secant matrix does not jump either as a spin begins: of order omega a / V.
        Motion begun = motion;
        begun.angular_velocity = Vector3d(1e-9, 2e-9, -1e-9);
        for (const Precision precision : hostile::precisions) {
          const Model how = hostile::in(precision, model);
          const Matrix6d S = resistance(surface, motion, {}, how);
          CHECK((S - resistance(surface, begun, {}, how)).norm() < 1e-6 * S.norm());
        }
        model.effects = Effects::all().without(Effect::spin);
        CHECK(force_jacobian(surface, motion, {}, model).rightCols<3>().isZero(0.0));
      }
}

TEST_CASE("in a wind that varies the secant matrix stays of the size of the drag, and what it misses is the excess", "[hard][limit]") {
  // The body moves with the wind at its reference point, almost: power against that wind is then any number, and no measure of anything.
  zoo::Random random(31);
  const Surface cube = zoo::surface(Box{}, 2);
  for (const Pillow& pillow : hostile::pillows())
    for (int i = 0; i < 400; ++i) {
      const Model model = hostile::in(hostile::precisions[i % 2], {.law = closed_law(), .pillow = pillow});
      Motion motion{.wind = {5, 0, 0}, .velocity = {5, 0, 0}, .reference_point = {-1.0, 0.3, 0.2}};
      motion.velocity += std::pow(10.0, random.uniform(-12, 0)) * random.vector(1.0);
      motion.wind_gradient = 3.0 * random.rotation();
      const Matrix6d S = resistance(cube, motion, {}, model);
      const Wrench total = wrench(cube, motion, {}, model).total();
      // q A C/U: 0.6 * 6 m^2 * 2 * 10 m/s, arms of 2 m squared.
      CHECK(S.norm() < 500.0);
      const Vector6d left = wind_excess(total, S, motion);
      CHECK(
          (S * (six(motion.wind, Vector3d::Zero()) - six(motion.velocity, motion.angular_velocity)) + left - six(total.force, total.torque))
              .norm() < 1e-11);
      // Masked spin: what is felt is S times the velocity without it.
      Motion spinning{.wind = {5, 0, 0}, .velocity = random.vector(3.0), .angular_velocity = random.vector(100.0)};
      Model unspun = model;
      unspun.effects = Effects::all().without(Effect::spin);
      const Wrench felt = wrench(cube, spinning, {}, unspun).total();
      const Matrix6d R = resistance(cube, spinning, {}, unspun);
      CHECK((R * six(spinning.wind - spinning.velocity, Vector3d::Zero()) - six(felt.force, felt.torque)).norm() <
            apart(model, 1e-11, cube, {.wind = spinning.wind, .velocity = spinning.velocity}));
    }
}

TEST_CASE("the share of an impulse is from 0 to 1 for impulses as small and as large as numbers go", "[hard][energy]") {
  const MassProperties body{.mass = 0.1, .inertia = 1e-3 * Matrix3d::Identity()};
  const Motion motion{.velocity = {1, 2, 3}, .angular_velocity = {0, 5, 0}};
  for (const double size : {denormal, 1e-300, 1e-170, 1e-3, 1e170, 1e300})
    for (const double dt : {0.0, 1e-300, 1.0 / 60, 1e10, 1e300})
      for (const double sign : {1.0, -1.0}) {
        const double share = impulse_share({.force = sign * Vector3d(size, 0, 0), .torque = {0, sign * size, 0}}, body, motion, dt);
        INFO("size " << size << ", dt " << dt << ", sign " << sign);
        // work = 6 size dt, growth = 1010 (size dt)^2: all of it, none or their ratio.
        const double ratio = 6.0 / 1010.0 / size / dt;
        CHECK_THAT(share,
                   WithinRel(sign > 0.0 ? 0.0 : std::min(1.0, ratio), 1e-12) || WithinAbs(sign > 0.0 ? 0.0 : std::min(1.0, ratio), 1e-300));
      }
}

TEST_CASE("a step too long for numbers ends at rest in the air or is refused, never at a velocity that is none", "[hard][energy]") {
  const Matrix6d stiff = 1e250 * Matrix6d::Identity();
  const MassProperties unit{.mass = 1.0, .inertia = Matrix3d::Identity()};
  for (const double dt : {1e-200, 1e50, 1e100})
    CHECK(step_secant_implicit(stiff, unit, {.velocity = {1, 2, 3}}, Vector6d::Zero(), dt).norm() < 1e-40);
  const Vector6d push = Vector6d::Constant(1e200);
  CHECK_THROWS_WITH(step_secant_implicit(Matrix6d::Zero(), unit, {}, push, 1e200), Catch::Contains("not finite"));
  CHECK_THROWS_WITH(step_scalar_implicit(Matrix6d::Zero(), unit, {}, push, 1e200), Catch::Contains("not finite"));
}
