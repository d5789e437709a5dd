// The number of threads does not change a bit.

#include <tbb/task_arena.h>

#include <catch2/catch.hpp>
#include <dragcore/batch.hpp>
#include <dragcore/deforming.hpp>

#include "tests/support/zoo.hpp"

using namespace dragcore;

TEST_CASE("one, two, three and eight threads give the same bits", "[kernels][threads]") {
  const Surface large = zoo::surface(Sphere{}, 60), cube = zoo::surface(Box{}, 1), cone = zoo::surface(Cone{}, 4);
  REQUIRE(large.size() > 16384);
  const Model model = model_for(large);
  const MassProperties mass{0.1, Eigen::Vector3d(0.02, 0.03, 0.04).asDiagonal()};
  const auto work = [&] {
    zoo::Random random(71);
    std::vector<double> all;
    const auto keep = [&](const auto& numbers) { all.insert(all.end(), numbers.data(), numbers.data() + numbers.size()); };
    for (const double spin : {0.0, 2.0}) {
      const Motion motion = random.motion(5.0, spin);
      for (const Wrench& term : wrench(large, motion, {}, model).terms) keep(term.force), keep(term.torque);
      keep(resistance(large, motion, {}, model));
    }
    std::vector<BodyInFlow> bodies;
    std::vector<FreeBody> free;
    for (std::size_t i = 0; i < 500; ++i) {
      const Surface* surface = std::array{&cube, &cone, i < 3 ? &large : &cube}[i % 3];
      bodies.push_back({surface, &model, random.motion(5.0, 3.0)});
      free.push_back({.surface = surface, .model = &model, .mass = &mass, .motion = bodies.back().motion});
    }
    std::vector<Wrench> wrench(bodies.size());
    std::vector<Vector6d> velocity(free.size());
    wrenches(bodies, {}, wrench);
    step_free_bodies(free, {}, 0.01, velocity);
    for (const Wrench& w : wrench) keep(w.force), keep(w.torque);
    for (const Vector6d& v : velocity) keep(v);

    const TriangleMesh cloth = triangulate(Plate{.chord = 1.0, .span = 1.0, .thickness = 0.0}, 80);
    REQUIRE(cloth.triangles.size() > 8192);  // several chunks of triangles, and of vertices
    std::vector<Eigen::Vector3f> position, moving, force(cloth.vertices.size());
    for (const Eigen::Vector3d& r : cloth.vertices)
      position.push_back((r + random.vector(0.01)).cast<float>()), moving.push_back(random.vector(4.0).cast<float>());
    DeformingMesh(cloth.triangles, position.size(), Surface::Sides::two).forces(position, moving, {0, 1, 5}, {}, sheet_law(), force);
    for (const Eigen::Vector3f& f : force) all.insert(all.end(), f.data(), f.data() + 3);
    return all;
  };
  const std::vector<double> alone = tbb::task_arena(1).execute(work);
  for (const int threads : {2, 3, 8}) {
    INFO(threads << " threads");
    CHECK(tbb::task_arena(threads).execute(work) == alone);
  }
}
