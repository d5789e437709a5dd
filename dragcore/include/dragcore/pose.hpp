#pragma once

#include <Eigen/Core>

namespace dragcore {

/// Orientation of a body in the wind, r_wind = rotation() * r_body with R = Rz(yaw) Ry(incidence) Rx(roll); docs/conventions.md.
struct Pose {
  double incidence = 0.0;  ///< about y, positive lifts the nose [rad]
  double yaw = 0.0;        ///< about z [rad]
  double roll = 0.0;       ///< about x [rad]

  Eigen::Matrix3d rotation() const;
};

}  // namespace dragcore
