#pragma once

#include <dragcore/drag.hpp>
#include <vector>

#include "drag/body_law.hpp"
#include "drag/folded_model.hpp"
#include "kernels/wrench_kernel.hpp"

namespace dragcore::kernels {

/// Whether the kernels can do this model on this surface: one that asks for single precision, whose laws and pillows they have, packed as
/// the surface is now.
bool know(const Surface& surface, const Model& model);

/// Terms that push the body through the air; all others hold it back.
inline bool pushes(Term term) { return term == Term::curvature || term == Term::rear_recovery; }

/// @param pillow_factor  kappa, faded; 0: no pillow
ResolvedLaw resolved(const BodyLaw& law, const ActiveEffects& active, const PackedSurface::Part& part, double pillow_factor);

/// What the kernels need of one part in one motion, and the way back to newtons.
struct PartFlow {
  PartTask task{};
  double speed = 0.0;                                  ///< that velocities are in units of; 0: nothing moves [m/s]
  double area = 1.0, size = 1.0;                       ///< of the part [m^2], [m]
  Eigen::Vector3d arm = Eigen::Vector3d::Zero();       ///< from the reference point to the part's origin [m]
  Eigen::Vector3d relative = Eigen::Vector3d::Zero();  ///< flow at the origin, in units of `speed`
  double to_newton = 0.0;                              ///< density/2 speed^2 area

  /// @param force, torque  about the origin, in the kernels' units
  Wrench in_newton(const Eigen::Vector3d& force, const Eigen::Vector3d& torque) const {
    const Eigen::Vector3d f = to_newton * force;
    return {f, to_newton * size * torque + arm.cross(f)};
  }
};

/// A body in one motion.
class BodyFlow {
 public:
  BodyFlow(const Surface& surface, const Motion& motion, const Medium& medium, const Model& model);

  /// Valid until the next call. @return  false where the speeds are beyond single precision
  bool of(std::size_t part, PartFlow& result);
  bool varies() const { return flow_.varies(); }

 private:
  Descriptors described(std::size_t part, const Eigen::Vector3d& direction, const Law& law, const ActiveEffects& active);
  void add_winds(PartFlow& part, std::size_t index, double base_speed, const Eigen::Vector3d& base);

  struct GroupWind {
    Row velocity[3];
  };
  const Surface& surface_;
  const Motion& motion_;
  const Medium& medium_;
  const Model& model_;
  RelativeFlow flow_;
  std::vector<float> reached_;          // of every lane
  std::vector<double> facets_reached_;  // of every facet
  Aligned<GroupWind> winds_;
};

}  // namespace dragcore::kernels
