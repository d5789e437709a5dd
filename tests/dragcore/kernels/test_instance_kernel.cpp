// One body a lane: the same on every instruction set. tests/dragcore/batch says that it is right.

#include <dragcore/batch.hpp>

#include "kernels/instances.hpp"
#include "tests/dragcore/drag/hostile.hpp"
#include "tests/dragcore/kernels/targets.hpp"

using namespace dragcore;

TEST_CASE("a batch has the same bits whatever the width of the vectors", "[kernels][backend][batch]") {
  std::vector<Surface> surfaces{zoo::surface(Box{}, 1), zoo::surface(Plate{.chord = 0.3, .span = 0.2, .thickness = 0.0}, 1),
                                zoo::surface(Sphere{}, 1)};
  std::vector<Model> models;
  for (const Surface& surface : surfaces) models.push_back(model_for(surface));
  const MassProperties mass{0.1, Eigen::Vector3d(0.02, 0.03, 0.04).asDiagonal()};
  for (std::size_t k = 0; k < surfaces.size(); ++k) CHECK(kernels::instanced(surfaces[k], models[k]));
  kernels::same_bits([&] {
    zoo::Random random(61);
    std::vector<BodyInFlow> bodies;
    std::vector<FreeBody> free;
    for (std::size_t i = 0; i < 300; ++i) {
      const Motion motion = random.motion(5.0, i % 2 == 0 ? 0.0 : 3.0);
      bodies.push_back({&surfaces[i % 3], &models[i % 3], motion});
      free.push_back({.surface = &surfaces[i % 3], .model = &models[i % 3], .mass = &mass, .motion = motion});
    }
    std::vector<Wrench> wrench(bodies.size());
    std::vector<Vector6d> velocity(free.size());
    wrenches(bodies, {}, wrench);
    step_free_bodies(free, {}, 0.01, velocity);
    std::vector<double> all;
    for (const Wrench& w : wrench)
      for (const auto& v : {w.force, w.torque}) all.insert(all.end(), v.data(), v.data() + 3);
    for (const Vector6d& v : velocity) all.insert(all.end(), v.data(), v.data() + 6);
    return all;
  });
}
