#pragma once

#include <dragcore/drag.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "compare/calibration/prediction.hpp"
#include "compare/store/store.hpp"

namespace CLI {
class App;
}

/// The program `dragval`. A command parses, calls the library and prints: results on stdout, progress on stderr.
namespace cli {

/// What the program returns to the shell.
namespace exit_code {
constexpr int pass = 0;
constexpr int gate_failed = 1;
constexpr int usage = 2;             ///< command line, matrix or baseline not as needed
constexpr int environment = 3;       ///< a tool or a readable file is missing
constexpr int run_failed = 4;        ///< a case failed, diverged or ran out of time
constexpr int nothing_compared = 5;  ///< no case had both sides, or fewer cases than planned
}  // namespace exit_code

/// Shared by all commands; a callback sets `exit_code` when it ends with anything but success.
struct Context {
  int exit_code = exit_code::pass;
};

/// Thrown anywhere below a command: main() prints "dragval: <message>" on stderr and returns the exit code. std::invalid_argument counts as
/// UsageError, any other std::exception (a file that cannot be read, a full disk) as EnvironmentError.
struct UsageError : std::invalid_argument {
  using std::invalid_argument::invalid_argument;
};
struct EnvironmentError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// One per command, in a file of its own. Each adds its subcommand with options, example and callback; `context` outlives the app.
void add_doctor(CLI::App& app, Context& context);
void add_plan(CLI::App& app, Context& context);
void add_run(CLI::App& app, Context& context);
void add_explain(CLI::App& app, Context& context);
void add_collect(CLI::App& app, Context& context);
void add_import(CLI::App& app, Context& context);
void add_compare(CLI::App& app, Context& context);
void add_truth(CLI::App& app, Context& context);
void add_variants(CLI::App& app, Context& context);
void add_calibrate(CLI::App& app, Context& context);
void add_cost(CLI::App& app, Context& context);
void add_gate(CLI::App& app, Context& context);
void add_odds(CLI::App& app, Context& context);
void add_baseline(CLI::App& app, Context& context);
void add_report(CLI::App& app, Context& context);
void add_mesh(CLI::App& app, Context& context);
void add_drag(CLI::App& app, Context& context);
void add_bake(CLI::App& app, Context& context);

/// The drag model asked for on the command line: --law (with --scale and --base-suction), --pillow, --factor, --quadrature. Nothing asked
/// for is what model_for() recommends.
struct ModelOptions {
  std::string law = "class";
  double scale = 1.0, base_suction = 0.0;  ///< of --law scaled
  std::string pillow;                      ///< empty: with the law by class its class_pillow(), with any other law none
  std::string falloff = "circular";
  std::optional<double> factor;
  int quadrature = 3;

  compare::ModelChoice model() const;  ///< @throws std::invalid_argument naming the known laws and forms
  std::string label() const;           ///< "note", "consistent, pillow tilt 0.78": for headings and files
};
void add_model_options(CLI::App& command, ModelOptions& options);

/// What a gate watches: the model that was asked for by --law or --pillow, by itself; compare::gated_models() where neither was.
std::vector<compare::NamedModel> watched_models(const CLI::App& command, const ModelOptions& options);

/// Where the references come from: --store FILE or --cache DIR, and which of them: --matrix TIER or file.
struct SourceOptions {
  std::string store = "results/reference.h5";
  std::string cache;   ///< when given, DIR/runs/*.h5 instead of the store
  std::string matrix;  ///< when given, only its cases, and those without a result as missing
};
void add_source_options(CLI::App& command, SourceOptions& options);

/// References in order of name, bodies at rest apart from those that spin, and the names of the cases that the matrix asks for and no
/// record answers.
struct Sources {
  compare::Reference reference;  ///< bodies at rest
  std::vector<compare::CaseRecord> spinning;
  std::vector<std::string> missing;
};
Sources load(const SourceOptions& options);

/// Runs of a cache folder that --solved names. @throws EnvironmentError  when there is no such folder
std::vector<compare::CaseRecord> solved_again(const std::string& cache);

/// Revision of the tree that the program works in, for provenance; "unknown" outside a repository.
std::string revision();

/// A share as people write it, "2%", "2 %" or "0.02"; from 1 on a bare number is per cent. @throws UsageError  unless in (0, 1)
double share_from(const std::string& option, std::string word);

}  // namespace cli
