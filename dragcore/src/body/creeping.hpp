#pragma once

#include <dragcore/surface.hpp>

namespace dragcore {

/// Semi-axes of the ellipsoid whose surface has these second moments per area about its centre, in the same order. A moment of zero: flat.
/// @accuracy  1e-4 for aspect ratios up to 10, 1e-3 beyond (tests/dragcore/body/test_creeping.cpp)
Eigen::Vector3d semi_axes_of(const Eigen::Vector3d& moments);

/// Fills in drag, turning and spread from second moments of the wetted area, per area about its centroid [m^2].
void find_creeping_resistance(const Eigen::Matrix3d& second_moment, CreepingResistance& creeping);

}  // namespace dragcore
