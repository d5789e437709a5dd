#include "compare/calibration/cost.hpp"

#include <fmt/format.h>  // before any header of compare: fmt has a function of that name

#include <CLI/CLI.hpp>
#include <fstream>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "compare/cli/campaign_options.hpp"
#include "compare/cli/commands.hpp"

namespace cli {

namespace {

nlohmann::json optional_json(const std::optional<double>& value) { return value ? nlohmann::json(*value) : nlohmann::json(nullptr); }

nlohmann::json to_json(const compare::CostTable& table) {
  nlohmann::json models = nlohmann::json::array(), cfd = nlohmann::json::array();
  for (const compare::ModelCost& row : table.models)
    models.push_back({{"shape", row.shape},
                      {"law", row.law},
                      {"pillow", row.pillow},
                      {"quadrature", row.quadrature},
                      {"triangles", row.triangles},
                      {"microseconds", row.microseconds},
                      {"spinning_microseconds", row.spinning_microseconds},
                      {"rms_drag_error", row.rms_drag_error},
                      {"rms_moment_error", optional_json(row.rms_moment_error)},
                      {"cases", row.cases}});
  for (const compare::CfdCost& row : table.cfd)
    cfd.push_back({{"case", row.case_name},
                   {"mesh_level", row.mesh_level},
                   {"cells", row.cells},
                   {"iterations", row.iterations},
                   {"mesh_cpu_s", row.mesh_s},
                   {"convert_cpu_s", row.convert_s},
                   {"solve_cpu_s", row.solve_s},
                   {"total_cpu_s", row.total_s},
                   {"drag_error", optional_json(row.drag_error)},
                   {"finest", row.finest}});
  return {{"models", models}, {"cfd", cfd}};
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

void print(const compare::CostTable& table, bool all) {
  fmt::print("Drag model: microseconds per body and evaluation on one thread, rms error over the orientations of the references\n");
  fmt::print("  {:<6} {:<10} {:<9} {:>9} {:>5} {:>12} {:>12} {:>9} {:>9}\n", "shape", "law", "pillow", "triangles", "rule", "us, no spin",
             "us, spin", "C_D", "C_m");
  for (const compare::ModelCost& row : table.models) {
    // Without --all: the rule of three points, which is the default of the library.
    if (!all && row.quadrature != 3) continue;
    fmt::print("  {:<6} {:<10} {:<9} {:>9} {:>5} {:>12.2f} {:>12.2f} {:>9.3f} {:>9}\n", row.shape, row.law, row.pillow, row.triangles,
               fmt::format("Q{}", row.quadrature), row.microseconds, row.spinning_microseconds, row.rms_drag_error,
               row.rms_moment_error ? fmt::format("{:.4f}", *row.rms_moment_error) : "");
  }
  fmt::print("\nOpenFOAM: CPU seconds per case, C_D against the finest mesh of the same case\n");
  fmt::print("  {:<44} {:>8} {:>6} {:>8} {:>8} {:>8} {:>8} {:>9}\n", "case", "cells", "iter", "mesh", "convert", "solve", "total", "C_D");
  for (const compare::CfdCost& row : table.cfd)
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

void add_cost(CLI::App& app, Context&) {
  struct Options {
    SourceOptions source;
    bool json = false, all = false, fit = false;
    std::string write;
  };
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("cost", "What accuracy costs in time: every option of the model, and OpenFOAM at each mesh level");
  command->footer("Example: dragval cost --all\nTimes are of this machine, now: compare the ratios, not the microseconds.");
  add_source_options(*command, options->source);
  command->add_flag("--json", options->json, "Print JSON (all rows)");
  command->add_flag("--all", options->all, "All orders of quadrature, not only the default");
  CLI::Option* fit_option =
      command->add_flag("--fit", options->fit, "Instead: fit the model of what a CFD case costs, which `dragval plan` uses, and print it");
  command->add_option("--write", options->write, "Where to put the fitted model: cfd_cases/campaign/cost_model.toml")->needs(fit_option);
  command->callback([options] {
    if (options->fit) return fit(options->source, options->write);
    const auto records = load(options->source).reference.cases;
    const compare::CostTable table = compare::measure_cost(records, compare::calibrate(records));
    const auto checks = compare::check_cost(records, cost_predictor());
    if (options->json) {
      nlohmann::json text = to_json(table);
      text["predicted_cfd_cost"] = to_json(checks);
      std::cout << text.dump(2) << "\n";
    } else {
      print(table, options->all);
      if (!checks.empty()) print(checks);
    }
  });
}

}  // namespace cli
