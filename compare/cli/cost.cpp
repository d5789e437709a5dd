#include <fmt/format.h>  // before any header of compare: fmt has a function of that name

#include "compare/cost.hpp"

#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

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

void print(const compare::CostTable& table, bool all) {
  fmt::print("Drag model: microseconds per body and evaluation on one thread, rms error over the orientations of the references\n");
  fmt::print("  {:<6} {:<10} {:<9} {:>9} {:>5} {:>12} {:>12} {:>9} {:>9}\n", "shape", "law", "pillow", "triangles", "rule", "us, no spin", "us, spin", "C_D", "C_m");
  for (const compare::ModelCost& row : table.models) {
    // Without --all: the rule of three points, which is the default of the library.
    if (!all && row.quadrature != 3) continue;
    fmt::print("  {:<6} {:<10} {:<9} {:>9} {:>5} {:>12.2f} {:>12.2f} {:>9.3f} {:>9}\n", row.shape, row.law, row.pillow, row.triangles, fmt::format("Q{}", row.quadrature),
               row.microseconds, row.spinning_microseconds, row.rms_drag_error, row.rms_moment_error ? fmt::format("{:.4f}", *row.rms_moment_error) : "");
  }
  fmt::print("\nOpenFOAM: CPU seconds per case, C_D against the finest mesh of the same case\n");
  fmt::print("  {:<44} {:>8} {:>6} {:>8} {:>8} {:>8} {:>8} {:>9}\n", "case", "cells", "iter", "mesh", "convert", "solve", "total", "C_D");
  for (const compare::CfdCost& row : table.cfd)
    fmt::print("  {:<44} {:>8} {:>6} {:>8.1f} {:>8.1f} {:>8.1f} {:>8.1f} {:>9}\n", row.case_name, row.cells, row.iterations, row.mesh_s, row.convert_s, row.solve_s, row.total_s,
               row.drag_error ? fmt::format("{:.4f}", *row.drag_error) : row.finest ? "finest" : "one mesh");
}

}  // namespace

void add_cost(CLI::App& app, Context&) {
  struct Options {
    SourceOptions source;
    bool json = false, all = false;
  };
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("cost", "What accuracy costs in time: every option of the model, and OpenFOAM at each mesh level");
  command->footer("Example: dragval cost --all\nTimes are of this machine, now: compare the ratios, not the microseconds.");
  add_source_options(*command, options->source);
  command->add_flag("--json", options->json, "Print JSON (all rows)");
  command->add_flag("--all", options->all, "All orders of quadrature, not only the default");
  command->callback([options] {
    const auto records = load(options->source).reference.cases;
    const compare::CostTable table = compare::measure_cost(records, compare::calibrate(records));
    if (options->json)
      std::cout << to_json(table).dump(2) << "\n";
    else
      print(table, options->all);
  });
}

}  // namespace cli
