#include <fmt/format.h>  // before any header of compare: fmt has a function of that name

#include <CLI/CLI.hpp>
#include <cmath>
#include <dragcore/law_file.hpp>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "compare/calibration/calibration.hpp"
#include "compare/cli/calibrate_body.hpp"
#include "compare/cli/commands.hpp"

namespace cli {

namespace {

nlohmann::json to_json(const compare::Calibration& calibration) {
  nlohmann::json list = nlohmann::json::array();
  for (const compare::Fit& fit : calibration.fits) {
    nlohmann::json entry{{"fit", fit.name},
                         {"target", fit.target},
                         {"cases", fit.cases},
                         {"condition_number", fit.condition_number},
                         {"correlation", fit.correlation}};
    for (const compare::Estimate& e : fit.estimates) {
      nlohmann::json estimate{{"name", e.name}, {"value", e.value}, {"at_bound", e.at_bound}, {"interval_95", nullptr}};
      if (e.interval) estimate["interval_95"] = {e.interval->first, e.interval->second};
      entry["estimates"].push_back(estimate);
    }
    for (const compare::FitErrors& e : fit.errors)
      entry["rms_errors"].push_back(
          {{"group", e.group},
           {"n", e.n},
           {"before", e.before},
           {"note", e.note},
           {"in_sample", e.in_sample},
           {"left_out_pose", e.left_out_pose},
           {"left_out_shape", std::isnan(e.left_out_shape) ? nlohmann::json() : nlohmann::json(e.left_out_shape)}});
    list.push_back(entry);
  }
  return list;
}

void print(const compare::Calibration& calibration) {
  std::vector<compare::Fit> fits = calibration.fits;
  if (calibration.by_class_pillow) fits.push_back(*calibration.by_class_pillow);
  for (const compare::Fit& fit : fits) {
    fmt::print("{}, fitted to {} of {} cases\n", fit.name, fit.target, fit.cases.size());
    for (const compare::Estimate& e : fit.estimates)
      fmt::print(
          "  {:<14} {:7.4f}   {}\n", e.name, e.value,
          e.interval ? fmt::format("95 % interval {:.4f} to {:.4f}", e.interval->first, e.interval->second) : "at its bound: no interval");
    if (fit.estimates.size() == 2)
      fmt::print("  correlation {:.2f}, condition number {:.1f}\n", fit.correlation[0][1], fit.condition_number);
    if (fit.estimates.size() > 2) {
      fmt::print("  condition number {:.1f}; correlations\n", fit.condition_number);
      for (std::size_t i = 1; i < fit.estimates.size(); ++i) {
        fmt::print("  {:<14}", fit.estimates[i].name);
        for (std::size_t j = 0; j < i; ++j) fmt::print(" {:6.2f}", fit.correlation[i][j]);
        fmt::print("\n");
      }
    }
    fmt::print("  rms error of {:<11}   n   uncalibrated  note's own  fitted  left-out pose  left-out shape\n", fit.target);
    for (const compare::FitErrors& e : fit.errors)
      fmt::print("  {:<24} {:3}   {:12.4f} {:11.4f} {:7.4f} {:14.4f} {:>15}\n", e.group, e.n, e.before, e.note, e.in_sample,
                 e.left_out_pose, std::isnan(e.left_out_shape) ? "-" : fmt::format("{:.4f}", e.left_out_shape));
    fmt::print("\n");
  }
}

void print_legend() {
  fmt::print(
      "Uncalibrated: pillow factor 0, or the note's law as it is. Note's own: pillow factor 1. Force arm: distance of the force's line of "
      "action\n"
      "from the centroid, in L_ref; it is what the pillow moves, free of the error of the force. Intervals: bootstrap over cases.\n");
}

std::map<std::string, std::string> provenance(const compare::Fit& fit) {
  const compare::FitErrors& all = fit.errors.front();
  std::string intervals;
  for (const compare::Estimate& e : fit.estimates)
    intervals += fmt::format("{}{} {}", intervals.empty() ? "" : ", ", e.name,
                             e.interval ? fmt::format("{:.3f} to {:.3f}", e.interval->first, e.interval->second) : "at its bound");
  return {{"fitted_to",
           fmt::format("force vectors of {} cases of results/reference.h5, k-omega SST at Re 1e5; held-out bodies are not among them",
                       fit.cases.size())},
          {"command", "dragval calibrate --class-laws --write dragcore/laws"},
          {"intervals_95", intervals},
          {"errors",
           "rms relative error of the force: " +
               fmt::format("fitted {:.3f}, left-out pose {:.3f}, left-out shape {}; the {} law {:.3f}", all.in_sample, all.left_out_pose,
                           std::isnan(all.left_out_shape) ? "not known: one shape" : fmt::format("{:.3f}", all.left_out_shape),
                           fit.model.law.name == "sheet" ? "consistent" : "note's", all.note)},
          {"validity", fit.model.law.name == "sheet" ? "thin plates and discs; Re >= 1e4, and below where the viscosity is known"
                                                     : "closed convex bodies; Re 1e4 to 2e5, and below where the viscosity is known: 10 to "
                                                       "40 % too draggy between Re 200 and 1e4"}};
}

std::string viscous_provenance(const compare::Fit& fit) {
  const compare::FitErrors& all = fit.errors.front();
  return fmt::format(
      "layer and layer_curvature fitted to force vectors of {} cases of results/reference.h5 below Re 200 by "
      "dragval calibrate --viscous --write dragcore/laws; rms relative error of the force: fitted {:.3f}, left-out pose {:.3f}, "
      "left-out shape {:.3f}; stokes is exact for ellipsoids as Re -> 0",
      fit.cases.size(), all.in_sample, all.left_out_pose, all.left_out_shape);
}

/// What a folder has of a law already, or the built-in one.
dragcore::LawFile law_on_file(const std::filesystem::path& file, const dragcore::Law& otherwise) {
  return std::filesystem::exists(file) ? dragcore::read_law(file) : dragcore::LawFile{otherwise, {}};
}

}  // namespace

void add_calibrate(CLI::App& app, Context& context) {
  struct Options {
    SourceOptions source;
    bool json = false, class_laws = false, viscous = false;
    std::string write;
    BodyCalibration body;
  };
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("calibrate", "Fit scale, base suction and the factor of each pillow form to the references");
  command->footer(
      "Examples: dragval calibrate --store results/reference.h5\n          dragval calibrate --mesh body.stl --unit mm --poses 12 --write "
      "body.h5\n"
      "One body (--mesh, --wind-tunnel, --stored) gets a law, a pillow and a map of what they miss: docs/calibrating.md.");
  add_source_options(*command, options->source);
  command->add_flag("--json", options->json, "Print JSON");
  command->add_flag("--class-laws", options->class_laws, "Fit the laws by class, sheet and closed, to the force vector instead (a minute)");
  command->add_flag("--viscous", options->viscous, "Fit the viscous terms of both laws by class to the force vectors below Re 200 instead");
  command->add_option("--write", options->write,
                      "With --class-laws or --viscous: folder for sheet.toml and closed.toml with what was found; of one body: file for "
                      "its model, body.h5");
  BodyCalibration& body = options->body;
  CLI::Option* mesh = command->add_option("--mesh", body.mesh, "One body: STL or OBJ, solved in --poses by OpenFOAM");
  command->add_option("--unit", body.unit, "Of the mesh: mm, cm, m, in, ft, or its size in metres")->needs(mesh);
  command->add_option(
      "--wind-tunnel", body.table,
      "One body from a table of measurements instead: the columns of `dragval import`; its shape may be the file name of --mesh");
  command->add_option("--stored", body.stored, "One body from stored references: cube, cone-apex_angle_deg-60, ...");
  command->add_option("--poses", body.poses, "Directions of the wind to begin with")->check(CLI::Range(3, 200))->capture_default_str();
  command->add_option("--more", body.more, "So many more, where the map is least sure")->check(CLI::Range(1, 200));
  command->add_option("--reynolds", body.reynolds, "On the reference length")->check(CLI::Range(0.1, 1e9))->capture_default_str();
  command->add_option("--area", body.area, "A_ref of the mesh [m^2] (default: its largest silhouette along an axis)")
      ->check(CLI::PositiveNumber);
  command->add_option("--length", body.length, "L_ref of the mesh [m] (default: the root of the area)")->check(CLI::PositiveNumber);
  command->add_option("--levels", body.levels, "Meshes of every pose; from two on the error of the mesh is in u")->capture_default_str();
  command->add_option("-j,--jobs", body.jobs, "Cases side by side")->check(CLI::Range(1, 1000));
  command->add_flag("--retry-failed", body.retry_failed, "Solve cases that failed, diverged or drifted once more");
  command->add_flag("--dry-run", body.dry_run, "Say what would be solved and what it would cost, and end");
  command->callback([options, &context] {
    if (options->body.wanted()) {
      if (options->json || options->class_laws || options->viscous)
        throw UsageError("--json, --class-laws and --viscous are not of one body");
      options->body.write = options->write;
      if (!options->source.cache.empty()) options->body.cache = options->source.cache;
      return calibrate_body(options->body, options->source, context);
    }
    if (options->class_laws && options->viscous) throw UsageError("--class-laws and --viscous are two fits: one after the other");
    if (!options->write.empty() && !options->class_laws && !options->viscous)
      throw UsageError("--write belongs to --class-laws and --viscous");
    const auto cases = load(options->source).reference.cases;
    const compare::Calibration calibration = options->class_laws ? compare::calibrate_class_laws(cases)
                                             : options->viscous ? compare::calibrate_viscous_terms(cases)
                                                                : compare::calibrate(cases);
    if (options->json) {
      std::cout << to_json(calibration).dump(2) << "\n";
    } else {
      print(calibration);
      options->class_laws || options->viscous ? fmt::print(
                                "Force vector: length of the error over the larger of the force and 0.3 q A_ref; uncalibrated and the "
                                "note's own: the note's law for closed bodies,\nthe consistent law for sheets.\n")
                          : print_legend();
    }
    if (options->write.empty()) return;
    for (const compare::Fit& fit : calibration.fits) {
      std::vector<dragcore::Law> laws{fit.model.law};
      if (fit.model.sheets) laws.push_back(fit.model.sheets->law);
      for (const dragcore::Law& law : laws) {
        const auto file = std::filesystem::path(options->write) / (law.name + ".toml");
        dragcore::LawFile kept = law_on_file(file, law);
        if (options->viscous) {
          kept.law.stokes = law.stokes, kept.law.layer = law.layer, kept.law.layer_curvature = law.layer_curvature;
          kept.provenance["viscous"] = viscous_provenance(fit);
        } else {
          std::map<std::string, std::string> found = provenance(fit);
          found.merge(kept.provenance);  // of the viscous terms
          kept = {law, found};
        }
        dragcore::write_law(file, kept);
        std::cerr << file.string() << "\n";
      }
    }
  });
}

}  // namespace cli
