#include "kernels/part_flow.hpp"

#include <algorithm>
#include <cmath>

#include "drag/viscous.hpp"

namespace dragcore::kernels {

using Eigen::Vector3d;

namespace {

std::array<float, 5> single(const Law::Polynomial& p) {
  std::array<float, 5> result;
  std::transform(p.begin(), p.end(), result.begin(), [](double x) { return static_cast<float>(x); });
  return result;
}

}  // namespace

ResolvedLaw resolved(const BodyLaw& law, const ActiveEffects& active, const PackedSurface::Part& part, double pillow_factor) {
  ResolvedLaw result;
  result.windward_polynomial = single(law.law().windward);
  result.leeward = active.has<Effect::leeward_suction>();
  result.leeward_polynomial = single(law.law().leeward);
  result.base_suction = static_cast<float>(law.base_suction());
  result.base = result.base_suction > 0.0f;
  result.base_edge = static_cast<float>(law.law().base_edge);
  result.shelter_rate = static_cast<float>(law.shelter_rate());
  result.shelter = result.shelter_rate > 0.0f;
  if (result.shelter) result.per_sharpness = static_cast<float>(1.0 / law.sharpness());
  result.curvature = active.has<Effect::curvature>() && part.curved;
  result.curvature_suction = static_cast<float>(law.law().curvature);
  result.push = static_cast<float>(law.push());
  result.recovery = result.push > 0.0f;
  result.recovery_edge = static_cast<float>(law.law().recovery_edge);
  result.skin_friction = static_cast<float>(law.friction());
  result.friction = result.skin_friction > 0.0f;
  result.layer = static_cast<float>(law.layer_scale());
  result.viscous = result.layer > 0.0f;
  result.layer_curvature = static_cast<float>(law.law().layer_curvature);
  result.pillow_factor = static_cast<float>(pillow_factor);
  result.pillow = result.pillow_factor > 0.0f;
  return result;
}

bool know(const Surface& surface, const Model& model) {
  return model.precision == Precision::single && surface.packed && surface.packed->parts.size() == surface.parts.size() &&
         surface.packed->by_triangle == (surface.exposure != nullptr) && FoldedModel::of(model).single;
}

BodyFlow::BodyFlow(const Surface& surface, const Motion& motion, const Medium& medium, const Model& model)
    : surface_(surface), motion_(motion), medium_(medium), model_(model), flow_(surface, motion, ActiveEffects(motion, model)) {}

Descriptors BodyFlow::described(std::size_t p, const Vector3d& direction, const Law& law, const ActiveEffects& active) {
  const PackedSurface& packed = *surface_.packed;
  const Part& part = surface_.parts[p];
  const bool slender = active.has<Effect::base_suction>() && law.aspect_gain != 0.0;
  if (!surface_.exposure && !slender) {
    const Seen found = seen(packed, p, direction.cast<float>(), part.two_sided);
    const double area = packed.parts[p].area;
    return descriptors_of({.frontal = area * found.frontal, .whole = area * found.frontal, .sharp = area * found.sharp}, part);
  }
  if (surface_.exposure) {
    const Exposure::Sample sample = surface_.exposure->towards(-direction);
    facets_reached_.resize(packed.facets.triangle.size(), 1.0);
    for (std::size_t slot = packed.parts[p].facets.first; slot < packed.parts[p].facets.last; ++slot)
      if (packed.facets.triangle[slot] >= 0) facets_reached_[slot] = surface_.exposure->share(packed.facets.triangle[slot], sample);
  }
  return descriptors_of(silhouette(packed, p, direction, part.two_sided, surface_.exposure ? facets_reached_.data() : nullptr), part,
                        direction);
}

bool BodyFlow::of(std::size_t p, PartFlow& result) {
  const PackedSurface& packed = *surface_.packed;
  const Part& part = surface_.parts[p];
  const PackedSurface::Part& packed_part = packed.parts[p];
  result.area = packed_part.area, result.size = packed_part.size, result.arm = packed_part.origin - motion_.reference_point;
  // The same velocities as the kernels take them: a flow at the origin, its gradient, and the winds of triangles in place of the first.
  const Vector3d centre_flow = flow_.at_centre(p);
  const double directed = flow_.directed(p), travel = centre_flow.norm();
  double speed = travel + flow_.variation_per_metre() * result.size;
  if (flow_.varies_by_triangle())
    for (std::size_t slot = packed_part.groups.first * lanes; slot < packed_part.groups.last * lanes; ++slot)
      if (packed.triangle[slot] >= 0) speed = std::max(speed, flow_.at(packed_part.origin, packed.triangle[slot]).norm());
  result.speed = speed;
  if (speed == 0.0) return true;
  if (!(speed < 1e140)) return false;  // its square, times an area, must be a number
  result.to_newton = 0.5 * medium_.density * speed * speed * result.area;
  result.relative = centre_flow / speed;

  const Law& law = model_.law_of(part.body_class);
  const ActiveEffects active(motion_, model_, law, model_.pillow_of(part.body_class), medium_);
  double kappa = 0.0, layer = 0.0;
  if (active.has<Effect::pillow>()) kappa = model_.pillow_of(part.body_class).factor;
  if (active.has<Effect::viscous>()) {
    if (kappa > 0.0) kappa = pillow_at(model_.pillow_of(part.body_class), part, travel, medium_, active).factor;
    layer = layer_scale(law, part, medium_, active) / std::sqrt(speed);
  }
  const Vector3d direction = travel > 0.0 ? Vector3d(centre_flow / travel) : Vector3d::Zero();
  Descriptors body;
  if (travel > 0.0 && BodyLaw::needs_descriptors(law, active)) body = described(p, direction, law, active);
  PartTask& task = result.task;
  task.surface = &packed, task.part = p;
  task.law = resolved(BodyLaw(law, body, directed, active, layer), active, packed_part, kappa * directed);
  task.flow = result.relative.cast<float>();
  task.gradient = (result.size / speed * flow_.gradient()).cast<float>();
  task.varies = flow_.varies() || task.law.viscous;
  task.direction = direction.cast<float>();
  task.variation = static_cast<float>(flow_.variation_per_metre() * result.size / speed);
  task.quadrature = flow_.varies_on_triangles() ? model_.quadrature : Quadrature::one;
  task.wind = nullptr;
  if (flow_.varies_by_triangle()) {
    if (winds_.size() == 0) winds_ = Aligned<GroupWind>(packed.groups.size());
    for (std::size_t slot = packed_part.groups.first * lanes; slot < packed_part.groups.last * lanes; ++slot)
      if (packed.triangle[slot] >= 0) {
        const Vector3d wind = flow_.at(packed_part.origin, packed.triangle[slot]) / speed;
        for (std::size_t axis = 0; axis < 3; ++axis)
          winds_[slot / lanes].velocity[axis][slot % lanes] = static_cast<float>(wind[static_cast<Eigen::Index>(axis)]);
      }
    task.wind = &winds_.data()->velocity;
  }
  task.reached = nullptr;
  if (surface_.exposure && directed > 0.0) {
    const Exposure::Sample sample = surface_.exposure->towards(-centre_flow);
    reached_.resize(packed.triangle.size(), 1.0f);
    for (std::size_t slot = packed_part.groups.first * lanes; slot < packed_part.groups.last * lanes; ++slot)
      if (packed.triangle[slot] >= 0)
        reached_[slot] = static_cast<float>(1.0 - directed * (1.0 - surface_.exposure->share(packed.triangle[slot], sample)));
    task.reached = reached_.data();
  }
  return true;
}

}  // namespace dragcore::kernels
