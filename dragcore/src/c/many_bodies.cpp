#include <deque>
#include <dragcore/batch.hpp>
#include <map>
#include <stdexcept>
#include <string>

#include "c/handles.hpp"

namespace dragcore::c {

namespace {

/// Models and bodies as C++ has them, one for each pointer: what shares one there shares one here.
template <class Given, class Made>
class Once {
 public:
  explicit Once(Made (*make)(const Given&)) : make_(make) {}
  const Made* operator()(const Given* given, const char* name) {
    require(given, name);
    if (given == latest_.first) return latest_.second;
    auto found = made_.find(given);
    if (found == made_.end()) found = made_.emplace(given, make_(*given)).first;
    latest_ = {given, &found->second};
    return latest_.second;
  }

 private:
  Made (*make_)(const Given&);
  std::map<const Given*, Made> made_;
  std::pair<const Given*, const Made*> latest_{};
};

template <class Body>
Motion motion_in(std::deque<MotionOf>& winds, const Body& body) {
  if (!body.motion.triangle_wind) return motion_of(body.motion);
  return winds.emplace_back(body.motion, body.surface->surface).motion;
}

/// Of all bodies.
template <class Body>
Medium medium_of_all(double density, const Body* bodies, size_t count) {
  for (size_t i = 1; i < count; ++i)
    if (bodies[i].motion.viscosity != bodies[0].motion.viscosity)
      throw std::invalid_argument("motion.viscosity of body " + std::to_string(i) + " = " + std::to_string(bodies[i].motion.viscosity) +
                                  ", but it must be that of body 0, " + std::to_string(bodies[0].motion.viscosity) +
                                  ": all bodies of a call are in one medium");
  return medium_of(density, bodies[0].motion);
}

}  // namespace

}  // namespace dragcore::c

using namespace dragcore::c;

extern "C" {

dragcore_status dragcore_evaluate_many(const dragcore_body_in_flow* bodies, size_t count, double density, dragcore_wrench* results) {
  return guarded([&] {
    if (count == 0) return;
    require(bodies, "bodies");
    require(results, "results");
    Once<dragcore_model, dragcore::Model> model(model_of);
    std::deque<MotionOf> winds;
    std::vector<dragcore::BodyInFlow> given(count);
    for (size_t i = 0; i < count; ++i) {
      require(bodies[i].surface, "surface");
      given[i] = {&bodies[i].surface->surface, model(bodies[i].model, "model"), motion_in(winds, bodies[i])};
    }
    std::vector<dragcore::Wrench> found(count);
    dragcore::wrenches(given, medium_of_all(density, bodies, count), found);
    for (size_t i = 0; i < count; ++i) copy(found[i].force, results[i].force), copy(found[i].torque, results[i].torque);
  });
}

dragcore_status dragcore_step_free_bodies(const dragcore_free_body* bodies, size_t count, double density, double dt, double* velocities) {
  return guarded([&] {
    if (count == 0) return;
    require(bodies, "bodies");
    require(velocities, "velocities");
    Once<dragcore_model, dragcore::Model> model(model_of);
    Once<dragcore_body, dragcore::MassProperties> mass([](const dragcore_body& body) { return body_of(body); });
    std::deque<MotionOf> winds;
    std::vector<dragcore::FreeBody> given(count);
    for (size_t i = 0; i < count; ++i) {
      require(bodies[i].surface, "surface");
      given[i] = {.surface = &bodies[i].surface->surface,
                  .model = model(bodies[i].model, "model"),
                  .mass = mass(bodies[i].body, "body"),
                  .motion = motion_in(winds, bodies[i])};
      given[i].external << vector(bodies[i].external.force), vector(bodies[i].external.torque);
    }
    std::vector<dragcore::Vector6d> found(count);
    dragcore::step_free_bodies(given, medium_of_all(density, bodies, count), dt, found);
    for (size_t i = 0; i < count; ++i) Eigen::Map<dragcore::Vector6d>{velocities + 6 * i} = found[i];
  });
}

}  // extern "C"
