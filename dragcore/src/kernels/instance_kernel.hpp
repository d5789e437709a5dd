#pragma once

#include <Eigen/Core>

#include "kernels/wrench_kernel.hpp"

namespace dragcore::kernels {

/// What sixteen bodies of one shape and model share.
struct InstanceTask {
  const PackedSurface* surface = nullptr;                       ///< of one part
  ResolvedLaw law{};                                            ///< with what does not depend on the flow
  float size = 1.0f;                                            ///< that lengths are in units of [m]
  bool whole_silhouette = false;                                ///< two-sided: its descriptors count both sides
  bool described = false;                                       ///< shelter or recovery: the law needs descriptors
  float shelter = 0.0f;                                         ///< s
  float recovery = 0.0f, recovery_depth = 1.0f, volume = 0.0f;  ///< B R; lambda_0; volume in units of area^1.5
  Quadrature quadrature = Quadrature::three;
  float pillow_gain = 0.0f;  ///< of the pillow's factor over the root of the speed: eq. 17
};

/// Motion of sixteen bodies, body frame, SI units.
struct InstanceMotions {
  alignas(64) Row flow[3];  ///< of the air relative to the body at the reference point
  Row spin[3];
  Row gradient[9];  ///< of the wind: (0, 0), (0, 1), ...
  Row arm[3];       ///< from the reference point to the shape's origin
  Row creeping_power;  ///< what Stokes' resistance takes, over density/2 area [m^3/s^3]
};

/// Their wrenches, in units of density/2 speed^2 area, torque times size, about the reference point.
struct InstanceWrenches {
  alignas(64) Row force[3], torque[3];
  Row speed;  ///< [m/s]; 0 where it is beyond single precision: there is no result then
};
/// @param varies  one of them at least turns, or is in wind that varies
void instance_wrenches(const InstanceTask& task, const InstanceMotions& motions, bool varies, InstanceWrenches& result);

/// Sixteen free bodies, in double precision.
struct InstanceSteps {
  using Wide = double[lanes];
  alignas(64) Wide velocity[3];  ///< of the body relative to the air
  Wide spin[3];
  Wide mass, inertia[6];  ///< xx, xy, xz, yy, yz, zz
  Wide external[6];
  double dt = 0.0, half_density = 0.0, area = 1.0;
  bool turns = true;  ///< spin is felt
  double creeping[6][6] = {};  ///< Stokes' resistance about the shape's origin, SI units

  alignas(64) Wide result[6];  ///< velocity relative to the air, and spin, after dt
  Wide sound;                  ///< 1 where there is a result
};
/// @param motions  but for the spin, which is worked out here
void instance_steps(const InstanceTask& task, InstanceMotions& motions, InstanceSteps& steps);

}  // namespace dragcore::kernels
