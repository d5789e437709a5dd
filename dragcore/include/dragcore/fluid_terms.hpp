#pragma once

#include <dragcore/ellipsoid.hpp>
#include <dragcore/stepping.hpp>

namespace dragcore {

// Effects of fluid mechanics that a pressure law cannot have. Nothing else in the library calls these functions: an effect exists where its
// result is asked for and added, and only there. Body frame; uniform, steady wind; force [N], torque about `motion.reference_point` [N m].
// Equations: docs/ellipsoids.md.
//
// Every function throws std::invalid_argument for an ellipsoid out of range, for negative density, for viscosity that is not positive and
// for anything not finite.

/// Lift coefficient of a spinning ball, C_L(S) on pi a^2, S = a |omega_t| / |u|, with omega_t the part of the spin across the flow.
enum class MagnusLaw {
  creeping,     ///< C_L = 2 S, exact for Re << 1 and S Re << 1 [rubinow_keller_1961]
  sports_ball,  ///< C_L = 1.5 S up to S = 0.1, then 0.09 + 0.6 S: a fit for rough balls, Re 4e4..2.5e5, S < 0.6 [sawicki_2003]
};

/// Lift of spin, along u x omega: backspin lifts. Acts at the centre and does no work on it. The torque that brakes spin is not part of it.
///   F = rho/2 pi a^3 (C_L / S) u x omega
/// An ellipsoid counts as the sphere of its volume: our extension, without data. Smooth balls near the drag crisis can be pushed the other
/// way: not modelled.
Wrench magnus_lift(const PlacedEllipsoid& body, const Motion& motion, const Medium& medium, MagnusLaw law);

/// Added mass M about `reference_point` [kg, kg m, kg m^2]: in potential flow an ellipsoid moves air of the kinetic energy V^T M V / 2.
/// Symmetric, positive semidefinite. To add to MassProperties::matrix() when the reference point is the centre of mass. Accuracy 1e-12.
/// @source [lamb_1932] art. 114, 115; here with the differences of his integrals taken under the integral, so that spheres, discs and
/// needles cost no digits
Matrix6d added_mass(const PlacedEllipsoid& body, const Eigen::Vector3d& reference_point, const Medium& medium);

/// Of the reference point and of the body, as seen from an inertial frame, in components of the body frame.
struct Acceleration {
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();   ///< [m/s^2]
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();  ///< [rad/s^2]
};

/// What the air's inertia answers to acceleration: -M a. Leave it out where M is already part of the mass matrix.
Wrench acceleration_reaction(const Matrix6d& added_mass, const Acceleration& acceleration);

/// What remains of Kirchhoff's equations without acceleration: the moment that turns a slender body broadside to the flow (Munk), and the
/// gyroscopic terms of M. With acceleration_reaction() it conserves the energy of body and air. Zero for a sphere. A real, separated flow
/// shows only a part of it.
/// @source [lamb_1932] art. 124
Wrench munk_wrench(const Matrix6d& added_mass, const Motion& motion);

/// Resistance of an ellipsoid in creeping flow (Re << 1): the wrench is exactly S (V_air - V), as for resistance() of stepping.hpp, whose
/// updates take it. 6 pi mu a and 8 pi mu a^3 for a sphere. Symmetric, positive definite. Accuracy 1e-12.
/// @param viscosity  dynamic, mu [Pa s]; air at 15 C: 1.79e-5
/// @source [oberbeck_1876], [jeffery_1922], [lamb_1932] art. 339; Perrin's spheroids are the case of two equal axes
Matrix6d stokes_resistance(const PlacedEllipsoid& body, const Eigen::Vector3d& reference_point, double viscosity);
Wrench stokes_wrench(const Matrix6d& stokes_resistance, const Motion& motion);

/// Drag coefficient on pi d^2/4 of a smooth sphere, from Stokes' law to the drag crisis, Re = rho |u| d / mu up to 2e5, within 6 %:
///   C_D = 24/Re (1 + 0.15 Re^0.687) + 0.42 / (1 + 42500 Re^-1.16)             [clift_gauvin_1970], as printed in [clift_grace_weber_1978]
/// Beyond 2e5 the curve goes on level: the fall of drag at the crisis is not in it. @throws std::invalid_argument unless Re > 0
double sphere_drag_coefficient(double reynolds);

/// Drag of a sphere by that curve, exact Stokes drag as u -> 0. It replaces the pressure law's force on the sphere, it does not add to it.
/// No torque from spin.
Wrench sphere_drag(const Sphere& sphere, const Eigen::Vector3d& centre, const Motion& motion, const Medium& medium, double viscosity);

}  // namespace dragcore
