#include <fmt/format.h>  // before any header of compare: fmt has a function of that name
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "compare/cli/campaign_options.hpp"
#include "compare/cli/commands.hpp"
#include "compare/cost/answers.hpp"
#include "compare/cost/cfd_cost.hpp"
#include "compare/tables/text_grid.hpp"

namespace cli {

namespace {

nlohmann::json to_json(const std::vector<compare::CfdCost>& rows) {
  nlohmann::json list = nlohmann::json::array();
  for (const compare::CfdCost& row : rows)
    list.push_back({{"case", row.case_name},
                    {"mesh_level", row.mesh_level},
                    {"cells", row.cells},
                    {"iterations", row.iterations},
                    {"mesh_cpu_s", row.mesh_s},
                    {"convert_cpu_s", row.convert_s},
                    {"solve_cpu_s", row.solve_s},
                    {"total_cpu_s", row.total_s},
                    {"drag_error", compare::optional_json(row.drag_error)},
                    {"finest", row.finest}});
  return list;
}

nlohmann::json to_json(const std::vector<compare::CostCheck>& checks) {
  nlohmann::json list = nlohmann::json::array();
  for (const compare::CostCheck& check : checks)
    list.push_back({{"quantity", check.quantity},
                    {"cases", check.cases},
                    {"predicted", check.predicted},
                    {"actual", check.found},
                    {"rms_ln_ratio", check.rms},
                    {"worst_ratio", check.worst},
                    {"worst_case", check.worst_case}});
  return list;
}

void print(const compare::CostTable& table, bool colour) { fmt::print("\n{}\n{}", table.caption, compare::aligned(table.grid, colour)); }

void print(const std::vector<compare::CfdCost>& rows) {
  fmt::print("\nOpenFOAM: CPU seconds per case, C_D against the finest mesh of the same case\n");
  fmt::print("  {:<44} {:>8} {:>6} {:>8} {:>8} {:>8} {:>8} {:>9}\n", "case", "cells", "iter", "mesh", "convert", "solve", "total", "C_D");
  for (const compare::CfdCost& row : rows)
    fmt::print("  {:<44} {:>8} {:>6} {:>8.1f} {:>8.1f} {:>8.1f} {:>8.1f} {:>9}\n", row.case_name, row.cells, row.iterations, row.mesh_s,
               row.convert_s, row.solve_s, row.total_s,
               row.drag_error ? fmt::format("{:.4f}", *row.drag_error)
               : row.finest   ? "finest"
                              : "one mesh");
}

void print(const std::vector<compare::CostCheck>& checks) {
  fmt::print(
      "\nPredicted by `dragval plan` against actual: sums over the cases that ran to their end, CPU seconds; rms of ln(actual / "
      "predicted)\n");
  fmt::print("  {:<10} {:>5} {:>10} {:>10} {:>6} {:>6} {:>6}  {}\n", "", "cases", "predicted", "actual", "ratio", "rms", "worst", "case");
  for (const compare::CostCheck& check : checks)
    fmt::print("  {:<10} {:>5} {:>10.0f} {:>10.0f} {:>6.2f} {:>6.2f} {:>6.2f}  {}\n", check.quantity, check.cases, check.predicted,
               check.found, check.ratio(), check.rms, check.worst, check.worst_case);
}

void fit(const SourceOptions& source, const std::string& output) {
  const auto records = load(source).reference.cases;
  cfd_cases::CostModel model = cfd_cases::fit_cost_model(cfd_cases::read_cost_model(cfd_cases::cost_model_file()), records);
  const std::string from = source.cache.empty() ? source.store : source.cache;
  model.provenance = {
      {"command", fmt::format("dragval cost --fit {} {} --write {}", source.cache.empty() ? "--store" : "--cache", from, output)},
      {"fitted_to", fmt::format("{} of the {} cases of {}", model.cells_fit.cases, records.size(), from)},
      {"revision", revision()}};
  const std::string text = cfd_cases::to_toml(model);
  cfd_cases::parse_cost_model(text, output.empty() ? "the fitted model" : output);  // what could not be read again is not written
  if (output.empty()) {
    fmt::print("{}", text);
    return;
  }
  std::ofstream file(output);
  if (!(file << text << std::flush)) throw EnvironmentError("cannot write " + output + "; check that the folder is writable");
  fmt::print("{}: fitted to {}\n", output, model.provenance.at("fitted_to"));
}

}  // namespace

void add_cost(CLI::App& app, Context& context) {
  struct Options {
    SourceOptions source;
    bool json = false, all = false, fit = false, quick = false;
    std::string write, target, body, studies = "results/studies.h5";
  };
  const auto options = std::make_shared<Options>();
  CLI::App* command =
      app.add_subcommand("cost", "What accuracy costs in time: from one drag coefficient over engines and laws to OpenFOAM and DDES");
  command->footer(
      "Times are measured now, on this machine: CPU seconds, best of several.\n"
      "Examples: dragval cost\n"
      "          dragval cost --target 10% --body cone");
  add_source_options(*command, options->source);
  command->add_flag("--json", options->json, "Print JSON (all rows)");
  command->add_flag("--all", options->all, "Every rung and every OpenFOAM case, too, and what `dragval plan` predicted for them");
  command->add_option("--target", options->target, "Which law, mesh or CFD level has an rms error of at most this, in % of the force");
  command->add_option("--body", options->body, "Only the bodies whose name holds this: cone, say");
  command->add_option("--studies", options->studies, "Studies of the numerics: what a later stop of the solver costs")
      ->check(CLI::ExistingFile)
      ->capture_default_str();
  command->add_flag("--quick", options->quick, "Fewer repetitions and meshes");
  CLI::Option* fit_option =
      command->add_flag("--fit", options->fit, "Instead: fit the model of what a CFD case costs, which `dragval plan` uses, and print it");
  command->add_option("--write", options->write, "Where to put the fitted model: cfd_cases/campaign/cost_model.toml")->needs(fit_option);
  command->callback([options, &context] {
    if (options->fit) return fit(options->source, options->write);
    const double target = options->target.empty() ? 0.0 : share_from("--target", options->target);  // 0: none asked for
    Sources sources = load(options->source);
    const std::vector<compare::CaseRecord>& records = sources.reference.cases;
    std::optional<compare::Calibration> calibration;
    try {
      calibration = compare::calibrate(records);
    } catch (const std::invalid_argument& fault) {
      fmt::print(stderr, "without fitted laws: {}\n", fault.what());
    }
    compare::LadderOptions wanted{.calibration = calibration ? &*calibration : nullptr,
                                  .spinning = std::move(sources.spinning),
                                  .body = options->body,
                                  .quick = options->quick};
    if (std::filesystem::exists(options->studies)) wanted.studies = compare::read_reference(options->studies).cases;
    const compare::Ladder ladder = compare::measure_ladder(records, wanted);
    if (ladder.poses == 0) {
      fmt::print(stderr, "dragval: no usable turbulent case at Re >= 1e4 to hold a law against. Solve some: dragval run quick\n");
      context.exit_code = exit_code::nothing_compared;
      return;
    }
    const bool colour = ::isatty(STDOUT_FILENO) && !std::getenv("NO_COLOR");
    if (options->json) {
      nlohmann::json text = compare::to_json(ladder);
      if (target > 0.0) text["target"] = compare::to_json(compare::reach(ladder, target));
      text["cfd"] = to_json(compare::cfd_costs(records));
      text["predicted_cfd_cost"] = to_json(compare::check_cost(records, cost_predictor()));
      std::cout << text.dump(2) << "\n";
    } else if (target > 0.0) {
      fmt::print("{}", compare::answer(ladder, compare::reach(ladder, target)));
    } else {
      fmt::print("{}", compare::answer(ladder));
      for (const compare::CostTable& table : compare::cost_tables(ladder)) print(table, colour);
      if (options->all) {
        print(compare::all_rungs(ladder), colour);
        print(compare::cfd_costs(records));
        if (const auto checks = compare::check_cost(records, cost_predictor()); !checks.empty()) print(checks);
      }
    }
  });
}

}  // namespace cli
