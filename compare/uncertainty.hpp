#pragma once

#include <string>
#include <vector>

#include "compare/case_record/case_record.hpp"

namespace compare {

/// Discretisation uncertainty of one quantity on systematically refined meshes.
struct GridStudy {
  double uncertainty = 0.0;   ///< one standard uncertainty of the value on the finest mesh: half the 95 % figure of the procedure
  double extrapolated = 0.0;  ///< fitted value at cell size zero
  double order = 0.0;         ///< observed order; 0 where the branch does not use it
  std::string branch;         ///< how it was found: "observed order 1.83, safety factor 1.25", "data range ...", ...
};

/// Least-squares procedure of Eca and Hoekstra (2014): fit phi = phi_0 + alpha h^p, weighted and not, with fall-backs on fixed orders when
/// p is outside [0.5, 2], and a safety factor 1.25 or 3. Differs: three meshes leave no freedom to see scatter, so they always get the
/// factor 3, and the range of the data where p is not in [0.5, 2].
/// @param cells   number of cells of each mesh; the cell size is cells^(-1/3)
/// @param values  same order
/// @throws std::invalid_argument  fewer than three meshes, sizes that do not match, or two meshes less than 5 % apart in cell size
///                                (the same mesh twice would fake convergence)
GridStudy grid_study(const std::vector<double>& cells, const std::vector<double>& values);

/// Standard uncertainty of the mean load of a case, SI channels.
struct LoadUncertainty {
  case_record::CaseRecord::Channels total = case_record::CaseRecord::Channels::Zero();  ///< root sum square of all parts that are known
  case_record::CaseRecord::Channels discretisation = case_record::CaseRecord::Channels::Zero();
  bool discretisation_assessed = false;
  std::vector<std::string> branches;  ///< one per channel when assessed; or why the meshes were refused
};

/// A case at all mesh levels that were solved. `levels` ascend in cells; the last usable one is the case of record.
struct CaseFamily {
  const case_record::CaseRecord* record = nullptr;  ///< finest usable level; the finest of all when none is usable
  std::vector<const case_record::CaseRecord*> levels;
  LoadUncertainty uncertainty;
};

/// The name of a case without its mesh level: "cube_re-1e5_medium" and "cube_re-1e5_fine" are one family.
std::string family_name(const std::string& case_name, const std::string& mesh_level);

/// Groups records that differ in nothing but the mesh level, in order of name. Pointers into `records`.
std::vector<CaseFamily> case_families(const std::vector<case_record::CaseRecord>& records);

}  // namespace compare
