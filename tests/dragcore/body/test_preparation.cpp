// Meshes as files have them, each with the right answer of the same body said well. Wind 10 m/s, density 1.2: F/60 is C_D on 1 m^2.
#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <dragcore/descriptors.hpp>
#include <dragcore/preparation.hpp>
#include <numbers>

#include "tests/support/zoo.hpp"

using namespace dragcore;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;
using Eigen::Vector3d;
using Kind = Finding::Kind;

namespace {

const Eigen::Matrix3d identity = Eigen::Matrix3d::Identity();

TriangleMesh moved(const TriangleMesh& mesh, const Vector3d& by) { return transformed(mesh, identity, by); }
TriangleMesh scaled(const TriangleMesh& mesh, double by) { return transformed(mesh, by * identity, Vector3d::Zero()); }

TriangleMesh flipped(TriangleMesh mesh) {
  for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

TriangleMesh operator+(TriangleMesh a, const TriangleMesh& b) {
  const auto shift = static_cast<int>(a.vertices.size());
  a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (const auto& t : b.triangles) a.triangles.push_back(t + Eigen::Vector3i::Constant(shift));
  return a;
}

/// Corners of every triangle for itself, as STL files have them, each rounded by itself.
TriangleMesh jittered(const TriangleMesh& mesh, double relative) {
  zoo::Random random(3);
  TriangleMesh soup;
  for (const auto& t : mesh.triangles) {
    const int first = static_cast<int>(soup.vertices.size());
    for (const int corner : t) soup.vertices.push_back(mesh.vertices[corner].cwiseProduct(Vector3d::Ones() + random.vector(relative)));
    soup.triangles.emplace_back(first, first + 1, first + 2);
  }
  return soup;
}

TriangleMesh rectangle(const Vector3d& corner, const Vector3d& a, const Vector3d& b) {
  return {{corner, corner + a, corner + a + b, corner + b}, {{0, 1, 2}, {0, 2, 3}}};
}

Vector3d force(const Surface& surface, const Vector3d& direction) {
  const Motion motion{.wind = 10 * direction, .reference_point = surface.centre};
  return wrench(surface, motion, {1.2}, model_for(surface)).total().force;
}
Vector3d force(const TriangleMesh& mesh, const Vector3d& direction) { return force(Surface(mesh), direction); }

const Vector3d x = Vector3d::UnitX(), y = Vector3d::UnitY(), z = Vector3d::UnitZ();
const TriangleMesh cube = triangulate(Box{}, 1), ball = triangulate(Sphere{.diameter = 1.0}, 8);
const TriangleMesh small_cone = scaled(triangulate(Cone{.diameter = 1.0, .apex_angle = std::numbers::pi / 3}, 6), 0.5);

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

TEST_CASE("corners a rounding apart are one corner", "[preparation][invariance]") {
  const double right = force(ball, x).x();
  for (const double relative : {1e-7, 1e-6}) {
    const Preparation prepared = prepare(jittered(ball, relative));
    CHECK(prepared.found(Kind::welded));
    const Surface surface(prepared);
    CHECK(surface.sides == Surface::Sides::one);
    CHECK_THAT(force(surface, x).x(), WithinRel(right, 1e-4));  // the shape itself moved by 1e-6
  }
  // Nothing is welded that is meant: two plates a hundredth of their edge apart stay two.
  CHECK_FALSE(prepare(rectangle({0, 0, 0}, x, y) + rectangle({0, 0, 0.01}, x, y)).found(Kind::welded));
}

TEST_CASE("a face is one face however often the file says it, whatever its winding", "[preparation][invariance]") {
  const Vector3d right = force(cube, x);
  for (const TriangleMesh& mesh : {cube + cube, cube + flipped(cube)}) {
    const Preparation prepared = prepare(mesh);
    CHECK(prepared.found(Kind::duplicate));
    const Surface surface(prepared);
    CHECK_THAT(surface.volume, WithinRel(1.0, 1e-14));
    CHECK((force(surface, x) - right).norm() < 1e-12 * right.norm());
  }
}

TEST_CASE("each shell is wound by its own volume", "[preparation][invariance]") {
  const TriangleMesh cone = moved(small_cone, {0, 3, 0});
  const Vector3d right = force(cube, x) + force(cone, x);
  // Two bodies, one energy balance: what pushes is held a little less below what brakes (eq. 13), by 4e-4 here.
  CHECK((force(cube + cone, x) - right).norm() < 1e-3 * right.norm());
  const Preparation prepared = prepare(cube + flipped(cone));
  CHECK(prepared.found(Kind::inside_out));
  CHECK((force(Surface(prepared), x) - force(cube + cone, x)).norm() < 1e-12 * right.norm());
  CHECK_THAT(Surface(prepared).volume, WithinRel(1.0 + Surface(cone).volume, 1e-12));
  // One by itself, and one with a sliver of 5e-7 m^2 the wrong way round.
  CHECK_THAT(force(flipped(ball), x).x(), WithinRel(force(ball, x).x(), 1e-12));
  TriangleMesh sliver = cube;
  const Eigen::Vector3i first = sliver.triangles.front();
  sliver.triangles.erase(sliver.triangles.begin());
  const Vector3d middle = 0.5 * (sliver.vertices[first[0]] + sliver.vertices[first[1]]);
  sliver.vertices.push_back(middle + 1e-6 * (sliver.vertices[first[2]] - middle));
  const int point = static_cast<int>(sliver.vertices.size()) - 1;
  sliver.triangles.insert(sliver.triangles.end(), {{first[0], point, first[2]}, {point, first[1], first[2]}, {first[1], first[0], point}});
  const Preparation mended = prepare(sliver);
  CHECK(mended.found(Kind::reversed));
  CHECK_THAT(force(Surface(mended), x).x(), WithinRel(59.08, 1e-3));
}

TEST_CASE("a sheet beside a body has both sides and the law of sheets, whichever way it is wound", "[preparation][invariance]") {
  const TriangleMesh wing = rectangle({2.75, -2, 0}, 0.5 * x, 4 * y), small = rectangle({2.85, -0.4, 0}, 0.3 * x, 0.8 * y);
  for (const TriangleMesh& sheet : {wing, flipped(wing), small, flipped(small)}) {
    const Surface both(cube + sheet);
    REQUIRE(both.parts.size() == 2);
    CHECK(both.parts[0].body_class == BodyClass::sharp);
    CHECK(both.parts[1].body_class == BodyClass::sheet);
    CHECK(both.sides == Surface::Sides::automatic);
    CHECK(model_for(both).sheets.has_value());
    for (const Vector3d& wind : {x, z}) {
      const Vector3d right = force(cube, wind) + force(sheet, wind);
      CHECK((force(both, wind) - right).norm() < 1e-6 * right.norm());  // one energy balance for both: 5e-8
    }
  }
  CHECK_THAT(force(cube + wing, z).z(), WithinRel(201.4, 1e-3));
  CHECK_THAT(force(cube + small, z).z(), WithinRel(76.2, 1e-3));
}

TEST_CASE("walls inside a closed shell feel no wind", "[preparation][invariance]") {
  const Vector3d of_ball = force(ball, x), of_cube = force(cube, x);
  for (const TriangleMesh& inner :
       {scaled(ball, 0.96), flipped(scaled(ball, 0.96)), scaled(cube, 0.4), rectangle({-0.2, -0.2, 0}, 0.4 * x, 0.4 * y)}) {
    const Preparation prepared = prepare(ball + inner);
    CHECK(prepared.found(Kind::hidden));
    CHECK((force(Surface(prepared), x) - of_ball).norm() < 1e-12 * of_ball.norm());
  }
  CHECK((force(cube + flipped(scaled(cube, 0.9)), x) - of_cube).norm() < 1e-12 * of_cube.norm());
  // Two cubes that share a face are a box: the walls between them lie inside.
  const Surface two(moved(cube, {-0.5, 0, 0}) + moved(cube, {0.5, 0, 0}));
  CHECK(two.parts.size() == 1);
  CHECK_THAT(two.volume, WithinRel(2.0, 1e-14));
  const TriangleMesh box = triangulate(Box{.length = 2.0}, 1);
  for (const Vector3d& wind : {x, y}) CHECK_THAT(force(two, wind).norm(), WithinRel(force(box, wind).norm(), 1e-12));
}

TEST_CASE("a box with a hole is a box, whatever the size of the hole and whichever way it looks", "[preparation][limit]") {
  const double h = 0.5;
  const double closed = force(cube, x).x();
  for (const double a : {0.0, 0.3, 0.5, 0.53, 0.54, 0.6, 0.9, 1.0}) {
    TriangleMesh mesh = rectangle({-h, -h, -h}, z, y) + rectangle({-h, -h, -h}, x, z) + rectangle({-h, h, -h}, z, x) +
                        rectangle({-h, -h, -h}, y, x) + rectangle({-h, -h, h}, x, y);
    const double b = a / 2;
    const Vector3d outer[4] = {{h, -h, -h}, {h, h, -h}, {h, h, h}, {h, -h, h}}, inner[4] = {{h, -b, -b}, {h, b, -b}, {h, b, b}, {h, -b, b}};
    for (int k = 0; k < 4 && a < 1.0; ++k)
      mesh = mesh + TriangleMesh{{outer[k], outer[(k + 1) % 4], inner[(k + 1) % 4], inner[k]}, {{0, 1, 2}, {0, 2, 3}}};
    if (a > 0.0) CHECK(prepare(mesh).found(Kind::capped));
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
  CHECK_FALSE(Surface(cube + moved(cube, {1.5, 0, 0})).convex);
  TriangleMesh dented = triangulate(Box{}, 4);
  for (Vector3d& v : dented.vertices)
    if (v.x() > 0.49 && std::max(std::abs(v.y()), std::abs(v.z())) < 0.3) v.x() = 0.2;
  CHECK_FALSE(Surface(dented).convex);
}
