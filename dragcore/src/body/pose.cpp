#include <Eigen/Geometry>
#include <dragcore/pose.hpp>

namespace dragcore {

Eigen::Matrix3d Pose::rotation() const {
  using Eigen::AngleAxisd, Eigen::Vector3d;
  return (AngleAxisd(yaw, Vector3d::UnitZ()) * AngleAxisd(incidence, Vector3d::UnitY()) * AngleAxisd(roll, Vector3d::UnitX()))
      .toRotationMatrix();
}

}  // namespace dragcore
