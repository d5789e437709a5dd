#include "kernels/instances.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "drag/corrected_flow.hpp"
#include "drag/viscous.hpp"
#include "kernels/instance_kernel.hpp"
#include "kernels/part_flow.hpp"

namespace dragcore::kernels {

using Eigen::Vector3d;

namespace {

static_assert(instances == lanes);

/// Up to here sixteen bodies at once are faster than sixteen triangles at once.
constexpr std::size_t small_shape = 128 / lanes;

const ActiveEffects at_rest(const Surface& surface, const Model& model, const Medium& medium = {}) {
  const BodyClass body_class = surface.parts[0].body_class;
  return ActiveEffects(Motion{}, model, model.law_of(body_class), model.pillow_of(body_class), medium);
}

InstanceTask task_of(const Surface& surface, const Medium& medium, const Model& model, Quadrature quadrature) {
  const PackedSurface::Part& packed = surface.packed->parts[0];
  const Part& part = surface.parts[0];
  const Law& law = model.law_of(part.body_class);
  const ActiveEffects active = at_rest(surface, model, medium);
  InstanceTask task{.surface = surface.packed.get(), .quadrature = quadrature};
  const Pillow& pillow = model.pillow_of(part.body_class);
  const double layer = layer_scale(law, part, medium, active);
  task.law = resolved(BodyLaw(law, Descriptors{}, 1.0, active, layer), active, packed, active.has<Effect::pillow>() ? pillow.factor : 0.0);
  if (active.has<Effect::viscous>() && pillow.viscous_gain > 0.0)
    task.pillow_gain = static_cast<float>(pillow.viscous_gain / std::sqrt(reynolds(part, 1.0, medium)));
  // Worked out for every body by itself.
  task.law.shelter = active.has<Effect::shelter>();
  task.law.recovery = active.has<Effect::recovery>() && part.volume > 0.0;
  task.described = task.law.shelter || task.law.recovery;
  task.whole_silhouette = part.two_sided;
  task.shelter = static_cast<float>(law.shelter);
  task.recovery = static_cast<float>(law.base_suction * law.recovery), task.recovery_depth = static_cast<float>(law.recovery_depth);
  task.size = static_cast<float>(packed.size);
  task.volume = static_cast<float>(part.volume / (packed.area * std::sqrt(packed.area)));
  return task;
}

/// Which of the effects of motion a model feels.
struct Felt {
  bool spin, wind;
  explicit Felt(const Model& model)
      : spin(model.effects.has(Effect::spin) && instrument::built(Effect::spin)),
        wind(model.effects.has(Effect::wind_variation) && instrument::built(Effect::wind_variation)) {}
};

void set(Row (&rows)[3], std::size_t lane, const Vector3d& v) {
  for (std::size_t axis = 0; axis < 3; ++axis) rows[axis][lane] = static_cast<float>(v[static_cast<Eigen::Index>(axis)]);
}

/// @param motions  zero at first; @param vary  the gradient may count, too  @return  whether the motion is one that lanes can do
bool set(InstanceMotions& motions, std::size_t lane, const Motion& motion, const Felt& felt, bool vary, const Vector3d& origin) {
  set(motions.flow, lane, motion.wind - motion.velocity);
  set(motions.arm, lane, origin - motion.reference_point);
  if (vary && felt.spin) set(motions.spin, lane, motion.angular_velocity);
  if (vary && felt.wind)
    for (std::size_t i = 0; i < 9; ++i)
      motions.gradient[i][lane] =
          static_cast<float>(motion.wind_gradient(static_cast<Eigen::Index>(i / 3), static_cast<Eigen::Index>(i % 3)));
  // What is not felt must be numbers all the same.
  return (felt.spin || motion.angular_velocity.allFinite()) &&
         (felt.wind ? motion.triangle_wind.empty() : motion.wind_gradient.allFinite());
}

/// What is viscous is put in units of the density here.
bool in_range(const Medium& medium) {
  return medium.density >= 0.0 && medium.density < 1e100 && medium.viscosity >= 0.0 && medium.viscosity < 1e100 &&
         (medium.viscosity == 0.0 || medium.density > 0.0);
}

constexpr unsigned all_of(std::size_t count) { return (1u << count) - 1u; }

}  // namespace

bool varies(const Motion& motion) {
  return motion.angular_velocity.cwiseAbs().sum() + motion.wind_gradient.cwiseAbs().sum() != 0.0;  // without a branch; of NaN, too
}

bool instanced(const Surface& surface, const Model& model) {
  if (!know(surface, model) || surface.parts.size() != 1 || surface.exposure || is_corrected(model) ||
      model.quadrature == Quadrature::adaptive)
    return false;
  if (surface.packed->groups.size() > small_shape || (model.check && !FoldedModel::of(model).valid)) return false;
  return !(at_rest(surface, model).has<Effect::base_suction>() && model.law_of(surface.parts[0].body_class).aspect_gain != 0.0);
}

unsigned wrenches_of(std::span<const BodyInFlow* const> bodies, const Medium& medium, std::span<Wrench* const> results) {
  if (!in_range(medium)) return all_of(bodies.size());
  const Surface& surface = *bodies[0]->surface;
  const Model& model = *bodies[0]->model;
  const PackedSurface::Part& part = surface.packed->parts[0];
  const Felt felt(model);
  const bool vary = varies(bodies[0]->motion) && (felt.spin || felt.wind);
  InstanceMotions motions{};
  unsigned left = 0;
  for (std::size_t lane = 0; lane < bodies.size(); ++lane)
    left |= set(motions, lane, bodies[lane]->motion, felt, vary, part.origin) ? 0u : 1u << lane;
  const InstanceTask task = task_of(surface, medium, model, vary ? model.quadrature : Quadrature::one);
  // Creeping flow: exact, and in double.
  std::array<Wrench, instances> creeping{};
  for (std::size_t lane = 0; medium.viscosity > 0.0 && lane < bodies.size(); ++lane)
    for_each_creeping_flow(surface, bodies[lane]->motion, medium, model, [&](const dragcore::Part& whole, const CreepingFlow& flow) {
      creeping[lane] = flow.wrench(whole);
      motions.creeping_power[lane] = static_cast<float>(flow.power(whole) / (0.5 * medium.density * part.area));
    });
  InstanceWrenches found;
  instance_wrenches(task, motions, vary || task.law.viscous, found);
  for (std::size_t lane = 0; lane < bodies.size(); ++lane) {
    const double speed = found.speed[lane], to_newton = 0.5 * medium.density * speed * speed * part.area;
    Wrench& result = *results[lane];
    result.force = to_newton * Vector3d(found.force[0][lane], found.force[1][lane], found.force[2][lane]);
    result.torque = to_newton * part.size * Vector3d(found.torque[0][lane], found.torque[1][lane], found.torque[2][lane]);
    result += creeping[lane];
    if (const double size = result.force.cwiseAbs().sum() + result.torque.cwiseAbs().sum(); !(speed > 0.0 && size < 1e300))
      left |= 1u << lane;
  }
  return left;
}

unsigned steps_of(std::span<const FreeBody* const> bodies, const Medium& medium, double dt, std::span<Vector6d* const> velocities) {
  if (!in_range(medium) || !(dt >= 0.0) || !std::isfinite(dt)) return all_of(bodies.size());
  const Surface& surface = *bodies[0]->surface;
  const Model& model = *bodies[0]->model;
  const PackedSurface::Part& part = surface.packed->parts[0];
  const Felt felt(model);
  InstanceMotions motions{};
  InstanceSteps steps{.dt = dt, .half_density = 0.5 * medium.density, .area = part.area, .turns = felt.spin};
  unsigned left = 0;
  constexpr Eigen::Index row[6] = {0, 0, 0, 1, 1, 2}, column[6] = {0, 1, 2, 1, 2, 2};
  for (std::size_t lane = 0; lane < lanes; ++lane) {
    const FreeBody& body = *bodies[std::min(lane, bodies.size() - 1)];  // what fills up is no worse than its neighbour
    const Motion& motion = body.motion;
    const MassProperties& mass = *body.mass;
    const bool simple = set(motions, lane, motion, felt, false, part.origin) && motion.wind_gradient.isZero(0.0) &&
                        mass.added.isZero(0.0) &&
                        (mass.inertia - mass.inertia.transpose()).cwiseAbs().maxCoeff() <= 1e-9 * mass.inertia.trace();
    if (!simple && lane < bodies.size()) left |= 1u << lane;
    steps.mass[lane] = mass.mass;
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      steps.velocity[axis][lane] = motion.velocity[axis] - motion.wind[axis];
      steps.spin[axis][lane] = motion.angular_velocity[axis];
    }
    for (std::size_t k = 0; k < 6; ++k) {
      steps.inertia[k][lane] = mass.inertia(row[k], column[k]);
      steps.external[k][lane] = body.external[static_cast<Eigen::Index>(k)];
    }
  }
  for_each_creeping_flow(surface, {.reference_point = part.origin}, medium, model, [&](const dragcore::Part& whole, const CreepingFlow& flow) {
    Eigen::Map<Eigen::Matrix<double, 6, 6>>(steps.creeping[0]) = flow.matrix(whole);  // symmetric: rows are columns
  });
  instance_steps(task_of(surface, medium, model, felt.spin ? model.quadrature : Quadrature::one), motions, steps);
  for (std::size_t lane = 0; lane < bodies.size(); ++lane) {
    Vector6d& velocity = *velocities[lane];
    for (Eigen::Index k = 0; k < 6; ++k) velocity[k] = steps.result[k][lane];
    velocity.head<3>() += bodies[lane]->motion.wind;
    if (!(steps.sound[lane] > 0.0) || !velocity.allFinite()) left |= 1u << lane;
  }
  return left;
}

}  // namespace dragcore::kernels
