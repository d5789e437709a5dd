// Many bodies at once, by one thread and by two: copies of a cube, free boxes, and a frame of 10,000 bodies with 4 million triangles.

#include <oneapi/tbb/task_arena.h>

#include <dragcore/batch.hpp>

#include "rows.hpp"

namespace dragcore::bench {

namespace {

constexpr int frame_bodies = 10'000;

/// Surfaces of ten shapes with 4000 triangles together, cubes to balls; scaled by `size`.
std::vector<Surface> ten_shapes(double size) {
  std::vector<Surface> surfaces;
  const auto add = [&](const Shape& shape, int divisions) {
    TriangleMesh mesh = triangulate(shape, divisions);
    for (Eigen::Vector3d& vertex : mesh.vertices) vertex *= size;
    surfaces.emplace_back(mesh);
  };
  for (const int divisions : {1, 2, 3, 4}) add(Box{0.3, 0.2, 0.1}, divisions);
  add(Plate{1.0, 1.0, 0.0}, 6);
  for (const int divisions : {4, 8, 10, 11, 12}) add(Sphere{}, divisions);
  return surfaces;
}

std::vector<Surface> unique_shapes() {
  std::vector<Surface> all;
  for (int k = 0; k < frame_bodies / 10; ++k)
    for (Surface& surface : ten_shapes(1.0 + 1e-4 * k)) all.push_back(std::move(surface));
  return all;
}

/// Every body goes its own way.
Motion motion_of(int k, bool spins) {
  Motion result = motion(spins ? "spinning" : "straight");
  result.velocity = Eigen::AngleAxisd(0.37 * k, Eigen::Vector3d(1, 2, 3).normalized()) * result.velocity;
  return result;
}

double triangles_of(const std::vector<BodyInFlow>& bodies) {
  double sum = 0.0;
  for (const BodyInFlow& body : bodies) sum += static_cast<double>(body.surface->size());
  return sum;
}

/// A row of wrenches() for each number of threads. `make` fills the bodies and keeps what they point to.
void add_batch_rows(const std::string& name, const std::function<std::vector<BodyInFlow>()>& make) {
  for (const int threads : {1, 2})
    add_row("batch/" + name + "/threads:" + std::to_string(threads),
            [=](benchmark::State& state) {
              const std::vector<BodyInFlow> bodies = make();
              std::vector<Wrench> found(bodies.size());
              tbb::task_arena arena(threads);
              for (auto _ : state) arena.execute([&] { wrenches(bodies, {}, found); });
              count(state, static_cast<double>(bodies.size()), "per_body");
              count(state, triangles_of(bodies));
              Hash hash;
              for (const Wrench& one : found) hash.add(one);
              state.SetLabel(hash.text());
              for (std::size_t k = 0; k < bodies.size(); k += 997) {
                const auto& [surface, model, motion] = bodies[k];
                if (!(error(found[k], wrench(*surface, motion, {}, *model).total(), *surface, motion, {}) <= 2e-6))  // each within 1e-6
                  wrong(state, "a body of the batch has another wrench by itself");
              }
            })
        ->UseRealTime()
        ->Unit(benchmark::kMicrosecond);
}

/// Bodies of surfaces in turn, each with the model of its class.
std::vector<BodyInFlow> in_turn(const std::vector<Surface>& surfaces, const std::vector<Model>& models, bool spins) {
  std::vector<BodyInFlow> bodies;
  for (int k = 0; k < frame_bodies; ++k) {
    const std::size_t which = static_cast<std::size_t>(k) % surfaces.size();
    bodies.push_back({&surfaces[which], &models[which], motion_of(k, spins)});
  }
  return bodies;
}

std::vector<Model> models_of(const std::vector<Surface>& surfaces) {
  std::vector<Model> models;
  for (const Surface& surface : surfaces) models.push_back(model_for(surface));
  return models;
}

}  // namespace

void add_batch_rows() {
  for (const bool spins : {false, true}) {
    const std::string way = spins ? "spinning" : "straight";
    add_batch_rows("cubes/" + way, [=] {
      static const std::vector<Surface> cube{body("cube-12").surface};
      static const std::vector<Model> best = models_of(cube);
      return in_turn(cube, best, spins);
    });
    add_batch_rows("frame/shared/" + way, [=] {
      static const std::vector<Surface> surfaces = ten_shapes(1.0);
      static const std::vector<Model> models = models_of(surfaces);
      return in_turn(surfaces, models, spins);
    });
    add_batch_rows("frame/unique/" + way, [=] {
      static const std::vector<Surface> surfaces = unique_shapes();  // both ways share them: they are two gigabytes
      static const std::vector<Model> models = models_of(surfaces);
      return in_turn(surfaces, models, spins);
    });
  }

  // One mesh alone, shared out by triangles.
  add_batch_rows("one/ball-1002528", [] {
    static const Model best = model_for(body("ball-1002528").surface);
    return std::vector<BodyInFlow>{{&body("ball-1002528").surface, &best, motion("straight")}};
  });

  for (const int threads : {1, 2})
    add_row("batch/steps/box-12/threads:" + std::to_string(threads),
            [=](benchmark::State& state) {
              const FreeBox box;
              std::vector<FreeBody> bodies;
              const Vector6d weight = (Vector6d() << 0, 0, -9.81 * box.mass.mass, 0, 0, 0).finished();
              for (int k = 0; k < frame_bodies; ++k) bodies.push_back({&box.surface, &box.model, &box.mass, motion_of(k, true), weight});
              std::vector<Vector6d> velocities(bodies.size());
              tbb::task_arena arena(threads);
              for (auto _ : state) arena.execute([&] { step_free_bodies(bodies, {}, 1.0 / 60, velocities); });
              count(state, static_cast<double>(bodies.size()), "per_body");
              Hash hash;
              for (const Vector6d& V : velocities) hash.add(V);
              state.SetLabel(hash.text());
              for (std::size_t k = 0; k < bodies.size(); k += 997) {
                Motion motion = bodies[k].motion;
                motion.angular_velocity = gyroscopic_spin(box.mass, motion.angular_velocity, 1.0 / 60);
                const Vector6d alone =
                    step_secant_implicit(resistance(box.surface, motion, {}, box.model), box.mass, motion, weight, 1.0 / 60);
                // Velocities of order ten, of forces within 1e-6: light bodies are as fast as the air says.
                if (!((velocities[k] - alone).norm() <= 1e-4 * alone.norm())) wrong(state, "a body of the batch moves otherwise by itself");
              }
            })
        ->UseRealTime()
        ->Unit(benchmark::kMicrosecond);
}

}  // namespace dragcore::bench
