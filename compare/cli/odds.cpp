#include "compare/gate/odds.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <memory>

#include "compare/cli/commands.hpp"

namespace cli {

void add_odds(CLI::App& app, Context& context) {
  struct Options {
    SourceOptions source;
    std::string baseline = "results/baselines/quick.json", solved, format = "table";
    bool json = false;
  };
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("odds", "How often the gate is wrong: defects that it misses, unchanged code that it stops");
  command->footer(
      "Exit code 1 when a defect is missed or unchanged code is stopped.\n"
      "Example: dragval run seeds -j2 --cache .dragval && dragval odds --solved .dragval");
  add_source_options(*command, options->source);
  command->add_option("--baseline", options->baseline, "Accepted predictions, errors and budgets")->capture_default_str();
  command->add_option("--solved", options->solved, "Cache folder with cases of the matrix seeds, for the rate of false alarms");
  command->add_option("--format", options->format, "table, md or json")->capture_default_str();
  command->add_flag("--json", options->json, "The same as --format json");
  command->callback([options, &context] {
    const compare::Format format = compare::format_from(options->json ? "json" : options->format);
    const compare::Baseline baseline = compare::read_baseline(options->baseline);
    std::vector<compare::CaseRecord> solved;
    if (!options->solved.empty()) solved = solved_again(options->solved);
    const compare::Odds odds = compare::gate_odds(baseline, load(options->source).reference.cases, solved);
    if (!options->solved.empty() && odds.repeats == 0)
      throw UsageError(
          fmt::format("--solved {}: no case of the matrix seeds is there; dragval run seeds --cache {}", options->solved, options->solved));
    std::cout << compare::render(odds, format);
    context.exit_code = odds.passed() ? exit_code::pass : exit_code::gate_failed;
  });
}

}  // namespace cli
