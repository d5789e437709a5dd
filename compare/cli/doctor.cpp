#include <fmt/format.h>  // before any header of compare: fmt has a function of that name

#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "cfd_cases/campaign/slurm.hpp"
#include "cfd_cases/programs/tools.hpp"
#include "compare/cli/commands.hpp"

namespace cli {

void add_doctor(CLI::App& app, Context& context) {
  struct Options {
    std::string cache = ".dragval";
    bool json = false;
  };
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "doctor", "Checks what solving cases needs (OpenFOAM, gmsh, MPI, cores, disk, Slurm) and prints the fix of each fault");
  command->add_option("--cache", options->cache, "folder of solved cases, for the space on its disk")->capture_default_str();
  command->add_flag("--json", options->json, "machine-readable");
  command->footer("Example:  dragval doctor");
  command->callback([options, &context] {
    nlohmann::json list = nlohmann::json::array();
    auto checks = cfd_cases::examine(options->cache);
    checks.push_back(cfd_cases::check_slurm());
    for (const auto& check : checks) {
      if (!check.good && check.needed) context.exit_code = exit_code::environment;
      const char* state = check.good ? "ok" : check.needed ? "MISSING" : "absent";
      list.push_back({{"name", check.name}, {"state", state}, {"found", check.found}, {"fix", check.fix}});
      if (options->json) continue;
      fmt::print("{:<8} {:<22} {}\n", state, check.name, check.found);
      if (!check.good) fmt::print("         {:<22} fix: {}\n", "", check.fix);
    }
    if (options->json) std::cout << list.dump(2) << "\n";
  });
}

}  // namespace cli
