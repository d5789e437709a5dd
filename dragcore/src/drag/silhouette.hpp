#pragma once

#include <Eigen/Core>
#include <dragcore/descriptors.hpp>

namespace dragcore {

/// Sums over the surface that meets a flow, weighted by area times c times what the flow reaches; places from the part's centre.
struct SilhouetteSums {
  double frontal = 0.0, whole = 0.0;  ///< whole: with no shadows [m^2]
  double sharp = 0.0;                 ///< with c^4 [m^2]
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
};

/// All but the aspect ratio.
Descriptors descriptors_of(const SilhouetteSums& sums, const Part& part);
/// @param direction  of the flow, unit
Descriptors descriptors_of(const SilhouetteSums& sums, const Part& part, const Eigen::Vector3d& direction);

}  // namespace dragcore
