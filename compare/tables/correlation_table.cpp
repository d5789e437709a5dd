#include "compare/tables/correlation_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <numbers>
#include <tuple>

#include "compare/peers/correlations.hpp"
#include "compare/tables/text_grid.hpp"

namespace compare {
namespace {

using case_record::CaseRecord;

constexpr double highest_reynolds = 1.01e4;

/// Mean of |error| / reference over the rows where there is a value.
std::string mean_error(const std::vector<const CorrelationRow*>& rows,
                       const std::function<std::optional<double>(const CorrelationRow&)>& of) {
  double sum = 0.0;
  int n = 0;
  for (const CorrelationRow* row : rows)
    if (const auto value = of(*row)) sum += std::abs(*value / row->reference - 1.0), ++n;
  return n == 0 ? "" : fmt::format("{:.0f} % of {}", 100.0 * sum / n, n);
}

/// One line: the law and each of the correlations, with the number of rows that they speak of.
std::vector<std::string> mean_line(const std::string& name, const std::vector<const CorrelationRow*>& rows) {
  const auto law = [](const CorrelationRow& row) { return std::optional(row.law); };
  std::vector<std::string> cells = {name, mean_error(rows, law)};
  for (std::size_t k = 0; k < peers::correlations().size(); ++k)
    cells.push_back(mean_error(rows, [k](const CorrelationRow& row) { return row.correlations[k]; }));
  return cells;
}

}  // namespace

std::optional<double> correlated_drag(const CaseRecord& record, std::size_t index) {
  const peers::Correlation& correlation = peers::correlations().at(index);
  if (correlation.ball_only && !std::holds_alternative<dragcore::Sphere>(record.shape)) return std::nullopt;
  const auto particle = peers::particle(record.shape, record.pose.rotation().transpose() * Eigen::Vector3d::UnitX());
  if (!particle) return std::nullopt;
  const dragcore::ShapeProperties body = dragcore::properties(record.shape);
  const double reynolds = record.reynolds * particle->diameter / body.reference_length;
  return correlation.drag(reynolds, *particle) * std::numbers::pi / 4.0 * particle->diameter * particle->diameter / body.reference_area;
}

std::vector<CorrelationRow> correlation_table(const std::vector<CaseRecord>& records, const Predictor& law) {
  std::vector<CorrelationRow> rows;
  for (const CaseOfRecord& chosen : cases_of_record(records)) {
    const CaseRecord& record = *chosen.family.record;
    const auto drag = coefficients(record)[Channel::drag];
    if (!case_record::is_usable(record.status) || record.spins() || record.reynolds > highest_reynolds || !drag) continue;
    const dragcore::Wrench predicted = law(record);
    CorrelationRow row{.case_name = record.name, .reynolds = record.reynolds, .reference = *drag};
    row.u = chosen.family.uncertainty.total[0] / coefficient_scales(record)[0];
    row.law = *coefficients(record, predicted.force, predicted.torque)[Channel::drag];
    for (std::size_t k = 0; k < peers::correlations().size(); ++k) row.correlations.push_back(correlated_drag(record, k));
    rows.push_back(std::move(row));
  }
  std::stable_sort(rows.begin(), rows.end(), [](const CorrelationRow& a, const CorrelationRow& b) { return a.reynolds < b.reynolds; });
  return rows;
}

std::string render(const std::vector<CorrelationRow>& rows, const std::string& law_name, Format format, bool colour) {
  if (format == Format::json) return to_json(rows).dump(2) + "\n";
  std::vector<std::string> names;
  for (const peers::Correlation& correlation : peers::correlations()) names.push_back(correlation.name);
  if (format == Format::csv) {
    std::vector<std::string> head = {"case", "reynolds", "reference", "u", "law"};
    head.insert(head.end(), names.begin(), names.end());
    std::string text = csv_line(head);
    for (const CorrelationRow& row : rows) {
      const auto full = [](const std::optional<double>& value) { return number_text(value, "{:.9g}"); };
      std::vector<std::string> cells = {row.case_name, full(row.reynolds), full(row.reference), full(row.u), full(row.law)};
      for (const auto& value : row.correlations) cells.push_back(full(value));
      text += csv_line(cells);
    }
    return text;
  }
  TextGrid grid, means;
  std::vector<std::string> head = {"case", "reference", "u", "law"}, mean_head = {"mean |error| of C_D", "law"};
  head.insert(head.end(), names.begin(), names.end());
  mean_head.insert(mean_head.end(), names.begin(), names.end());
  grid.add(head);
  means.add(mean_head);
  std::vector<const CorrelationRow*> all, of_reynolds;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const CorrelationRow& row = rows[i];
    std::vector<std::string> cells = {row.case_name, number_text(row.reference), number_text(row.u, "{:.2g}"), number_text(row.law)};
    for (const auto& value : row.correlations) cells.push_back(number_text(value));
    grid.add(cells);
    all.push_back(&row);
    of_reynolds.push_back(&row);
    if (i + 1 < rows.size() && rows[i + 1].reynolds == row.reynolds) continue;
    means.add(mean_line(fmt::format("Re {:g}", row.reynolds), of_reynolds));
    of_reynolds.clear();
  }
  means.add(mean_line("all", all));
  const std::string title = fmt::format("C_D up to Re 1e4: law {} and correlations of particles, which give drag alone", law_name);
  if (format == Format::table) return title + "\n" + aligned(grid, colour) + "\n" + aligned(means, colour);
  return "### " + title + "\n\n" + markdown(grid) + "\n" + markdown(means);
}

nlohmann::json to_json(const std::vector<CorrelationRow>& rows) {
  nlohmann::json list = nlohmann::json::array();
  for (const CorrelationRow& row : rows) {
    nlohmann::json entry = {
        {"case", row.case_name}, {"reynolds", row.reynolds}, {"reference", row.reference}, {"u", row.u}, {"law", row.law}};
    for (std::size_t k = 0; k < row.correlations.size(); ++k) entry[peers::correlations()[k].name] = optional_json(row.correlations[k]);
    list.push_back(entry);
  }
  return list;
}

}  // namespace compare
