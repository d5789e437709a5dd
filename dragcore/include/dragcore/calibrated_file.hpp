#pragma once

#include <dragcore/drag.hpp>
#include <filesystem>
#include <map>
#include <string>

/// Models that were calibrated for one body, in files: what `dragval calibrate --mesh` or `--wind-tunnel` makes. Part of
/// dragcore::calibrated_files, for it needs HDF5, whose C library is not safe for threads: read and write from one thread at a time.
namespace dragcore {

/// Errors of a calibrated model in poses that its fit had not seen, over all of them: shares of the larger of the force and 0.3 of the mean
/// force; a moment's, of that force times L_ref.
struct CalibrationError {
  double mean_force = 0.0, worst_force = 0.0, mean_drag = 0.0, worst_drag = 0.0, mean_moment = 0.0, worst_moment = 0.0;
  double reference = 0.0;  ///< mean standard uncertainty of what it was fitted to, same units as the force
  int poses = 0;
};

struct CalibratedModel {
  Model model{};  ///< law, pillow and correction of the body
  CalibrationError error{};
  double most_mach = 0.3;  ///< of incompressible CFD, or of the wind tunnel: beyond, nothing is known
  /// Texts by key: program, method, poses, date, reynolds, fit, body.
  std::map<std::string, std::string> provenance{};
};

/// HDF5: root attributes `schema` = "dragcore.calibrated_model", `schema_version` = "1.0", `law` (and `sheet_law`: a law file's TOML, the
/// provenance in the first), `origin`, `viscous` ("yes" or "no"); datasets `map` [n, n, 1, 8], float, `body` [17] (ShapeMoments),
/// `reynolds` [2] (on the diameter 2 radius), `pillow` [2 or 4] (tilt factor and viscous gain; of sheets), `most_mach` [1], `error` [8];
/// double. Each dataset has attributes `units`, `frame` and `long_name`.
/// @throws std::runtime_error  file missing, truncated, not HDF5, without checksums, of another or a newer schema; a law that read_law()
///                             refuses; wrong shapes, units or types; values that are not finite or out of range: file and fault
CalibratedModel read_calibrated(const std::filesystem::path& file);

/// Writes under a temporary name beside it and renames.
/// @throws std::invalid_argument  a model without correction, or one of no body; with a pillow of a form other than tilt; a law without
/// name
/// @throws std::runtime_error     when the file cannot be written
void write_calibrated(const std::filesystem::path& file, const CalibratedModel& calibrated);

}  // namespace dragcore
