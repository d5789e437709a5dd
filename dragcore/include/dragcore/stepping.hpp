#pragma once

#include <dragcore/drag.hpp>

namespace dragcore {

// Drag grows with the square of speed, so that an explicit step of a light body overshoots or explodes (a sheet of paper of 80 g/m^2 from
// 16 m/s at 60 Hz). The updates below never do, at any time step: relative to a uniform wind, kinetic energy never grows.
//
// They leave out the gyroscopic term: gyroscopic_spin() adds it without a change of energy. As an explicit torque -omega x I omega it makes
// long bodies that tumble gain energy without bound, at any usual time step.
//
// Safe is not accurate: the pose lags by a step, and so do pressure and pillow. A free sheet of paper or a leaf is right at up to 1/30 s
// and falls several times too fast at 0.5 s.
//
// That is a promise about the step, not about the model. A law without friction lets a thin sheet that is edge-on to its motion glide
// faster and faster in its own plane: take sheet_law() or closed_law().

using Vector6d = Eigen::Matrix<double, 6, 1>;  ///< linear, then angular part: (velocity, angular_velocity) or (force, torque)
using Matrix6d = Eigen::Matrix<double, 6, 6>;  ///< of such vectors: the first three rows and columns are linear

/// Mass properties about the centre of mass, which must be `motion.reference_point`; axes of the body frame.
/// `added` is for bodies so light that the air they carry along counts: a disc of radius a broadside carries 8/3 rho a^3, of A4 paper
/// several times its mass. Munk's moment of that air is a steady one, part of what a pillow was fitted to: do not add munk_wrench() to a
/// model with a pillow. It turns with the body, and the steps leave that out: energy with it may grow by some per cent in a turn, that of
/// the body alone does not.
struct MassProperties {
  double mass = 0.0;                                  ///< [kg]; to be set
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  ///< [kg m^2], symmetric, positive definite; to be set

  Matrix6d added = Matrix6d::Zero();  ///< added mass: added_mass() of fluid_terms.hpp [kg, kg m, kg m^2]

  /// diag(m, m, m, I) + added. @throws std::invalid_argument when mass or inertia is not positive, added mass is negative, or anything not
  /// finite or not symmetric
  Matrix6d matrix() const;
};

/// Secant matrix S of the drag at this motion: the wrench is exactly S (V_air - V), with V = (velocity, angular_velocity), V_air = (wind,
/// 0). Symmetric and positive semidefinite, whatever the law: terms that push are worked in by a Broyden update (BFGS). SI units of force
/// over velocity. With Effect::spin masked off the torque does not feel the spin, and the promise about energy is about the linear motion
/// alone. In a wind that is not uniform S (V_air - V) is not the whole wrench: give the steps what is missing, wind_excess(), as part of
/// `external`.
Matrix6d resistance(const Surface& surface, const Motion& motion, const Medium& medium, const Model& model);

/// What S (V_air - V) misses of the total wrench in a wind that varies over the body; rounding errors in a uniform one.
/// @return  (force [N], torque [N m])
Vector6d wind_excess(const Wrench& total, const Matrix6d& resistance, const Motion& motion);

/// Derivative of (force, torque) by (velocity, angular_velocity), for engines that step implicitly themselves. The pillow's displacement,
/// the body's descriptors and the share of pushing terms are held fixed.
Matrix6d force_jacobian(const Surface& surface, const Motion& motion, const Medium& medium, const Model& model);

/// Spin after `dt` by the body's inertia alone (Euler's equations, implicit midpoint): rotational energy stays, at any spin and dt, of
/// bodies whose principal moments are up to 1e14 apart; so does the size of angular momentum while the body turns by less than about a
/// third of a radian a step. Second order in dt. Replace `motion.angular_velocity` with it before resistance(), and turn the body by dt
/// times the spin that the step returns.
/// @return  body axes [rad/s]. @throws std::invalid_argument  as MassProperties::matrix(), or on a spin or dt that is not finite
Eigen::Vector3d gyroscopic_spin(const MassProperties& body, const Eigen::Vector3d& angular_velocity, double dt);

/// New (velocity, angular_velocity) after `dt` under drag and a constant external wrench (gravity, say), without the gyroscopic term.
///   (M + dt S) V' = M V + dt (S V_air + W_external)
/// Terminal velocity is an exact fixed point. For W_external = 0: |V' - V_air|_M <= |V - V_air|_M for every dt >= 0.
/// @param external  (force [N], torque about the reference point [N m]), body frame
/// @return          (velocity [m/s], angular_velocity [rad/s]), body frame: `head<3>()` and `tail<3>()`
Vector6d step_secant_implicit(const Matrix6d& resistance, const MassProperties& body, const Motion& motion, const Vector6d& external,
                              double dt);

/// The same bound without solving a system: V' = V + dt M^-1 W / (1 + dt tr(M^-1 S)). More damping than the above, first order in dt.
Vector6d step_scalar_implicit(const Matrix6d& resistance, const MassProperties& body, const Motion& motion, const Vector6d& external,
                              double dt);

/// For an engine that takes impulses and nothing else: the share in [0, 1] of the impulse dt * wrench that may be applied so that kinetic
/// energy relative to the air does not grow and motion is not reversed beyond its minimum of energy. Holds for any wrench, also one that is
/// not passive.
double impulse_share(const Wrench& wrench, const MassProperties& body, const Motion& motion, double dt);

}  // namespace dragcore
