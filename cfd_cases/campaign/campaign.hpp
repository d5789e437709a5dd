#pragma once

#include <atomic>
#include <compare/case_record/case_record.hpp>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cfd_cases/campaign/cost_model.hpp"
#include "cfd_cases/flow_case/case_mesh.hpp"
#include "cfd_cases/flow_case/matrix.hpp"

namespace cfd_cases {

/// How finished cases are kept: cfd_cases knows records, the caller knows the file format. Both throw when the file system or the file is
/// bad.
struct RunStore {
  std::function<void(const std::filesystem::path&, const case_record::CaseRecord&)> write;
  std::function<case_record::CaseRecord(const std::filesystem::path&)> read;
};

/// A case of the matrix and what the cache knows of it.
struct PlannedCase {
  CaseSpec spec;
  CaseIdentity identity;
  std::optional<case_record::CaseRecord> cached;
  bool keep_fields = false;     ///< a case of the matrix starts from its fields
  bool fields_missing = false;  ///< such a case is to be solved, and the fields are not in the cache

  CostEstimate estimate;                ///< of solving it, on the machine of the fit
  Pace pace;                            ///< of this machine, the same for all cases of a plan
  double predicted_cpu_s = 0.0;         ///< of all stages, here
  double predicted_memory_bytes = 0.0;  ///< largest resident set, on one rank

  bool to_solve(bool retry_failed) const { return !cached || fields_missing || (retry_failed && !case_record::is_usable(cached->status)); }
};

/// Whether `only` means this case: a shell pattern (* ? [...]) on its name, or part of it; empty for every case.
bool named(const std::string& only, const std::string& case_name);

/// @param known  cases solved elsewhere, by key: they count as cached, so that a campaign goes on from a committed file of references
/// @param only   which cases, as named() reads it
/// Costs come from the model in cost_model_file(), scaled by the pace of the cases that are cached. A case that is to be solved pays
/// nothing for a mesh that is cached, or that an earlier case of the plan makes.
std::vector<PlannedCase> plan(const Matrix& matrix, const Tools& tools, const Cache& cache, const RunStore& store,
                              const std::string& only = {}, const std::map<std::string, case_record::CaseRecord>& known = {});

/// CPU seconds of the cases of a plan that are not cached, with one standard uncertainty: that of each case, and of the pace for all.
struct PredictedSum {
  double cpu_s = 0.0, uncertainty = 0.0;
};
PredictedSum predicted_sum(const std::vector<PlannedCase>& cases);

struct CampaignOptions {
  int jobs = 1;   ///< cases side by side
  int ranks = 1;  ///< MPI ranks of each
  bool retry_failed = false;
  bool keep = false;  ///< the folders of cases that went well, too
};

struct CampaignResult {
  int solved = 0;  ///< now, usable or not
  int cached = 0;  ///< before, or by somebody else meanwhile
  bool interrupted = false;
  std::vector<case_record::CaseRecord> unusable;  ///< of all cases planned
};

/// Solves what is missing and stores each case as it ends. Cases are independent: after a kill at any moment only those at work are lost.
/// Campaigns on the same cache share the work: a case that another one holds is left to it and waited for at the end. Progress goes to
/// stderr: one line per finished case, and on a terminal a status line besides.
CampaignResult run_campaign(const std::vector<PlannedCase>& cases, const Tools& tools, const Cache& cache, const RunStore& store,
                            const CampaignOptions& options, const std::atomic<bool>& cancel);

/// Words of the progress: "sphere_incidence-000_re-1e2-laminar_coarse: steady, C_D 1.1382 (4213 cells, 150 iterations, 4 s)", "3 min left".
std::string outcome_line(const case_record::CaseRecord& record, double wall_s);
std::string time_left(double seconds);

}  // namespace cfd_cases
