#pragma once

#include <map>
#include <string>
#include <vector>

#include "compare/report/report.hpp"

namespace compare {

/// Cases that differ in nothing but their orientation: what one figure, or one table of errors, is about.
struct Sweep {
  std::string family;             ///< as ErrorRow::family
  std::string title;              ///< for people: "cube at Re 1e5, k-omega SST"
  std::string angle;              ///< the one that varies: "incidence", "yaw" or "roll"
  Channel force = Channel::lift;  ///< the lateral force and the moment that it drives
  Channel moment = Channel::pitch;
  std::vector<const CaseRecord*> cases;  ///< finest usable mesh of each, by orientation
  bool curve = false;                    ///< three or more orientations: worth a line

  double angle_of(const ErrorRow& row) const;  ///< [deg]
  std::string slug() const;                    ///< the family as an HTML id
};

/// In order of Reynolds number (the highest first) and name. Pointers into `report`.
std::vector<Sweep> sweeps(const Report& report);

/// "note's law", "consistent law", "calibrated law": what people read for Law::name.
std::string law_label(const std::string& law_name);

/// "10⁵" as people write it.
std::string reynolds_text(double reynolds);

/// C_D, C_L, ... of a model at these angles [deg] of the sweep.
std::vector<Coefficients> coefficients_along(const Sweep& sweep, const ModelChoice& choice, const std::vector<double>& angles_deg);

/// Rows of a model's table that belong to the sweep, one per case, in order of orientation.
std::vector<const ErrorRow*> rows_of(const ErrorTable& table, const Sweep& sweep, Channel channel);

}  // namespace compare
