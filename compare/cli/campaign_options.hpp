#pragma once

#include <string>

#include "cfd_cases/campaign.hpp"
#include "compare/cost.hpp"

namespace cli {

/// The matrix, the cache and the choice of cases that plan, run and explain share.
struct CampaignInput {
  std::string matrix = "quick";
  std::string cache = ".dragval";
  std::string only;
};

/// Runs are stored in compare's HDF5 files.
cfd_cases::RunStore run_store();

/// The cases of the matrix that `only` leaves, looked up in the cache. @throws UsageError when it leaves none
std::vector<cfd_cases::PlannedCase> plan_cases(const CampaignInput& input, const cfd_cases::Tools& tools);

/// The repository's cost model, as the comparison asks for it.
compare::CostPredictor cost_predictor();

}  // namespace cli
