#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <dragcore/direction_map.hpp>
#include <dragcore/drag.hpp>
#include <dragcore/stepping.hpp>
#include <span>
#include <string>
#include <vector>

namespace dragcore {

/// Differences between a baked body and wrench(), over a set of motions: force in units of the rms force of these motions, torque in units
/// of that force times `BakedBody::length`.
struct BakeError {
  double rms_force = 0.0, worst_force = 0.0, rms_torque = 0.0, worst_torque = 0.0;
  double rms() const { return rms_force > rms_torque ? rms_force : rms_torque; }
};

struct BakeOptions {
  double rms_error = 0.01;             ///< of force and torque without spin, as BakeError has them; 0: as small as `most_bytes` allow
  std::size_t most_bytes = 64u << 10;  ///< of all maps together
};

/// Force and torque of one body by one model over the direction of the flow. Costs the same whatever was baked. Made by bake(), or read
/// from a file; its members are to be read.
struct BakedBody {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< where u is taken and torque is stored about: Surface::centre [m]
  double area = 0.0;                                 ///< A: Surface::total_area, one side [m^2]
  double length = 0.0;                               ///< L: Surface::radius [m]

  DirectionMap steady;  ///< F(u): at rest, over the direction of the flow; 1 row
  DirectionMap rate;    ///< J(u): change by spin, over the same; 3 rows. None where the model does without Effect::spin
  DirectionMap tumble;  ///< P(omega), in still air, over the direction of the spin; and K(omega), change by flow; 4 rows. As `rate`

  BakeError error;                                                       ///< without spin, at 2,000 directions that are no nodes
  static constexpr std::array<double, 3> spin_ratios = {0.1, 0.3, 1.0};  ///< |omega| L/|u|
  std::array<BakeError, 3> spin_error{};  ///< at these, over 300 pairs of directions each, against six points a triangle
  double rms_force = 0.0;                 ///< over direction, without spin: of density/2 |u|^2 A

  std::string model;               ///< law and pillow with their numbers, for people
  std::uint64_t surface_hash = 0;  ///< of all that wrench() reads of the surface
  std::uint64_t model_hash = 0;    ///< of all numbers of the model; not of names, checks, precision and points a triangle

  std::size_t bytes() const;  ///< of the maps

  /// Whether this was baked from that surface and that model: a map of a body that was changed since is stale.
  bool matches(const Surface& surface, const Model& model) const;
};

/// Evaluates the model over directions and keeps the result. The frequency of `steady` is the smallest of 2, 3, ... 8, 10, ... 20, 24, ...
/// 128 whose measured rms error is what is wanted.
///
/// Everything that a uniform motion of air and body has to do with is baked. Winds by triangle and rates of strain are not: their number is
/// not bounded, or their effect not nearly linear; nor is a body that deforms, whose surface is another one every step.
///
/// @param model  evaluated in its own precision, at six points a triangle. Precision::single errs by 1e-6, which no map feels
/// @throws std::invalid_argument  an empty surface; options out of range; a wanted error that needs more than `most_bytes`: what was
/// reached;
///                                whatever wrench() refuses
/// Cost: of the order of 10,000 wrench().
BakedBody bake(const Surface& surface, const Model& model, const BakeOptions& options = {});

/// Force and torque about `motion.reference_point` from the maps, with U = |u|, w = |omega| L, R = sqrt(U^2 + w^2), rho/2 A:
///
///   W = U^2 F(u) + w^2 P(omega) + U^2/(R + w) J(u) omega L + w^2/(R + U) K(omega) u
///
/// u is the flow relative to `centre`, omega the spin relative to the air's own turning (half the curl of `wind_gradient`). Value and slope
/// are those of the model for slow and for fast spin; continuous everywhere, zero where nothing moves. What interpolation would let the
/// body gain from the air is taken back along the motion: power against a uniform wind is never positive. A map is of coefficients that do
/// not change with speed, as those of a law with viscosity do: so there is none of that.
///
/// @throws std::invalid_argument  a medium with viscosity; a motion with `triangle_wind`; a wind that strains (the symmetric part of
///                                `wind_gradient`); density negative, or anything not finite
/// @accuracy  `error` and `spin_error`: for spin ratios of 0.1, 0.3 and 1 about 0.5, 2 and 10 % of the force (docs/baking.md)
Wrench wrench(const BakedBody& body, const Motion& motion, const Medium& medium);

/// The same for many motions, to 4e-6 of density/2 (U^2 + w^2) A, at half the cost; cheapest where those that spin stand together.
/// @param results  as many entries. A fault names the entry
void wrenches(const BakedBody& body, std::span<const Motion> motions, const Medium& medium, std::span<Wrench> results);

/// Secant matrix of the baked wrench for step_secant_implicit(): symmetric, positive semidefinite, and S (V_air - V) is wrench() exactly.
/// Broyden's update of a multiple of the identity (velocity, spin times L): across the motion it damps as along it.
/// @throws std::invalid_argument  as wrench(); and on a wind that varies, for which it is not the wrench
Matrix6d resistance(const BakedBody& body, const Motion& motion, const Medium& medium);

}  // namespace dragcore
