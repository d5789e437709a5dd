#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <dragcore/descriptors.hpp>
#include <dragcore/drag.hpp>
#include <dragcore/expose.hpp>
#include <dragcore/shapes.hpp>
#include <dragcore/surface.hpp>
#include <map>
#include <numbers>
#include <numeric>
#include <set>

#include "dragcore/bench/thin_bodies.hpp"
#include "exposure/direction_sphere.hpp"
#include "tests/support/meshes.hpp"
#include "tests/support/zoo.hpp"

using namespace dragcore;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using support::box;
using support::moved;
using support::together;

namespace {

const TriangleMesh cube = box({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5});

/// Two unit cubes behind each other along x, 0.5 m apart.
const TriangleMesh tandem = together({moved(cube, {-0.75, 0, 0}), moved(cube, {0.75, 0, 0})});

/// An L of a unit square's height, its inner corner towards +x and +z; one shell.
TriangleMesh bracket() {
  const std::vector<Eigen::Vector2d> outline{{0, 0}, {1, 0}, {1, 0.3}, {0.3, 0.3}, {0.3, 1}, {0, 1}};  // counterclockwise in x-z
  TriangleMesh mesh;
  for (const double y : {0.0, 0.8})
    for (const Eigen::Vector2d& corner : outline) mesh.vertices.emplace_back(corner.x(), y, corner.y());
  for (int k = 0; k < 6; ++k) {
    const int next = (k + 1) % 6;
    mesh.triangles.insert(mesh.triangles.end(), {{k, 6 + k, next}, {next, 6 + k, 6 + next}});
  }
  for (const Eigen::Vector3i& t : {Eigen::Vector3i(0, 1, 2), {0, 2, 3}, {0, 3, 4}, {0, 4, 5}}) {
    mesh.triangles.push_back(t);
    mesh.triangles.emplace_back(6 + t[0], 6 + t[2], 6 + t[1]);
  }
  return mesh;
}

Surface exposed(const TriangleMesh& mesh, const ExposeOptions& options = {}) { return Surface(expose(prepare(mesh), options)); }

constexpr Medium medium{.density = 1.2};
constexpr double speed = 10.0;

Vector3d force(const Surface& surface, const Vector3d& direction) {
  return wrench(surface, {.wind = speed * direction, .reference_point = surface.centre}, medium, zoo::exactly(model_for(surface))).total().force;
}

/// Area times c times share over all triangles that face the direction.
double reached_area(const Surface& surface, const Vector3d& towards) {
  double sum = 0.0;
  const Exposure::Sample sample = surface.exposure ? surface.exposure->towards(towards) : Exposure::Sample{};
  for (Eigen::Index i = 0; i < surface.size(); ++i) {
    const double c = surface.normal.row(i).matrix().dot(towards);
    sum += surface.area[i] * std::max(c, -surface.back[i] * c) * (surface.exposure ? surface.exposure->share(i, sample) : 1.0);
  }
  return sum;
}

std::vector<Vector3d> ten_directions() {
  std::vector<Vector3d> list;
  for (int k = 0; k < 10; ++k) {  // a spiral from pole to pole
    const double z = -0.9 + 0.2 * k, r = std::sqrt(1.0 - z * z);
    list.emplace_back(r * std::cos(2.4 * k), r * std::sin(2.4 * k), z);
  }
  return list;
}

}  // namespace

TEST_CASE("boxes a hair apart are the box that they make, however each is cut", "[exposure][regression]") {
  const TriangleMesh apart_by_a_hair = together({box({-1, -.5, -.5}, {-1e-4, .5, .5}), box({0, -.5, -.5}, {1, .5, .5})});
  const Preparation prepared = expose(prepare(apart_by_a_hair));
  INFO(describe(prepared.report));
  CHECK(prepared.found(Finding::Kind::hidden));
  CHECK(prepared.found(Finding::Kind::joined));
  const Surface surface(prepared);
  REQUIRE(surface.parts.size() == 1);
  CHECK_THAT(surface.volume, WithinRel(2.0, 0.02));       // shares of 256 points to a triangle are good to 1 %
  CHECK_THAT(surface.total_area, WithinRel(10.0, 0.02));  // the same
  const Surface whole(box({-1, -.5, -.5}, {1, .5, .5}));
  for (const Vector3d& wind : {Vector3d(1, 0, 0), Vector3d(0, 1, 0)})
    CHECK((force(surface, wind) - force(whole, wind)).norm() < 0.02 * force(whole, wind).norm());  // of the shares
  // Faces that meet, but not triangle by triangle.
  const TriangleMesh shifted = together({box({-1, -.5, -.5}, {0, .5, .5}, 2), box({0, -.5, -.5}, {1, .5, .5}, 3)});
  CHECK(expose(prepare(shifted)).found(Finding::Kind::joined));
  CHECK_THAT(exposed(shifted).total_area, WithinRel(10.0, 1e-12));
  // Wholly covered faces leave whole ones only.
  const TriangleMesh touching = together({box({-1, -.5, -.5}, {0, .5, .5}), box({0, -.5, -.5}, {1, .5, .5})});
  CHECK(expose(prepare(touching)).wetted.empty());
}

TEST_CASE("bodies that pass through each other are one, and their volume is that of both together", "[exposure][analytic]") {
  // A bar through a cube: 1 + 2 * 0.5 * 0.16.
  const Surface surface = exposed(together({cube, box({-1, -.2, -.2}, {1, .2, .2})}));
  CHECK(surface.parts.size() == 1);
  CHECK_THAT(surface.volume, WithinRel(1.16, 0.02));
  CHECK_THAT(surface.total_area, WithinRel(6.0 - 2 * 0.16 + 2 * 0.16 + 2 * 4 * 0.4 * 0.5, 0.02));
}

TEST_CASE("a box on a larger one covers what it stands on, and no more", "[exposure][analytic]") {
  for (const int divisions : {1, 4}) {
    const Surface surface =
        exposed(together({box({-.5, -.5, -.5}, {.5, .5, .5}, divisions), box({-.1, -.2, .5}, {.3, .1, .8}, divisions)}));
    CHECK(surface.parts.size() == 1);
    CHECK_THAT(surface.total_area, WithinRel(6.0 + 2 * 0.3 * (0.4 + 0.3), 0.005));  // 0.12 m^2 of 6 known to the 1 or 2 % of the points
    CHECK_THAT(surface.volume, WithinRel(1.0 + 0.4 * 0.3 * 0.3, 0.005));
  }
}

TEST_CASE("a crate of six boards is the box that it makes", "[exposure][analytic]") {
  const Surface crate =
      exposed(together({box({-.5, -.5, -.5}, {.5, .5, -.4}), box({-.5, -.5, .4}, {.5, .5, .5}), box({-.5, -.5, -.4}, {-.4, .5, .4}),
                        box({.4, -.5, -.4}, {.5, .5, .4}), box({-.4, -.5, -.4}, {.4, -.4, .4}), box({-.4, .4, -.4}, {.4, .5, .4})}));
  CHECK(crate.parts.size() == 1);
  CHECK(crate.exposure == nullptr);
  CHECK_THAT(crate.total_area, WithinRel(6.0, 1e-9));  // no triangle is covered in part
  CHECK_THAT(crate.volume, WithinRel(1.0, 1e-9));      // what is sealed in belongs to it
  CHECK_THAT(force(crate, Vector3d::UnitX()).x(), WithinRel(force(Surface(cube), Vector3d::UnitX()).x(), 0.01));  // regions end at boards
}

TEST_CASE("a box with a hole is the closed box to rays, too", "[exposure][limit]") {
  for (const double hole : {0.53, 0.54, 1.0})
    for (const double way : {1.0, -1.0}) {  // hole behind, hole in front
      const Vector3d wind = way * Vector3d::UnitX();
      CHECK_THAT(force(exposed(support::box_with_hole(hole)), wind).dot(wind), WithinRel(force(Surface(cube), wind).dot(wind), 1e-12));
    }
}

TEST_CASE("bodies far apart across the wind feel what they feel without rays", "[exposure][invariance]") {
  const TriangleMesh both = together({cube, moved(triangulate(Cone{1.0 / std::numbers::sqrt3}, 8), {0, 3, 0})});
  // Every share is 1 in this wind; descriptors are summed over triangles in place of patches.
  CHECK_THAT(force(exposed(both), Vector3d::UnitX()).x(), WithinRel(force(Surface(both), Vector3d::UnitX()).x(), 1e-9));
}

TEST_CASE("a cube behind another is in its wind at 0 degrees and not at 90", "[exposure][limit]") {
  const Surface surface = exposed(tandem);
  REQUIRE(surface.exposure);
  CHECK(surface.parts.size() == 2);
  const auto along = surface.exposure->towards(-Vector3d::UnitX()), across = surface.exposure->towards(-Vector3d::UnitY());
  int fronts = 0;
  for (Eigen::Index i = 0; i < surface.size(); ++i) {
    if (surface.normal(i, 0) < -0.99) {
      CHECK(surface.exposure->share(i, along) == (surface.centroid(i, 0) > 0.0 ? 0.0 : 1.0));
      ++fronts;
    }
    if (surface.normal(i, 1) < -0.99) CHECK(surface.exposure->share(i, across) == 1.0);
  }
  CHECK(fronts == 4);
  CHECK_THAT(force(surface, Vector3d::UnitY()).y(), WithinRel(2.0 * force(Surface(cube), Vector3d::UnitY()).y(), 1e-9));
  CHECK(force(surface, Vector3d::UnitX()).x() < 1.75 * force(Surface(cube), Vector3d::UnitX()).x());
}

TEST_CASE("a body that comes out of another's lee does so without a jump, and is never blown upwind", "[exposure][limit][regression]") {
  // The rear recovery of a body of which a sliver met the wind was that of an endless bar: 23 N of 60 within 0.01 degrees.
  const Surface surface = exposed(tandem);
  const double alone = force(Surface(cube), Vector3d::UnitX()).x(), straight = force(surface, Vector3d::UnitX()).x();
  CHECK_THAT(straight, WithinRel(alone, 0.02));  // the rear cube feels friction alone
  for (const double degrees : {0.01, 0.1, 0.5}) {
    const double angle = degrees * std::numbers::pi / 180.0;
    const Vector3d wind(std::cos(angle), std::sin(angle), 0.0);
    // Over the first degree the windward area grows by 5 % and nothing else changes more: 0.1 N and 10 % per degree.
    CHECK_THAT(force(surface, wind).dot(wind), WithinAbs(straight, 0.1 + 0.1 * degrees * straight));
    CHECK(describe(surface, wind, std::size_t{1}).reached < 0.1);
  }
  CHECK(describe(surface, Vector3d::UnitX(), std::size_t{1}).reached == 0.0);
  CHECK(describe(surface, Vector3d::UnitX(), std::size_t{0}).reached == 1.0);
}

TEST_CASE("a convex body costs no exposure and keeps its force to the bit", "[exposure][invariance]") {
  for (const Shape& shape : zoo::shapes()) {
    const TriangleMesh mesh = triangulate(shape, 6);
    const Preparation before = prepare(mesh), after = expose(before);
    INFO(kind(shape));
    CHECK(after.exposed);
    CHECK(after.exposure == nullptr);
    CHECK(after.wetted.empty());
    CHECK(after.report.size() == before.report.size());
    const Vector3d direction = Vector3d(0.8, 0.36, 0.48);
    CHECK(force(Surface(after), direction) == force(Surface(before), direction));
  }
}

TEST_CASE("a dented ball is not convex, however fine its triangles", "[exposure][regression]") {
  // Over a short edge no neighbour rises by a thousandth of the body: fine meshes were all convex, and no ray was cast.
  for (const int divisions : {8, 60}) {
    TriangleMesh mesh = triangulate(Sphere{1.0}, divisions);
    CHECK(Surface(mesh).convex);
    for (Vector3d& v : mesh.vertices) v *= 1.0 - 0.5 * std::exp(-10.0 * (v / v.norm() - Vector3d::UnitX()).squaredNorm());
    const Surface dented = exposed(mesh);
    CHECK_FALSE(dented.convex);
    REQUIRE(dented.exposure);
    const Vector3d towards = Vector3d(0.5, 0.8, 0.33).normalized();  // over the rim
    CHECK_THAT(reached_area(dented, towards),
               WithinRel(silhouette_area(mesh, towards), 0.03));  // 42 directions on the fine mesh, 32 degrees apart
  }
}

TEST_CASE("what is reached adds up to what one sees", "[exposure][analytic]") {
  for (const TriangleMesh& mesh : {bracket(), tandem}) {
    const Surface surface = exposed(mesh);
    double worst = 0.0;
    for (const Vector3d& towards : ten_directions()) {
      const double seen = silhouette_area(mesh, towards);
      worst = std::max(worst, std::abs(reached_area(surface, towards) / seen - 1.0));
    }
    CHECK(worst < 0.02);  // 642 directions stand 8 degrees apart, and shares have kinks in between
  }
}

TEST_CASE("the silhouette of a box is the sum of its faces' projections", "[exposure][analytic]") {
  const TriangleMesh mesh = box({0, 0, 0}, {2, 1, 0.5});
  for (const Vector3d& d : ten_directions()) {
    const double exact = 0.5 * std::abs(d.x()) + 1.0 * std::abs(d.y()) + 2.0 * std::abs(d.z());
    CHECK_THAT(silhouette_area(mesh, 3.0 * d), WithinRel(exact, 0.005));  // 512 rays across
  }
  CHECK_THROWS_AS(silhouette_area(mesh, Vector3d::Zero()), std::invalid_argument);
  CHECK(silhouette_area({}, Vector3d::UnitX()) == 0.0);
}

TEST_CASE("the force on cubes in tandem does not jump with the direction", "[exposure][limit]") {
  const Surface surface = exposed(tandem);
  const Model model = model_for(surface);
  Vector3d last;
  double largest = 0.0, size = 0.0;
  constexpr int steps = 1800;
  for (int k = 0; k <= steps; ++k) {
    const double angle = std::numbers::pi / 2 * k / steps + 1e-3;
    const Vector3d wind(std::cos(angle) * 0.98, std::sin(angle) * 0.98, std::sqrt(1.0 - 0.98 * 0.98));
    const Vector3d now = wrench(surface, {.wind = speed * wind}, medium, model).total().force;
    if (k > 0) largest = std::max(largest, (now - last).norm());
    size = std::max(size, now.norm());
    last = now;
  }
  // A step of 0.05 degrees changes a force that turns over within 8 degrees by less than 1 %; a jump of one cell would be 10 % and more.
  CHECK(largest < 0.01 * size);
}

TEST_CASE("the force on cubes in tandem hardly depends on how they lie to the directions", "[exposure][invariance]") {
  // Straight behind each other the shadow has a kink, a wedge over all neighbouring directions: linear interpolation between corners 8
  // degrees apart adds up to 4 % of the force where no corner falls on it, and nothing where one does.
  zoo::Random random(7);
  const Surface straight = exposed(tandem);
  for (int k = 0; k < 4; ++k) {
    const Matrix3d R = random.rotation();
    const Surface turned = exposed(transformed(tandem, R, Vector3d::Zero()));
    for (const Vector3d& wind : {Vector3d(1, 0, 0), Vector3d(0.96, 0.28, 0), Vector3d(0.8, 0, 0.6), Vector3d(0, 1, 0)}) {
      const Vector3d expected = R * force(straight, wind);
      CHECK((force(turned, R * wind) - expected).norm() < 0.05 * expected.norm());
    }
  }
}

TEST_CASE("a mesh far off the origin is exposed alike", "[exposure][hard]") {
  const Preparation near = expose(prepare(tandem)), far = expose(prepare(moved(tandem, {1e5, -1e5, 1e5})));
  REQUIRE(near.exposure);
  REQUIRE(far.exposure);
  // Corners move by 1e-11 m; a ray at an edge may fall on its other side: one point of 256.
  const auto difference = near.exposure->reached.cast<int>() - far.exposure->reached.cast<int>();
  CHECK(difference.abs().maxCoeff() <= 2);
  const Preparation touching = expose(prepare(moved(together({cube, moved(cube, {1, 0, 0})}), {1e5, 1e5, 1e5})));
  CHECK(touching.parts() == 1);
}

TEST_CASE("the size of a mesh does not matter to what is reached", "[exposure][invariance]") {
  const Preparation small = expose(prepare(transformed(tandem, 1e-3 * Matrix3d::Identity(), Vector3d::Zero())));
  const Preparation large = expose(prepare(transformed(tandem, 1e4 * Matrix3d::Identity(), Vector3d::Zero())));
  REQUIRE(small.exposure);
  REQUIRE(large.exposure);
  CHECK((small.exposure->reached.cast<int>() - large.exposure->reached.cast<int>()).abs().maxCoeff() <= 2);  // as above
}

TEST_CASE("the number of threads does not change a byte", "[exposure][invariance]") {
  for (const TriangleMesh& mesh :
       {bracket(), together({box({-1, -.5, -.5}, {.2, .5, .5}, 8), box({-.2, -.5, -.5}, {1, .5, .5}, 7), moved(cube, {3, 0, 0})}),
        together({box({0, 0, 0}, {1, 1, 1}, 20), box({1.2, 0, 0}, {2, 1, 1}, 20)})}) {
    const Preparation one = expose(prepare(mesh), {.threads = 1}), two = expose(prepare(mesh), {.threads = 2});
    REQUIRE(one.exposure);
    REQUIRE(two.exposure);
    CHECK((one.exposure->reached == two.exposure->reached).all());
    CHECK(one.part == two.part);
    REQUIRE(one.wetted.size() == two.wetted.size());
    for (std::size_t i = 0; i < one.wetted.size(); ++i) {
      CHECK(one.wetted[i].front == two.wetted[i].front);
      CHECK(one.wetted[i].centroid == two.wetted[i].centroid);
    }
    CHECK(describe(one.report) == describe(two.report));
  }
}

TEST_CASE("a sheet feels on each side what reaches that side", "[exposure][limit]") {
  // A plate of 1 m^2 with a cube of 3 m standing 0.5 m behind its -z side.
  const TriangleMesh plate = triangulate(Plate{1.0, 1.0, 0.0}, 4);
  const Surface surface = exposed(together({plate, box({-1.5, -1.5, -3.5}, {1.5, 1.5, -0.5})}));
  REQUIRE(surface.exposure);
  const auto above = surface.exposure->towards(Vector3d::UnitZ()), below = surface.exposure->towards(-Vector3d::UnitZ());
  int checked = 0;
  for (Eigen::Index i = 0; i < surface.size(); ++i)
    if (surface.back[i] > 0.0) {
      CHECK(surface.exposure->share(i, above) == 1.0);
      CHECK(surface.exposure->share(i, below) == 0.0);
      ++checked;
    }
  CHECK(checked == 32);
}

TEST_CASE("a sheet on a body's face has one side in the air", "[exposure][limit]") {
  const TriangleMesh plate = moved(triangulate(Plate{0.5, 0.5, 0.0}, 2), {0, 0, 0.5 + 1e-5});
  const Preparation prepared = expose(prepare(together({cube, plate})));
  CHECK(prepared.parts() == 2);
  REQUIRE(prepared.found(Finding::Kind::covered));
  double back = 0.0;
  for (std::size_t i = 0; i < prepared.part.size(); ++i)
    if (prepared.sheet[static_cast<std::size_t>(prepared.part[i])]) back += std::min(prepared.wetted[i].front, prepared.wetted[i].back);
  CHECK(back == 0.0);
}

TEST_CASE("windward area over silhouette tells of what stands behind", "[exposure][analytic]") {
  const auto ratios = windward_over_silhouette(prepare(tandem));
  CHECK(ratios[0].direction == Vector3d::UnitX());
  CHECK(ratios[3].direction == Vector3d(-Vector3d::UnitY()));
  for (std::size_t k = 0; k < 6; ++k) {
    CHECK_THAT(ratios[k].summed, WithinRel(2.0, 1e-12));
    CHECK_THAT(ratios[k].silhouette, WithinRel(k < 2 ? 1.0 : 2.0, 0.005));  // by 512 rays across
  }
  for (const WindwardRatio& ratio : windward_over_silhouette(prepare({}))) CHECK(ratio.summed == 0.0);
}

TEST_CASE("options out of range and empty meshes", "[exposure][hard]") {
  CHECK_THROWS_AS(expose(prepare(tandem), {.directions = 43}), std::invalid_argument);
  CHECK_THROWS_AS(expose(prepare(tandem), {.rays = 0.0}), std::invalid_argument);
  CHECK_THROWS_AS(expose(prepare(tandem), {.threads = -1}), std::invalid_argument);
  CHECK(expose(prepare({})).exposed);
  const Preparation once = expose(prepare(tandem)), twice = expose(once);
  CHECK(twice.exposure == once.exposure);
  for (const int directions : {42, 162, 642}) {
    const Preparation prepared = expose(prepare(tandem), {.directions = directions});
    REQUIRE(prepared.exposure);
    CHECK(prepared.exposure->directions.size() == static_cast<std::size_t>(directions));
    const auto& cells = prepared.exposure->cells;
    const auto whole = std::count_if(cells.begin(), cells.end(), [](const Exposure::Cell& cell) { return cell.children == 0; });
    CHECK(whole == 2 * directions - 4);   // Euler
    for (int axis = 0; axis < 3; ++axis)  // a wind along an axis needs no interpolation
      CHECK_THAT(prepared.exposure->towards(Vector3d::Unit(axis)).weight.maxCoeff(), WithinAbs(1.0, 1e-12));
  }
}

TEST_CASE("every direction falls into a cell that holds it", "[exposure][analytic]") {
  const Preparation prepared = expose(prepare(tandem));
  zoo::Random random(3);
  for (int k = 0; k < 2000; ++k) {
    const Vector3d direction = random.vector(1.0).normalized();
    const Exposure::Sample sample = prepared.exposure->towards(direction);
    Vector3d sum = Vector3d::Zero();
    for (int c = 0; c < 3; ++c) sum += sample.weight[c] * prepared.exposure->directions[static_cast<std::size_t>(sample.corner[c])];
    CHECK((sum.normalized() - direction).norm() < 1e-12);
  }
}

TEST_CASE("a quadrotor keeps its force when body and wind are turned together, as far as it can be looked at",
          "[exposure][invariance][regression]") {
  // Its arms and rotors cast shadows of 1 to 5 degrees; directions 8 degrees apart hit them or not, and the force changed by 41 %.
  zoo::Random random(11);
  const TriangleMesh mesh = thin_bodies::quadrotor();
  const std::vector<Vector3d> winds{Vector3d::UnitX(), Vector3d(1, 1, 0).normalized(), Vector3d(1, 1, 1).normalized()};
  std::vector<std::vector<double>> forces(winds.size());
  for (int turn = 0; turn < 8; ++turn) {
    const Matrix3d R = turn == 0 ? Matrix3d(Matrix3d::Identity()) : random.rotation();
    const Surface surface = exposed(transformed(mesh, R, Vector3d::Zero()));
    for (std::size_t k = 0; k < winds.size(); ++k) forces[k].push_back(force(surface, R * winds[k]).dot(R * winds[k]));
  }
  for (const std::vector<double>& list : forces) {
    const double mean = std::accumulate(list.begin(), list.end(), 0.0) / static_cast<double>(list.size());
    const auto [least, most] = std::minmax_element(list.begin(), list.end());
    CHECK((*most - *least) / mean < 0.2);  // of rotors 4 mm thick, edge-on, directions 1 degree apart still see more than there is
  }
}

TEST_CASE("what remains uncertain between the directions is said, and is little where shadows are wide", "[exposure][limit]") {
  const auto residual = [](const TriangleMesh& mesh, const ExposeOptions& options) {
    return expose(prepare(mesh), options).exposure->residual;
  };
  const double adapted = residual(tandem, {}), even = residual(tandem, {.directions = 642});
  CHECK(adapted < 0.03);  // directions are added until the errors that are looked at are below 0.02
  CHECK(adapted < even);
  CHECK(residual(thin_bodies::frame(), {}) > 0.1);  // bars of 2 degrees in all planes: the rays run out
}

TEST_CASE("of a fine mesh neighbours share what reaches them, and the body has the force of a coarse one", "[exposure][convergence]") {
  const auto with = [](int divisions) {
    return together({box({-1.25, -.5, -.5}, {-.25, .5, .5}, divisions), box({.25, -.5, -.5}, {1.25, .5, .5}, divisions)});
  };
  const Preparation coarse = expose(prepare(with(12))), fine = expose(prepare(with(40)));
  REQUIRE(fine.exposure);
  CHECK(coarse.exposure->reached.rows() == static_cast<Eigen::Index>(coarse.mesh.triangles.size()));
  CHECK(fine.mesh.triangles.size() == 38400);
  CHECK(fine.exposure->row.size() == 38400);
  CHECK(fine.exposure->reached.rows() < 10000);
  for (const Vector3d& wind : ten_directions()) {
    const Vector3d expected = force(Surface(coarse), wind);
    CHECK((force(Surface(fine), wind) - expected).norm() < 0.02 * expected.norm());  // shares of some thousand points: 1 % each
  }
}

TEST_CASE("the sphere of directions is halved where one asks, without gaps and without needles", "[exposure][analytic]") {
  DirectionSphere sphere(1);
  zoo::Random random(5);
  for (int round = 0; round < 6; ++round) {
    const Vector3d towards = random.vector(1.0).normalized();
    std::set<DirectionSphere::Edge> edges;
    for (const Exposure::Cell& cell : sphere.cells())
      for (int k = 0; k < 3 && cell.children == 0; ++k)
        if (const DirectionSphere::Edge edge = DirectionSphere::edge(cell, k); sphere.middle(edge).dot(towards) > 0.9) edges.insert(edge);
    sphere.halve(edges);
    for (const DirectionSphere::Edge& edge : edges)
      CHECK(std::find(sphere.parents().begin(), sphere.parents().end(), edge) != sphere.parents().end());
  }
  std::map<DirectionSphere::Edge, int> uses;
  int whole = 0;
  double least = 180.0;
  for (const Exposure::Cell& cell : sphere.cells()) {
    if (cell.children > 0) continue;
    ++whole;
    for (int k = 0; k < 3; ++k) {
      ++uses[DirectionSphere::edge(cell, k)];
      const auto at = [&](int corner) { return sphere.directions()[static_cast<std::size_t>(cell.corner[(k + corner) % 3])]; };
      const double cosine = (at(1) - at(0)).normalized().dot((at(2) - at(0)).normalized());
      least = std::min(least, std::acos(cosine) * 180.0 / std::numbers::pi);
    }
  }
  CHECK(whole == 2 * static_cast<int>(sphere.directions().size()) - 4);  // Euler, of a closed polyhedron
  for (const auto& [edge, count] : uses) CHECK(count == 2);
  CHECK(least > 20.0);  // halving the longest edge at most halves the least angle of the icosahedron's halves, 54 degrees
}
