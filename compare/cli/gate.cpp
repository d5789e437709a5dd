#include "compare/gate/gate.hpp"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "compare/cli/commands.hpp"

namespace cli {

void add_gate(CLI::App& app, Context& context) {
  struct Options {
    SourceOptions source;
    std::string baseline = "results/baselines/quick.json";
    std::string solved;
    bool json = false;
  };
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("gate", "Check that no coefficient error has become worse than the accepted baseline");
  command->footer(
      "Exit code 1 when a check fails, 5 when planned cases were not compared.\n"
      "Example: dragval gate --baseline results/baselines/quick.json");
  add_source_options(*command, options->source);
  command->add_option("--baseline", options->baseline, "Accepted predictions, errors and budgets")->capture_default_str();
  command->add_option("--solved", options->solved, "Cache folder of cases that were solved again: they must agree with the stored ones");
  command->add_flag("--json", options->json, "Print JSON");
  command->callback([options, &context] {
    const compare::Baseline baseline = compare::read_baseline(options->baseline);
    const std::vector<compare::CaseRecord> records = load(options->source).reference.cases;
    compare::GateResult result = compare::run_gate(baseline, records);
    if (!options->solved.empty())
      result.checks.push_back(compare::check_solved_again(records, compare::read_runs(std::filesystem::path(options->solved) / "runs")));
    if (options->json)
      std::cout << compare::to_json(result).dump(2) << "\n";
    else
      std::cout << compare::render(result, ::isatty(STDOUT_FILENO) && !std::getenv("NO_COLOR"));
    // An incomplete comparison says nothing, whatever the checks made of the rest.
    context.exit_code = !result.complete() ? exit_code::nothing_compared : result.passed() ? exit_code::pass : exit_code::gate_failed;
  });
}

}  // namespace cli
