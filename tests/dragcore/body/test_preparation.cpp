// Meshes as files have them. More, each as a file: tests/dragcore/exposure/test_files_as_users_have_them.cpp. Wind 10 m/s, density 1.2.
#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <dragcore/descriptors.hpp>
#include <dragcore/preparation.hpp>
#include <numbers>

#include "tests/support/meshes.hpp"
#include "tests/support/zoo.hpp"

using namespace dragcore;
using Catch::Matchers::WithinRel;
using Eigen::Vector3d;
using support::moved;
using support::rectangle;
using support::scaled;
using support::together;
using Kind = Finding::Kind;

namespace {

Vector3d force(const Surface& surface, const Vector3d& direction) {
  const Motion motion{.wind = 10 * direction, .reference_point = surface.centre};
  return wrench(surface, motion, {1.2}, zoo::exactly(model_for(surface))).total().force;
}
Vector3d force(const TriangleMesh& mesh, const Vector3d& direction) { return force(Surface(mesh), direction); }

const Vector3d x = Vector3d::UnitX(), y = Vector3d::UnitY();
const TriangleMesh cube = triangulate(Box{}, 1), ball = triangulate(Sphere{.diameter = 1.0}, 8);

}  // namespace

TEST_CASE("a clean closed mesh goes through preparation untouched and without a finding", "[preparation][invariance]") {
  for (const Shape& shape : zoo::shapes()) {
    const TriangleMesh mesh = triangulate(shape, 4);
    const Preparation prepared = prepare(mesh);
    CHECK(prepared.report.empty());
    REQUIRE(prepared.mesh.triangles.size() == mesh.triangles.size());
    CHECK(prepared.parts() == 1);
    const Surface told(mesh, zoo::sides_of(shape)), found(mesh);
    CHECK((told.normal == found.normal).all());
    CHECK((told.area == found.area).all());
    CHECK(told.body_class == found.body_class);
    CHECK_THAT(found.volume, WithinRel(told.volume, 1e-12));
  }
}

TEST_CASE("what is a hundredth of an edge apart is meant to be apart", "[preparation][limit]") {
  CHECK_FALSE(prepare(together({rectangle({0, 0, 0}, x, y), rectangle({0, 0, 0.01}, x, y)})).found(Kind::welded));
}

TEST_CASE("a fin on a body keeps no crack of it open", "[preparation][weld]") {
  // Every triangle by itself, corners a hair off: as STL files are.
  const auto soup = [](const TriangleMesh& mesh) {
    zoo::Random random(5);
    TriangleMesh apart;
    for (const Eigen::Vector3i& t : mesh.triangles) {
      const auto first = static_cast<int>(apart.vertices.size());
      for (const int corner : t) apart.vertices.push_back(mesh.vertices[static_cast<std::size_t>(corner)] + random.vector(1e-7));
      apart.triangles.emplace_back(first, first + 1, first + 2);
    }
    return apart;
  };
  const TriangleMesh body = triangulate(Box{1.0, 0.7, 0.5}, 3);
  TriangleMesh finned = body;
  finned.vertices.emplace_back(0.5, 0.35, 0.3);
  const auto edge = std::find_if(body.triangles.begin(), body.triangles.end(), [&](const Eigen::Vector3i& t) {
    return body.vertices[static_cast<std::size_t>(t[0])].z() == 0.25 && body.vertices[static_cast<std::size_t>(t[1])].z() == 0.25;
  });
  finned.triangles.emplace_back((*edge)[0], (*edge)[1], static_cast<int>(body.vertices.size()));
  const Preparation exact = prepare(finned), jittered = prepare(soup(finned));
  CHECK(jittered.parts() == exact.parts());
  CHECK(Surface(jittered).volume == Approx(0.35).epsilon(1e-5));
  // Said twice, each time with other roundings.
  TriangleMesh twice = support::together({soup(body), soup(support::moved(body, Vector3d::Constant(3e-8)))});
  CHECK(prepare(twice).parts() == 1);
  CHECK(Surface(prepare(twice)).volume == Approx(0.35).epsilon(1e-5));
  // Two bodies that share a face.
  const TriangleMesh pair = support::together({body, support::moved(body, {1.0, 0.0, 0.0})});
  CHECK(prepare(soup(pair)).parts() <= 2);
}

TEST_CASE("an open sheet far from the origin keeps its corners", "[preparation][weld]") {
  // At 1e6 m four steps of single precision are 0.4 m: longer than these triangles.
  for (const double edge : {0.001, 0.1, 0.33}) {
    const TriangleMesh near = triangulate(Plate{.chord = 3 * edge, .span = 3 * edge, .thickness = 0.0}, 3);
    const Surface far(support::moved(near, {6e5, 7e5, 2e5}));
    CHECK(far.total_area == Approx(9 * edge * edge).epsilon(1e-6));
    CHECK(far.two_sided());
  }
}

TEST_CASE("a thin body with a crack or a triangle missing is a body still", "[preparation][limit]") {
  const Motion motion{.wind = {1, 0, 10}};
  const TriangleMesh plate = triangulate(Plate{.chord = 1.0, .span = 1.0, .thickness = 0.05}, 4);
  const Vector3d right = wrench(Surface(plate), motion, {}, zoo::exactly(model_for(Surface(plate)))).total().force;
  // An edge split in one of its two triangles.
  TriangleMesh cracked = plate;
  const Eigen::Vector3i t = cracked.triangles[0];
  const auto middle = static_cast<int>(cracked.vertices.size());
  cracked.vertices.push_back(0.5 * (cracked.vertices[static_cast<std::size_t>(t[0])] + cracked.vertices[static_cast<std::size_t>(t[1])]));
  cracked.triangles[0] = {t[0], middle, t[2]};
  cracked.triangles.emplace_back(middle, t[1], t[2]);
  TriangleMesh lacking = plate;
  lacking.triangles.pop_back();
  for (const TriangleMesh& mesh : {cracked, lacking}) {
    const Surface surface(mesh);
    CHECK_FALSE(surface.two_sided());
    const Vector3d force = wrench(surface, motion, {}, zoo::exactly(model_for(surface))).total().force;
    CHECK((force - right).norm() < 1e-6 * right.norm());  // a lid lies where the triangle was
  }
}

TEST_CASE("whatever is sealed in a closed shell feels no wind", "[preparation][invariance]") {
  const Vector3d of_ball = force(ball, x);
  for (const TriangleMesh& inner : {scaled(ball, 0.96), scaled(cube, 0.4), rectangle({-0.2, -0.2, 0}, 0.4 * x, 0.4 * y)}) {
    const Preparation prepared = prepare(together({ball, inner}));
    CHECK(prepared.found(Kind::hidden));
    CHECK((force(Surface(prepared), x) - of_ball).norm() < 1e-12 * of_ball.norm());
  }
}

TEST_CASE("a box with a hole is a box, whatever the size of the hole and whichever way it looks", "[preparation][limit]") {
  const double closed = force(cube, x).x();
  for (const double hole : {0.0, 0.3, 0.5, 0.53, 0.54, 0.6, 0.9, 1.0}) {
    const TriangleMesh mesh = support::box_with_hole(hole);
    CHECK(prepare(mesh).found(Kind::capped) == (hole > 0.0));
    CHECK_THAT(force(mesh, x).x(), WithinRel(closed, 1e-12));    // hole in the rear: the base is at base pressure either way
    CHECK_THAT(-force(mesh, -x).x(), WithinRel(closed, 1e-12));  // hole in front: at least the drag of the closed face
  }
}

TEST_CASE("a tube that one can look through stays open; a cup does not", "[preparation][limit]") {
  TriangleMesh tube = triangulate(Cylinder{.diameter = 1.0, .length = 2.0}, 8);
  std::erase_if(tube.triangles, [&](const Eigen::Vector3i& t) {
    const Vector3d normal = (tube.vertices[t[1]] - tube.vertices[t[0]]).cross(tube.vertices[t[2]] - tube.vertices[t[0]]).normalized();
    return std::abs(normal.x()) > 0.5;
  });
  const Preparation open = prepare(tube);
  CHECK(open.found(Kind::open_through));
  CHECK(Surface(open).two_sided());
  TriangleMesh cup = ball;
  std::erase_if(cup.triangles,
                [&](const Eigen::Vector3i& t) { return (cup.vertices[t[0]] + cup.vertices[t[1]] + cup.vertices[t[2]]).x() > 1e-9; });
  const Preparation capped = prepare(cup);
  CHECK(capped.found(Kind::capped));
  CHECK_THAT(Surface(capped).volume, WithinRel(Surface(ball).volume / 2, 1e-12));
  // A shallow bowl is a sheet: it stays thin when capped.
  TriangleMesh bowl = triangulate(Plate{1.0, 1.0, 0.0}, 6);
  for (Vector3d& v : bowl.vertices) v.z() = 0.1 * v.head<2>().squaredNorm();
  CHECK(Surface(bowl).two_sided());
}

TEST_CASE("the mean projected area of a convex body is a quarter of its surface, and bodies know whether they are convex",
          "[preparation][property]") {
  for (const Shape& shape : zoo::shapes()) {
    const Surface surface = zoo::surface(shape, 6);
    CHECK(surface.convex);
    double sum = 0.0;
    constexpr int count = 2000;
    for (int i = 0; i < count; ++i) {  // golden spiral: equal areas of the sphere
      const double height = 1.0 - (2.0 * i + 1.0) / count, angle = i * std::numbers::pi * (3.0 - std::sqrt(5.0));
      const double radius = std::sqrt(1.0 - height * height);
      sum += describe(surface, {radius * std::cos(angle), radius * std::sin(angle), height}).frontal_area;
    }
    const double expected = surface.total_area * (surface.two_sided() ? 0.5 : 0.25);
    CHECK_THAT(sum / count, WithinRel(expected, 1e-3));  // of the spiral's quadrature of |cos|
  }
  CHECK_FALSE(Surface(together({cube, moved(cube, {1.5, 0, 0})})).convex);
  TriangleMesh dented = triangulate(Box{}, 4);
  for (Vector3d& v : dented.vertices)
    if (v.x() > 0.49 && std::max(std::abs(v.y()), std::abs(v.z())) < 0.3) v.x() = 0.2;
  CHECK_FALSE(Surface(dented).convex);
}
