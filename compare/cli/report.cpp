#include "compare/report/report.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <fstream>
#include <memory>

#include "compare/cli/campaign_options.hpp"
#include "compare/cli/commands.hpp"

namespace cli {

void add_report(CLI::App& app, Context& context) {
  struct Options {
    SourceOptions source;
    std::string output = "results/report/index.html";
    std::string assets = "compare/report";
    std::string wasm = DRAG_WASM_MODULE;
    std::string specs;
    bool quick_cost = false;
  };
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("report", "Write one HTML page with all tables and figures");
  command->footer("Example: dragval report --store results/reference.h5\nThe page needs no network and no other file.");
  add_source_options(*command, options->source);
  command->add_option("--output", options->output, "The page")->capture_default_str();
  command->add_option("--assets", options->assets, "Folder of the page's template, style and figure libraries")->capture_default_str();
  command->add_option("--wasm", options->wasm, "The library for JavaScript, which the page runs where there is one (target dragcore_wasm)")
      ->capture_default_str();
  command->add_option("--specs", options->specs, "Folder for the figures as Vega-Lite files too (scripts/figures.sh makes SVG of them)");
  command->add_flag("--quick-cost", options->quick_cost, "Measure the cost of the drag model with fewer repetitions and meshes");
  command->callback([options, &context] {
    Sources sources = load(options->source);
    compare::Report report =
        compare::make_report(std::move(sources.reference), std::move(sources.spinning), sources.missing, options->quick_cost);
    report.source = options->source.cache.empty() ? options->source.store : options->source.cache;
    report.commit = revision();
    report.cost_checks = compare::check_cost(report.reference.cases, cost_predictor());
    if (report.compared() == 0) {
      fmt::print(
          stderr,
          "dragval report: none of the {} cases has usable coefficients, so there is nothing to report; run `dragval run quick` first\n",
          report.reference.cases.size());
      context.exit_code = exit_code::nothing_compared;
      return;
    }
    compare::write_report(report, options->output, options->assets, options->wasm);
    if (!options->specs.empty()) {
      std::filesystem::create_directories(options->specs);
      for (const auto& [name, spec] : compare::figures(report)) {
        const std::filesystem::path path = std::filesystem::path(options->specs) / (name + ".vl.json");
        std::ofstream file(path);
        if (!(file << spec.dump() << std::flush))
          throw EnvironmentError("cannot write " + path.string() + "; check that the folder is writable");
      }
    }
    fmt::print("{}\n", options->output);
  });
}

}  // namespace cli
