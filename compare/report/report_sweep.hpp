#pragma once

#include <map>
#include <string>
#include <vector>

#include "compare/report/report.hpp"

namespace compare {

/// Cases that differ in one angle of their pose and in nothing else: what one figure, or one table of errors, is about.
struct Sweep {
  std::string family;             ///< as ErrorRow::family
  std::string title;              ///< for people: "cube at Re 1e5, k-omega SST"
  std::string detail;             ///< what sets a further sweep of the same family apart: "incidence at yaw 45\u00b0"; empty for the first
  std::string angle;              ///< the one that varies: "incidence", "yaw" or "roll"
  Channel force = Channel::lift;  ///< the lateral force and the moment that it drives: of yaw C_S and C_n, else C_L and C_m
  Channel moment = Channel::pitch;
  std::vector<const CaseRecord*> cases;  ///< finest usable mesh of each, by that angle
  bool curve = false;                    ///< three or more orientations: worth a line

  double angle_of(const ErrorRow& row) const;  ///< [deg]
  bool holds(const ErrorRow& row) const;       ///< whether the case of the row is one of `cases`
  std::string slug() const;                    ///< family and detail as an HTML id
};

/// The sweeps of every family: the longest run of poses that share two angles, then further runs of three or more of which two are new.
/// In order of Reynolds number (the highest first) and name. Pointers into `report`.
std::vector<Sweep> sweeps(const Report& report);

/// Rows of a model's table, missing ones left out, whose pose is on no sweep.
std::vector<const ErrorRow*> rows_off_sweeps(const ErrorTable& table, const std::vector<Sweep>& list);

/// "incidence 15\u00b0, yaw 45\u00b0": the angles that are not zero, in full; "0\u00b0" when all are.
std::string pose_text(const ErrorRow& row);

/// Letters and digits of a text with hyphens between: an HTML id.
std::string slug_of(const std::string& text);

/// "note's law", "consistent law", "calibrated law": what people read for Law::name.
std::string law_label(const std::string& law_name);

/// "10⁵" as people write it.
std::string reynolds_text(double reynolds);

/// C_D, C_L, ... of a model at these angles [deg] of the sweep.
std::vector<Coefficients> coefficients_along(const Sweep& sweep, const ModelChoice& choice, const std::vector<double>& angles_deg);

/// Rows of a model's table that belong to the sweep, one per case, in order of orientation.
std::vector<const ErrorRow*> rows_of(const ErrorTable& table, const Sweep& sweep, Channel channel);

}  // namespace compare
