#pragma once

#include <compare/case_record/case_record.hpp>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "cfd_cases/mesh/mesh_recipe.hpp"

namespace cfd_cases {

/// One iteration of the solver: the load on the faces that are meshed.
struct ForceSample {
  double time = 0.0;
  case_record::Load load;
};

/// Rows of a pair of OpenFOAM files force.dat and moment.dat. Columns are found by the header "(total_x ...) (pressure_x ...) (viscous_x
/// ...)". A last line that is not finished yet is left out; rows that only one file has are too.
/// @throws std::runtime_error when the header is another, a row has not ten numbers, or total is not pressure + viscous (to 1e-6 of the
/// row)
std::vector<ForceSample> parse_forces(std::string_view force, std::string_view moment);

/// All of postProcessing/forces: a restart makes another time folder, whose rows replace those of the earlier ones from its time on.
/// Empty while there is nothing yet. @throws std::runtime_error as parse_forces() does, naming the folder
std::vector<ForceSample> read_forces(const std::filesystem::path& case_folder);

/// Load on the whole body from that on the meshed half: doubled in the plane of symmetry, zero across it.
case_record::Load whole_body(const case_record::Load& meshed, Symmetry symmetry);

}  // namespace cfd_cases
