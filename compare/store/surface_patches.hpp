#pragma once

#include <string>
#include <vector>

#include "compare/case_record/case_record.hpp"

namespace compare {

using case_record::CaseRecord;

/// What the air does on average to one patch of a body's surface at the last iteration. Body frame.
///
/// Patches are the planar faces of the shape: "x-", "x+", "y-", ... of plates, boxes, prisms (the slanted ones are "z-" and "z+") and the
/// ends of cylinders, "base" of a cone. Curved parts are binned into "curved_b<band>_s<sector>": four bands of equal length along x, from
/// the nose, times eight sectors of 45 deg about the x axis, counted from +y towards +z.
struct PatchMean {
  std::string name;
  double area = 0.0;                                               ///< [m^2]
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero();              ///< [m]
  Eigen::Vector3d area_vector = Eigen::Vector3d::Zero();           ///< integral of the outward normal [m^2]
  double pressure_coefficient = 0.0;                               ///< mean C_p
  Eigen::Vector3d friction_coefficient = Eigen::Vector3d::Zero();  ///< mean C_f
  Eigen::Vector3d pressure_moment = Eigen::Vector3d::Zero();       ///< integral of C_p (r - centroid) dA [m^3]
  Eigen::Vector3d pressure_force = Eigen::Vector3d::Zero();        ///< integral of -C_p n dA, the pressure force / q [m^2]
};

/// The patch that a piece of the shape's surface belongs to, by its outward unit normal on flat sides, by its centre [m] on curved ones.
/// Body frame.
std::string patch_of(const dragcore::Shape& shape, const Eigen::Vector3d& centre, const Eigen::Vector3d& normal);

/// The means over the whole body in order of name; a half model is mirrored first. Empty when the record has no surface sample.
/// @throws std::runtime_error  when their pressure forces do not add up to `load_last.force_pressure` within 1e-3 of the force scale
///                             (the larger of that force and 0.05 q A_ref): sample and force are then not of the same flow field
std::vector<PatchMean> patch_means(const CaseRecord& record);

}  // namespace compare
