#include <CLI/CLI.hpp>
#include <dragcore/unknown_word.hpp>
#include <exception>
#include <iostream>

#include "compare/cli/commands.hpp"

namespace {

/// Words that name no subcommand where one is due. The parser would say no more than that one is missing.
void check_subcommands(const CLI::App& app, int argc, char** argv) {
  const CLI::App* at = &app;
  for (int i = 1; i < argc && argv[i][0] != '-'; ++i) {
    const auto subcommands = at->get_subcommands([](const CLI::App*) { return true; });
    if (subcommands.empty()) return;
    std::vector<std::string> names;
    const CLI::App* next = nullptr;
    for (const CLI::App* subcommand : subcommands) {
      names.push_back(subcommand->get_name());
      if (names.back() == argv[i]) next = subcommand;
    }
    if (!next) throw cli::UsageError(dragcore::unknown_word(at == &app ? "command" : "command of " + at->get_name(), argv[i], names));
    at = next;
  }
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(
      "Validates real-time aerodynamic drag of triangle meshes against OpenFOAM.\n"
      "Exit codes: 0 pass, 1 gate failed, 2 usage or configuration, 3 environment, 4 a run failed or diverged, 5 nothing was compared.",
      "dragval");
  app.footer("Start here:  dragval doctor && dragval run quick && dragval compare --cache .dragval");
  app.require_subcommand(1);
  cli::Context context;
  for (const auto add : {cli::add_doctor, cli::add_plan, cli::add_run, cli::add_explain, cli::add_collect, cli::add_import,
                         cli::add_compare, cli::add_truth, cli::add_variants, cli::add_calibrate, cli::add_cost, cli::add_gate, cli::add_odds,
                         cli::add_baseline, cli::add_report, cli::add_mesh, cli::add_drag, cli::add_bake})
    add(app, context);
  try {
    check_subcommands(app, argc, argv);
    app.parse(argc, argv);
    return context.exit_code;
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? cli::exit_code::pass : cli::exit_code::usage;  // --help arrives here too
  } catch (const std::invalid_argument& error) {
    std::cerr << "dragval: " << error.what() << "\n";
    return cli::exit_code::usage;
  } catch (const std::exception& error) {
    std::cerr << "dragval: " << error.what() << "\n";
    return cli::exit_code::environment;
  }
}
