#include "compare/gate/gate.hpp"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <iostream>
#include <memory>

#include "compare/cli/commands.hpp"

namespace cli {

void add_gate(CLI::App& app, Context& context) {
  struct Options {
    SourceOptions source;
    std::string baseline = "results/baselines/quick.json";
    std::string solved;
    std::string solved_budget;
    ModelOptions model;
    std::string format = "table";
    bool json = false;
  };
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("gate", "Check that no coefficient error has become worse than the accepted baseline");
  command->footer(
      "Exit code 1 when a check fails, 5 when planned cases were not compared.\n"
      "Example: dragval gate --baseline results/baselines/quick.json\n"
      "A law of your own, in a baseline of its own: dragval gate --law mine.toml --baseline mine.json");
  add_source_options(*command, options->source);
  command->add_option("--baseline", options->baseline, "Accepted predictions, errors and budgets")->capture_default_str();
  command->add_option("--solved", options->solved, "Cache folder of cases that were solved again: they must agree with the stored ones");
  command->add_option("--solved-budget", options->solved_budget,
                      "How far such cases may be apart, in % of C_D; refused below what meshes of other seeds are apart");
  add_model_options(*command, options->model);
  command->add_option("--format", options->format, "table, md, json, junit (CI servers) or github (annotations)")->capture_default_str();
  command->add_flag("--json", options->json, "The same as --format json");
  command->callback([options, command, &context] {
    const compare::GateFormat format = compare::gate_format_from(options->json ? "json" : options->format);
    if (!options->solved_budget.empty() && options->solved.empty()) throw UsageError("--solved-budget needs --solved, the cache folder");
    const compare::Baseline baseline = compare::read_baseline(options->baseline);
    const std::vector<compare::CaseRecord> records = load(options->source).reference.cases;
    compare::GateResult result = compare::run_gate(baseline, records, watched_models(*command, options->model));
    if (!options->solved.empty())
      result.checks.push_back(
          compare::check_solved_again(baseline, records, solved_again(options->solved),
                                      options->solved_budget.empty() ? 0.0 : share_from("--solved-budget", options->solved_budget)));
    std::cout << compare::render(result, format, ::isatty(STDOUT_FILENO) && !std::getenv("NO_COLOR"));
    // An incomplete comparison says nothing, whatever the checks made of the rest.
    context.exit_code = !result.complete() ? exit_code::nothing_compared : result.passed() ? exit_code::pass : exit_code::gate_failed;
  });
}

}  // namespace cli
