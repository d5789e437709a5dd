#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "compare/tables/error_table.hpp"

namespace compare {

/// A row of the table of drag coefficients that opens the note, with what the case of record and the laws say; all on the note's frontal
/// area.
struct NoteRow {
  std::string label;  ///< "Cube at 45 deg"
  double published = 0.0;
  std::optional<double> cfd;             ///< empty when no usable record fits
  double u = 0.0;                        ///< standard uncertainty of `cfd`, as far as assessed
  bool discretisation_assessed = false;  ///< false: `u` lacks the part of the mesh and is printed with a *
  std::string case_name;
  std::vector<std::optional<double>> laws;  ///< in the order of the models asked for
  bool measured = false;                    ///< the case of record is an experiment
};

/// @param models  whose C_D to add
std::vector<NoteRow> note_table(const std::vector<case_record::CaseRecord>& records, const std::vector<NamedModel>& models);

/// "table" and "md" forms. @throws std::invalid_argument for the others
std::string render(const std::vector<NoteRow>& rows, const std::vector<NamedModel>& models, Format format);
nlohmann::json to_json(const std::vector<NoteRow>& rows, const std::vector<NamedModel>& models);

}  // namespace compare
