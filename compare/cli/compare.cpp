#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "cfd_cases/campaign/campaign.hpp"
#include "compare/cli/commands.hpp"
#include "compare/tables/correlation_table.hpp"
#include "compare/tables/error_table.hpp"
#include "compare/tables/note_table.hpp"
#include "compare/tables/spin_table.hpp"

namespace cli {

void add_compare(CLI::App& app, Context& context) {
  struct Options {
    SourceOptions source;
    ModelOptions model;
    std::vector<std::string> by;
    std::string only;
    int divisions = 0;  ///< 0: default_divisions() of the shape
    std::string format = "table", output = "results/comparison.h5";
    bool json = false, correlations = false;
  };
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("compare", "Predict every case with the drag model and print the errors against the references");
  command->footer(
      "Without options the recommended model is compared: the law by class with its pillow.\n"
      "Examples: dragval compare --only cube\n"
      "          dragval compare --matrix quick --law consistent --pillow tilt --factor 0.78 --format md");
  add_source_options(*command, options->source);
  command->add_option("--only", options->only, "Cases whose name holds this, or matches this pattern with * ? []");
  add_model_options(*command, options->model);
  command->add_option("--divisions", options->divisions, "Fineness of the triangles; 0: 2 on flat sides, 32 per quarter turn")
      ->check(CLI::Range(0, 1000))
      ->capture_default_str();
  command->add_option("--by", options->by, "Group the statistics by any of shape, orientation, Re, held_out")->delimiter(',');
  command->add_option("--format", options->format, "table, md, csv or json")->capture_default_str();
  command->add_flag("--correlations", options->correlations,
                    "C_D up to Re 1e4 beside correlations of particles (Haider-Levenspiel, Ganser, Hoelzer-Sommerfeld), instead");
  command->add_flag("--json", options->json, "The same as --format json");
  command->add_option("--output", options->output, "HDF5 file for both sides and the errors; \"\" for none")->capture_default_str();
  command->callback([options, &context] {
    const compare::Format format = compare::format_from(options->json ? "json" : options->format);
    std::vector<compare::GroupBy> by;
    for (const std::string& word : options->by) by.push_back(compare::group_by_from(word));
    const compare::Predictor model = compare::predictor(options->model.model(), options->divisions);
    Sources sources = load(options->source);
    const auto shown = [&](const std::string& name) { return cfd_cases::named(options->only, name); };
    std::erase_if(sources.spinning, [&](const compare::CaseRecord& record) { return !shown(record.name); });
    const auto& cases = sources.reference.cases;
    if (options->correlations) {
      auto rows = compare::correlation_table(cases, model);
      std::erase_if(rows, [&](const compare::CorrelationRow& row) { return !shown(row.case_name); });
      if (rows.empty()) throw UsageError("no usable case up to Re 1e4 among these references");
      std::cout << compare::render(rows, options->model.label(), format, ::isatty(STDOUT_FILENO) && !std::getenv("NO_COLOR"));
      return;
    }
    const compare::ErrorTable table = compare::compare_with(cases, model, options->model.label(), sources.missing, by, shown);
    const std::vector<compare::NamedModel> laws = {{"note", dragcore::Model{}},
                                                   {"consistent", dragcore::Model{.law = dragcore::consistent_law()}},
                                                   {"by class", compare::ModelChoice::of_class()}};
    auto note = compare::note_table(cases, laws);
    std::erase_if(note, [&](const compare::NoteRow& row) { return !shown(row.case_name); });
    const auto spin = compare::spin_table(sources.spinning, model);
    if (format == compare::Format::json) {
      nlohmann::json document = compare::to_json(table);
      document["note_table"] = compare::to_json(note, laws);
      document["spin"] = compare::to_json(spin);
      std::cout << document.dump(2) << "\n";
    } else {
      const bool colour = ::isatty(STDOUT_FILENO) && !std::getenv("NO_COLOR");
      std::cout << compare::render(table, format, colour);
      if (format != compare::Format::csv && !note.empty())
        std::cout << (format == compare::Format::markdown ? "\n### " : "\n") << "C_D of the note's own table, each on its frontal area\n"
                  << (format == compare::Format::markdown ? "\n" : "") << compare::render(note, laws, format);
      if (!spin.empty()) std::cout << "\n" << compare::render(spin, options->model.label(), format, colour);
    }
    const bool any_spin = std::any_of(spin.begin(), spin.end(), [](const compare::SpinRow& row) { return row.cfd.has_value(); });
    if (table.compared == 0 && !any_spin) {
      const std::string place = options->source.cache.empty() ? options->source.store : options->source.cache;
      std::cerr << "dragval: Nothing was compared. " << place << " has no usable case"
                << (options->source.matrix.empty() ? "" : " of the matrix " + options->source.matrix)
                << (options->only.empty() ? ". Solve some: dragval run quick\n"
                                          : " with '" + options->only + "' in its name. dragval compare --format csv lists all names.\n");
      context.exit_code = exit_code::nothing_compared;
      return;
    }
    if (options->output.empty() || table.rows.empty()) return;
    if (const auto folder = std::filesystem::path(options->output).parent_path(); !folder.empty())
      std::filesystem::create_directories(folder);
    compare::write_comparison(options->output, {table});
    std::cerr << "both sides and their errors: " << options->output << "\n";
  });
}

}  // namespace cli
