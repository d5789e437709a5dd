#include <fmt/format.h>  // before any header of compare: fmt has a function of that name
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <iostream>
#include <memory>

#include "compare/cli/commands.hpp"
#include "compare/tables/mesh_table.hpp"
#include "compare/tables/truth_table.hpp"

namespace cli {

void add_truth(CLI::App& app, Context& context) {
  struct Options {
    SourceOptions source;
    std::string format = "table";
    bool json = false, mesh = false, held_back = false;
  };
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("truth", "Hold the CFD against published values: forces, angles, torque of spin");
  command->footer(
      "Every method that solved a pose has its row. Exit code 5 when nothing was published about any case.\nExample: dragval truth "
      "--format md");
  add_source_options(*command, options->source);
  command->add_option("--format", options->format, "table, md, csv or json")->capture_default_str();
  command->add_flag("--mesh", options->mesh, "How far the mesh, and symmetry, leave C_D open by body and flow, instead");
  command->add_flag("--held-back", options->held_back, "Whether that holds: each finest mesh against what those before it said, instead");
  command->add_flag("--json", options->json, "The same as --format json");
  command->callback([options, &context] {
    const compare::Format format = compare::format_from(options->json ? "json" : options->format);
    const Sources sources = load(options->source);
    const bool colour = ::isatty(STDOUT_FILENO) && !std::getenv("NO_COLOR");
    if (options->mesh) {
      std::cout << compare::render(compare::mesh_rows(sources.reference.cases), format, colour);
      return;
    }
    if (options->held_back) {
      std::cout << compare::render(compare::held_back_rows(sources.reference.cases), format, colour);
      return;
    }
    auto checks = compare::published_checks(sources.reference.cases, true);
    for (compare::PublishedCheck& check : compare::published_checks(sources.spinning, true)) checks.push_back(std::move(check));
    std::cout << compare::render(checks, format, colour);
    if (!checks.empty()) return;
    std::cerr << "dragval: nothing was compared: no usable case of these references has a published value\n";
    context.exit_code = exit_code::nothing_compared;
  });
}

}  // namespace cli
