#include "compare/gate/baseline.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "compare/cli/commands.hpp"

namespace cli {
namespace {

struct BaselineOptions {
  SourceOptions source;
  std::string baseline = "results/baselines/quick.json", reason;
  bool json = false;
};

void print_differences(const std::vector<std::string>& lines, bool json) {
  if (json) {
    std::cout << nlohmann::json{{"differences", lines}}.dump(2) << "\n";
    return;
  }
  for (const std::string& line : lines) std::cout << line << "\n";
  if (lines.empty()) std::cout << "no difference\n";
}

}  // namespace

void add_baseline(CLI::App& app, Context&) {
  const auto options = std::make_shared<BaselineOptions>();
  CLI::App* command = app.add_subcommand("baseline", "Show or accept a change of the baseline that the gate holds errors against");
  command->require_subcommand(1);
  command->footer("Example: dragval baseline accept --matrix quick --reason \"base suction added to the law\"");
  CLI::App* diff = command->add_subcommand("diff", "Show what accepting would change");
  CLI::App* accept = command->add_subcommand("accept", "Make the present predictions and errors the baseline");
  for (CLI::App* action : {diff, accept}) {
    add_source_options(*action, options->source);
    action->add_option("--baseline", options->baseline, "File of the baseline")->capture_default_str();
    action->add_flag("--json", options->json, "Print JSON");
  }
  accept->add_option("--reason", options->reason, "Why; it stays in the file")->required();
  diff->callback([options] {
    const compare::Baseline before = compare::read_baseline(options->baseline);
    print_differences(
        compare::differences(before, compare::make_baseline(load(options->source).reference.cases, "to see the difference", before)),
        options->json);
  });
  accept->callback([options] {
    const bool exists = std::filesystem::exists(options->baseline);
    const compare::Baseline before = exists ? compare::read_baseline(options->baseline) : compare::Baseline{};
    const Sources sources = load(options->source);
    const compare::Baseline after = compare::make_baseline(sources.reference.cases, options->reason, before);
    for (const std::string& name : sources.missing) std::cerr << "not in the baseline, no result: " << name << "\n";
    compare::write_baseline(options->baseline, after);
    print_differences(compare::differences(before, after), options->json);
    std::cerr << options->baseline << ": " << after.planned.size() << " cases accepted\n";
  });
}

}  // namespace cli
