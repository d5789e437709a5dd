#pragma once

#include <Eigen/Core>
#include <array>
#include <span>

namespace dragcore {

enum class FollowerLag {
  none,       ///< the note's: moves with gain * wind at once
  linear,     ///< force `linear_drag` * relative velocity: time constant mass / linear_drag
  quadratic,  ///< force rho `drag_area` |relative velocity|^2 / 2
};

enum class Facing { keep, into_wind, away_from_wind };

/// An object without a mesh (a sprite, a sound, a marker) that follows the wind.
struct Follower {
  double gain = 1.0;  ///< the note's alpha: 1 travels as the air does
  FollowerLag lag = FollowerLag::linear;
  double mass = 1.0;                                  ///< >= 0; 0 follows at once [kg]
  double linear_drag = 1.0;                           ///< > 0 with lag `linear` [kg/s]
  double drag_area = 1.0;                             ///< drag coefficient times area, > 0 with lag `quadratic` [m^2]
  double density = 1.225;                             ///< of the air, > 0 with lag `quadratic` [kg/m^3]
  Facing facing = Facing::keep;                       ///< which way the nose, at -x of the body, turns
  Eigen::Vector3d inertia = Eigen::Vector3d::Zero();  ///< about the body's axes, >= 0; 0 turns at once [kg m^2]
  double angular_drag = 1.0;              ///< > 0; time constant of the heading about an axis: inertia / angular_drag [kg m^2/s]
  std::array<bool, 3> position_locked{};  ///< world axes along which it does not move; they take no part in the drag either
  std::array<bool, 2> turn_locked{};      ///< body axes y and z about which it does not turn; it never turns about x
};

struct FollowerState {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();      ///< world [m]
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();      ///< world [m/s]
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  ///< r_world = rotation * r_body
};

/// @throws std::invalid_argument  on a value out of the ranges above or not finite
void validate(const Follower& follower);

/// Moves the follower through `dt` in a wind that is constant meanwhile. With u = gain * wind, e = v - u:
///   linear lag, tau = mass / linear_drag:           v' = u + e exp(-dt/tau),   r' = r + u dt + e tau (1 - exp(-dt/tau))
///   quadratic, k = rho drag_area / (2 mass), z = k |e| dt:   v' = u + e / (1 + z),   r' = r + u dt + e dt log(1 + z) / z
///   heading: the shortest arc from nose to wind, in body axes, shrinks by exp(-dt/tau_axis) about each of them
/// All are exact solutions: stable for every dt, and n steps end where one does. Calm air leaves the heading as it is.
/// Exactly opposite to its aim it turns about its z axis (y if z is locked).
///
/// @throws std::invalid_argument  as validate; if dt is negative or anything is not finite
/// @accuracy 1e-12 between 1 and 240 steps (tests/dragcore/wind/test_follower.cpp)
/// @source [toskan2020] sec. 3.4; differs: the printed displacement has no lag (erratum E28): it is the limit tau -> 0
FollowerState step(const Follower& follower, const FollowerState& state, const Eigen::Vector3d& wind, double dt);

/// Moves many followers of one kind through `dt`, each in its own wind. Each depends on its own state and wind alone, so that any split of
/// a batch gives the same bits.
/// @param winds    world [m/s], one for each state
/// @throws std::invalid_argument  as above, and on spans of different lengths: nothing has moved then
/// @accuracy       step() one by one to 1e-13 of speed, way and heading: 8 or 4 at once where the library was built with kernels
///                 (DRAGCORE_SIMD)
void step(const Follower& follower, std::span<FollowerState> states, std::span<const Eigen::Vector3d> winds, double dt);

}  // namespace dragcore
