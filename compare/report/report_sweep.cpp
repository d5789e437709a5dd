#include "compare/report/report_sweep.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <numbers>
#include <set>

#include "compare/calibration/prediction.hpp"
#include "compare/reference/uncertainty.hpp"

namespace compare {
namespace {

constexpr double deg = std::numbers::pi / 180.0;

}  // namespace

std::string law_label(const std::string& law_name) {
  return law_name == "note"       ? "note's law"
         : law_name == "scaled"   ? "calibrated law"
         : law_name == "by class" ? "law by class"
                                  : law_name + " law";
}

std::string reynolds_text(double reynolds) {
  static const char* const superscripts[] = {"\u2070", "\u00b9", "\u00b2", "\u00b3", "\u2074",
                                             "\u2075", "\u2076", "\u2077", "\u2078", "\u2079"};
  const int exponent = static_cast<int>(std::floor(std::log10(reynolds) + 1e-9));
  if (exponent < 3 || exponent > 9) return fmt::format("{:g}", reynolds);
  const double mantissa = reynolds / std::pow(10.0, exponent);
  return (std::abs(mantissa - 1.0) < 1e-9 ? "" : fmt::format("{:.3g}\u00b7", mantissa)) + "10" + superscripts[exponent];
}

double Sweep::angle_of(const ErrorRow& row) const {
  return angle == "yaw" ? row.yaw_deg : angle == "roll" ? row.roll_deg : row.incidence_deg;
}

std::string Sweep::slug() const {
  std::string id;
  for (const char letter : family) {
    if (std::isalnum(static_cast<unsigned char>(letter)))
      id += letter;
    else if (!id.empty() && id.back() != '-')
      id += '-';
  }
  return id;
}

std::vector<Sweep> sweeps(const Report& report) {
  const ErrorTable& table = report.models.front().table;
  std::map<std::string, const CaseRecord*> records;
  for (const CaseRecord& record : report.reference.cases) records[record.name] = &record;
  std::map<std::string, Sweep> found;
  std::map<std::string, std::set<Channel>> channels;
  for (const ErrorRow& row : table.rows) {
    channels[row.family].insert(row.channel);
    if (row.channel != Channel::drag || row.status == "missing") continue;
    Sweep& sweep = found[row.family];
    sweep.family = row.family;
    sweep.cases.push_back(records.at(row.case_name));
  }
  std::vector<Sweep> list;
  for (auto& [family, sweep] : found) {
    std::array<std::set<double>, 3> angles;  // incidence, yaw, roll
    for (const CaseRecord* record : sweep.cases) {
      angles[0].insert(record->pose.incidence);
      angles[1].insert(record->pose.yaw);
      angles[2].insert(record->pose.roll);
    }
    const auto widest = static_cast<std::size_t>(
        std::max_element(angles.begin(), angles.end(), [](const auto& a, const auto& b) { return a.size() < b.size(); }) - angles.begin());
    sweep.angle = std::array{"incidence", "yaw", "roll"}[widest];
    sweep.curve = angles[widest].size() >= 3;
    if (!channels[family].contains(Channel::lift)) sweep.force = Channel::side, sweep.moment = Channel::yaw;
    const CaseRecord& record = *sweep.cases.front();
    sweep.title = shape_label(record.shape) + " at Re " + reynolds_text(record.reynolds) +
                  (flow_class(record.flow_model) == "k_omega_sst" ? ", k-\u03c9 SST" : ", " + record.flow_model);
    list.push_back(sweep);
  }
  std::stable_sort(list.begin(), list.end(),
                   [](const Sweep& a, const Sweep& b) { return a.cases.front()->reynolds > b.cases.front()->reynolds; });
  return list;
}

std::vector<Coefficients> coefficients_along(const Sweep& sweep, const ModelChoice& choice, const std::vector<double>& angles_deg) {
  CaseRecord record = *sweep.cases.front();
  std::vector<Coefficients> curve;
  for (const double angle : angles_deg) {
    (sweep.angle == "yaw" ? record.pose.yaw : sweep.angle == "roll" ? record.pose.roll : record.pose.incidence) = angle * deg;
    const dragcore::Wrench wrench = predict(record, choice).total();
    curve.push_back(coefficients(record, wrench.force, wrench.torque));
  }
  return curve;
}

std::vector<const ErrorRow*> rows_of(const ErrorTable& table, const Sweep& sweep, Channel channel) {
  std::vector<const ErrorRow*> rows;
  for (const ErrorRow& row : table.rows)
    if (row.family == sweep.family && row.channel == channel && row.status != "missing") rows.push_back(&row);
  std::stable_sort(rows.begin(), rows.end(), [&](const ErrorRow* a, const ErrorRow* b) { return sweep.angle_of(*a) < sweep.angle_of(*b); });
  return rows;
}

}  // namespace compare
