#include <fmt/format.h>  // before any header of compare: fmt has a function of that name

#include <CLI/CLI.hpp>
#include <cmath>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

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
  auto cases = cfd_cases::plan(cfd_cases::load_matrix(input.matrix), tools, {input.cache}, run_store(), input.only, known);
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

void add_plan(CLI::App& app, Context&) {
  struct Options {
    CampaignInput input;
    bool json = false;
  };
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("plan", "Lists the cases of a matrix, which of them are solved, and what the others will cost");
  add_campaign_options(*command, options->input);
  command->add_flag("--json", options->json, "machine-readable");
  command->footer("Example:  dragval plan quick --only 'cone*'");
  command->callback([options] {
    const auto cases = plan_cases(options->input, cfd_cases::find_tools());
    const cfd_cases::PredictedSum sum = cfd_cases::predicted_sum(cases);
    const cfd_cases::Pace pace = cases.front().pace;
    int missing = 0;
    nlohmann::json list = nlohmann::json::array();
    for (const auto& planned : cases) {
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
      if (!options->json) fmt::print("{:<60} {:<21}{}\n", planned.spec.name, state, prediction);
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
