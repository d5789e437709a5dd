#pragma once

#include <dragcore/drag.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "compare/case_record/case_record.hpp"

namespace compare {

/// A fitted coefficient with its 95 % interval; the interval is empty when the fit has no degrees of freedom left or sits on a bound.
struct Estimate {
  std::string name;
  double value = 0.0;
  std::optional<std::pair<double, double>> interval;
  bool at_bound = false;
};

/// Root-mean-square errors of one quantity over a set of cases.
struct FitErrors {
  std::string group;  ///< "all", or a shape
  int n = 0;
  double before = 0.0;  ///< the null model: pillow factor 0, or the note's own law with scale 1 and no suction
  double note = 0.0;    ///< the note's own constant (pillow factor 1; for C_D the same as `before`)
  double in_sample = 0.0;
  double left_out_pose = 0.0;   ///< each orientation predicted by a fit to all others
  double left_out_shape = 0.0;  ///< each shape predicted by a fit to all others; not a number when there is one shape only
};

/// One fit: what was adjusted to what, and how well that works on cases it has not seen.
struct Fit {
  std::string name;    ///< "C_D: scale and base suction", "pillow tilt on law note"
  std::string target;  ///< "C_D", "force arm" (distance of the line of action from the centroid / L_ref)
  std::vector<Estimate> estimates;
  std::vector<std::vector<double>> correlation;  ///< of the estimates
  double condition_number = 1.0;                 ///< of the scaled normal matrix
  std::vector<FitErrors> errors;
  std::vector<std::string> cases;  ///< names of those used
  dragcore::Model model;           ///< with the fitted coefficients
};

struct Calibration {
  std::vector<Fit> fits;
  std::optional<Fit> by_class_pillow{};           ///< the tilt form on the laws by class; its `model` is for pillow alone
  const Fit& fit(const std::string& name) const;  ///< @throws std::out_of_range
};

/// Fits scale and base suction of scaled_law() to C_D, then the factor of each pillow form, on the note's law and on the fitted one, to the
/// force arm. Uses usable cases of plates, cubes and cones at Re >= 1e4 that are not marked held_out; other shapes are never fitted.
/// @throws std::invalid_argument when fewer than three cases qualify
Calibration calibrate(const std::vector<case_record::CaseRecord>& records);

/// Fits dragcore's laws by class, sheet_law() and closed_law(), to the force vector of all turbulent cases of record, measured or
/// solved, that know all of it and are not held out; each case weighs by its relative error. Numbers of the laws that are not fitted keep their values. Takes a minute: every error estimate
/// is a refit.
/// @throws std::invalid_argument  with fewer than two cases per parameter
Calibration calibrate_class_laws(const std::vector<case_record::CaseRecord>& records);

/// Fits the boundary layer of both laws by class, Law::layer and Law::layer_curvature, to the force vector of all usable cases at rest below
/// Re 200 that are not held out, each at its own Reynolds number; weights as above. `model` has both laws. Takes a minute.
/// @throws std::invalid_argument  with fewer than four cases
Calibration calibrate_viscous_terms(const std::vector<case_record::CaseRecord>& records);

/// Distance of the force's line of action from the centroid, over L_ref, signed like the moment that the pose drives.
/// Empty where the force is below 1e-3 q A_ref.
std::optional<double> force_arm(const case_record::CaseRecord& record, const Eigen::Vector3d& force, const Eigen::Vector3d& moment);

}  // namespace compare
