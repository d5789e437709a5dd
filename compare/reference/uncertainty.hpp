#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "compare/case_record/case_record.hpp"

namespace compare {

/// Discretisation uncertainty of one quantity on systematically refined meshes.
struct GridStudy {
  double uncertainty = 0.0;   ///< one standard uncertainty of the value on the finest mesh: half the 95 % figure of the procedure
  double extrapolated = 0.0;  ///< fitted value at cell size zero
  double order = 0.0;         ///< observed order; 0 where the branch does not use it
  double safety = 3.0;        ///< factor from the fitted error, or the range of the data, to the 95 % figure
  std::string branch;         ///< how it was found: "observed order 1.83, safety factor 1.25", "data range ...", ...
};

/// Least-squares procedure of Eca and Hoekstra (2014): fit phi = phi_0 + alpha h^p, weighted and not, with fall-backs on fixed orders when
/// p is outside [0.5, 2], and a safety factor 1.25 or 3. Differs: three meshes leave no freedom to see scatter, so they get the factor 1.25
/// with an order of 1 to 2.1 only (Roache 1998, sec. 5.9), and three times the range of the data where p is below 0.5 or there is none;
/// which also is the most that four or more get where scatter hides the trend. `dragval truth --held-back` shows how often that holds.
/// @param cells   number of cells of each mesh; the cell size is cells^(-1/3)
/// @param values  same order
/// @param earned  safety factor of a clean order, where it is to be less trusted than with 1.25
/// @throws std::invalid_argument  fewer than three meshes, sizes that do not match, or two meshes less than 5 % apart in cell size
///                                (the same mesh twice would fake convergence)
GridStudy grid_study(const std::vector<double>& cells, const std::vector<double>& values, double earned = 1.25);

/// Generalised Richardson extrapolation from two meshes, which show no order: that of the scheme, 2, is assumed, and the safety factor 3
/// gives the 95 % figure (Roache 1998, sec. 5.9), so that u = 3/2 |phi_1 - phi_2| / (r^2 - 1) with r the ratio of cell sizes.
/// @throws std::invalid_argument  as grid_study(), for anything but two meshes
GridStudy two_grid_study(const std::vector<double>& cells, const std::vector<double>& values);

/// What is said of a flow on two meshes by two_grid_study(), on more by grid_study(): laminar flow earns its factor 1.25, a turbulent one
/// keeps the factor 3 whatever its order, since wakes that settle on three meshes were seen to change on the fourth (docs/cfd.md).
/// @throws std::invalid_argument  as those do
GridStudy mesh_study(const std::vector<double>& cells, const std::vector<double>& values, const std::string& flow_model);

/// Standard uncertainty of the mean load of a case, SI channels.
struct LoadUncertainty {
  using Channels = case_record::CaseRecord::Channels;
  Channels total = Channels::Zero();      ///< root sum square of `numerical` and `method`
  Channels numerical = Channels::Zero();  ///< of discretisation, iteration, statistics and symmetry, as far as known; an experiment's own
  Channels method = Channels::Zero();     ///< of the equations solved: cases_of_record() adds it
  Channels discretisation = Channels::Zero();
  bool discretisation_assessed = false;  ///< true, too, where there is no mesh: `total` lacks no part
  std::vector<std::string> branches;     ///< one per channel when assessed, or one that says why not
};

/// Standard uncertainty of a quantity that follows from force [N] and moment [N m]: linear propagation, the six channels taken as
/// independent.
/// @param quantity  may be undefined near the load of the case: a channel in which it is counts as none
double propagated(const case_record::CaseRecord& record, const LoadUncertainty::Channels& u,
                  const std::function<std::optional<double>(const Eigen::Vector3d& force, const Eigen::Vector3d& moment)>& quantity);

/// A case at all mesh levels that were solved. `levels` ascend in cells; the last usable one is the case of record.
struct CaseFamily {
  std::string name;                                 ///< family_name() of its cases
  const case_record::CaseRecord* record = nullptr;  ///< finest usable level; the finest of all when none is usable
  std::vector<const case_record::CaseRecord*> levels;
  LoadUncertainty uncertainty;

  std::vector<const case_record::CaseRecord*> usable_levels() const;
};

/// A case name taken apart at its mesh level: "plate_re-1e5_medium_upwind" is the case "plate_re-1e5" with the variant "upwind".
struct CaseName {
  std::string stem, variant;
};
CaseName split_name(const std::string& case_name, const std::string& mesh_level);

/// The name of a case without its mesh level: "cube_re-1e5_medium" and "cube_re-1e5_fine" are one family. A variant stays in the name.
std::string family_name(const std::string& case_name, const std::string& mesh_level);

/// u_disc [N, N m] of any level of a family: its distance from the finest, and the u of that. Empty where u_disc of the family is not
/// assessed.
std::optional<LoadUncertainty::Channels> discretisation_at(const CaseFamily& family, const case_record::CaseRecord& level);

/// Groups records that differ in nothing but the mesh level, in order of name. Pointers into `records`.
///
/// The discretisation uncertainty comes from mesh_study() where three or more levels are usable. Elsewhere it is carried from the
/// representative family (three levels, same body or else kind of shape, flow model and spin, no variant) whose wind, or axis of spin, is
/// nearest in the body's frame and whose Reynolds number is near (a decade counts as 26 degrees): the distance of its mesh of the same level
/// from its finest and the u of the finest, relative to max(|C| of the channel, 0.3 of the force, or 0.1 for a moment); and two usable levels
/// give mesh_study(), never less than what is carried.
/// docs/conventions.md, "Uncertainty".
std::vector<CaseFamily> case_families(const std::vector<case_record::CaseRecord>& records);

}  // namespace compare
