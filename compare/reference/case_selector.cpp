#include "compare/reference/case_selector.hpp"

#include <algorithm>
#include <numbers>
#include <optional>

#include "compare/reference/read_selector.hpp"

namespace compare {
namespace {

using Range = CaseSelector::Range;

Range range_from(const toml::node& node, double slack) {
  if (const toml::array* pair = node.as_array(); pair && pair->size() == 2)
    return {pair->get(0)->value<double>().value(), pair->get(1)->value<double>().value()};
  const double value = node.value<double>().value();
  return {value - slack, value + slack};
}

bool holds(const Range& range, double value) { return range.first <= value && value <= range.second; }

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

}  // namespace

bool read_selector(CaseSelector& selector, const std::string& key, const toml::node& node) {
  constexpr double half_degree = 0.5;
  if (key == "shape")
    selector.shape = node.value<std::string>().value();
  else if (key == "flow_model")
    selector.flow_model = node.value<std::string>().value();
  else if (key == "ratios")
    for (const auto& [ratio, value] : *node.as_table())
      selector.ratios[std::string(ratio.str())] = range_from(value, 0.01 * value.value_or(0.0));
  else if (key == "incidence_deg")
    selector.incidence_deg = range_from(node, half_degree);
  else if (key == "yaw_deg")
    selector.yaw_deg = range_from(node, half_degree);
  else if (key == "reynolds")
    selector.reynolds = range_from(node, 0.01 * node.value_or(0.0));
  else
    return false;
  return true;
}

bool CaseSelector::fits(const case_record::CaseRecord& record) const {
  constexpr double deg = std::numbers::pi / 180.0;
  return (shape.empty() || dragcore::kind(record.shape) == shape) && (flow_model.empty() || record.flow_model == flow_model) &&
         holds(reynolds, record.reynolds) && holds(incidence_deg, record.pose.incidence / deg) && holds(yaw_deg, record.pose.yaw / deg) &&
         std::all_of(ratios.begin(), ratios.end(), [&](const auto& ratio) {
           const auto value = ratio_of(record.shape, ratio.first);
           return value && holds(ratio.second, *value);
         });
}

}  // namespace compare
