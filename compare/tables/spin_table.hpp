#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "compare/tables/error_table.hpp"

namespace compare {

/// A body that spins: its torque about the axis of spin, C_spin = M . omega / |omega| / (q A_ref L_ref), model against reference. In still
/// air q = rho (omega L_ref)^2 / 2. Negative: the air brakes.
struct SpinRow {
  std::string case_name;
  std::string shape;  ///< as shape_label()
  std::string axis;   ///< of the spin in the body frame: "x", "xy"
  std::string air;    ///< "still", or "wind, omega L/U 1"
  double reynolds = 0.0;
  std::string flow_model;
  std::string status, reason;
  std::optional<double> cfd;
  double u = 0.0;
  bool discretisation_assessed = false;
  std::optional<double> pressure_share, friction_share;  ///< of the reference's torque; they sum to one
  double model = 0.0;
  std::optional<double> error, relative_error;  ///< model - cfd, and that over |cfd| where |cfd| > 2u
  std::optional<Verdict> verdict;
  std::optional<PublishedValue> published;
  std::string note;  ///< how u_disc was found
};

/// One row per case at its finest usable mesh, in order of name. @param records  spinning() ones
std::vector<SpinRow> spin_table(const std::vector<case_record::CaseRecord>& records, const Predictor& model);

std::string render(const std::vector<SpinRow>& rows, const std::string& model_name, Format format, bool colour = false);
nlohmann::json to_json(const std::vector<SpinRow>& rows);

}  // namespace compare
