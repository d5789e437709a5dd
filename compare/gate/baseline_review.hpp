#pragma once

#include <string>
#include <vector>

#include "compare/gate/baseline.hpp"

namespace compare {

/// What accepting a baseline means, for someone who is to agree to it: per model and channel how many errors shrink and grow, and by how
/// many u, then the cases that change most.
struct BaselineReview {
  /// Of the cases that both baselines have, in one channel of one model.
  struct Group {
    std::string model, channel;
    int cases = 0, better = 0, worse = 0;   ///< beyond rounding
    int better_by_2u = 0, worse_by_2u = 0;  ///< of these, |error| changes by more than twice the numerical u of the reference
    double rms_before = 0.0, rms_after = 0.0;
  };
  struct CaseChange {
    std::string model, case_name, channel;
    double error_before = 0.0, error_after = 0.0;  ///< model - CFD
    double u = 0.0;                                ///< numerical, of the reference now
    double growth_in_u() const;                    ///< of |error|; over a thousandth where u is less
  };
  int cases_added = 0, cases_removed = 0, references_changed = 0;  ///< references: cases whose CFD or u is another one
  std::vector<Group> groups;                                       ///< those in which anything changed
  std::vector<CaseChange> largest;                                 ///< by change of |error| in u, at most ten for each model
};

BaselineReview review(const Baseline& before, const Baseline& after);

std::string render(const BaselineReview& review, Format format);  ///< table, md or json; @throws std::invalid_argument for csv

}  // namespace compare
