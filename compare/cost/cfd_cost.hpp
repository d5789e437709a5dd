#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "compare/case_record/case_record.hpp"

namespace compare {

/// A mesh level of OpenFOAM: what it costs, and how far it is from the finest level of the same case.
struct CfdCost {
  std::string case_name;
  std::string shape;
  std::string mesh_level;
  double reynolds = 0.0;
  int cells = 0;
  int iterations = 0;
  double mesh_s = 0.0, convert_s = 0.0, solve_s = 0.0;  ///< CPU seconds
  double total_s = 0.0;
  std::optional<double> drag_error;  ///< |C_D - C_D of the finest level|; empty for the finest itself and for cases with one level
  bool finest = false;
};

/// Every usable case, in order of name.
std::vector<CfdCost> cfd_costs(const std::vector<case_record::CaseRecord>& records);

/// What somebody said beforehand about the cost of a CFD case.
struct PredictedCost {
  double cells = 0.0, iterations = 0.0;
  std::map<std::string, double> cpu_s;  ///< by stage
};
/// Empty where nothing was said, as of references from elsewhere.
using CostPredictor = std::function<std::optional<PredictedCost>(const case_record::CaseRecord&)>;

/// One quantity of the prediction over all cases where it is known on both sides.
struct CostCheck {
  std::string quantity;  ///< "cells", "iterations", a stage, or "total": CPU seconds of all stages
  int cases = 0;
  double predicted = 0.0, found = 0.0;  ///< sums
  double rms = 0.0;                     ///< of ln(found / predicted)
  double worst = 1.0;                   ///< found / predicted of the case where it is furthest from 1
  std::string worst_case;

  double ratio() const { return found / predicted; }
};

/// Over the cases that ended by themselves, steady or drifting: a divergence is cheap, a repeated one dear. Empty without any. A mesh that
/// several flows share counts for each of them, on both sides.
std::vector<CostCheck> check_cost(const std::vector<case_record::CaseRecord>& records, const CostPredictor& predict);

}  // namespace compare
