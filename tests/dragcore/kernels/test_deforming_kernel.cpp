// Forces on a mesh that deforms: the same on every instruction set. tests/dragcore/drag says that they are
// right.

#include <catch2/catch.hpp>
#include <dragcore/deforming.hpp>
#include <dragcore/shapes.hpp>

#include "tests/dragcore/kernels/targets.hpp"
#include "tests/support/zoo.hpp"

using namespace dragcore;
using Eigen::Vector3f;

namespace {

struct Waves {
  TriangleMesh mesh;
  std::vector<Vector3f> position, velocity;
  Eigen::Vector3d wind{7.0, -2.0, 1.0};

  explicit Waves(int divisions) : mesh(triangulate(Plate{.chord = 1.0, .span = 1.0, .thickness = 0.0}, divisions)) {
    zoo::Random random(17);
    for (const Eigen::Vector3d& r : mesh.vertices) {
      position.push_back((r + random.vector(0.3 / divisions)).cast<float>());
      velocity.push_back(random.vector(4.0).cast<float>());
    }
    position[3] *= 1e-20f, velocity[3] *= 1e-20f;  // some that do not fit into single precision
    position[40] *= 1e12f;
  }
  std::vector<float> forces(Surface::Sides sides, const Law& law) const {
    std::vector<Vector3f> force(position.size());
    DeformingMesh(mesh.triangles, position.size(), sides).forces(position, velocity, wind, {}, law, force);
    return {force.front().data(), force.front().data() + 3 * force.size()};
  }
};

std::vector<Law> every_kernel() {
  std::vector<Law> laws;
  for (unsigned on = 0; on < 8; ++on) {
    Law law = consistent_law();
    if (on & 1) law.leeward = {0.0, 0.4, 0.1, 0.0, 0.0};
    if (on & 2) law.base_suction = 0.3;
    if (on & 4) law.friction = 0.01;
    laws.push_back(law);
  }
  return laws;
}

}  // namespace

TEST_CASE("a deforming mesh has the same bits whatever the width of the vectors", "[kernels][backend][deforming]") {
  const Waves waves(9);
  for (const Surface::Sides sides : {Surface::Sides::one, Surface::Sides::two})
    for (const Law& law : every_kernel()) kernels::same_bits([&] { return waves.forces(sides, law); });
}

TEST_CASE("a deforming mesh has the reference's forces on every instruction set", "[kernels][backend][deforming]") {
  Waves waves(9);
  waves.position[40] *= 1e-12f;  // or it would be all of the scale
  std::vector<Eigen::Vector3d> position, velocity;
  for (std::size_t v = 0; v < waves.position.size(); ++v)
    position.push_back(waves.position[v].cast<double>()), velocity.push_back(waves.velocity[v].cast<double>());
  for (const Surface::Sides sides : {Surface::Sides::one, Surface::Sides::two})
    for (const Law& law : every_kernel()) {
      const std::vector<Eigen::Vector3d> expected =
          reference::vertex_forces(waves.mesh.triangles, sides, position, velocity, waves.wind, {}, law);
      kernels::on_every_target([&] {
        const std::vector<float> found = waves.forces(sides, law);
        for (std::size_t v = 0; v < expected.size(); ++v)
          for (int axis = 0; axis < 3; ++axis)
            // Single precision, of some newtons per square metre times the squares of six triangles' longest edges: 200 Pa, 0.1 m^2.
            CHECK(std::abs(static_cast<double>(found[3 * v + static_cast<std::size_t>(axis)]) - expected[v][axis]) < 1e-6 * 20.0);
      });
    }
}
