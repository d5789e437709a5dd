#pragma once

#include <filesystem>
#include <string>

#include "compare/cli/commands.hpp"

namespace cli {

/// What `dragval calibrate` is to do about one body: from CFD of a mesh, from a wind tunnel's table, or from stored references.
struct BodyCalibration {
  std::string mesh, unit;  ///< file of triangles
  std::string table;       ///< of a wind tunnel; of `mesh` where its column `shape` has that name
  std::string stored;      ///< beginning of the names of stored references: "cone-apex_angle_deg-60"
  int poses = 12, more = 0;
  double reynolds = 1e5;
  double area = 0.0, length = 0.0;  ///< of the coefficients and of Re; 0: largest silhouette along an axis, and its root [m^2, m]
  std::string levels = "coarse,medium";
  std::string cache = ".dragval";
  int jobs = 1;
  bool retry_failed = false;
  bool dry_run = false;
  std::string write;  ///< file for the calibrated model; empty: none

  bool wanted() const { return !mesh.empty() || !table.empty() || !stored.empty(); }
};

/// Plans, solves what is missing, fits, prints.
void calibrate_body(const BodyCalibration& wanted, const SourceOptions& source, Context& context);

}  // namespace cli
