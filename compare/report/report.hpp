#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "compare/calibration/calibration.hpp"
#include "compare/cost/cfd_cost.hpp"
#include "compare/cost/ladder.hpp"
#include "compare/store/store.hpp"
#include "compare/tables/error_table.hpp"

namespace compare {

/// A model as the report shows it, with its errors against the references.
struct ReportedModel {
  std::string law;     ///< "note's law", "consistent law", "law by class", "calibrated law": decides the colour
  std::string pillow;  ///< "none", "triangle", "patch", "tilt": decides the dash of a line
  ModelChoice choice;
  ErrorTable table;

  std::string label() const;  ///< "calibrated law, tilt pillow 0.78"
};

/// Everything that the page is made of.
struct Report {
  Reference reference;                     ///< bodies at rest
  std::vector<CaseRecord> spinning;        ///< and those that spin
  std::vector<ReportedModel> models;       ///< the laws without pillow first, the note's at their head; then each fitted pillow
  std::optional<Calibration> calibration;  ///< empty when the references do not suffice, and then:
  std::string calibration_fault;           ///< why
  Ladder cost;                             ///< without rungs when there are no turbulent cases at Re >= 1e4
  std::vector<CostCheck> cost_checks;      ///< predicted against actual CPU time of the references; filled by whoever has a prediction
  std::string source;                      ///< file or folder that the references came from
  std::string commit;                      ///< of the program

  int compared() const { return models.front().table.compared; }
};

/// Predicts, calibrates and measures the cost.
/// @param reference   bodies at rest
/// @param missing     names of planned cases that have no result
/// @param quick_cost  fewer repetitions and meshes in the measurement of cost, for tests
Report make_report(Reference reference, std::vector<CaseRecord> spinning, const std::vector<std::string>& missing, bool quick_cost = false);

/// Vega-Lite specifications by name: "drag_against_orientation", "drag_against_reynolds", "cost", "face_pressure", and "sweep-<slug>" for
/// every Sweep with a curve.
std::map<std::string, nlohmann::json> figures(const Report& report);

/// Writes one HTML file that needs nothing else, neither files nor network.
/// @param assets  folder of the template, the style and node_modules with vega, vega-lite, vega-embed and three
/// @param wasm    the library for JavaScript, dragcore.mjs; where it is missing, the page says how to make it
/// @throws std::runtime_error  when one of these is missing or the output cannot be written: the message says what to do
void write_report(const Report& report, const std::filesystem::path& output, const std::filesystem::path& assets,
                  const std::filesystem::path& wasm);

}  // namespace compare
