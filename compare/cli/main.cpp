#include <CLI/CLI.hpp>
#include <exception>
#include <iostream>

#include "compare/cli/commands.hpp"

int main(int argc, char** argv) {
  CLI::App app(
      "Validates real-time aerodynamic drag of triangle meshes against OpenFOAM.\n"
      "Exit codes: 0 pass, 1 gate failed, 2 usage or configuration, 3 environment, 4 a run failed or diverged, 5 nothing was compared.",
      "dragval");
  app.footer("Start here:  dragval doctor && dragval run quick && dragval compare --cache .dragval");
  app.require_subcommand(1);
  cli::Context context;
  for (const auto add :
       {cli::add_doctor, cli::add_plan, cli::add_run, cli::add_explain, cli::add_collect, cli::add_compare, cli::add_truth,
        cli::add_variants, cli::add_calibrate, cli::add_cost, cli::add_gate, cli::add_baseline, cli::add_report, cli::add_mesh})
    add(app, context);
  try {
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
