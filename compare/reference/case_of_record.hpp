#pragma once

#include <optional>
#include <string>
#include <vector>

#include "compare/reference/uncertainty.hpp"

namespace compare {

/// What stands for the truth about one body in one pose and flow: of the families that solved it, by one method or another, the one whose
/// force is known best.
struct CaseOfRecord {
  CaseFamily family;                     ///< its `uncertainty` holds the part of the method
  std::vector<CaseFamily> alternatives;  ///< not taken, in order of name
  std::optional<std::size_t>
      other_branch;  ///< the alternative that was stepped the other way in angle and differs by more than 2u: the flow has two branches
  std::string note;  ///< which was taken, what the others say, and why; empty without alternatives
};

/// One for every body, pose, spin and Reynolds number of the records, in order of name. Turbulent families, scale-resolving, with
/// a transition model or neither, compete for the same pose; laminar ones are another flow. Variants of the numerics (dragval variants)
/// compete only where nothing else was solved.
///
/// The smallest standard uncertainty of the force vector, over its length, wins, u_method included: method_uncertainty.toml, and for a flow
/// that was stepped up and down in angle (variants "up" and "down") no less than half the difference between the two.
std::vector<CaseOfRecord> cases_of_record(const std::vector<case_record::CaseRecord>& records);

/// "laminar", or the model of turbulence, scale-resolving, with a transition model or neither: "k_omega_sst".
std::string flow_class(const std::string& flow_model);

}  // namespace compare
