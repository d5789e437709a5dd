#include <array>
#include <dragcore/batch.hpp>
#include <exception>
#include <map>
#include <mutex>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

#include "kernels/instances.hpp"
#include "support/for_each_index.hpp"
#include "support/require.hpp"

namespace dragcore {

namespace {

/// The first of what went wrong, by the body's number, whatever the order in which threads come upon it.
class FirstError {
 public:
  template <class Work>
  void guard(std::size_t body, const Work& work) {
    try {
      work();
    } catch (...) {
      const std::lock_guard lock(mutex_);
      if (!error_ || body < body_) error_ = std::current_exception(), body_ = body;
    }
  }
  /// Says which body it was.
  void rethrow() const {
    if (!error_) return;
    const auto named = [&](const std::exception& error) { return "body " + std::to_string(body_) + " of the batch: " + error.what(); };
    try {
      std::rethrow_exception(error_);
    } catch (const std::invalid_argument& error) {
      throw std::invalid_argument(named(error));
    } catch (const std::overflow_error& error) {
      throw std::overflow_error(named(error));
    }
  }

 private:
  std::mutex mutex_;
  std::exception_ptr error_;
  std::size_t body_ = 0;
};

/// Bodies that go together: of one shape and model, and where the flow varies over all of them or none.
struct Pack {
  std::size_t count = 0;
  std::array<std::size_t, kernels::instances> body;
};

template <class Body>
std::vector<Pack> packs(std::span<const Body> bodies) {
  std::vector<Pack> result;
  struct Open {
    std::size_t capacity, pack;
  };
  std::map<std::tuple<const Surface*, const Model*, bool>, Open> open;
  auto latest = open.end();
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const std::tuple key{bodies[i].surface, bodies[i].model, kernels::varies(bodies[i].motion)};
    bool fresh = false;
    if (latest == open.end() || latest->first != key) {
      std::tie(latest, fresh) = open.try_emplace(key);
      if (fresh) latest->second.capacity = kernels::instanced(*bodies[i].surface, *bodies[i].model) ? kernels::instances : 1;
    }
    Open& entry = latest->second;
    if (fresh || result[entry.pack].count == entry.capacity) entry.pack = result.size(), result.emplace_back();
    Pack& pack = result[entry.pack];
    pack.body[pack.count++] = i;
  }
  return result;
}

/// Calls together(bodies, results), which says by bits what it has left, for the packs that are instances, and alone(body, result) for the
/// rest.
template <class Body, class Result, class Together, class Alone>
void for_each_body(const char* name, std::span<const Body> bodies, std::span<Result> results, const Together& together,
                   const Alone& alone) {
  require(bodies.size() == results.size(), name, results.size(), [&] { return "there are " + std::to_string(bodies.size()) + " bodies"; });
  const std::vector<Pack> all = packs(bodies);
  FirstError error;
  for_each_index(all.size(), 4, [&](std::size_t k) {
    const Pack& pack = all[k];
    unsigned left = 1;
    if (pack.count > 1) {
      std::array<const Body*, kernels::instances> given{};
      std::array<Result*, kernels::instances> found{};
      for (std::size_t lane = 0; lane < pack.count; ++lane) given[lane] = &bodies[pack.body[lane]], found[lane] = &results[pack.body[lane]];
      left = together(std::span<const Body* const>(given.data(), pack.count), std::span<Result* const>(found.data(), pack.count));
    }
    for (std::size_t lane = 0; left != 0; left >>= 1, ++lane)
      if (left & 1u) error.guard(pack.body[lane], [&] { alone(bodies[pack.body[lane]], results[pack.body[lane]]); });
  });
  error.rethrow();
}

}  // namespace

void wrenches(std::span<const BodyInFlow> bodies, const Medium& medium, std::span<Wrench> results) {
  for_each_body(
      "wrenches: results", bodies, results,
      [&](std::span<const BodyInFlow* const> pack, std::span<Wrench* const> found) { return kernels::wrenches_of(pack, medium, found); },
      [&](const BodyInFlow& body, Wrench& result) { result = wrench(*body.surface, body.motion, medium, *body.model).total(); });
}

void step_free_bodies(std::span<const FreeBody> bodies, const Medium& medium, double dt, std::span<Vector6d> velocities) {
  for_each_body(
      "step_free_bodies: velocities", bodies, velocities,
      [&](std::span<const FreeBody* const> pack, std::span<Vector6d* const> found) { return kernels::steps_of(pack, medium, dt, found); },
      [&](const FreeBody& body, Vector6d& velocity) {
        Motion motion = body.motion;
        motion.angular_velocity = gyroscopic_spin(*body.mass, motion.angular_velocity, dt);
        const Matrix6d s = resistance(*body.surface, motion, medium, *body.model);
        Vector6d external = body.external;
        if (!motion.triangle_wind.empty() || !motion.wind_gradient.isZero(0.0))
          external += wind_excess(wrench(*body.surface, motion, medium, *body.model).total(), s, motion);
        velocity = step_secant_implicit(s, *body.mass, motion, external, dt);
      });
}

}  // namespace dragcore
