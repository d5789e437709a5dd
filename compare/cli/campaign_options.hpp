#pragma once

#include <string>

#include "cfd_cases/campaign/campaign.hpp"
#include "compare/cost/cfd_cost.hpp"

namespace CLI {
class App;
}

namespace cli {

/// The matrix, the cache and the choice of cases that plan, run and explain share.
struct CampaignInput {
  std::string matrix = "quick";
  std::string cache = ".dragval";
  std::string only;
  std::string key;    ///< when given, `only` is the full name of the one case, which must have this key
  std::string known;  ///< file of references whose cases are not solved again; empty for none
};

/// The options that plan and run share.
void add_campaign_options(CLI::App& command, CampaignInput& input);

/// Runs are stored in compare's HDF5 files.
cfd_cases::RunStore run_store();

/// The cases of the matrix that `only` leaves, looked up in the cache. @throws UsageError when it leaves none
std::vector<cfd_cases::PlannedCase> plan_cases(const CampaignInput& input, const cfd_cases::Tools& tools);

/// The repository's cost model, as the comparison asks for it.
compare::CostPredictor cost_predictor();

}  // namespace cli
