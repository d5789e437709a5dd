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
  bool held_out = false;  ///< not to be used for fitting: so the record says or, where it is an experiment, one of the solved cases
  std::string note;       ///< which was taken, what the others say, and why; empty without alternatives
};

/// One for every body, pose, spin and Reynolds number of the records, in order of name. Turbulent families, scale-resolving, with a
/// transition model or neither, compete for the same pose; laminar ones are another flow. Variants of the numerics (dragval variants)
/// compete only where nothing else was solved. An experiment competes, too, but one that does not know the whole force stands only where
/// nothing else does.
///
/// The smallest standard uncertainty of the force vector, over its length, wins, u_method included: method_uncertainty.toml, and for a flow
/// that was stepped up and down in angle (variants "up" and "down") no less than half the difference between the two. A family whose
/// discretisation is not assessed yields to one whose u is complete, unless the entry of its method holds the mesh.
std::vector<CaseOfRecord> cases_of_record(const std::vector<case_record::CaseRecord>& records);

/// What a case is about besides body and pose: "laminar", or the model of turbulence, "k_omega_sst", solved in time, with a transition model
/// or neither. Nature has one flow: an experiment answers what is asked of a turbulent solution from Re 1e4 on, of a laminar one below.
std::string flow_class(const case_record::CaseRecord& record);

/// Whether two cases are about the same body, pose, spin, Reynolds number and flow, whoever solved or measured them.
bool same_question(const case_record::CaseRecord& a, const case_record::CaseRecord& b);

}  // namespace compare
