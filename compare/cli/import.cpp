#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <fstream>
#include <iterator>
#include <memory>
#include <numbers>

#include "cfd_cases/flow_case/case_key.hpp"
#include "cfd_cases/flow_case/matrix.hpp"
#include "compare/cli/commands.hpp"
#include "compare/reference/experiments.hpp"

namespace cli {

namespace {

/// As a solved case is named, with the source where that has its mesh.
std::string name_of(const compare::CaseRecord& record) {
  constexpr double deg = std::numbers::pi / 180.0;
  cfd_cases::CaseSpec spec;
  spec.shape = record.shape;
  spec.pose = {record.pose.incidence / deg, record.pose.yaw / deg, record.pose.roll / deg};
  spec.reynolds = record.reynolds;
  spec.mesh_level = record.source;
  return cfd_cases::case_name(spec);
}

}  // namespace

void add_import(CLI::App& app, Context&) {
  struct Options {
    std::string table, into = "results/reference.h5";
  };
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("import", "Enters measured coefficients into a file of references");
  command->footer(
      "A row takes the place of one of the same name: body, pose, Reynolds number and source. Columns: docs/command_line.md.\n"
      "Example: dragval import compare/reference/experiments.csv");
  command->add_option("table", options->table, "CSV table, a measurement a line")->required();
  command->add_option("--into", options->into, "File of references to make or extend")->capture_default_str();
  command->callback([options] {
    std::ifstream file(options->table, std::ios::binary);
    if (!file) throw EnvironmentError(fmt::format("{} cannot be read; name a CSV table of measurements", options->table));
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    std::vector<compare::CaseRecord> records = compare::read_experiments(text, options->table);
    for (compare::CaseRecord& record : records) record.name = name_of(record), record.key = cfd_cases::sha256(record.description);
    const bool exists = std::filesystem::exists(options->into);
    const compare::Reference merged = compare::merged(exists ? compare::read_reference(options->into) : compare::Reference{}, records);
    if (const auto folder = std::filesystem::path(options->into).parent_path(); !folder.empty())
      std::filesystem::create_directories(folder);
    const bool written = compare::write_reference(options->into, merged, revision());
    fmt::print("{}: {} cases, {} measurements entered{}\n", options->into, merged.cases.size(), records.size(),
               written ? "" : ", nothing changed");
  });
}

}  // namespace cli
