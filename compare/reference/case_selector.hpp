#pragma once

#include <limits>
#include <map>
#include <string>
#include <utility>

#include "compare/case_record/case_record.hpp"

namespace compare {

/// Which cases an entry of published.toml or method_uncertainty.toml is about. What is left out of the file leaves it open.
struct CaseSelector {
  using Range = std::pair<double, double>;
  static constexpr Range any{-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};

  std::string shape;  ///< kind of shape
  std::string flow_model;
  std::map<std::string, Range> ratios;  ///< "span/chord" or "apex_angle_deg": parameters of the shape, or ratios of two of them
  Range incidence_deg = any;
  Range yaw_deg = any;
  Range reynolds = any;

  bool fits(const case_record::CaseRecord& record) const;
};

}  // namespace compare
