#pragma once

#include <compare/case_record/case_record.hpp>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "cfd_cases/flow_case/case_key.hpp"

namespace cfd_cases {

/// What a case will need, before anything of it exists.
struct CostEstimate {
  double cells = 0.0;
  double iterations = 0.0;
  std::map<std::string, double> cpu_s;  ///< by stage: "mesh", "convert", "solve", "post"
  double memory_bytes = 0.0;            ///< largest resident set of any program of the case, on one rank
  double relative_uncertainty = 0.0;    ///< of the sum of cpu_s, one standard uncertainty, on the machine of the fit

  double total_cpu_s() const;
};

/// How well numbers were found.
struct FitQuality {
  int cases = 0;
  double rms = 0.0;    ///< of ln(found / predicted)
  double worst = 0.0;  ///< largest |ln(found / predicted)|
};

/// value (cells / 20,000)^exponent
struct PowerLaw {
  double value = 0.0;
  double exponent = 0.0;
  FitQuality fit;

  double operator()(double cells) const;
};

/// Cells, iterations and CPU seconds of a case, from its description alone:
///
///   cells      = per_volume int_air h^-3 dV + per_surface int_boundary h^-2 dA              (cell_count.hpp)
///   iterations = iterations(cells), not beyond the limits of the stop policy                a law of the method
///   solve      = solve(cells) cells iterations                                              a law of the method
///   mesh, convert, post = stage(cells) cells
///   memory     = memory_bytes + memory_bytes_per_cell cells
///
/// with every law a power of the number of cells, and one method for each word of CaseSpec::flow_model. Neither the class of the body
/// beside the cells nor the level instead of them foretells iterations better (left-out rms of the logarithm 0.34, 0.38; with cells alone
/// 0.35): they vary with whether the wake settles, which is most of the uncertainty.
struct CostModel {
  struct Method {
    PowerLaw solve;       ///< CPU seconds per cell and iteration
    PowerLaw iterations;  ///< their mean, so that sums over many cases are right
    FitQuality total;     ///< of the whole CPU time of a case
  };
  double per_volume = 0.0, per_surface = 0.0;
  FitQuality cells_fit;
  std::map<std::string, PowerLaw> stages;  ///< "mesh", "convert", "post": CPU seconds per cell
  std::map<std::string, Method> methods;   ///< by flow model
  double memory_bytes = 0.0, memory_bytes_per_cell = 0.0;
  std::string memory_measured;  ///< on what
  std::map<std::string, std::string> provenance;

  /// @throws ConfigurationError when there is no method for the flow model: the message names those that there are
  CostEstimate estimate(const CaseSpec& spec, const CaseIdentity& identity) const;

  /// CPU seconds of the solver on this many cells and iterations. @throws as estimate()
  double solve_cpu_s(const std::string& flow_model, double cells, double iterations) const;

 private:
  const Method& method(const std::string& flow_model) const;
};

/// cost_model.toml of the source tree, or of cfd_cases/ in the working folder.
std::filesystem::path cost_model_file();

/// @throws ConfigurationError  with "file:line:column: " when the text is no TOML, when a number is missing, out of range or not a number,
///                             when a key is unknown; read_cost_model() also when there is no such file
CostModel parse_cost_model(std::string_view text, const std::filesystem::path& file);
CostModel read_cost_model(const std::filesystem::path& file);

/// The file's text: parse_cost_model() of it gives the same model.
std::string to_toml(const CostModel& model);

/// Fits cells, stages and methods to cases that ended by themselves (steady or drifting). Laws are fitted to logarithms with Huber's
/// weights, so that a machine busy for some cases does not show; the mean of the iterations is kept, for they are no noise. What the cases
/// say nothing about (memory, methods without cases) stays as it is in `known`.
/// @throws std::invalid_argument when fewer than 5 of the cases were described by this program
CostModel fit_cost_model(const CostModel& known, const std::vector<case_record::CaseRecord>& cases);

/// How much slower than the machine of the fit the solver ran here.
struct Pace {
  double factor = 1.0;
  int cases = 0;  ///< that it is the median of; 0: nothing is known of this machine

  /// One standard uncertainty, relative: what a case's CPU time varies by on a machine shared with others, over the root of their number.
  double relative_uncertainty() const;
};

/// Median over the cases that ended by themselves of CPU seconds / solve_cpu_s() of the cells and iterations that they had, so that a case
/// with many iterations does not pass for a slow machine.
Pace pace_of(const CostModel& model, const std::vector<const case_record::CaseRecord*>& cases);

}  // namespace cfd_cases
