#include "compare/gate/baseline.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "compare/cli/commands.hpp"
#include "compare/gate/baseline_review.hpp"

namespace cli {
namespace {

struct BaselineOptions {
  SourceOptions source;
  ModelOptions model;
  std::string baseline = "results/baselines/quick.json", reason, seeds, format = "table";
  bool json = false, all = false;
};

/// What changes: a review for people, or every number.
void print_change(const compare::Baseline& before, const compare::Baseline& after, const BaselineOptions& options) {
  const compare::Format format = compare::format_from(options.json ? "json" : options.format);
  if (!options.all) {
    std::cout << compare::render(compare::review(before, after), format);
    return;
  }
  const std::vector<std::string> lines = compare::differences(before, after);
  if (format == compare::Format::json) {
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
  CLI::App* diff = command->add_subcommand("diff", "Show what accepting would change: what gets better, what worse, and by how many u");
  CLI::App* accept = command->add_subcommand("accept", "Make the present predictions and errors the baseline");
  for (CLI::App* action : {diff, accept}) {
    add_source_options(*action, options->source);
    add_model_options(*action, options->model);
    action->add_option("--baseline", options->baseline, "File of the baseline")->capture_default_str();
    action->add_option("--seeds", options->seeds,
                       "Cache folder with the cases of the matrix seeds: what they scatter, solving again may, too");
    action->add_option("--format", options->format, "table, md or json")->capture_default_str();
    action->add_flag("--json", options->json, "The same as --format json");
    action->add_flag("--all", options->all, "Every number that changes, a line each");
  }
  accept->add_option("--reason", options->reason, "Why; it stays in the file")->required();
  const auto state = [options](const CLI::App& action, const std::string& reason, const compare::Baseline& before) {
    const Sources sources = load(options->source);
    compare::Baseline after = compare::make_baseline(sources.reference.cases, reason, before, watched_models(action, options->model));
    if (!options->seeds.empty())
      after.seed_scatter = compare::scatter_over_seeds(compare::read_runs(std::filesystem::path(options->seeds) / "runs"));
    for (const std::string& name : sources.missing) std::cerr << "not in the baseline, no result: " << name << "\n";
    return after;
  };
  diff->callback([=] {
    const compare::Baseline before = compare::read_baseline(options->baseline);
    print_change(before, state(*diff, "to see the difference", before), *options);
  });
  accept->callback([=] {
    const bool exists = std::filesystem::exists(options->baseline);
    const compare::Baseline before = exists ? compare::read_baseline(options->baseline) : compare::Baseline{};
    const compare::Baseline after = state(*accept, options->reason, before);
    compare::write_baseline(options->baseline, after);
    print_change(before, after, *options);
    std::cerr << options->baseline << ": " << after.planned.size() << " cases accepted\n";
  });
}

}  // namespace cli
