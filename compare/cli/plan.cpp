#include <fmt/format.h>  // before any header of compare: fmt has a function of that name

#include <CLI/CLI.hpp>
#include <cmath>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "cfd_cases/campaign/slurm.hpp"
#include "compare/cli/campaign_options.hpp"
#include "compare/cli/commands.hpp"

namespace cli {

cfd_cases::RunStore run_store() { return {.write = compare::write_run, .read = compare::read_run}; }

std::vector<cfd_cases::PlannedCase> plan_cases(const CampaignInput& input, const cfd_cases::Tools& tools) {
  std::map<std::string, case_record::CaseRecord> known;
  if (!input.known.empty())
    for (case_record::CaseRecord& record : compare::read_reference(input.known).cases) {
      const std::string key = record.key;
      known[key] = std::move(record);
    }
  auto matrix = cfd_cases::load_matrix(input.matrix);
  // What starts from the case stays in the plan, which therefore keeps its fields; thousands of others need not be looked up.
  if (!input.key.empty())
    std::erase_if(matrix.cases, [&](const cfd_cases::CaseSpec& spec) {
      return spec.name != input.only && !(spec.start && spec.start->name == input.only);
    });
  auto cases = cfd_cases::plan(matrix, tools, {input.cache}, run_store(), input.key.empty() ? input.only : "", known);
  if (!input.key.empty()) {
    std::erase_if(cases, [&](const auto& planned) { return planned.identity.key != input.key; });
    if (cases.empty())
      throw UsageError(fmt::format("{} does not have the key {}: keys hold the versions of the tools, here OpenFOAM {} and gmsh {}",
                                   input.only, input.key, tools.openfoam, tools.gmsh));
  }
  if (cases.empty())
    throw UsageError(
        fmt::format("no case of the matrix {} has '{}' in its name: `dragval plan {}` lists them", input.matrix, input.only, input.matrix));
  return cases;
}

void add_campaign_options(CLI::App& command, CampaignInput& input) {
  command.add_option("matrix", input.matrix, "smoke, quick, reference or a TOML file")->capture_default_str();
  command.add_option("--only", input.only, "cases whose name holds this, or matches this pattern with * ? []");
  command.add_option("--cache", input.cache, "folder of solved cases")->capture_default_str();
  command.add_option("--known", input.known, "file of references, such as results/reference.h5: what it holds is not solved again");
}

compare::CostPredictor cost_predictor() {
  return [model = cfd_cases::read_cost_model(cfd_cases::cost_model_file())](
             const case_record::CaseRecord& record) -> std::optional<compare::PredictedCost> {
    const auto known = cfd_cases::described_case(record.description);
    if (!known || !model.methods.contains(known->spec.flow_model)) return std::nullopt;
    const cfd_cases::CostEstimate estimate = model.estimate(known->spec, known->identity);
    return compare::PredictedCost{estimate.cells, estimate.iterations, estimate.cpu_s};
  };
}

namespace {

/// The costs of the matrix over and over, until there are `count` of them, given to slots.
void simulate(const std::vector<cfd_cases::PlannedCase>& cases, int count, int slots, double overhead_s) {
  std::vector<double> seconds;
  double cpu_s = 0.0;
  for (int i = 0; i < count; ++i) {
    const double cost = cases[static_cast<std::size_t>(i) % cases.size()].predicted_cpu_s;
    cpu_s += cost;
    seconds.push_back(cost + overhead_s);
  }
  const double wall_s = cfd_cases::list_schedule_s(seconds, slots), paid_s = wall_s * slots;
  fmt::print("{} cases, {:.1f} CPU h: {:.1f} min on {} slots, which work for {:.1f} % of it, start and end jobs for {:.1f} %\n", count,
             cpu_s / 3600.0, wall_s / 60.0, slots, 100.0 * cpu_s / paid_s, 100.0 * count * overhead_s / paid_s);
}

}  // namespace

void add_plan(CLI::App& app, Context&) {
  struct Options {
    CampaignInput input;
    bool json = false;
    int simulate = 0, slots = 64;
    double overhead_s = cfd_cases::kSlurmOverhead_s;
  };
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("plan", "Lists the cases of a matrix, which of them are solved, and what the others will cost");
  add_campaign_options(*command, options->input);
  command->add_flag("--json", options->json, "machine-readable");
  CLI::Option* simulation =
      command->add_option("--simulate", options->simulate, "wall time of this many such cases on a cluster, from the predicted costs")
          ->check(CLI::Range(1, 10000000));
  command->add_option("-j,--jobs,--slots", options->slots, "cases at a time of --simulate")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str()
      ->needs(simulation);
  command->add_option("--overhead", options->overhead_s, "of --simulate: seconds of a slot that a case costs beyond its own")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str()
      ->needs(simulation);
  command->footer("Example:  dragval plan quick --only 'cone*'");
  command->callback([options] {
    const auto cases = plan_cases(options->input, cfd_cases::find_tools());
    if (options->simulate > 0) return simulate(cases, options->simulate, options->slots, options->overhead_s);
    const auto tasks = cfd_cases::slurm_tasks({options->input.cache});
    const cfd_cases::PredictedSum sum = cfd_cases::predicted_sum(cases);
    const cfd_cases::Pace pace = cases.front().pace;
    int missing = 0;
    nlohmann::json list = nlohmann::json::array();
    for (const auto& planned : cases) {
      const auto task = tasks.find(planned.identity.key);
      const std::string slurm = task == tasks.end() || planned.cached ? "" : task->second.describe();
      const std::string state = planned.cached ? case_record::to_string(planned.cached->status) : "to solve";
      const cfd_cases::CostEstimate& cost = planned.estimate;
      list.push_back({{"name", planned.spec.name}, {"key", planned.identity.key}, {"state", state}});
      std::string prediction;
      if (!planned.cached) {
        ++missing;
        list.back().update({{"predicted_cells", std::round(cost.cells)},
                            {"predicted_iterations", std::round(cost.iterations)},
                            {"predicted_cpu_s", planned.predicted_cpu_s},
                            {"predicted_memory_bytes", planned.predicted_memory_bytes}});
        prediction = fmt::format("{:7.0f} cells {:5.0f} iterations {:6.0f} CPU s", cost.cells, cost.iterations, planned.predicted_cpu_s);
      }
      if (!slurm.empty()) list.back()["slurm"] = slurm;
      if (!options->json) fmt::print("{:<60} {:<21}{}\n", planned.spec.name, state, slurm.empty() ? prediction : slurm);
    }
    if (options->json)
      std::cout << nlohmann::json{{"cases", list},
                                  {"to_solve", missing},
                                  {"predicted_cpu_s", sum.cpu_s},
                                  {"predicted_cpu_s_uncertainty", sum.uncertainty},
                                  {"pace", {{"factor", pace.factor}, {"cases", pace.cases}}}}
                       .dump(2)
                << "\n";
    else
      fmt::print("{} cases, {} to solve: {:.0f} ± {:.0f} CPU s ({})\n", cases.size(), missing, sum.cpu_s, sum.uncertainty,
                 pace.cases > 0 ? fmt::format("times {:.2f}, from {} cases solved here", pace.factor, pace.cases)
                                : "on the machine of the cost model: no case of these is solved here yet");
  });
}

}  // namespace cli
