#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "cfd_cases/campaign/campaign.hpp"
#include "cfd_cases/programs/tools.hpp"

namespace cfd_cases {

/// A case as Slurm knows it. Nothing of this is stored: Slurm is asked by the name of the job, which is that of its folder
/// CACHE/slurm/NAME, so that no record can get out of step with the queue.
struct SlurmTask {
  std::string job_name, job;  ///< "dragval-20250131T120000-1a2b3c4d", "17_3"; the second is empty when Slurm forgot the job
  std::string state;          ///< Slurm's word, or what the job's log says once Slurm forgot it; "UNKNOWN" when that says nothing
  std::string reason;         ///< why it waits, in Slurm's words
  std::filesystem::path log;  ///< may not exist

  bool queued() const;           ///< it will start by itself
  bool running() const;          ///< or about to start or to end
  bool held() const;             ///< given up by Slurm after too many starts: it stays in the queue and never starts
  bool ended_by_slurm() const;   ///< time limit, memory, lost node, ...; not a cancellation, which is somebody's will
  std::string describe() const;  ///< "queued in Slurm, job 17_3 (Resources)"
};

/// The newest job of every case that was ever given to Slurm from this cache, by the key of the case. @throws EnvironmentFault when squeue
/// does not answer
std::map<std::string, SlurmTask> slurm_tasks(const Cache& cache);

struct SlurmOptions {
  std::filesystem::path matrix;             ///< copied, so that an edit does not reach jobs that wait
  std::vector<std::string> sbatch_options;  ///< "--account=wind"; they win over what is chosen here
  bool detach = false;                      ///< end once all is submitted
};

/// run_campaign() with Slurm instead of threads: the cases that Slurm does not hold yet are submitted as job arrays, one per class of cost,
/// each task of which runs this program for one case, and are followed until their records are in the cache. `options.jobs` is the largest
/// number of cases at a time, 0 for as many as Slurm gives. A case whose job Slurm ended gets a record that says why. When `cancel` becomes
/// true the jobs go on.
/// @throws EnvironmentFault without Slurm, and when sbatch refuses, in its own words
CampaignResult run_on_slurm(const std::vector<PlannedCase>& cases, const Tools& tools, const Cache& cache, const RunStore& store,
                            const CampaignOptions& options, const SlurmOptions& slurm, const std::atomic<bool>& cancel);

/// What a job asks for.
struct SlurmLimits {
  int memory_mb = 0;
  int minutes = 0;

  auto operator<=>(const SlurmLimits&) const = default;
};
SlurmLimits slurm_limits(const PlannedCase& planned, int ranks);

/// Seconds of a slot that a case costs on Slurm beyond its stages: start of the job, of this program, end of the job; docs/cluster.md,
/// "Overhead".
inline constexpr double kSlurmOverhead_s = 2.5;

/// Wall time of jobs that are given, the longest first, to whichever slot is free.
double list_schedule_s(std::vector<double> seconds, int slots);

/// The line of `dragval doctor` on Slurm: programs, configuration, controller.
Check check_slurm();

}  // namespace cfd_cases
