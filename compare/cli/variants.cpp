#include "compare/tables/variants.hpp"

#include <fmt/format.h>  // before any header of compare: fmt has a function of that name
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <iostream>
#include <memory>

#include "compare/cli/commands.hpp"

namespace cli {

void add_variants(CLI::App& app, Context& context) {
  struct Options {
    SourceOptions source;
    std::string format = "table";
    bool json = false;
  };
  const auto options = std::make_shared<Options>();
  CLI::App* command =
      app.add_subcommand("variants", "Hold variants of the numerics, of the mesh's seed or of the start against their base case");
  command->footer(
      "Exit code 5 when no variant has a usable base on its mesh level.\nExample: dragval variants --store results/studies.h5 --format md");
  add_source_options(*command, options->source);
  command->add_option("--format", options->format, "table, md, csv or json")->capture_default_str();
  command->add_flag("--json", options->json, "The same as --format json");
  command->callback([options, &context] {
    const compare::Format format = compare::format_from(options->json ? "json" : options->format);
    Sources sources = load(options->source);
    std::vector<compare::CaseRecord> records = std::move(sources.reference.cases);
    for (compare::CaseRecord& record : sources.spinning) records.push_back(std::move(record));
    const compare::VariantTable table = compare::variant_table(records);
    std::cout << compare::render(table, format, ::isatty(STDOUT_FILENO) && !std::getenv("NO_COLOR"));
    if (table.compared > 0) return;
    std::cerr << "dragval: nothing was compared: no usable variant has a usable base case on the same mesh level\n";
    context.exit_code = exit_code::nothing_compared;
  });
}

}  // namespace cli
