#pragma once

#include <dragcore/drag.hpp>
#include <dragcore/wind.hpp>

namespace dragcore {

/// Where a body is: r_world = rotation * r_body + position.
struct BodyPlacement {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< of the body frame's origin, world [m]
  /// Body to world, a proper rotation to 1e-9: its columns are the body's axes. Of a unit quaternion:
  /// Eigen::Quaterniond(w, x, y, z).toRotationMatrix(), where w is given first but stored last (`coeffs()` are x, y, z, w).
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
};

/// The wind that a body meets, in the body frame. Owns the values per triangle that Motion::triangle_wind refers to: keep it as long as the
/// motion.
class BodyWind {
 public:
  /// Samples a wind field over a body.
  ///   constant:      the velocity at the reference point
  ///   affine:        velocity and gradient at the surface's centre, as a field about the reference point
  ///   per_triangle:  the velocity at the centroid of every triangle
  /// @param precision  of per_triangle, as Wind::velocities() has it; the others are always in double precision, and so is everything about
  ///                   the body
  /// @param reference_point  of the motion it is meant for, body frame [m]
  /// @throws std::invalid_argument  if the rotation is none or anything is not finite
  BodyWind(const Wind& wind, const Surface& surface, const BodyPlacement& place, const Eigen::Vector3d& reference_point,
           WindSampling sampling, Precision precision = Precision::single);

  /// The same with the cheapest sampling whose error bound is within `tolerance` [m/s]: choose_sampling().
  static BodyWind within(const Wind& wind, const Surface& surface, const BodyPlacement& place, const Eigen::Vector3d& reference_point,
                         double tolerance, Precision precision = Precision::single);

  WindSampling sampling() const { return sampling_; }

  /// Sets `wind`, `wind_gradient` and `triangle_wind` of a motion with the same reference point. Not for a temporary: the motion refers to
  /// this object.
  void apply_to(Motion& motion) const&;
  void apply_to(Motion& motion) const&& = delete;

 private:
  WindSampling sampling_;
  Eigen::Vector3d velocity_ = Eigen::Vector3d::Zero();
  Eigen::Matrix3d gradient_ = Eigen::Matrix3d::Zero();
  std::vector<Eigen::Vector3d> per_triangle_;
};

}  // namespace dragcore
