#include "drag/fast_wrench.hpp"

#include <algorithm>
#include <cmath>

#include "drag/energy_balance.hpp"
#include "kernels/wrench_kernel.hpp"

namespace dragcore {

using Eigen::Vector3d;
using kernels::PackedSurface;
using kernels::PartTask;

namespace {

/// Whether a polynomial is never negative from 0 to 1, by its Bernstein coefficients: enough of a reason, though not the only one.
bool never_negative(const Law::Polynomial& p) {
  static constexpr double share[5][5] = {
      {1, 0, 0, 0, 0}, {1, 1.0 / 4, 0, 0, 0}, {1, 2.0 / 4, 1.0 / 6, 0, 0}, {1, 3.0 / 4, 3.0 / 6, 1.0 / 4, 0}, {1, 1, 1, 1, 1}};
  for (const auto& row : share) {
    double sum = 0.0;
    for (std::size_t k = 0; k < p.size(); ++k) sum += row[k] * p[k];
    if (sum < 0.0) return false;
  }
  return true;
}

/// Whether a law's numbers are numbers in single precision: what is checked may be beyond it, what is not may be none.
bool fits(const Law& law) {
  const auto usable = [](double x) { return std::abs(x) < 1e30; };
  const auto divides = [](double x) { return x > 1e-30 && x < 1e30; };
  return std::all_of(law.windward.begin(), law.windward.end(), usable) && std::all_of(law.leeward.begin(), law.leeward.end(), usable) &&
         usable(law.friction) && usable(law.base_suction) && usable(law.shelter) && usable(law.curvature) && divides(law.base_edge) &&
         divides(law.recovery_edge);
}

std::array<float, 5> single(const Law::Polynomial& p) {
  std::array<float, 5> result;
  std::transform(p.begin(), p.end(), result.begin(), [](double x) { return static_cast<float>(x); });
  return result;
}

kernels::ResolvedLaw resolved(const BodyLaw& law, const ActiveEffects& active) {
  kernels::ResolvedLaw result;
  result.windward_polynomial = single(law.law().windward);
  result.leeward = active.has<Effect::leeward_suction>();
  result.leeward_polynomial = single(law.law().leeward);
  result.base_suction = static_cast<float>(law.base_suction());
  result.base = result.base_suction > 0.0f;
  result.base_edge = static_cast<float>(law.law().base_edge);
  result.shelter_rate = static_cast<float>(law.shelter_rate());
  result.shelter = result.shelter_rate > 0.0f;
  if (result.shelter) result.per_sharpness = static_cast<float>(1.0 / law.sharpness());
  result.curvature = active.has<Effect::curvature>();
  result.curvature_suction = static_cast<float>(law.law().curvature);
  result.push = static_cast<float>(law.push());
  result.recovery = result.push > 0.0f;
  result.recovery_edge = static_cast<float>(law.law().recovery_edge);
  result.skin_friction = static_cast<float>(law.friction());
  result.friction = result.skin_friction > 0.0f;
  return result;
}

/// Winds by triangle as what they differ by from `base`, in units of `speed`, in the packed order.
std::array<kernels::Aligned<float>, 3> packed_winds(const PackedSurface& packed, std::span<const Vector3d> winds, const Vector3d& base,
                                                    double speed) {
  std::array<kernels::Aligned<float>, 3> result;
  for (auto& axis : result) axis = kernels::Aligned<float>(packed.triangle.size());
  for (std::size_t slot = 0; slot < packed.triangle.size(); ++slot)
    if (packed.triangle[slot] >= 0) {
      const Vector3d wind = (winds[static_cast<std::size_t>(packed.triangle[slot])] - base) / speed;
      for (std::size_t axis = 0; axis < 3; ++axis) result[axis][slot] = static_cast<float>(wind[static_cast<Eigen::Index>(axis)]);
    }
  return result;
}

}  // namespace

std::optional<WrenchByTerm> fast_wrench(const Surface& surface, const Motion& motion, const Medium& medium, const Model& model) {
  if (model.precision != Precision::single || !surface.packed) return std::nullopt;
  const PackedSurface& packed = *surface.packed;
  // Somebody changed the surface since it was packed.
  if (packed.part.size() != surface.parts.size() || packed.by_triangle != (surface.exposure != nullptr)) return std::nullopt;
  const ActiveEffects moving(motion, model);
  const RelativeFlow flow(surface, motion, moving);

  // Of the same velocities as the kernel takes them: a flow at the origin, its gradient, and what the wind differs by.
  Vector3d origin_flow;
  double speed = 0.0;
  Vector3d base_wind = Vector3d::Zero();
  if (flow.varies_by_triangle()) {
    for (std::size_t i = 0; i < motion.triangle_wind.size(); ++i)
      base_wind += surface.area[static_cast<Eigen::Index>(i)] * motion.triangle_wind[i];
    base_wind /= packed.area;
    for (const Vector3d& wind : motion.triangle_wind) speed = std::max(speed, (wind - base_wind).norm());
    origin_flow = base_wind - motion.velocity + flow.gradient() * (packed.origin - motion.reference_point);
  } else {
    origin_flow = flow.at(packed.origin, 0);
  }
  const Eigen::Matrix3d gradient = packed.size * flow.gradient();
  speed += origin_flow.norm() + flow.variation_per_metre() * packed.size;
  if (speed == 0.0) return WrenchByTerm{};
  if (!std::isfinite(speed)) return std::nullopt;

  std::array<kernels::Aligned<float>, 3> winds;
  if (flow.varies_by_triangle()) winds = packed_winds(packed, motion.triangle_wind, base_wind, speed);
  kernels::TermSums sums{};
  std::vector<float> reached;
  std::vector<double> facets_reached;
  for (std::size_t p = 0; p < surface.parts.size(); ++p) {
    const Part& part = surface.parts[p];
    const Law& law = model.law_of(part.body_class);
    const Pillow& pillow = model.pillow_of(part.body_class);
    const ActiveEffects active(motion, model, law, pillow);
    if (active.has<Effect::pillow>() && pillow.form != PillowForm::tilt) return std::nullopt;
    if (!fits(law)) return std::nullopt;
    if (!never_negative(law.windward) || (active.has<Effect::leeward_suction>() && !never_negative(law.leeward))) return std::nullopt;
    const Vector3d centre_flow = flow.at_centre(p);
    const double directed = flow.directed(p), travel = centre_flow.norm();
    PartTask task{.part = p};
    if (travel > 0.0) task.direction = (centre_flow / travel).cast<float>();

    const Exposure* exposure = directed > 0.0 ? surface.exposure.get() : nullptr;
    Exposure::Sample sample;
    if (exposure) {
      sample = exposure->towards(-centre_flow);
      reached.resize(packed.triangle.size(), 1.0f);
      for (std::size_t slot = packed.part[p].first; slot < packed.part[p].last; ++slot)
        if (packed.triangle[slot] >= 0)
          reached[slot] = static_cast<float>(1.0 - directed * (1.0 - exposure->share(packed.triangle[slot], sample)));
      task.reached = reached.data();
    }
    Descriptors body;
    if (travel > 0.0 && BodyLaw::needs_descriptors(law, active)) {
      if (exposure) {
        facets_reached.resize(packed.facets.triangle.size(), 1.0);
        for (std::size_t slot = packed.facets.part[p].first; slot < packed.facets.part[p].last; ++slot)
          if (packed.facets.triangle[slot] >= 0) facets_reached[slot] = exposure->share(packed.facets.triangle[slot], sample);
      }
      const Vector3d direction = centre_flow / travel;
      body = descriptors_of(
          kernels::silhouette(packed, packed.facets.part[p], direction, part.two_sided, exposure ? facets_reached.data() : nullptr), part,
          direction);
    }
    task.law = resolved(BodyLaw(law, body, directed, active), active);
    task.flow = (origin_flow / speed).cast<float>();
    task.gradient = (gradient / speed).cast<float>();
    task.varies = flow.varies();
    if (flow.varies_by_triangle()) task.wind = &winds;
    if (active.has<Effect::pillow>()) task.pillow = static_cast<float>(pillow.factor * directed);
    task.variation = static_cast<float>(flow.variation_per_metre() * packed.size / speed);
    task.quadrature = flow.varies_on_triangles() ? model.quadrature : Quadrature::one;
    kernels::add_part(packed, task, sums);
  }

  // Eq. 13. Curvature and rear recovery push, all else takes.
  EnergyBalance balance;
  const auto pushes = [](std::size_t term) {
    return term == static_cast<std::size_t>(Term::curvature) || term == static_cast<std::size_t>(Term::rear_recovery);
  };
  for (std::size_t term = 0; term < sums.size(); ++term)
    balance.add(pushes(term) ? 0.0 : sums[term][6], pushes(term) ? sums[term][6] : 0.0);
  const double gain = balance.gain_share();
  const double to_newton = 0.5 * medium.density * speed * speed * packed.area;
  const Vector3d arm = packed.origin - motion.reference_point;
  WrenchByTerm result;
  for (std::size_t term = 0; term < sums.size(); ++term) {
    const auto& sum = sums[term];
    const double scale = to_newton * (pushes(term) ? gain : 1.0);
    const Vector3d force = scale * Vector3d(sum[0], sum[1], sum[2]);
    result.terms[term] = {force, scale * packed.size * Vector3d(sum[3], sum[4], sum[5]) + arm.cross(force)};
  }
  return result;
}

}  // namespace dragcore
