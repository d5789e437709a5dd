#pragma once

#include <array>
#include <dragcore/wrench.hpp>
#include <span>
#include <string>
#include <vector>

#include "drag/quadrature.hpp"
#include "drag/silhouette.hpp"
#include "kernels/packed_surface.hpp"

namespace dragcore::kernels {

/// The law as one part feels it in one flow: whatever depends on the body, the direction or the class is in these numbers already, so that
/// the loop over triangles sees polynomials and scalars alone. A term whose flag is off is not in the code of the loop at all.
struct ResolvedLaw {
  bool base = false, shelter = false, curvature = false, leeward = false, recovery = false, friction = false, pillow = false, viscous = false;
  std::array<float, 5> windward_polynomial{}, leeward_polynomial{};
  float base_suction = 0.0f, base_edge = 1.0f;  ///< B h
  float shelter_rate = 0.0f, per_sharpness = 0.0f;
  float curvature_suction = 0.0f;
  float push = 0.0f, recovery_edge = 1.0f;  ///< B R lambda/(lambda + lambda_0), faded
  float skin_friction = 0.0f;
  float layer = 0.0f, layer_curvature = 0.0f;  ///< a/sqrt(Re_l) at the speed that velocities are in units of
  float pillow_factor = 0.0f;  ///< kappa of the tilt form, faded
};

/// A number of every triangle, or of none: rows of 16 at a stride.
struct Rows {
  const float* first = nullptr;
  std::size_t stride = 0;  ///< from the row of one group to that of the next
};

/// One part of a surface in one flow. Lengths in units of the part's size, areas of its area, velocities of one speed.
struct PartTask {
  const PackedSurface* surface = nullptr;
  std::size_t part = 0;
  ResolvedLaw law{};
  Eigen::Vector3f flow = Eigen::Vector3f::Zero();       ///< of the air relative to the body, at the part's origin
  Eigen::Matrix3f gradient = Eigen::Matrix3f::Zero();   ///< of that flow, per unit of length
  bool varies = false;                                  ///< the gradient counts, or the winds
  const Row (*wind)[3] = nullptr;                       ///< flow at the origin as each triangle has it, of every group of the surface
  Eigen::Vector3f direction = Eigen::Vector3f::Zero();  ///< unit: of the flow at the part's centre
  const float* reached = nullptr;                       ///< share that the wind reaches, of every lane of the surface; null: all
  float variation = 0.0f;                               ///< of the flow per unit of length: adaptive quadrature goes by it
  Quadrature quadrature = Quadrature::one;
};

/// Sums over a part, of every term: force, and torque about its origin. In units of density/2 speed^2 area, times length.
struct PartSums {
  std::array<std::array<double, 6>, static_cast<std::size_t>(Term::correction)> terms{};  // the last is no sum over triangles
  double taken = 0.0, given = 0.0;  ///< power of what holds the body back, and of what pushes it; times speed
};
PartSums part_sums(const PartTask& task);

/// What a flow along `direction` sees of a part, in units of its area: frontal area, and the same weighted by c^4. No shadows.
struct Seen {
  double frontal = 0.0, sharp = 0.0;
};
Seen seen(const PackedSurface& surface, std::size_t part, const Eigen::Vector3f& direction, bool two_sided);

/// Sums over the facets of a part that meet a flow along `direction`, in the surface's units.
/// @param reached  share that the flow reaches, of every facet; null where it reaches all
SilhouetteSums silhouette(const PackedSurface& surface, std::size_t part, const Eigen::Vector3d& direction, bool two_sided,
                          const double* reached);

/// Instruction sets that this machine has and the kernels were built for, best first; and a way for tests and benchmarks to force one.
std::vector<std::string> targets();
/// @param name  one of targets(); empty: the best again
void force_target(const std::string& name);

}  // namespace dragcore::kernels
