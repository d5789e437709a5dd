#pragma once

#include <dragcore/correction.hpp>
#include <dragcore/drag.hpp>

#include "drag/instrument.hpp"

namespace dragcore {

/// Whether a model has a correction and lets it be felt.
inline bool is_corrected(const Model& model) {
  const bool felt = instrument::built(Effect::correction) && model.correction && model.effects.has(Effect::correction);
  if (felt) instrument::count(Effect::correction);  // here, where it is asked for: what follows is in a file of its own
  return felt;
}

/// A correction in one motion: eq. 18, before its share.
struct CorrectedFlow {
  CorrectedFlow(const Surface& surface, const Motion& motion, const Medium& medium, const Model& model);

  /// How much of it may be felt beside a wrench that the law gives, about the reference point: in [0, 1].
  double share(const Wrench& of_law) const;
  /// About the reference point.
  Wrench wrench(double share) const;
  Wrench beside(const Wrench& of_law) const { return wrench(share(of_law)); }

 private:
  Eigen::Vector3d arm_;          // from the reference point to the centre
  Eigen::Vector3d u_, turning_;  // of the air at the centre; of the body relative to the air
  Eigen::Vector3d force_ = Eigen::Vector3d::Zero(), torque_ = Eigen::Vector3d::Zero();  // about the centre
};

/// Adds the correction by triangle to what the law gives, force and torque about the reference point: a traction F/A + b x (r - centre), with
/// b such that its torque is that of the correction.
void add_spread_correction(const Surface& surface, const Motion& motion, const Medium& medium, const Model& model,
                           Eigen::Matrix<double, 6, Eigen::Dynamic>& by_triangle);

/// @throws std::invalid_argument  for a surface or a medium that it was not found for
void check_correction(const Correction& correction, const Surface& surface, const Medium& medium);

}  // namespace dragcore
