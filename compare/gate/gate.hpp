#pragma once

#include <functional>
#include <string>
#include <vector>

#include "compare/gate/baseline.hpp"

namespace compare {

/// Predictions are sums of a few thousand products: compilers and processors reorder them to about 1e-13; no change of a model is this
/// small.
constexpr double rounding = 1e-9;

/// Uncertainties come from fits and finite differences, which stretch rounding; an edit that matters is far larger.
bool same_uncertainty(double a, double b);

/// One check of one model, with its numbers.
struct GateCheck {
  std::string name;  ///< "note: predictions"
  bool passed = false;
  int compared = 0;    ///< numbers looked at; a check that looked at none does not pass
  std::string detail;  ///< worst case with its numbers, or all offenders
};

struct GateResult {
  std::vector<GateCheck> checks;
  int planned = 0;   ///< cases that the baseline asks for
  int compared = 0;  ///< of these, cases with both sides

  bool complete() const { return planned > 0 && compared == planned; }
  bool passed() const;
};

/// Regression of the coefficient errors against the accepted baseline. Per model:
///   terms        what the baseline allows is what the rules allow: u is that of the references, no budget is above the standing one, and
///                the rms errors are those of the baseline's own numbers
///   predictions  equal the baseline's to rounding
///   references   equal the baseline's to rounding: a gate sees no noise of the CFD
///   group error  no rms error worse by more than its budget
///   case error   no single error worse by more than max(budget, 2u)
///   signs        a coefficient beyond 0.01 keeps the sign that it had
///   null         channels that a mirror plane makes zero are zero, in prediction and reference
/// and once: coverage, every planned case compared.
/// @param models        those that the baseline was made of
/// @param predictor_of  how a named model predicts; seeded defects come in here (odds.hpp)
GateResult run_gate(const Baseline& baseline, const std::vector<case_record::CaseRecord>& records,
                    const std::vector<NamedModel>& models = gated_models(),
                    const std::function<Predictor(const NamedModel&)>& predictor_of = predictor_of_choice);

/// Cases solved again against the stored ones of the same name (a variant "seed-N" against the case on the usual mesh), channel by channel:
/// apart by no more than twice their uncertainties of iteration, statistics and symmetry, the tolerance at which a run stops, 0.3 % of C_D,
/// or `seed_factor` times the scatter over mesh seeds that the baseline has for the case. A case that is not stored, or not usable now, fails.
/// @param budget  of C_D, in place of all that; 0: none
/// @throws std::invalid_argument  a budget below the scatter between seeds: unchanged code would not keep it
GateCheck check_solved_again(const Baseline& baseline, const std::vector<case_record::CaseRecord>& stored,
                             const std::vector<case_record::CaseRecord>& solved, double budget = 0.0);

/// How a result is written: for a terminal, for a pull request, for programs, for CI servers (JUnit's XML), and as GitHub's annotations.
enum class GateFormat { table, markdown, json, junit, github };
GateFormat gate_format_from(const std::string& word);  ///< "table", "md", "json", "junit", "github"; @throws std::invalid_argument

/// One line, row, test case or annotation per check, and a verdict.
/// @param colour  ANSI colour in GateFormat::table
std::string render(const GateResult& result, GateFormat format = GateFormat::table, bool colour = false);

}  // namespace compare
