#include "compare/published.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <numbers>
#include <stdexcept>

#include "compare/uncertainty.hpp"

extern const char* const published_toml;  // published.toml, compiled in (CMakeLists.txt)

namespace compare {
namespace {

using Range = PublishedEntry::Range;

constexpr double deg = std::numbers::pi / 180.0;

/// A number stands for itself within 1 % (or half a degree), a pair for everything between.
Range range_from(const toml::node& node, double slack) {
  if (const toml::array* pair = node.as_array(); pair && pair->size() == 2)
    return {pair->get(0)->value<double>().value(), pair->get(1)->value<double>().value()};
  const double value = node.value<double>().value();
  return {value - slack, value + slack};
}

bool holds(const Range& range, double value) { return range.first <= value && value <= range.second; }

PublishedEntry entry_from(const toml::table& table) {
  constexpr double half_degree = 0.5;
  PublishedEntry entry;
  entry.incidence_deg = entry.yaw_deg = {-half_degree, half_degree};
  for (const auto& [key, node] : table) {
    const std::string name(key.str());
    const auto text = [&] { return node.value<std::string>().value(); };
    const auto number = [&] { return node.value<double>().value(); };
    if (name == "shape")
      entry.shape = text();
    else if (name == "ratios")
      for (const auto& [ratio, value] : *node.as_table())
        entry.ratios[std::string(ratio.str())] = range_from(value, 0.01 * value.value_or(0.0));
    else if (name == "incidence_deg")
      entry.incidence_deg = range_from(node, half_degree);
    else if (name == "yaw_deg")
      entry.yaw_deg = range_from(node, half_degree);
    else if (name == "reynolds")
      entry.reynolds = range_from(node, 0.01 * node.value_or(0.0));
    else if (name == "quantity")
      entry.quantity = text();
    else if (name == "value")
      entry.published.value = number();
    else if (name == "uncertainty")
      entry.published.uncertainty = number();
    else if (name == "citation")
      entry.published.citation = text();
    else if (name == "kind")
      entry.published.kind = text();
    else if (name == "confidence")
      entry.published.confidence = text();
    else if (name == "conversion")
      entry.published.conversion = text();
    else if (name == "area_factor")
      entry.area_factor = number();
    else if (name == "goal")
      entry.goal = number();
    else if (name == "note_label")
      entry.note_label = text();
    else
      throw std::invalid_argument(fmt::format("published.toml, line {}: unknown key '{}'", key.source().begin.line, name));
  }
  return entry;
}

/// The value of "span" or "span/chord" for this shape, if it has these parameters.
std::optional<double> ratio_of(const dragcore::Shape& shape, const std::string& ratio) {
  const auto parameters = dragcore::parameters(shape);
  const std::size_t slash = ratio.find('/');
  const auto above = parameters.find(ratio.substr(0, slash));
  if (above == parameters.end()) return std::nullopt;
  if (slash == std::string::npos) return above->second;
  const auto below = parameters.find(ratio.substr(slash + 1));
  if (below == parameters.end()) return std::nullopt;
  return above->second / below->second;
}

std::optional<double> measured(const case_record::CaseRecord& record, const std::string& quantity) {
  const Coefficients c = coefficients(record);
  if (quantity == "C_D") return c[Channel::drag];
  if (quantity == "C_L") return c[Channel::lift];
  if (quantity == "force_angle_deg") return std::atan2(*c[Channel::drag], *c[Channel::lift]) / deg;
  return std::nullopt;  // of bodies that spin: nothing here measures it yet
}

}  // namespace

bool PublishedEntry::fits(const case_record::CaseRecord& record) const {
  return dragcore::kind(record.shape) == shape && holds(reynolds, record.reynolds) && holds(incidence_deg, record.pose.incidence / deg) &&
         holds(yaw_deg, record.pose.yaw / deg) && std::all_of(ratios.begin(), ratios.end(), [&](const auto& ratio) {
           const auto value = ratio_of(record.shape, ratio.first);
           return value && holds(ratio.second, *value);
         });
}

PublishedValue PublishedEntry::on_reference_area(const case_record::CaseRecord& record) const {
  PublishedValue converted = published;
  // A force normal to the plate has the direction of its incidence: the one value that depends on the case.
  if (quantity == "force_angle_deg") converted.value = record.pose.incidence / deg;
  converted.value *= area_factor;
  converted.uncertainty *= area_factor;
  return converted;
}

const std::vector<PublishedEntry>& published_entries() {
  static const std::vector<PublishedEntry> entries = [] {
    std::vector<PublishedEntry> list;
    const toml::table file = toml::parse(std::string_view(published_toml), std::string_view("published.toml"));
    for (const toml::node& node : *file["value"].as_array()) list.push_back(entry_from(*node.as_table()));
    return list;
  }();
  return entries;
}

std::optional<PublishedValue> published_value(const case_record::CaseRecord& record, const std::string& quantity) {
  for (const PublishedEntry& entry : published_entries())
    if (entry.quantity == quantity && entry.fits(record)) return entry.on_reference_area(record);
  return std::nullopt;
}

std::vector<PublishedCheck> published_checks(const std::vector<case_record::CaseRecord>& records) {
  std::vector<PublishedCheck> checks;
  for (const CaseFamily& family : case_families(records)) {
    if (!case_record::is_usable(family.record->status)) continue;
    for (const PublishedEntry& entry : published_entries())
      if (const auto cfd = measured(*family.record, entry.quantity); cfd && entry.fits(*family.record))
        checks.push_back({family.record->name, entry.quantity, *cfd, entry.on_reference_area(*family.record), entry.goal});
  }
  return checks;
}

}  // namespace compare
