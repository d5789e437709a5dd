#include "compare/tables/spin_table.hpp"

#include <fmt/color.h>
#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "compare/tables/text_grid.hpp"

namespace compare {
namespace {

using case_record::CaseRecord;
using Eigen::Vector3d;
using nlohmann::json;

/// The body axes that the spin has a part along: "z", "xy"; with signs where they differ.
std::string axis_text(const Vector3d& spin_body) {
  constexpr double none = 1e-6;
  std::string text;
  for (int k = 0; k < 3; ++k)
    if (std::abs(spin_body[k]) > none * spin_body.norm()) text += (spin_body[k] < 0.0 ? "-" : "") + std::string(1, "xyz"[k]);
  return text;
}

SpinRow row_of(const CaseFamily& family, const Predictor& model) {
  const CaseRecord& record = *family.record;
  const Vector3d axis = record.angular_velocity.normalized();
  const double scale = coefficient_scales(record)[3];
  SpinRow row;
  row.case_name = record.name;
  row.shape = shape_label(record.shape);
  row.axis = axis_text(record.pose.rotation().transpose() * record.angular_velocity);
  row.air = record.still_air ? "still"
                             : fmt::format("wind, omega L/U {:g}", record.angular_velocity.norm() *
                                                                       dragcore::properties(record.shape).reference_length / record.speed);
  row.reynolds = record.reynolds;
  row.flow_model = record.flow_model;
  row.status = case_record::to_string(record.status);
  row.reason = record.reason;
  row.model = model(record).torque.dot(axis) / scale;
  if (!case_record::is_usable(record.status)) return row;
  const double torque = record.load.moment().dot(axis);
  row.cfd = torque / scale;
  row.u = propagated(record, family.uncertainty.total,
                     [&](const Vector3d&, const Vector3d& moment) { return std::optional(moment.dot(axis)); }) /
          scale;
  row.discretisation_assessed = family.uncertainty.discretisation_assessed;
  if (torque != 0.0) {
    row.pressure_share = record.load.moment_pressure.dot(axis) / torque;
    row.friction_share = record.load.moment_viscous.dot(axis) / torque;
  }
  row.error = row.model - *row.cfd;
  if (std::abs(*row.cfd) > 2.0 * row.u) row.relative_error = *row.error / std::abs(*row.cfd);
  row.verdict = std::abs(*row.error) > 2.0 * row.u ? Verdict::resolved : Verdict::within_noise;
  row.published = published_value(record, "C_spin");
  Eigen::Index along = 0;
  axis.cwiseAbs().maxCoeff(&along);
  const auto& branches = family.uncertainty.branches;
  row.note = branches.size() == 1 ? branches.front() : branches[static_cast<std::size_t>(3 + along)];
  return row;
}

std::string verdict_text(const SpinRow& row) {
  if (!row.verdict) return row.status + (row.reason.empty() ? "" : ": " + row.reason);
  return *row.verdict == Verdict::resolved ? (row.discretisation_assessed ? "resolved" : "resolved*") : "noise";
}

std::string percent(const std::optional<double>& ratio, const char* format) { return ratio ? number_text(100.0 * *ratio, format) : ""; }

TextGrid grid_of(const std::vector<SpinRow>& rows) {
  TextGrid grid;
  grid.add({"case", "axis", "CFD", "u", "pressure", "friction", "model", "error", "relative", "verdict", "published"});
  for (const SpinRow& row : rows) {
    const auto style = !row.cfd                           ? fg(fmt::terminal_color::red)
                       : row.verdict == Verdict::resolved ? fg(fmt::terminal_color::yellow)
                                                          : fmt::text_style{};
    grid.add(
        {row.case_name, row.axis, number_text(row.cfd, "{:.5f}"),
         row.cfd ? number_text(row.u, "{:.2g}") + (row.discretisation_assessed ? "" : "*") : "", percent(row.pressure_share, "{:.0f} %"),
         percent(row.friction_share, "{:.0f} %"), number_text(row.model, "{:.5f}"), number_text(row.error, "{:+.5f}"),
         percent(row.relative_error, "{:+.0f} %"), verdict_text(row), row.published ? number_text(row.published->value, "{:.5f}") : ""},
        style);
  }
  return grid;
}

}  // namespace

std::vector<SpinRow> spin_table(const std::vector<CaseRecord>& records, const Predictor& model) {
  std::vector<SpinRow> rows;
  for (const CaseOfRecord& chosen : cases_of_record(records)) rows.push_back(row_of(chosen.family, model));
  return rows;
}

std::string render(const std::vector<SpinRow>& rows, const std::string& model_name, Format format, bool colour) {
  if (format == Format::json) return to_json(rows).dump(2) + "\n";
  if (format == Format::csv) {
    std::string text =
        "case,shape,axis,air,reynolds,flow_model,status,C_spin,u,discretisation_assessed,pressure_share,friction_share,model,error,"
        "relative_error,verdict,published,citation\n";
    for (const SpinRow& row : rows) {
      const auto full = [](const std::optional<double>& value) { return number_text(value, "{:.9g}"); };
      text +=
          csv_line({row.case_name, row.shape, row.axis, row.air, full(row.reynolds), row.flow_model, row.status, full(row.cfd),
                    row.cfd ? full(row.u) : "", row.discretisation_assessed ? "1" : "0", full(row.pressure_share), full(row.friction_share),
                    full(row.model), full(row.error), full(row.relative_error), row.verdict ? verdict_text(row) : "",
                    row.published ? full(row.published->value) : "", row.published ? row.published->citation : ""});
    }
    return text;
  }
  const bool terminal = format == Format::table;
  const std::string title = fmt::format("Bodies that spin: torque coefficient about the axis of spin (model: {})", model_name);
  std::string text = terminal ? title + "\n" + aligned(grid_of(rows), colour) : "### " + title + "\n\n" + markdown(grid_of(rows)) + "\n";
  text +=
      "C_spin = M . omega/|omega| / (q A_ref L_ref), in still air q = rho (omega L_ref)^2 / 2; pressure and friction: their shares of the "
      "CFD's torque. "
      "The model has friction with some laws only. u is numerical: what turbulence models leave open under spin is not known.\n";
  for (const SpinRow& row : rows)
    if (row.cfd) text += fmt::format("{}{}: u of the mesh {}\n", terminal ? "" : "* ", row.case_name, row.note);
  return text;
}

json to_json(const std::vector<SpinRow>& rows) {
  json list = json::array();
  for (const SpinRow& row : rows)
    list.push_back({{"case", row.case_name},
                    {"shape", row.shape},
                    {"axis", row.axis},
                    {"air", row.air},
                    {"reynolds", row.reynolds},
                    {"flow_model", row.flow_model},
                    {"status", row.status},
                    {"reason", row.reason},
                    {"C_spin", optional_json(row.cfd)},
                    {"u", row.cfd ? json(row.u) : json(nullptr)},
                    {"discretisation_assessed", row.discretisation_assessed},
                    {"pressure_share", optional_json(row.pressure_share)},
                    {"friction_share", optional_json(row.friction_share)},
                    {"model", row.model},
                    {"error", optional_json(row.error)},
                    {"relative_error", optional_json(row.relative_error)},
                    {"verdict", row.verdict ? json(verdict_text(row)) : json(nullptr)},
                    {"published", row.published ? json(row.published->value) : json(nullptr)},
                    {"citation", row.published ? json(row.published->citation) : json(nullptr)},
                    {"note", row.note}});
  return list;
}

}  // namespace compare
