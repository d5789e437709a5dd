#pragma once

#include <string>
#include <vector>

#include "compare/reference/case_selector.hpp"

namespace compare {

/// What the equations of a method leave open, however fine the mesh: one entry of method_uncertainty.toml.
struct MethodUncertainty {
  CaseSelector cases;
  double relative = 0.0;    ///< one standard uncertainty over the force
  bool holds_mesh = false;  ///< `relative` was judged from solutions on other meshes and covers the error of a single one
  std::string reason;
  std::string evidence;  ///< key in references.bib, or the command that shows it
};

/// All entries, as compiled into the library; the first that fits a case counts.
const std::vector<MethodUncertainty>& method_uncertainties();

/// @return  nullptr when no entry fits, and for bodies that spin: nothing is known of the method
const MethodUncertainty* method_uncertainty(const case_record::CaseRecord& record);

}  // namespace compare
