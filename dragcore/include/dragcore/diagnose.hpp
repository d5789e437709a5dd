#pragma once

#include <dragcore/drag.hpp>
#include <optional>
#include <string>
#include <vector>

namespace dragcore {

/// What diagnose() looks for.
enum class Mistake {
  empty_surface,    ///< no triangle with an area
  unit_of_length,   ///< larger than 50 m or smaller than 1 mm
  reference_point,  ///< outside the box about the surface: not its centre of mass
  not_finite,       ///< infinite or not a number
  speed,            ///< above 100 m/s
  density,          ///< neither of a gas nor of a liquid
  rotation,         ///< the matrix is none: scaled, sheared, mirrored
  frame,            ///< the motion is not that of the world turned into the body frame: with the transposed matrix, say
};

/// A value that is possible, but is more often a mistake. `text` says what was found, what was expected and what to do.
struct Warning {
  Mistake mistake;
  std::string text;
};

/// What a program knows in its world, to check what it made of it in the body frame. A transposed rotation is a rotation, too, so that it
/// can only be found where a velocity is given and is not zero.
struct WorldMotion {
  /// r_world = to_world * r_body + position; as BodyPlacement::rotation, of a quaternion too.
  Eigen::Matrix3d to_world = Eigen::Matrix3d::Identity();
  std::optional<Eigen::Vector3d> velocity{};  ///< of the reference point, world axes [m/s]
  std::optional<Eigen::Vector3d> wind{};      ///< at the reference point, world axes [m/s]
};

/// Looks for input that the library takes without a word and that is usually wrong: units, frames, reference points. Meant to be called
/// once, with a typical motion, when a program is written. Never throws for the values it is given; no warning is no proof.
/// @return  in the order of Mistake; empty: nothing found
std::vector<Warning> diagnose(const Surface& surface, const Motion& motion, const Medium& medium = {});

/// The same, and whether the motion is that of the world: velocity_body = to_world^T * velocity_world, and so for the wind.
std::vector<Warning> diagnose(const Surface& surface, const Motion& motion, const Medium& medium, const WorldMotion& world);

}  // namespace dragcore
