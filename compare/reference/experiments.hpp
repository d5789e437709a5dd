#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "compare/case_record/case_record.hpp"

namespace compare {

/// Measured coefficients as records: a CSV table, its first line the names of the columns, one measurement a line.
///
/// shape, parameters        kind and "diameter=1 length=2", as make_shape() takes them [m, deg]
/// incidence_deg, yaw_deg, roll_deg, reynolds   pose and Re of docs/conventions.md; an angle left out is 0
/// area_m2, length_m        what the coefficients of this line stand on, of this very body; length_m where there is a moment
/// C_D C_S C_L C_l C_m C_n  wind frame, moments about the centroid; each with its column u_C_D, ...: one standard uncertainty
/// held_out                 1: not to be used for fitting
/// source, confidence, remark   key in references.bib; how the number came here; what a reader should know
///
/// A channel that is left empty is known where symmetry makes it zero, and else is not. Names and keys are left to whoever stores them.
/// @param file  for messages
/// @param body  a body given by triangles, that `shape` may name
/// @throws std::invalid_argument  with file, line, what was found and what is needed
std::vector<case_record::CaseRecord> read_experiments(std::string_view csv, const std::string& file,
                                                      const std::optional<dragcore::MeshBody>& body = {});

}  // namespace compare
