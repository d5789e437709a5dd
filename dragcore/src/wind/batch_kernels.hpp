#pragma once

#include <cstddef>
#include <dragcore/follower.hpp>
#include <dragcore/gust.hpp>
#include <span>

namespace dragcore {

/// gust_factors() and step() of many followers, for checked input. False where the library is built without kernels: nothing is done then.
bool gust_factors_by_kernel(const Gust& gust, std::span<const double> times, std::span<double> factors);
bool step_by_kernel(const Follower& follower, std::span<FollowerState> states, std::span<const Eigen::Vector3d> winds, double dt);

/// Plane waves of Turbulence: wavevectors and amplitudes x y z after each other, one length for each component.
struct Waves {
  const double *wavevectors, *amplitudes, *phases;
  std::size_t count;
  const double* lengths;
};

/// Their sum, component i being that of a_i cos(k.x / L_i + phi), at `count` points, x y z after each other. False as above.
bool sum_of_waves(const Waves& waves, const double* points, std::size_t count, double* sums);

/// The first state or wind that is not plainly fit for a step, by its index; from there on each must be looked at. Their number where all
/// are. Without kernels: 0.
std::size_t first_doubtful_follower(std::span<const FollowerState> states, std::span<const Eigen::Vector3d> winds);

}  // namespace dragcore
