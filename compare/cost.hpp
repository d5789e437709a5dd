#pragma once

#include <optional>
#include <string>
#include <vector>

#include "compare/calibration.hpp"

namespace compare {

/// One option of the drag model on one shape: what it costs and how wrong it is over all orientations of the references.
struct ModelCost {
  std::string shape;
  std::string law;
  std::string pillow;
  int quadrature = 1;
  int triangles = 0;
  double microseconds = 0.0;       ///< per evaluation, one thread, median of repetitions
  double spinning_microseconds = 0.0;  ///< the same for a body that also spins: then the order of quadrature matters
  double rms_drag_error = 0.0;     ///< of C_D
  std::optional<double> rms_moment_error;  ///< of C_m or C_n
  int cases = 0;
};

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

struct CostTable {
  std::vector<ModelCost> models;
  std::vector<CfdCost> cfd;
};

/// @param quick  fewer repetitions and mesh sizes, for tests
CostTable measure_cost(const std::vector<case_record::CaseRecord>& records, const Calibration& calibration, bool quick = false);

}  // namespace compare
