#include <fmt/format.h>  // before any header of compare: fmt has a function of that name

#include <CLI/CLI.hpp>
#include <atomic>
#include <csignal>
#include <memory>

#include "cfd_cases/campaign/slurm.hpp"
#include "cfd_cases/programs/subprocess.hpp"
#include "compare/cli/campaign_options.hpp"
#include "compare/cli/commands.hpp"

namespace cli {

namespace {

std::atomic<bool> interrupted = false;
static_assert(std::atomic<bool>::is_always_lock_free, "set from a signal handler");

/// By the shell's convention: 128 + SIGINT.
constexpr int kInterrupted = 130;

}  // namespace

void add_run(CLI::App& app, Context& context) {
  struct Options {
    CampaignInput input;
    cfd_cases::CampaignOptions campaign{.jobs = 0};
    cfd_cases::SlurmOptions slurm;
    std::string executor = "local", partition;
    bool dry_run = false;
  };
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("run", "Solves the cases of a matrix that are not in the cache yet, with gmsh and OpenFOAM");
  add_campaign_options(*command, options->input);
  command->add_option("--key", options->input.key,
                      "with --only NAME: the case of exactly this name and key, as each job on Slurm asks for it");
  command->add_option("-j,--jobs,--slots", options->campaign.jobs, "cases side by side: 1 by default, on Slurm as many as it gives")
      ->check(CLI::Range(1, 100000));
  command->add_option("--ranks", options->campaign.ranks, "MPI ranks of each case")->check(CLI::Range(1, 1024))->capture_default_str();
  command->add_flag("--dry-run", options->dry_run, "say what would be solved, and end");
  command->add_flag("--retry-failed", options->campaign.retry_failed, "solve stored cases that failed, diverged or drifted once more");
  command->add_flag("--keep", options->campaign.keep, "keep the OpenFOAM folders of cases that went well, under CACHE/work");
  command->add_option("--executor", options->executor, "local or slurm: job arrays, one case each; the same command follows them again")
      ->check(CLI::IsMember({"local", "slurm"}))
      ->capture_default_str();
  command->add_option("--partition", options->partition, "of Slurm");
  command
      ->add_option("--sbatch-option", options->slurm.sbatch_options, "more for sbatch, such as --sbatch-option=--account=wind; repeatable")
      ->allow_extra_args(false);
  command->add_flag("--detach", options->slurm.detach, "submit to Slurm, and end");
  command->footer("Example:  dragval run quick -j2\nCtrl-C, and even kill -9, loses the running cases only; the same command goes on.");
  command->callback([options, &context] {
    const cfd_cases::Tools tools = cfd_cases::find_tools();
    if (options->campaign.ranks > 1 && cfd_cases::find_program("mpirun").empty())
      throw EnvironmentError("--ranks needs mpirun, which is not on PATH: apt-get install openmpi-bin");
    const bool on_slurm = options->executor == "slurm";
    if (!options->partition.empty()) options->slurm.sbatch_options.push_back("--partition=" + options->partition);
    if (!on_slurm && (options->slurm.detach || !options->slurm.sbatch_options.empty()))
      throw UsageError("--detach, --partition and --sbatch-option belong to --executor slurm");
    if (!on_slurm && options->campaign.jobs == 0) options->campaign.jobs = 1;
    const auto cases = plan_cases(options->input, tools);
    if (options->dry_run) {
      for (const auto& planned : cases)
        if (planned.to_solve(options->campaign.retry_failed)) fmt::print("{}\n", planned.spec.name);
      return;
    }
    std::signal(SIGINT, [](int) { interrupted = true; });
    std::signal(SIGTERM, [](int) { interrupted = true; });
    const cfd_cases::Cache cache{options->input.cache};
    options->slurm.matrix = cfd_cases::load_matrix(options->input.matrix).file;
    const auto result = on_slurm ? cfd_cases::run_on_slurm(cases, tools, cache, run_store(), options->campaign, options->slurm, interrupted)
                                 : cfd_cases::run_campaign(cases, tools, cache, run_store(), options->campaign, interrupted);
    fmt::print("{} solved, {} were in the cache, {} of {} not usable\n", result.solved, result.cached, result.unusable.size(),
               cases.size());
    for (const auto& record : result.unusable)
      fmt::print(stderr, "\n{}: {}, {}\n  folder: {}\n  repeat: dragval run {} --only {} --retry-failed --cache {}{}\n", record.name,
                 case_record::to_string(record.status), record.reason, cache.work(record.key).string(), options->input.matrix, record.name,
                 options->input.cache, on_slurm ? " --executor slurm" : "");
    if (!result.unusable.empty()) context.exit_code = exit_code::run_failed;
    if (result.interrupted) context.exit_code = kInterrupted;
  });
}

}  // namespace cli
