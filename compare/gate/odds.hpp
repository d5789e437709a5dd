#pragma once

#include <functional>
#include <string>
#include <vector>

#include "compare/gate/gate.hpp"

namespace compare {

/// What a gate looks at, for a defect to be seeded in.
struct Trial {
  std::vector<case_record::CaseRecord> records;
  std::function<Predictor(const NamedModel&)> predictor_of = predictor_of_choice;
  Baseline baseline;
};

/// A fault as people make them, in the prediction, in the references or in the baseline.
struct Defect {
  std::string where;  ///< "prediction", "references", "baseline"
  std::string name;
  std::function<void(Trial&)> seed;
};

/// All that the gate is tried with.
const std::vector<Defect>& defects();

/// How a gate answered to one defect.
struct DefectVerdict {
  std::string where, name;
  bool caught = false;
  int coefficients = 0;             ///< predicted or stored numbers that the defect changes by more than rounding
  std::vector<std::string> checks;  ///< those that turned red, without the model's name
};

/// How often a gate is wrong: a defect passed, or unchanged code stopped.
struct Odds {
  std::vector<DefectVerdict> defects;
  int repeats = 0;                        ///< cases solved again on meshes of other seeds by unchanged code
  std::vector<std::string> false_alarms;  ///< of these, what did not pass, with its numbers
  bool unchanged_passes = false;          ///< the gate itself on what is there

  int missed() const;
  bool passed() const { return unchanged_passes && missed() == 0 && false_alarms.empty(); }
};

/// Seeds every defect, one after the other, into what the gate sees of the laws by class, and asks it.
/// @param baseline  made of these records, or an accepted one
/// @param solved    cases of the matrix seeds, each held by itself against the stored one as `dragval gate --solved` would; seeds above
///                  `judged_seeds` are left out, since the scatter that is allowed is theirs
Odds gate_odds(const Baseline& baseline, const std::vector<case_record::CaseRecord>& records,
               const std::vector<case_record::CaseRecord>& solved);

std::string render(const Odds& odds, Format format);  ///< table, md or json; @throws std::invalid_argument for csv

}  // namespace compare
