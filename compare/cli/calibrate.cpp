#include <fmt/format.h>  // before any header of compare: fmt has a function of that name

#include "compare/calibration.hpp"

#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "compare/cli/commands.hpp"

namespace cli {

namespace {

nlohmann::json to_json(const compare::Calibration& calibration) {
  nlohmann::json list = nlohmann::json::array();
  for (const compare::Fit& fit : calibration.fits) {
    nlohmann::json entry{{"fit", fit.name}, {"target", fit.target}, {"cases", fit.cases}, {"condition_number", fit.condition_number}, {"correlation", fit.correlation}};
    for (const compare::Estimate& e : fit.estimates) {
      nlohmann::json estimate{{"name", e.name}, {"value", e.value}, {"at_bound", e.at_bound}, {"interval_95", nullptr}};
      if (e.interval) estimate["interval_95"] = {e.interval->first, e.interval->second};
      entry["estimates"].push_back(estimate);
    }
    for (const compare::FitErrors& e : fit.errors)
      entry["rms_errors"].push_back({{"group", e.group},
                                     {"n", e.n},
                                     {"before", e.before},
                                     {"note", e.note},
                                     {"in_sample", e.in_sample},
                                     {"left_out_pose", e.left_out_pose},
                                     {"left_out_shape", e.left_out_shape}});
    list.push_back(entry);
  }
  return list;
}

void print(const compare::Calibration& calibration) {
  for (const compare::Fit& fit : calibration.fits) {
    fmt::print("{}, fitted to {} of {} cases\n", fit.name, fit.target, fit.cases.size());
    for (const compare::Estimate& e : fit.estimates)
      fmt::print("  {:<14} {:7.4f}   {}\n", e.name, e.value,
                 e.interval ? fmt::format("95 % interval {:.4f} to {:.4f}", e.interval->first, e.interval->second) : "at its bound: no interval");
    if (fit.estimates.size() > 1) fmt::print("  correlation {:.2f}, condition number {:.1f}\n", fit.correlation[0][1], fit.condition_number);
    fmt::print("  rms error of {:<11}   n   uncalibrated  note's own  fitted  left-out pose  left-out shape\n", fit.target);
    for (const compare::FitErrors& e : fit.errors)
      fmt::print("  {:<24} {:3}   {:12.4f} {:11.4f} {:7.4f} {:14.4f} {:15.4f}\n", e.group, e.n, e.before, e.note, e.in_sample, e.left_out_pose, e.left_out_shape);
    fmt::print("\n");
  }
  fmt::print("Uncalibrated: pillow factor 0, or the note's law as it is. Note's own: pillow factor 1. Force arm: distance of the force's line of action\n"
             "from the centroid, in L_ref; it is what the pillow moves, free of the error of the force. Intervals: bootstrap over cases.\n");
}

}  // namespace

void add_calibrate(CLI::App& app, Context&) {
  struct Options {
    SourceOptions source;
    bool json = false;
  };
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("calibrate", "Fit scale, base suction and the factor of each pillow form to the references");
  command->footer("Example: dragval calibrate --store results/reference.h5");
  add_source_options(*command, options->source);
  command->add_flag("--json", options->json, "Print JSON");
  command->callback([options] {
    const compare::Calibration calibration = compare::calibrate(load(options->source).reference.cases);
    if (options->json)
      std::cout << to_json(calibration).dump(2) << "\n";
    else
      print(calibration);
  });
}

}  // namespace cli
