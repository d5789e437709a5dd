#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <iostream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "cfd_cases/flow_case/matrix.hpp"
#include "compare/cli/commands.hpp"

namespace cli {

void add_collect(CLI::App& app, Context& context) {
  struct Options {
    std::string cache = ".dragval", into = "results/reference.h5", matrix;
    bool json = false;
  };
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("collect", "Merge finished runs of a cache into a file of references");
  command->footer(
      "Rows of other cases stay as they are; a file that already holds these rows is not touched.\n"
      "Example: dragval collect --matrix quick --into results/reference.h5");
  command->add_option("--cache", options->cache, "Cache folder of dragval run")->capture_default_str();
  command->add_option("--into", options->into, "File of references to make or extend")->capture_default_str();
  command->add_option("--matrix", options->matrix, "Only the cases of this tier or matrix file");
  command->add_flag("--json", options->json, "Print JSON");
  command->callback([options, &context] {
    std::vector<compare::CaseRecord> runs = compare::read_runs(std::filesystem::path(options->cache) / "runs");
    // The matrix as it is now says what is held out of fits, whatever it said when a case was solved.
    std::map<std::string, bool> held_out;
    if (!options->matrix.empty()) {
      for (const cfd_cases::CaseSpec& spec : cfd_cases::load_matrix(options->matrix).cases) held_out[spec.name] = spec.held_out;
      std::erase_if(runs, [&](const compare::CaseRecord& run) { return !held_out.contains(run.name); });
      for (compare::CaseRecord& run : runs) run.held_out = held_out.at(run.name);
    }
    if (runs.empty()) {
      std::cerr << "dragval: no runs in " << options->cache << "/runs to collect; solve them first: dragval run quick\n";
      context.exit_code = exit_code::nothing_compared;
      return;
    }
    const bool exists = std::filesystem::exists(options->into);
    compare::Reference merged = compare::merged(exists ? compare::read_reference(options->into) : compare::Reference{}, runs);
    for (compare::CaseRecord& known : merged.cases)
      if (const auto now = held_out.find(known.name); now != held_out.end()) known.held_out = now->second;
    if (const auto folder = std::filesystem::path(options->into).parent_path(); !folder.empty())
      std::filesystem::create_directories(folder);
    const bool written = compare::write_reference(options->into, merged, revision());
    if (options->json)
      std::cout
          << nlohmann::json{{"file", options->into}, {"runs", runs.size()}, {"cases", merged.cases.size()}, {"changed", written}}.dump(2)
          << "\n";
    else
      fmt::print("{}: {} cases, {} runs merged{}\n", options->into, merged.cases.size(), runs.size(), written ? "" : ", nothing changed");
  });
}

}  // namespace cli
