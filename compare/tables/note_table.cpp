#include "compare/tables/note_table.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <stdexcept>

#include "compare/tables/text_grid.hpp"

namespace compare {

std::vector<NoteRow> note_table(const std::vector<case_record::CaseRecord>& records, const std::vector<NamedModel>& models) {
  const std::vector<CaseOfRecord> cases = cases_of_record(records);
  std::vector<NoteRow> rows;
  for (const PublishedEntry& entry : published_entries()) {
    if (entry.note_label.empty()) continue;
    NoteRow row{entry.note_label, entry.published.value, {}, 0.0, false, "", std::vector<std::optional<double>>(models.size())};
    for (const CaseOfRecord& chosen : cases) {
      const CaseFamily& family = chosen.family;
      const case_record::CaseRecord& record = *family.record;
      if (!case_record::is_usable(record.status) || !entry.fits(record)) continue;
      row.case_name = record.name;
      row.measured = record.is_experiment();
      row.cfd = *coefficients(record)[Channel::drag] / entry.area_factor;
      row.discretisation_assessed = family.uncertainty.discretisation_assessed;
      row.u = family.uncertainty.total[0] / coefficient_scales(record)[0] / entry.area_factor;
      for (std::size_t k = 0; k < models.size(); ++k) {
        const dragcore::Wrench wrench = predict(record, models[k].choice).total();
        row.laws[k] = *coefficients(record, wrench.force, wrench.torque)[Channel::drag] / entry.area_factor;
      }
      break;
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

std::string render(const std::vector<NoteRow>& rows, const std::vector<NamedModel>& models, Format format) {
  if (format != Format::table && format != Format::markdown)
    throw std::invalid_argument("the note's table is rendered as table or md only");
  TextGrid grid;
  std::vector<std::string> heading = {"shape", "note's table", "reference", "u"};
  for (const NamedModel& model : models) heading.push_back("law " + model.name);
  grid.add(heading);
  for (const NoteRow& row : rows) {
    std::vector<std::string> cells = {row.label, number_text(row.published, "{:.2f}"), row.cfd ? number_text(row.cfd) + (row.measured ? ", measured" : "") : "-",
                                      row.cfd ? number_text(row.u, "{:.2g}") + (row.discretisation_assessed ? "" : "*") : ""};
    for (const auto& value : row.laws) cells.push_back(value ? number_text(value) : "-");
    grid.add(cells);
  }
  return format == Format::table ? aligned(grid, false) : markdown(grid);
}

nlohmann::json to_json(const std::vector<NoteRow>& rows, const std::vector<NamedModel>& models) {
  nlohmann::json list = nlohmann::json::array();
  for (const NoteRow& row : rows) {
    nlohmann::json entry = {{"shape", row.label}, {"published", row.published}, {"cfd", nullptr},
                            {"u", nullptr},       {"case", row.case_name},      {"laws", nlohmann::json::object()}};
    if (row.cfd) entry["cfd"] = *row.cfd, entry["u"] = row.u;
    for (std::size_t k = 0; k < models.size(); ++k)
      if (row.laws[k]) entry["laws"][models[k].name] = *row.laws[k];
    list.push_back(entry);
  }
  return list;
}

}  // namespace compare
