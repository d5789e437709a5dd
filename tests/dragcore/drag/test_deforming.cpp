// Forces on meshes whose vertices move each by itself.

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <dragcore/deforming.hpp>
#include <limits>

#include "tests/dragcore/drag/hostile.hpp"

using namespace dragcore;
using Eigen::Vector3d;
using Eigen::Vector3f;

namespace {

/// A mesh in motion, in both precisions: the numbers of one are those of the other.
struct Cloth {
  std::vector<Eigen::Vector3i> triangles;
  Surface::Sides sides = Surface::Sides::two;
  std::vector<Vector3f> position, velocity;
  Vector3d wind = Vector3d::Zero();

  static std::vector<Vector3d> exact(const std::vector<Vector3f>& vectors) {
    std::vector<Vector3d> result;
    for (const Vector3f& v : vectors) result.push_back(v.cast<double>());
    return result;
  }
  TriangleMesh mesh() const { return {exact(position), triangles}; }
  std::vector<Vector3d> reference(const Law& law) const {
    return reference::vertex_forces(triangles, sides, exact(position), exact(velocity), wind, {}, law);
  }
  std::vector<Vector3d> forces(const Law& law) const {
    std::vector<Vector3f> force(position.size(), Vector3f::Constant(7.0f));
    DeformingMesh(triangles, position.size(), sides).forces(position, velocity, wind, {}, law, force);
    return exact(force);
  }
  /// Of density/2 speed^2, the square of the longest edge, summed: what the error is a share of.
  double scale() const {
    double sum = 0.0;
    for (const Eigen::Vector3i& t : triangles) {
      double edge = 0.0, speed = 0.0;
      for (int k = 0; k < 3; ++k) {
        const auto here = static_cast<std::size_t>(t[k]), there = static_cast<std::size_t>(t[(k + 1) % 3]);
        edge = std::max(edge, (position[here] - position[there]).cast<double>().norm());
        speed = std::max(speed, (wind - velocity[here].cast<double>()).norm());
      }
      sum += 0.5 * Medium{}.density * speed * speed * edge * edge;
    }
    return sum;
  }
  /// At least 0: what the air takes from the motion relative to it [W].
  double dissipation(const std::vector<Vector3d>& force) const {
    double sum = 0.0;
    for (std::size_t v = 0; v < force.size(); ++v) sum += force[v].dot(wind - velocity[v].cast<double>());
    return sum;
  }
};

std::vector<Law> local_laws() {
  Law based{.name = "based", .windward = {0.0, 0.3, 1.0, 0.0, 0.2}, .friction = 0.02, .base_suction = 0.4, .base_edge = 0.2};
  Law all = based;
  all.leeward = {0.0, 0.5, 0.0, 0.1, 0.0};
  return {note_law(), consistent_law(), sheet_law(), scaled_law(0.89, 0.25), based, all};
}

/// A rigid mesh in rigid motion, as float has it.
Cloth rigid(const TriangleMesh& mesh, Surface::Sides sides, const Motion& motion) {
  Cloth cloth{.triangles = mesh.triangles, .sides = sides, .wind = motion.wind};
  for (const Vector3d& r : mesh.vertices) {
    cloth.position.push_back(r.cast<float>());
    cloth.velocity.push_back((motion.velocity + motion.angular_velocity.cross(r - motion.reference_point)).cast<float>());
  }
  return cloth;
}

/// A flag that waves, bends and stretches.
Cloth flag(int divisions, unsigned seed) {
  zoo::Random random(seed);
  const TriangleMesh mesh = triangulate(Plate{.chord = 2.0, .span = 1.0, .thickness = 0.0}, divisions);
  Cloth cloth{.triangles = mesh.triangles, .wind = {9.0, 1.0, -2.0}};
  for (const Vector3d& r : mesh.vertices) {
    cloth.position.push_back(Vector3d(r.x(), r.y(), 0.2 * std::sin(5.0 * r.x() + r.y())).cast<float>() +
                             random.vector(0.1 / divisions).cast<float>());
    cloth.velocity.push_back(random.vector(3.0).cast<float>());
  }
  return cloth;
}

double largest_difference(const std::vector<Vector3d>& a, const std::vector<Vector3d>& b) {
  REQUIRE(a.size() == b.size());
  double largest = 0.0;
  for (std::size_t v = 0; v < a.size(); ++v) largest = std::max(largest, (a[v] - b[v]).norm());
  return largest;
}

}  // namespace

TEST_CASE("in rigid motion the vertices share what triangle_forces() says", "[deforming][analytic]") {
  zoo::Random random(3);
  for (const Shape& shape : zoo::shapes())
    for (const Law& law : local_laws()) {
      const TriangleMesh mesh = triangulate(shape, 4);
      const Surface::Sides sides = zoo::sides_of(shape);
      const Motion motion = random.motion(8.0, 3.0);
      std::vector<Vector3d> velocity;
      for (const Vector3d& r : mesh.vertices)
        velocity.push_back(motion.velocity + motion.angular_velocity.cross(r - motion.reference_point));
      const std::vector<Vector3d> force = reference::vertex_forces(mesh.triangles, sides, mesh.vertices, velocity, motion.wind, {}, law);
      const Surface surface(mesh, sides);
      REQUIRE(surface.size() == static_cast<Eigen::Index>(mesh.triangles.size()));
      const Eigen::Matrix3Xd parts = triangle_forces(surface, motion, {}, {.law = law, .quadrature = Quadrature::one}).force;
      std::vector<Vector3d> shared(force.size(), Vector3d::Zero());
      for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        for (const int corner : mesh.triangles[t])
          shared[static_cast<std::size_t>(corner)] += parts.col(static_cast<Eigen::Index>(t)) / 3.0;
      INFO(law.name << ", shape " << shape.index());
      // Both in double: rounding of some hundred terms.
      CHECK(largest_difference(force, shared) <= 1e-12 * hostile::force_scale(surface, motion, Medium{}.density));

      const Cloth cloth = rigid(mesh, sides, motion);
      CHECK(largest_difference(cloth.forces(law), cloth.reference(law)) <= 1e-6 * cloth.scale());  // the header's promise
      // Positions and velocities of float are rounded by 6e-8 each, of edges a quarter as long as the body: 1e-6 covers a few of them.
      Vector3d total = Vector3d::Zero();
      for (const Vector3d& f : cloth.forces(law)) total += f;
      const Vector3d whole = wrench(surface, motion, {}, {.law = law, .quadrature = Quadrature::one}).total().force;
      CHECK((total - whole).norm() <= 1e-6 * hostile::force_scale(surface, motion, Medium{}.density));
    }
}

TEST_CASE("a square sheet broadside has its formula's drag, and its corners a third of each triangle's", "[deforming][analytic]") {
  const Cloth cloth{.triangles = {{0, 1, 2}, {0, 2, 3}},
                    .position = {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}},
                    .velocity = std::vector<Vector3f>(4, Vector3f::Zero()),
                    .wind = {0, 0, 3}};
  const double newton = 0.5 * Medium{}.density * 9.0 * 2.0;  // of each triangle: c = 1, C_N = 1
  const std::vector<Vector3d> force = cloth.forces(note_law());
  for (std::size_t v = 0; v < 4; ++v) {
    const double share = v % 2 == 0 ? 2.0 / 3.0 : 1.0 / 3.0;
    CHECK((force[v] - Vector3d(0, 0, share * newton)).norm() < 1e-6 * newton);  // float
  }
}

TEST_CASE("a cloth that deforms has the reference's forces and takes no energy from the air", "[deforming][sign]") {
  for (const int divisions : {1, 2, 5, 30})
    for (const Law& law : local_laws()) {
      const Cloth cloth = flag(divisions, static_cast<unsigned>(divisions));
      const std::vector<Vector3d> force = cloth.forces(law);
      INFO(law.name << ", " << cloth.triangles.size() << " triangles");
      CHECK(largest_difference(force, cloth.reference(law)) <= 1e-6 * cloth.scale());
      CHECK(cloth.dissipation(force) > 0.0);
    }
}

TEST_CASE("only the flow relative to the cloth counts, at each vertex or everywhere", "[deforming][invariance]") {
  Cloth cloth = flag(6, 11);
  const std::vector<Vector3d> force = cloth.forces(sheet_law());
  std::vector<Vector3f> winds, sum(cloth.position.size());
  for (const Vector3f& v : cloth.velocity) winds.push_back(cloth.wind.cast<float>() - v);
  const std::vector<Vector3f> still(winds.size(), Vector3f::Zero());
  DeformingMesh(cloth.triangles, winds.size(), cloth.sides).forces(cloth.position, still, winds, {}, sheet_law(), sum);
  CHECK(largest_difference(Cloth::exact(sum), force) <= 1e-7 * cloth.scale());  // one rounding more or less
  DeformingMesh(cloth.triangles, winds.size(), cloth.sides).forces(cloth.position, winds, winds, {}, sheet_law(), sum);
  for (const Vector3f& f : sum) CHECK(f == Vector3f::Zero());
}

TEST_CASE("vertices may lie in an engine's own structure", "[deforming]") {
  struct Vertex {
    float inverse_mass, position[3], velocity[3], force[3];
  };
  const Cloth cloth = flag(4, 5);
  std::vector<Vertex> engine(cloth.position.size());
  for (std::size_t v = 0; v < engine.size(); ++v) {
    engine[v].inverse_mass = 1.0f;
    for (int k = 0; k < 3; ++k) engine[v].position[k] = cloth.position[v][k], engine[v].velocity[k] = cloth.velocity[v][k];
  }
  const std::size_t stride = sizeof(Vertex) / sizeof(float);
  DeformingMesh mesh(cloth.triangles, engine.size(), cloth.sides);
  mesh.forces({engine[0].position, engine.size(), stride}, {engine[0].velocity, engine.size(), stride}, cloth.wind, {}, sheet_law(),
              {engine[0].force, engine.size(), stride});
  const std::vector<Vector3d> force = cloth.forces(sheet_law());
  for (std::size_t v = 0; v < engine.size(); ++v) {
    CHECK(engine[v].inverse_mass == 1.0f);
    for (int k = 0; k < 3; ++k) CHECK(engine[v].force[k] == force[v][k]);
  }
}

TEST_CASE("triangles without area carry no force, and vertices without triangles none", "[deforming][hard]") {
  Cloth cloth{.triangles = {{0, 0, 1}, {0, 1, 2}, {3, 3, 3}, {0, 4, 5}},
              .position = {{0, 0, 0}, {1, 1, 1}, {2, 2, 2}, {5, 5, 5}, {0, 0, 0}, {0, 0, 0}},
              .velocity = std::vector<Vector3f>(6, Vector3f::Zero()),
              .wind = {3, -2, 1}};
  for (const Law& law : local_laws())
    for (const Vector3d& f : cloth.forces(law)) CHECK(f == Vector3d::Zero());
  cloth.triangles.clear();
  for (const Vector3d& f : cloth.forces(note_law())) CHECK(f == Vector3d::Zero());
  cloth.position.clear(), cloth.velocity.clear();
  CHECK(cloth.forces(note_law()).empty());
}

TEST_CASE("size and speed of any order give forces that scale", "[deforming][hard]") {
  // 2^-60 to 2^40 are exact in float: only what leaves its range could make a difference. Forces go with size^2 speed^2.
  const Cloth cloth = flag(3, 8);
  const std::vector<Vector3d> force = cloth.forces(sheet_law());
  for (const int size : {-60, -30, -10, 10, 25})
    for (const int speed : {-40, -10, 10, 20}) {
      Cloth scaled = cloth;
      for (Vector3f& r : scaled.position) r = r * std::ldexp(1.0f, size);
      for (Vector3f& v : scaled.velocity) v = v * std::ldexp(1.0f, speed);
      scaled.wind *= std::ldexp(1.0, speed);
      std::vector<Vector3d> found = scaled.forces(sheet_law());
      INFO("2^" << size << " m, 2^" << speed << " m/s");
      for (Vector3d& f : found) f *= std::ldexp(1.0, -2 * (size + speed));
      const double smallest = std::ldexp(1.0, -149 - 2 * (size + speed));  // that float has, scaled
      CHECK(largest_difference(found, force) <= 1e-6 * cloth.scale() + 10.0 * smallest);
    }
}

TEST_CASE("no mesh, motion or local law makes a force that is no number or feeds on the air", "[deforming][hard]") {
  int cases = 20000;
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  cases /= hostile::sanitizer_divisor;
#endif
  for (int seed = 0; seed < cases; ++seed) {
    zoo::Random random(static_cast<unsigned>(seed));
    const hostile::Body body = hostile::body(random, true);
    Cloth cloth = rigid(body.mesh, body.sides, hostile::motion(random));
    const float size = static_cast<float>(std::pow(10.0, random.uniform(-9.0, 6.0))),
                speed = static_cast<float>(std::pow(10.0, random.uniform(-9.0, 6.0)));
    for (Vector3f& r : cloth.position) r *= size;
    for (Vector3f& v : cloth.velocity) v = speed * (v + random.vector(5.0).cast<float>());
    cloth.wind *= static_cast<double>(speed);
    Law law = hostile::wild_law(random, true);
    law.aspect_gain = law.recovery = law.shelter = law.curvature = 0.0;
    for (std::size_t k = 0; k < 5; ++k) law.windward[k] = std::abs(law.windward[k]), law.leeward[k] = std::abs(law.leeward[k]);
    const std::vector<Vector3d> force = cloth.forces(law);
    INFO("seed " << seed);
    double spent = 0.0;
    for (std::size_t v = 0; v < force.size(); ++v) {
      REQUIRE(force[v].allFinite());
      spent += force[v].norm() * (cloth.wind - cloth.velocity[v].cast<double>()).norm();
    }
    // Forces of float times velocities of float: a few roundings of 6e-8 of each, and 1e-45 N where float ends.
    REQUIRE(cloth.dissipation(force) >= -1e-6 * spent - 1e-40 * static_cast<double>(speed));
  }
}

TEST_CASE("what a deforming mesh cannot use is said, and nothing is lost", "[deforming]") {
  const Cloth cloth = flag(2, 1);
  const std::size_t count = cloth.position.size();
  DeformingMesh mesh(cloth.triangles, count, cloth.sides);
  std::vector<Vector3f> force(count, Vector3f::Constant(7.0f));
  const auto refused = [&](const Cloth& given, const Medium& medium, const Law& law, const std::string& words) {
    CHECK_THROWS_WITH(mesh.forces(given.position, given.velocity, given.wind, medium, law, force), Catch::Matchers::Contains(words));
    for (const Vector3f& f : force) CHECK(f == Vector3f::Constant(7.0f));
  };
  const auto changed = [&](const auto& change) {
    Cloth copy = cloth;
    change(copy);
    return copy;
  };
  const float nan = std::numeric_limits<float>::quiet_NaN(), infinite = std::numeric_limits<float>::infinity();
  refused(changed([](Cloth& c) { c.position.pop_back(); }), {}, note_law(), "entries of position = 8, but the mesh has 9 vertices");
  refused(changed([](Cloth& c) { c.velocity.push_back({0, 0, 0}); }), {}, note_law(), "entries of velocity = 10");
  refused(changed([&](Cloth& c) { c.position[4].y() = nan; }), {}, note_law(), "position of vertex 4");
  refused(changed([&](Cloth& c) { c.position[8].z() = infinite; }), {}, note_law(), "position of vertex 8");
  refused(changed([&](Cloth& c) { c.velocity[0].x() = -infinite; }), {}, sheet_law(), "velocity of vertex 0");
  refused(changed([&](Cloth& c) { c.wind.x() = static_cast<double>(nan); }), {}, note_law(), "wind");
  refused(changed([&](Cloth& c) { c.wind.x() = 1e60; }), {}, note_law(), "finite in single precision");
  refused(changed([](Cloth& c) { c.position[0].x() = 1e37f, c.velocity[0].y() = 1e30f; }), {}, note_law(), "beyond 1e30 N");
  refused(cloth, {.density = -1.0}, note_law(), "density = -1");
  refused(cloth, {}, closed_law(), "recovery = 1, but it must be 0");
  for (const auto member : {&Law::aspect_gain, &Law::shelter, &Law::curvature}) {
    Law law = sheet_law();
    law.*member = 0.5;
    refused(cloth, {}, law, "= 0.5, but it must be 0");
  }
  Law pushing = note_law();
  pushing.leeward = {0.0, -1.0, 0.0, 0.0, 0.0};
  refused(cloth, {}, pushing, "leeward");
  std::vector<Vector3f> few(count - 1);
  CHECK_THROWS_WITH(mesh.forces(cloth.position, cloth.velocity, cloth.wind, {}, note_law(), few), Catch::Matchers::Contains("force"));
  CHECK_THROWS_WITH(mesh.forces(cloth.position, cloth.velocity, few, {}, note_law(), force), Catch::Matchers::Contains("wind"));
  CHECK_THROWS_WITH(mesh.forces({cloth.position[0].data(), count, 2}, cloth.velocity, cloth.wind, {}, note_law(), force),
                    Catch::Matchers::Contains("stride of position = 2"));
  const std::vector<Eigen::Vector3i> wild{{0, 1, 9}}, negative{{0, -1, 2}};
  CHECK_THROWS_WITH(DeformingMesh(wild, 9, Surface::Sides::two), Catch::Matchers::Contains("vertex of triangle 0 = 9"));
  CHECK_THROWS_WITH(DeformingMesh(negative, 9, Surface::Sides::two), Catch::Matchers::Contains("= -1"));
  CHECK_THROWS_WITH(DeformingMesh(cloth.triangles, std::size_t{1} << 28, cloth.sides), Catch::Matchers::Contains("below 2^28"));
  CHECK_THROWS_WITH(DeformingMesh(cloth.triangles, count, Surface::Sides::automatic), Catch::Matchers::Contains("sides = 0"));
}
