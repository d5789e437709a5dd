#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <charconv>
#include <cstdio>
#include <dragcore/unknown_word.hpp>
#include <filesystem>
#include <set>

#include "cfd_cases/flow_case/matrix.hpp"
#include "compare/calibration/prediction.hpp"
#include "compare/cli/commands.hpp"
#include "compare/gate/baseline.hpp"
#include "compare/reference/case_of_record.hpp"
#include "compare/reference/uncertainty.hpp"
#include "dragcore/law_file.hpp"

namespace cli {

namespace {

const std::vector<std::string> laws = {"note", "consistent", "sheet", "closed", "scaled", "class"};

}  // namespace

compare::ModelChoice ModelOptions::model() const {
  if (quadrature != 0 && quadrature != 1 && quadrature != 3 && quadrature != 6)
    throw UsageError(fmt::format("--quadrature {}: 1, 3 or 6 points per triangle are needed, or 0 for adaptive", quadrature));
  if (law != "scaled" && (scale != 1.0 || base_suction != 0.0)) throw UsageError("--scale and --base-suction belong to --law scaled");
  if (std::find(laws.begin(), laws.end(), law) == laws.end() && !law.ends_with(".toml"))
    throw UsageError(dragcore::unknown_word("law", law, laws) + ", or a file of your own, LAW.toml");
  dragcore::Pillow chosen_pillow;
  if (!pillow.empty()) chosen_pillow = {dragcore::pillow_form_from(pillow), factor.value_or(0.0), dragcore::falloff_from(falloff)};
  if (pillow.empty() && factor) throw UsageError("--factor needs --pillow: tilt, say");
  if (chosen_pillow.form != dragcore::PillowForm::none && !pillow.empty() && !factor)
    throw UsageError(fmt::format("--pillow {} needs --factor: 0 to 1, of the tilt form 0 to 1.5", pillow));
  compare::ModelChoice choice =
      law == "class" && pillow.empty() ? compare::ModelChoice::recommended() : compare::ModelChoice::of_class(chosen_pillow);
  choice.model.quadrature = static_cast<dragcore::Quadrature>(quadrature);
  if (law == "class") return choice;
  choice.by_class = false;
  choice.model.law = law == "scaled"          ? dragcore::scaled_law(scale, base_suction)
                     : law.ends_with(".toml") ? dragcore::read_law(law).law
                                              : dragcore::named_law(law);
  return choice;
}

std::string ModelOptions::label() const {
  const std::string name = law == "scaled"  ? fmt::format("scaled {:g} suction {:g}", scale, base_suction)
                           : law == "class" ? "by class"
                                            : std::filesystem::path(law).filename().string();
  const std::string pillow_label = model().pillow_label();
  return pillow_label.empty() ? name : name + ", " + pillow_label;
}

void add_model_options(CLI::App& command, ModelOptions& options) {
  command
      .add_option("--law", options.law,
                  "Pressure law: note, consistent, sheet, closed, scaled, class (the recommended: sheet or closed, by the body), or a TOML "
                  "file")
      ->capture_default_str();
  command.add_option("--scale", options.scale, "Of the scaled law: factor on the note's windward pressure (dragval calibrate)")
      ->check(CLI::Range(0.0, 3.0))
      ->capture_default_str();
  command.add_option("--base-suction", options.base_suction, "Of the scaled law: suction coefficient of leeward faces")
      ->check(CLI::Range(0.0, 3.0))
      ->capture_default_str();
  command.add_option(
      "--pillow", options.pillow,
      "Form of the pillow effect: none, triangle, patch, tilt or eccentricity (default: the recommended one with --law class, "
      "else none)");
  command.add_option("--falloff", options.falloff, "Of the triangle and patch forms: circular or linear")->capture_default_str();
  command.add_option("--factor", options.factor, "Factor of --pillow: 0 to 1, of the tilt form 0 to 1.5");
  command.add_option("--quadrature", options.quadrature, "Points per triangle: 1, 3 or 6, or 0 for adaptive")->capture_default_str();
}

std::vector<compare::NamedModel> watched_models(const CLI::App& command, const ModelOptions& options) {
  if (command.count("--law") + command.count("--pillow") == 0) return compare::gated_models();
  return {{options.label(), options.model()}};
}

void add_source_options(CLI::App& command, SourceOptions& options) {
  CLI::Option* store = command.add_option("--store", options.store, "Collected references")->capture_default_str();
  command.add_option("--cache", options.cache, "Take the runs of this cache folder instead, .dragval for example")->excludes(store);
  command.add_option("--matrix", options.matrix,
                     "Only the cases of this tier or matrix file; those without a result are listed as missing");
}

Sources load(const SourceOptions& options) {
  const std::filesystem::path place = options.cache.empty() ? options.store : options.cache;
  if (!std::filesystem::exists(place))
    throw EnvironmentError(options.cache.empty()
                               ? fmt::format("There is no {} in {}. Call dragval from the root of the repository, or name the file of "
                                             "references with --store.",
                                             place.string(), std::filesystem::current_path().string())
                               : fmt::format("There is no cache folder {} in {}. Solve cases first, dragval run quick, or name the folder "
                                             "with --cache.",
                                             place.string(), std::filesystem::current_path().string()));
  compare::Reference all = options.cache.empty() ? compare::read_reference(options.store)
                                                 : compare::merged({}, compare::read_runs(std::filesystem::path(options.cache) / "runs"));
  Sources sources;
  if (!options.matrix.empty()) {
    // By families: where a finer mesh of a case of the matrix is known, it counts too.
    std::map<std::string, std::string> wanted;
    for (const cfd_cases::CaseSpec& spec : cfd_cases::load_matrix(options.matrix).cases)
      wanted[compare::family_name(spec.name, spec.mesh_level)] = spec.name;
    compare::Reference kept;
    std::set<std::string> found;
    const auto of_matrix = [&](const compare::CaseRecord& record) {
      return wanted.contains(compare::family_name(record.name, record.mesh_level));
    };
    // No matrix asks for an experiment: it comes with the case whose question it answers.
    const auto asked = [&](const compare::CaseRecord& record) {
      return of_matrix(record) ||
             (record.is_experiment() && std::any_of(all.cases.begin(), all.cases.end(), [&](const compare::CaseRecord& other) {
                return of_matrix(other) && compare::same_question(record, other);
              }));
    };
    for (std::size_t i = 0; i < all.cases.size(); ++i) {
      const compare::CaseRecord& record = all.cases[i];
      if (!asked(record)) continue;
      found.insert(compare::family_name(record.name, record.mesh_level));
      kept.cases.push_back(record);
      kept.patches.push_back(all.patches[i]);
    }
    for (const auto& [family, name] : wanted)
      if (!found.contains(family)) sources.missing.push_back(name);
    all = std::move(kept);
  }
  sources.reference = compare::at_rest(all);
  sources.spinning = compare::spinning(all.cases);
  return sources;
}

std::vector<compare::CaseRecord> solved_again(const std::string& cache) {
  if (!std::filesystem::is_directory(cache))
    throw EnvironmentError(fmt::format("--solved {}: there is no such cache folder in {}; dragval run smoke --cache {} makes one", cache,
                                       std::filesystem::current_path().string(), cache));
  return compare::read_runs(std::filesystem::path(cache) / "runs");
}

std::string revision() {
  std::string text;
  if (std::FILE* pipe = ::popen("git describe --always --dirty 2>/dev/null", "r")) {
    std::array<char, 128> buffer;
    while (std::fgets(buffer.data(), buffer.size(), pipe)) text += buffer.data();
    ::pclose(pipe);
  }
  text.erase(text.find_last_not_of(" \n") + 1);
  return text.empty() ? "unknown" : text;
}

double share_from(const std::string& option, std::string word) {
  const std::string given = word;
  std::erase(word, ' ');
  const bool percent = word.ends_with('%');
  if (percent) word.pop_back();
  double value = 0.0;
  const auto [end, fault] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (fault == std::errc() && end == word.data() + word.size() && (percent || value >= 1.0)) value *= 0.01;
  if (fault != std::errc() || end != word.data() + word.size() || !(value > 0.0 && value < 1.0))
    throw UsageError(fmt::format("{} '{}': a share above 0 and below 100% is needed, such as 2% or 0.02", option, given));
  return value;
}

}  // namespace cli
