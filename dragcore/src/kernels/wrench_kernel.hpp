#pragma once

#include <array>
#include <dragcore/wrench.hpp>
#include <string>
#include <vector>

#include "drag/quadrature.hpp"
#include "drag/silhouette.hpp"
#include "kernels/packed_surface.hpp"

namespace dragcore::kernels {

/// The law as one part feels it in one flow: whatever depends on the body, the direction or the class is in these numbers already, so that
/// the loop over triangles sees polynomials and scalars alone. A term whose flag is off costs nothing: it is a pass that is not made.
struct ResolvedLaw {
  bool base = false, shelter = false, curvature = false, leeward = false, recovery = false, friction = false;
  std::array<float, 5> windward_polynomial{}, leeward_polynomial{};
  float base_suction = 0.0f, base_edge = 1.0f;  ///< B h
  float shelter_rate = 0.0f, per_sharpness = 0.0f;
  float curvature_suction = 0.0f;
  float push = 0.0f, recovery_edge = 1.0f;  ///< B R lambda/(lambda + lambda_0), faded
  float skin_friction = 0.0f;
};

/// One part of a surface in one flow. Velocities in units of one speed.
struct PartTask {
  std::size_t part = 0;
  ResolvedLaw law{};
  Eigen::Vector3f flow = Eigen::Vector3f::Zero();       ///< of the air relative to the body, at the packed surface's origin
  Eigen::Matrix3f gradient = Eigen::Matrix3f::Zero();   ///< of that flow, per unit of length
  bool varies = false;                                  ///< the gradient counts, or the winds
  const std::array<Aligned<float>, 3>* wind = nullptr;  ///< of every slot, to be added to the flow; null where there are none
  Eigen::Vector3f direction = Eigen::Vector3f::Zero();  ///< unit: of the flow at the part's centre
  float pillow = 0.0f;                                  ///< kappa of the tilt form, faded; 0: no pillow
  const float* reached = nullptr;                       ///< share that the wind reaches, of every slot; null where it reaches all
  float variation = 0.0f;                               ///< of the flow per unit of length: adaptive quadrature goes by it
  Quadrature quadrature = Quadrature::one;
};

/// Sums over a part, of every term: force, torque about the origin, and power. In units of density/2 speed^2 area, times length, times
/// speed.
using TermSums = std::array<std::array<double, 7>, static_cast<std::size_t>(Term::count)>;
void add_part(const PackedSurface& surface, const PartTask& task, TermSums& sums);

/// Sums over the facets of a part that meet a flow along `direction`, in the surface's units.
/// @param reached  share that the flow reaches, of every facet; null where it reaches all
SilhouetteSums silhouette(const PackedSurface& surface, PackedSurface::Range facets, const Eigen::Vector3d& direction, bool two_sided,
                          const double* reached);

/// Instruction sets that this machine has and the kernels were built for, best first; and a way for tests and benchmarks to force one.
std::vector<std::string> targets();
/// @param name  one of targets(); empty: the best again
void force_target(const std::string& name);

}  // namespace dragcore::kernels
