#include "compare/report/report_sweep.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "compare/calibration/prediction.hpp"
#include "compare/reference/uncertainty.hpp"

namespace compare {
namespace {

constexpr double deg = std::numbers::pi / 180.0;
constexpr std::array angle_names = {"incidence", "yaw", "roll"};

std::array<double, 3> angles_of(const ErrorRow& row) { return {row.incidence_deg, row.yaw_deg, row.roll_deg}; }

std::string pose_text(const std::array<double, 3>& angles_deg) {
  std::string text;
  for (std::size_t k = 0; k < 3; ++k)
    if (angles_deg[k] != 0.0) text += fmt::format("{}{} {:.4g}\u00b0", text.empty() ? "" : ", ", angle_names[k], angles_deg[k]);
  return text.empty() ? "0\u00b0" : text;
}

/// Rows whose poses differ in one angle alone, in its order.
struct Line {
  std::size_t angle = 0;  ///< index into angle_names
  std::vector<const ErrorRow*> rows;
};

/// The line with the most rows, of those whose rows are not all told: `fewest` are needed, and two of them new unless `told` is empty.
Line longest_line(const std::vector<const ErrorRow*>& rows, const std::set<const ErrorRow*>& told, std::size_t fewest) {
  constexpr double same = 1e-6;  // [deg]: poses are written with at most seven decimals
  Line longest;
  std::ptrdiff_t most_new = 0;
  for (std::size_t k = 0; k < 3; ++k)
    for (const ErrorRow* through : rows) {
      Line line{k, {}};
      for (const ErrorRow* row : rows) {
        const auto a = angles_of(*through), b = angles_of(*row);
        const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
        if (std::abs(a[i] - b[i]) < same && std::abs(a[j] - b[j]) < same) line.rows.push_back(row);
      }
      const auto fresh = std::count_if(line.rows.begin(), line.rows.end(), [&](const ErrorRow* row) { return !told.contains(row); });
      if (line.rows.size() < fewest || fresh < (told.empty() ? 1 : 2) || fresh <= most_new) continue;
      most_new = fresh;
      longest = std::move(line);
    }
  std::stable_sort(longest.rows.begin(), longest.rows.end(),
                   [&](const ErrorRow* a, const ErrorRow* b) { return angles_of(*a)[longest.angle] < angles_of(*b)[longest.angle]; });
  return longest;
}

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

bool Sweep::holds(const ErrorRow& row) const {
  return std::any_of(cases.begin(), cases.end(), [&](const CaseRecord* record) { return record->name == row.case_name; });
}

std::string slug_of(const std::string& text) {
  std::string id;
  for (const char letter : text) {
    if (std::isalnum(static_cast<unsigned char>(letter)))
      id += letter;
    else if (!id.empty() && id.back() != '-')
      id += '-';
  }
  if (id.ends_with('-')) id.pop_back();
  return id;
}

std::string Sweep::slug() const { return slug_of(detail.empty() ? family : family + " " + detail); }

std::string pose_text(const ErrorRow& row) { return pose_text(std::array{row.incidence_deg, row.yaw_deg, row.roll_deg}); }

std::vector<Sweep> sweeps(const Report& report) {
  std::map<std::string, const CaseRecord*> records;
  for (const CaseRecord& record : report.reference.cases) records[record.name] = &record;
  std::map<std::string, std::vector<const ErrorRow*>> families;
  for (const ErrorRow& row : report.models.front().table.rows)
    if (row.channel == Channel::drag && row.status != "missing") families[row.family].push_back(&row);

  std::vector<Sweep> list;
  for (const auto& [family, rows] : families) {
    std::set<const ErrorRow*> told;
    for (bool first = true;; first = false) {
      const Line line = longest_line(rows, told, first ? 1 : 3);
      if (line.rows.empty()) break;
      told.insert(line.rows.begin(), line.rows.end());
      Sweep sweep{.family = family, .angle = angle_names[line.angle]};
      sweep.curve = line.rows.size() >= 3;
      if (line.angle == 1) sweep.force = Channel::side, sweep.moment = Channel::yaw;
      for (const ErrorRow* row : line.rows) sweep.cases.push_back(records.at(row->case_name));
      const ErrorRow& row = *line.rows.front();
      sweep.title = row.shape + " at Re " + reynolds_text(row.reynolds) +
                    (row.flow_class == "k_omega_sst" ? ", k-\u03c9 SST" : ", " + row.flow_class);
      std::array<double, 3> fixed = angles_of(row);
      fixed[line.angle] = 0.0;
      const bool turned = std::any_of(fixed.begin(), fixed.end(), [](double angle) { return angle != 0.0; });
      if (!first || turned) sweep.detail = sweep.angle + (turned ? " at " + pose_text(fixed) : "");
      if (!sweep.detail.empty()) sweep.title += ", " + sweep.detail;
      list.push_back(sweep);
    }
  }
  std::stable_sort(list.begin(), list.end(),
                   [](const Sweep& a, const Sweep& b) { return a.cases.front()->reynolds > b.cases.front()->reynolds; });
  return list;
}

std::vector<const ErrorRow*> rows_off_sweeps(const ErrorTable& table, const std::vector<Sweep>& list) {
  std::vector<const ErrorRow*> rows;
  for (const ErrorRow& row : table.rows)
    if (row.status != "missing" && std::none_of(list.begin(), list.end(), [&](const Sweep& sweep) { return sweep.holds(row); }))
      rows.push_back(&row);
  return rows;
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
    if (row.channel == channel && row.status != "missing" && sweep.holds(row)) rows.push_back(&row);
  std::stable_sort(rows.begin(), rows.end(), [&](const ErrorRow* a, const ErrorRow* b) { return sweep.angle_of(*a) < sweep.angle_of(*b); });
  return rows;
}

}  // namespace compare
