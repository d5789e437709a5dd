#include "compare/report/report_sections.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <fstream>
#include <functional>
#include <limits>
#include <map>
#include <numbers>
#include <set>
#include <utility>

#include "compare/cost/answers.hpp"
#include "compare/reference/uncertainty.hpp"
#include "compare/report/html.hpp"
#include "compare/tables/note_table.hpp"
#include "compare/tables/spin_table.hpp"

namespace compare {
namespace {

using html::Cell;
using html::escape;
using html::number;
using html::Table;
using RowFilter = std::function<bool(const ErrorRow&)>;

std::string polynomial_text(const dragcore::Law::Polynomial& polynomial) {
  std::string text;
  for (std::size_t power = 1; power < polynomial.size(); ++power) {
    const double k = polynomial[power];
    if (k == 0.0) continue;
    text += k < 0 ? (text.empty() ? "\u2212" : " \u2212 ") : (text.empty() ? "" : " + ");
    if (std::abs(k) != 1.0) text += fmt::format("{:.3g}\u2009", std::abs(k));
    text += power > 1 ? fmt::format("<i>c</i><sup>{}</sup>", power) : "<i>c</i>";
  }
  return "<span class=\"formula\">" + (text.empty() ? "0" : text) + "</span>";
}

std::string degrees(double angle) { return number(angle, std::abs(angle - std::round(angle)) < 1e-6 ? 0 : 1) + "\u00b0"; }

std::string figure(const std::string& name, const std::string& caption) {
  return fmt::format("<figure><div class=\"plot\" data-figure=\"{}\"></div><figcaption>{}</figcaption></figure>\n", name, caption);
}

std::string section(const std::string& id, const std::string& title, const std::string& content) {
  return fmt::format("<section id=\"{}\">\n<h2>{}</h2>\n{}</section>\n", id, title, content);
}

/// An error with its sign; in parentheses where the reference is not sure enough to call it one.
Cell error_cell(const ErrorRow* row, int decimals) {
  if (!row || !row->error) return {"\u2013", "faint"};
  const bool noise = row->verdict == Verdict::within_noise;
  const std::string text = number(*row->error, decimals, true);
  return noise ? Cell{"(" + text + ")", "faint"} : Cell{text};
}

Cell percent_cell(const ErrorRow* row) {
  if (!row || !row->relative_error) return {"\u2013", "faint"};
  return {number(100.0 * *row->relative_error, 0, true) + "\u2009%", row->verdict == Verdict::within_noise ? "faint" : ""};
}

/// "1.007 ± 0.012*"; a small u keeps a digit as far as one makes sense, and the star says that it lacks the part of the mesh.
std::string with_uncertainty(double value, double u, bool assessed, int decimals) {
  constexpr double smallest = 1e-4;
  const int digits = u > 0.0 ? std::clamp(static_cast<int>(std::ceil(-std::log10(u))), decimals, 4) : decimals;
  return number(value, decimals) + " \u00b1 " + (u > 0.0 && u < smallest ? "&lt;\u20090.0001" : number(u, digits)) + (assessed ? "" : "*");
}

std::string measured_word(const ErrorRow& row) { return row.flow_model == CaseRecord::experiment ? ", measured" : ""; }

/// Statistics of one model over the rows that pass; empty when none does.
std::optional<ErrorSummary> summary(const ReportedModel& model, Channel channel, const RowFilter& filter) {
  std::vector<const ErrorRow*> rows;
  for (const ErrorRow& row : model.table.rows)
    if (row.channel == channel && row.error && filter(row)) rows.push_back(&row);
  if (rows.empty()) return std::nullopt;
  return summarise("", rows);
}

/// All models, the forms of a law side by side, and the two rows of a table's head that name them.
std::vector<const ReportedModel*> models_by_law(const Report& report) {
  std::vector<const ReportedModel*> list;
  for (const ReportedModel& law : report.models)
    if (law.pillow == "none")
      for (const ReportedModel& model : report.models)
        if (model.law == law.law) list.push_back(&model);
  return list;
}

void add_model_heads(Table& table, const std::vector<const ReportedModel*>& models) {
  table.head.push_back(std::vector<Cell>(table.head[0].size(), Cell{""}));
  for (const ReportedModel* model : models) {
    if (model->pillow == "none") table.head[0].push_back({escape(model->law), "group", 0});
    ++table.head[0].back().columns;
    table.head[1].push_back(
        {model->pillow == "none" ? "no pillow" : fmt::format("{} {:.2f}", model->pillow, model->choice.model.pillow.factor), "tight"});
  }
}

std::vector<const ReportedModel*> laws_of(const Report& report) {
  std::vector<const ReportedModel*> list;
  for (const ReportedModel& model : report.models)
    if (model.pillow == "none") list.push_back(&model);
  return list;
}

bool turbulent(const ErrorRow& row) { return row.reynolds >= 1e4; }

/// The law that the verdict is about besides the note's: the one with the smallest error of C_D.
const ReportedModel& best_law(const Report& report) {
  const auto laws = laws_of(report);
  const auto error = [](const ReportedModel* law) {
    const auto statistics = summary(*law, Channel::drag, turbulent);
    return statistics ? statistics->rms : std::numeric_limits<double>::infinity();
  };
  return **std::min_element(laws.begin(), laws.end(), [&](const ReportedModel* a, const ReportedModel* b) { return error(a) < error(b); });
}

std::string worst_text(const Report& report, const ErrorSummary& statistics) {
  for (const ErrorRow& row : report.models.front().table.rows)
    if (row.case_name == statistics.worst_case) {
      return number(statistics.worst, 3, true) + " (" + escape(row.shape + ", " + pose_text(row)) + ")";
    }
  return number(statistics.worst, 3, true);
}

// --- 1. Verdict ------------------------------------------------------------------------------------------------------------------------

std::string verdict_sentence(const Report& report, const ReportedModel& model, bool held_out) {
  const auto statistics = summary(model, Channel::drag, [&](const ErrorRow& row) { return turbulent(row) && row.held_out == held_out; });
  if (!statistics) return "";
  return fmt::format(
      "<strong>{}</strong>: rms error of <i>C</i><sub>D</sub> {}, bias {}, worst {}; in {} of {} orientations the error exceeds "
      "2<i>u</i>. ",
      escape(model.law), number(statistics->rms, 3), number(statistics->bias, 3, true), worst_text(report, *statistics),
      statistics->resolved, statistics->n);
}

long without_mesh_part(const Report& report) {
  const auto& rows = report.models.front().table.rows;
  return std::count_if(rows.begin(), rows.end(),
                       [](const ErrorRow& row) { return row.channel == Channel::drag && row.cfd && !row.discretisation_assessed; });
}

std::string verdict_section(const Report& report, const std::vector<Sweep>& list) {
  const ReportedModel& note = report.models.front();
  const ReportedModel& best = best_law(report);
  const auto cases = static_cast<int>(cases_of_record(report.reference.cases).size());
  std::string text = fmt::format(
      "<p>This page compares a drag law that is evaluated triangle by triangle, fast enough for games and robots, with OpenFOAM on the "
      "same bodies in the same "
      "orientations, and with experiments where they know the force better. {} of {} cases ended with coefficients that can be compared; "
      "every one of them carries its standard uncertainty "
      "<i>u</i>, and a difference counts as an error of "
      "the law only beyond 2<i>u</i>. What follows here is of Re \u2265 10\u2074. Below, where the law by class takes the air's viscosity into "
      "account and the note's does not, the picture of C<sub>D</sub> against the Reynolds number and the tables by body say more.</p>\n",
      report.compared(), cases + static_cast<int>(std::count_if(note.table.rows.begin(), note.table.rows.end(), [](const ErrorRow& row) {
                           return row.status == "missing";
                         })));
  if (const auto blind = without_mesh_part(report); blind > 0)
    text += fmt::format(
        "<p>In {} of these cases <i>u</i> (marked *) holds what the iterations and the unsteadiness of the flow leave open, but not the "
        "part of the mesh: that takes two mesh "
        "levels of a case, or a like case on three. Their 2<i>u</i> is a lower bound.</p>\n",
        blind);
  std::set<const ReportedModel*> judged = {&note, &best};
  text += "<p>" + verdict_sentence(report, note, false) + (judged.size() > 1 ? verdict_sentence(report, best, false) : "") + "</p>\n";
  if (const std::string unseen = verdict_sentence(report, note, true); !unseen.empty())
    text += "<p>On cases held out from every fit: " + unseen + (judged.size() > 1 ? verdict_sentence(report, best, true) : "") + "</p>\n";

  Table table{
      .id = "verdict-table",
      .caption = "Error of <i>C</i><sub>D</sub> by body: law \u2212 reference. Bias with its 95 % interval; worst with its orientation."};
  table.head = {{{"body", "text"}, {"n"}, {escape(note.law), "group", 3}, {escape(best.law), "group", 3}}, {{"", "text"}, {""}}};
  if (&note == &best) table.head[0].pop_back();
  for (std::size_t i = 0; i < judged.size(); ++i)
    for (const char* name : {"rms", "bias", "worst"}) table.head[1].push_back({name});
  Table moments{.id = "moment-table",
                .caption =
                    "Rms error of the moment coefficient that each sweep drives, <i>C</i><sub>n</sub> by yaw and <i>C</i><sub>m</sub> by "
                    "incidence, over the poses of the sweep, by law and pillow form."};
  moments.head = {{{"body", "text"}, {""}, {"rms of the reference"}}};
  const auto models = models_by_law(report);
  add_model_heads(moments, models);

  std::map<std::pair<std::string, bool>, bool> family_told;
  for (const Sweep& sweep : list)
    for (const bool held_out : {false, true}) {
      const RowFilter filter = [&](const ErrorRow& row) { return row.family == sweep.family && row.held_out == held_out && row.error; };
      const RowFilter on_sweep = [&](const ErrorRow& row) { return filter(row) && sweep.holds(row); };
      const std::string body = escape(sweep.title) + (held_out ? " (held out)" : "");
      double squares = 0.0;
      int n = 0;
      for (const ErrorRow& row : note.table.rows)
        if (row.channel == sweep.moment && row.cfd && on_sweep(row)) squares += *row.cfd * *row.cfd, ++n;
      if (n > 0 && sweep.curve) {
        std::vector<Cell> cells = {{body, "text tight"}, {html::symbol(symbol(sweep.moment))}, {number(std::sqrt(squares / n), 4)}};
        for (const ReportedModel* model : models) {
          const auto found = summary(*model, sweep.moment, on_sweep);
          cells.push_back({found ? number(found->rms, 4) : "\u2013"});
        }
        moments.rows.push_back(cells);
      }

      // C_D of all poses of a family, on a sweep or not: once.
      const auto statistics = summary(note, Channel::drag, filter);
      if (!statistics || std::exchange(family_told[{sweep.family, held_out}], true)) continue;
      std::vector<Cell> cells = {{body, "text"}, {std::to_string(statistics->n)}};
      for (const ReportedModel* model : {&note, &best}) {
        if (model == &best && judged.size() == 1) continue;
        const ErrorSummary found = *summary(*model, Channel::drag, filter);
        const auto worst = std::find_if(model->table.rows.begin(), model->table.rows.end(),
                                        [&](const ErrorRow& row) { return row.case_name == found.worst_case; });
        cells.push_back({number(found.rms, 3)});
        cells.push_back({number(found.bias, 3, true) + (found.bias_half_width ? " \u00b1 " + number(*found.bias_half_width, 3) : "")});
        cells.push_back({number(found.worst, 3, true) + " at " + pose_text(*worst)});
      }
      table.rows.push_back(cells);
    }
  text += table.text();
  if (!moments.rows.empty()) text += moments.text();
  return section("verdict", "What this is, and the verdict", text);
}

// --- 2. The note's own table -----------------------------------------------------------------------------------------------------------

/// C_D on the frontal area of a body of the note's table that has no reference: a law needs its shape and pose alone.
double drag_of_note_body(const std::string& label, const ModelChoice& choice) {
  const auto& entries = published_entries();
  const auto entry =
      std::find_if(entries.begin(), entries.end(), [&](const PublishedEntry& candidate) { return candidate.note_label == label; });
  const auto middle = [](const CaseSelector::Range& range) { return 0.5 * (range.first + range.second) * std::numbers::pi / 180.0; };
  CaseRecord body;
  body.shape = dragcore::make_shape(entry->cases.shape, {});
  body.pose = {.incidence = middle(entry->cases.incidence_deg), .yaw = middle(entry->cases.yaw_deg)};
  return predict(body, choice).total().force.x() / (coefficient_scales(body)[0] * entry->area_factor);
}

std::string note_section(const Report& report) {
  const auto laws = laws_of(report);
  Table table{
      .id = "note-table",
      .caption =
          "Drag coefficients on the frontal area, as the note prints them. Errors are against the case of record where there is one, in "
          "parentheses against the note's own figure where it was not."};
  table.head = {{{"body", "text"}, {"note"}, {"reference \u00b1 <i>u</i>", "tight"}}, {{"", "text"}, {""}, {""}}};
  for (const ReportedModel* law : laws) {
    table.head[0].push_back({escape(law->law), "group", 2});
    for (const char* name : {"<i>C</i><sub>D</sub>", "error"}) table.head[1].push_back({name});
  }
  const auto& rows = report.models.front().table.rows;
  std::vector<NamedModel> asked;
  for (const ReportedModel* law : laws) asked.push_back({law->law, law->choice});
  for (NoteRow& row : note_table(report.reference.cases, asked)) {
    const auto found = std::find_if(rows.begin(), rows.end(), [&](const ErrorRow& other) { return other.case_name == row.case_name; });
    const bool assessed = found != rows.end() && found->discretisation_assessed;
    std::vector<Cell> cells = {
        {escape(row.label), "text"},
        {number(row.published, 2)},
        {row.cfd ? with_uncertainty(*row.cfd, row.u, assessed, 3) + (row.measured ? ", measured" : "") : "no usable case",
         row.cfd ? "" : "faint"}};
    const double reference = row.cfd.value_or(row.published);
    for (std::size_t k = 0; k < laws.size(); ++k) {
      const double value = row.laws[k] ? *row.laws[k] : drag_of_note_body(row.label, asked[k].choice);
      const std::string error = number(100.0 * (value - reference) / reference, 0, true) + "\u2009%";
      cells.push_back({number(value, 3)});
      cells.push_back({row.cfd ? error : "(" + error + ")", row.cfd ? "" : "faint"});
    }
    table.rows.push_back(cells);
  }
  return section("note", "The note's own table", table.text());
}

// --- 3. Figures ------------------------------------------------------------------------------------------------------------------------

std::string figures_section(const Report& report, const std::vector<Sweep>& list, const std::map<std::string, nlohmann::json>& specs) {
  std::string text =
      "<p>Lines: the laws, every 2.5\u00b0. Points: OpenFOAM with bars of \u00b12<i>u</i>. Diamonds: published values, with bars where "
      "they are the reference. The pillow effect "
      "moves the force's point, not its size: it shows in the "
      "moment alone. Coefficients, frames and signs: docs/conventions.md.</p>\n<p class=\"small\">Pressure coefficient of the laws on "
      "windward faces: ";
  for (const ReportedModel* law : laws_of(report))
    if (!law->choice.by_class)
      text += fmt::format("{} {}, leeward suction {}; ", escape(law->law), polynomial_text(law->choice.model.law.windward),
                          polynomial_text(law->choice.model.law.leeward));
  text.resize(text.size() - 2);
  text += ".</p>\n";
  for (const Sweep& sweep : list) {
    const auto drag = rows_of(report.models.front().table, sweep, Channel::drag);
    const auto shown = std::count_if(drag.begin(), drag.end(), [](const ErrorRow* row) { return row->cfd.has_value(); });
    if (sweep.curve)
      text += fmt::format("<h3>{}</h3>\n", escape(sweep.title)) +
              figure("sweep-" + sweep.slug(), fmt::format("{}: {} against {}. {} of {} cases have coefficients.", escape(sweep.title),
                                                          html::symbol("C_D") + ", " + html::symbol(symbol(sweep.force)) + " and " +
                                                              html::symbol(symbol(sweep.moment)),
                                                          sweep.angle, shown, drag.size()));
  }
  if (specs.contains("face_pressure"))
    text += "<h3>Where a law is wrong: pressure on planar faces</h3>\n" +
            figure("face_pressure",
                   "Mean <i>C</i><sub>p</sub> of each planar face of the turbulent cases against the cosine <i>c</i>, and what each law "
                   "says. Points off a line at <i>c</i> &gt; 0 are errors of the windward "
                   "pressure, at <i>c</i> \u2264 0 of the suction. Edges of plates are left out.");
  if (specs.contains("drag_against_reynolds"))
    text +=
        "<h3>Drag against the Reynolds number</h3>\n" +
        figure("drag_against_reynolds",
               "<i>C</i><sub>D</sub> of ball, cube and disc face-on, and of the plate at 30\u00b0. Line: the law by class. Black: OpenFOAM "
               "\u00b12<i>u</i>, hollow where another case is of record. Diamonds: experiments and other published values, "
               "\u00b12<i>u</i>; the "
               "bar along Re is the range that they are given for. Grey: correlations of particles, drag alone, up to Re 10\u2074.");
  return section("figures", "Coefficients against orientation and Reynolds number", text);
}

// --- 4. Errors by orientation ----------------------------------------------------------------------------------------------------------

/// Why a row has no coefficient.
std::string why_empty(const ErrorRow& row) {
  if (!case_record::is_usable(case_record::status_from(row.status))) return row.status + ": " + row.reason;
  return row.reason.empty() ? "not defined: the force has no part across the chord" : row.reason;
}

/// @param wide  model, error and percentage of each law; else the error alone of every model
std::string error_table(const Report& report, const Sweep& sweep, Channel channel, bool wide) {
  const auto rows = rows_of(report.models.front().table, sweep, channel);
  const auto zero_by_symmetry = [&](const CaseRecord* record) {
    return channel != Channel::centre_of_pressure && null_channels(*record)[static_cast<std::size_t>(channel)];
  };
  if (rows.empty() || std::all_of(sweep.cases.begin(), sweep.cases.end(), zero_by_symmetry)) return "";
  const int decimals = wide ? 3 : 4;
  const auto models = wide ? laws_of(report) : models_by_law(report);
  const bool any_published = std::any_of(rows.begin(), rows.end(), [](const ErrorRow* row) { return row->published.has_value(); });

  Table table{.id = "errors-" + sweep.slug() + "-" + symbol(channel),
              .caption = html::symbol(symbol(channel)) +
                         (wide ? ": reference, laws and their errors." : ": reference, and the error of every model.")};
  table.head = {{{sweep.angle, "text"}, {"reference \u00b1 <i>u</i>", "tight"}}};
  if (any_published) table.head[0].push_back({"published"});
  if (wide) {
    table.head.push_back(std::vector<Cell>(table.head[0].size(), Cell{""}));
    for (const ReportedModel* model : models) {
      table.head[0].push_back({escape(model->law), "group", 3});
      for (const char* name : {"law", "error", "%"}) table.head[1].push_back({name});
    }
  } else {
    add_model_heads(table, models);
  }
  const int model_columns = static_cast<int>(models.size()) * (wide ? 3 : 1);
  for (const ErrorRow* row : rows) {
    std::vector<Cell> cells = {{degrees(sweep.angle_of(*row)) + (row->held_out ? " held out" : ""), "text tight", 1, row->case_name}};
    if (!row->cfd) {
      cells.push_back({escape(why_empty(*row)), "text bad", 1 + (any_published ? 1 : 0) + model_columns});
      table.rows.push_back(cells);
      continue;
    }
    cells.push_back({with_uncertainty(*row->cfd, row->u, row->discretisation_assessed, decimals) + measured_word(*row) +
                     (row->other_branch ? " (two branches, other " + number(row->other_branch, decimals) + ")" : "")});
    if (any_published) cells.push_back({row->published ? number(row->published->value, 3) : ""});
    for (const ReportedModel* model : models) {
      const auto all = rows_of(model->table, sweep, channel);
      const auto same = std::find_if(all.begin(), all.end(), [&](const ErrorRow* other) { return other->case_name == row->case_name; });
      const ErrorRow* mine = same == all.end() ? nullptr : *same;
      if (wide) cells.push_back({mine ? number(mine->model, decimals) : "\u2013"});
      cells.push_back(error_cell(mine, decimals));
      if (wide) cells.push_back(percent_cell(mine));
    }
    table.rows.push_back(cells);
  }
  return table.text();
}

/// Poses on no sweep, a table for each family: every channel, whole names, and the error of every model.
std::vector<std::string> off_sweep_tables(const Report& report, const std::vector<Sweep>& list) {
  constexpr int decimals = 4;
  const auto models = models_by_law(report);
  std::vector<std::string> tables;
  Table table;
  std::string family, case_name;
  const auto end_table = [&] {
    if (!table.rows.empty()) tables.push_back(fmt::format("<h3>{}, other poses</h3>\n", escape(family)) + table.text());
  };
  for (const ErrorRow* row : rows_off_sweeps(report.models.front().table, list)) {
    if (row->family != family) {
      end_table();
      family = row->family;
      table = {.id = "errors-" + slug_of(family) + "-other", .caption = "Poses on no sweep: reference, and the error of every model."};
      table.head = {{{"case", "text"}, {"pose", "text"}, {""}, {"reference \u00b1 <i>u</i>", "tight"}}};
      add_model_heads(table, models);
    }
    const bool next = std::exchange(case_name, row->case_name) != row->case_name;
    std::vector<Cell> cells = {{next ? escape(row->case_name) + (row->held_out ? " held out" : "") : "", "text tight", 1, row->case_name},
                               {next ? pose_text(*row) : "", "text tight"},
                               {html::symbol(symbol(row->channel))}};
    if (!row->cfd) {
      cells.push_back({escape(why_empty(*row)), "text bad", 1 + static_cast<int>(models.size())});
      table.rows.push_back(cells);
      continue;
    }
    cells.push_back({with_uncertainty(*row->cfd, row->u, row->discretisation_assessed, decimals) + measured_word(*row)});
    for (const ReportedModel* model : models) {
      const auto same = std::find_if(model->table.rows.begin(), model->table.rows.end(), [&](const ErrorRow& other) {
        return other.case_name == row->case_name && other.channel == row->channel;
      });
      cells.push_back(error_cell(same == model->table.rows.end() ? nullptr : &*same, decimals));
    }
    table.rows.push_back(cells);
  }
  end_table();
  return tables;
}

std::string errors_section(const Report& report, const std::vector<Sweep>& list) {
  std::string text =
      "<p>Error = law \u2212 reference: OpenFOAM, or an experiment where that knows the force better. In parentheses: smaller than "
      "2<i>u</i>, within the noise of the reference. A percentage is given "
      "where the coefficient is not near zero. * <i>u</i> lacks the part "
      "of the mesh.</p>\n";
  for (const Sweep& sweep : list) {
    text += fmt::format("<h3>{}</h3>\n", escape(sweep.title));
    text += error_table(report, sweep, Channel::drag, true) + error_table(report, sweep, sweep.force, true);
    text += error_table(report, sweep, sweep.moment, false) + error_table(report, sweep, Channel::centre_of_pressure, false);
  }
  for (const std::string& channel_table : off_sweep_tables(report, list)) text += channel_table;
  Table missing{.id = "missing-table", .caption = "Planned, but without a result."};
  missing.head = {{{"case", "text"}, {"reason", "text"}}};
  for (const ErrorRow& row : report.models.front().table.rows)
    if (row.status == "missing") missing.rows.push_back({{escape(row.case_name), "text"}, {escape(row.reason), "text bad"}});
  if (!missing.rows.empty()) text += missing.text();
  if (const auto& notes = report.models.front().table.notes; !notes.empty()) {
    text += "<p class=\"small\">Uncertainty of the mesh:</p>\n<ul class=\"small\">";
    for (const std::string& note : notes) text += "<li>" + escape(note) + "</li>\n";
    text += "</ul>\n";
  }
  return section("errors", "Errors by orientation", text);
}

// --- 5. CFD against published values ---------------------------------------------------------------------------------------------------

std::string published_section(const Report& report) {
  Table table{.id = "published-table",
              .caption =
                  "OpenFOAM against published values, on the reference areas of docs/conventions.md. Here <i>u</i> is numerical, without "
                  "the part of the method, which "
                  "this comparison is to show."};
  table.head = {{{"case", "text"},
                 {"quantity"},
                 {"OpenFOAM \u00b1 <i>u</i>"},
                 {"published"},
                 {"difference"},
                 {"goal"},
                 {"verdict", "text"},
                 {"source", "text"}}};
  for (const PublishedCheck& check : report.models.front().table.published) {
    const int decimals = check.is_angle() ? 1 : 3;
    const std::string quantity = check.is_angle() ? "force angle [\u00b0]" : html::symbol(check.quantity);
    std::string source = escape(fmt::format("{} ({}; {})", check.published.citation, check.published.kind, check.published.confidence));
    if (!check.published.conversion.empty()) source += ", " + escape(check.published.conversion);
    table.rows.push_back({{escape(check.case_name), "text tight"},
                          {quantity},
                          {with_uncertainty(check.cfd, check.u, check.discretisation_assessed, decimals)},
                          {number(check.published.value, decimals) + " \u00b1 " + number(check.published.uncertainty, decimals)},
                          {number(check.difference_in_unit(), 1, true) + check.unit()},
                          {check.goal ? "\u00b1" + number(*check.goal, 0) + check.unit() : "\u2013"},
                          {check.verdict(), !check.agrees() || !check.within_goal() ? "text bad" : "text tight good"},
                          {source, "text small"}});
  }
  const std::string text = table.rows.empty() ? "<p>No case of these references has a published value.</p>\n" : table.text();
  return section("published", "OpenFOAM against published values", text);
}

// --- Spin ------------------------------------------------------------------------------------------------------------------------------

std::string spin_section(const Report& report) {
  if (report.spinning.empty()) return "";
  const auto laws = laws_of(report);
  Table table{.id = "spin-table",
              .caption =
                  "Torque coefficient about the axis of spin, <i>M</i>\u00b7<i>\u03c9</i>/|<i>\u03c9</i>| / (<i>q A L</i>), in still air "
                  "with <i>q</i> = "
                  "\u03c1(<i>\u03c9L</i>)\u00b2/2: OpenFOAM, the shares of pressure and friction in it, and the laws. Only some laws have "
                  "friction."};
  table.head = {{{"case", "text"}, {"axis", "text"}, {"OpenFOAM \u00b1 <i>u</i>", "tight"}, {"pressure"}, {"friction"}, {"published"}},
                std::vector<Cell>(6, Cell{""})};
  std::vector<std::vector<SpinRow>> by_law;
  for (const ReportedModel* law : laws) {
    by_law.push_back(spin_table(report.spinning, predictor(law->choice)));
    table.head[0].push_back({escape(law->law), "group", 2});
    for (const char* name : {"law", "error"}) table.head[1].push_back({name});
  }
  const auto share = [](const std::optional<double>& part) { return part ? number(100.0 * *part, 0) + "\u2009%" : std::string("\u2013"); };
  for (std::size_t i = 0; i < by_law.front().size(); ++i) {
    const SpinRow& row = by_law.front()[i];
    std::vector<Cell> cells = {{escape(row.case_name), "text tight"}, {row.axis, "text"}};
    if (!row.cfd) {
      cells.push_back({escape(row.status + ": " + row.reason), "text bad", 4 + 2 * static_cast<int>(laws.size())});
      table.rows.push_back(cells);
      continue;
    }
    cells.push_back({with_uncertainty(*row.cfd, row.u, row.discretisation_assessed, 4)});
    cells.push_back({share(row.pressure_share)});
    cells.push_back({share(row.friction_share)});
    cells.push_back({row.published ? number(row.published->value, 4) : ""});
    for (const auto& rows : by_law) {
      const bool noise = rows[i].verdict == Verdict::within_noise;
      const std::string error = number(rows[i].error, 4, true);
      cells.push_back({number(rows[i].model, 4)});
      cells.push_back({noise ? "(" + error + ")" : error, noise ? "faint" : ""});
    }
    table.rows.push_back(cells);
  }
  return section("spin", "Bodies that spin", table.text());
}

// --- 6. Calibration --------------------------------------------------------------------------------------------------------------------

std::string calibration_section(const Report& report) {
  if (!report.calibration)
    return section("calibration", "Calibration", "<p class=\"bad\">Not calibrated: " + escape(report.calibration_fault) + ".</p>\n");
  Table estimates{.id = "estimates-table", .caption = "Fitted coefficients with 95 % intervals."};
  estimates.head = {{{"fit", "text"},
                     {"to", "text"},
                     {"cases"},
                     {"coefficient", "text"},
                     {"estimate"},
                     {"95 % interval"},
                     {"correlation"},
                     {"condition number"}}};
  Table errors{.id = "calibration-table",
               .caption =
                   "Rms errors of each fit. Uncalibrated: the note's law as printed for <i>C</i><sub>D</sub>, no pillow for the force arm. "
                   "Note's own: its pillow factor 1. "
                   "Left out: every orientation, or every shape, predicted by a fit to all others."};
  errors.head = {
      {{"fit", "text"}, {"group", "text"}, {"n"}, {"uncalibrated"}, {"note's own"}, {"fitted"}, {"left-out pose"}, {"left-out shape"}}};
  for (const Fit& fit : report.calibration->fits) {
    const int decimals = fit.target == "C_D" ? 3 : 4;
    const std::string target = fit.target == "C_D" ? html::symbol("C_D") : escape(fit.target);
    const dragcore::Pillow& pillow = fit.model.pillow;
    const std::string name = escape(pillow.form == dragcore::PillowForm::none
                                        ? fit.name
                                        : fmt::format("{} pillow on the {}", to_string(pillow.form), law_label(fit.model.law.name)));
    for (std::size_t i = 0; i < fit.estimates.size(); ++i) {
      const Estimate& estimate = fit.estimates[i];
      std::string interval = "none";
      if (estimate.at_bound)
        interval = "at its bound";
      else if (estimate.interval)
        interval = number(estimate.interval->first, 3) + " to " + number(estimate.interval->second, 3);
      const bool several = fit.estimates.size() > 1 && i == 0;
      estimates.rows.push_back({{i == 0 ? name : "", "text"},
                                {i == 0 ? target : "", "text"},
                                {i == 0 ? std::to_string(fit.cases.size()) : ""},
                                {escape(estimate.name), "text"},
                                {number(estimate.value, 3)},
                                {interval},
                                {several ? number(fit.correlation[0][1], 2, true) : ""},
                                {several ? number(fit.condition_number, 1) : ""}});
    }
    for (const FitErrors& group : fit.errors)
      errors.rows.push_back({{group.group == "all" ? name : "", "text"},
                             {escape(group.group), "text"},
                             {std::to_string(group.n)},
                             {number(group.before, decimals)},
                             {number(group.note, decimals)},
                             {number(group.in_sample, decimals)},
                             {number(group.left_out_pose, decimals)},
                             {number(group.left_out_shape, decimals)}});
  }
  return section("calibration", "Calibration",
                 "<p>The pillow factor moves the centre of pressure and leaves <i>C</i><sub>D</sub> alone, so it is fitted to the force "
                 "arm: the distance of the force's line of action from the "
                 "centroid, in reference lengths. Error in sample flatters a fit; the left-out columns say what to expect of a pose or a "
                 "shape that was not fitted.</p>\n" +
                     estimates.text() + errors.text());
}

// --- 7. Cost ---------------------------------------------------------------------------------------------------------------------------

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

/// A table for a terminal as one for the page.
std::string html_of(const CostTable& shown) {
  Table table{.id = shown.id, .caption = escape(shown.caption + "." + (shown.note.empty() ? "" : " " + shown.note))};
  for (std::size_t i = 0; i < shown.grid.rows.size(); ++i) {
    std::vector<Cell> cells;
    for (std::size_t k = 0; k < shown.grid.rows[i].size(); ++k) {
      const std::string& cell = shown.grid.rows[i][k];
      cells.push_back({i == 0 && cell.starts_with("C_") ? html::symbol(cell) : escape(cell), k == 0 ? "text" : ""});
    }
    (i == 0 ? table.head : table.rows).push_back(cells);
  }
  return table.text();
}

std::string cost_section(const Report& report, const std::map<std::string, nlohmann::json>& specs) {
  std::string text;
  if (specs.contains("cost")) {
    for (std::string words = answer(report.cost); !words.empty();) {
      const auto end = words.find('\n');
      text += "<p>" + escape(words.substr(0, end)) + "</p>\n";
      words.erase(0, end + 1);
    }
    text +=
        figure("cost",
               "CPU time of one evaluation against rms error, every rung on the same poses. Grey band: one standard uncertainty of the "
               "references, what their equations leave open included; CFD is shown with the error of its mesh. Grey line and names: the "
               "rungs that nothing cheaper is as near as.");
    for (const CostTable& table : cost_tables(report.cost)) text += html_of(table);
    text += html_of(all_rungs(report.cost));
  } else {
    text = "<p>No figure: there is no turbulent case at Re \u2265 10\u2074 to hold a law against.</p>\n";
  }

  Table solver_cost{.id = "cfd-cost-table",
                    .caption =
                        "OpenFOAM by mesh level: medians over the usable cases; CPU seconds. Last column: largest |difference| of "
                        "<i>C</i><sub>D</sub> from the finest mesh of the same case."};
  solver_cost.head = {{{"body", "text"},
                       {"Re"},
                       {"mesh", "text"},
                       {"cases"},
                       {"cells"},
                       {"iterations"},
                       {"mesh"},
                       {"convert"},
                       {"solve"},
                       {"total"},
                       {"|\u0394<i>C</i><sub>D</sub>|"}}};
  std::map<std::tuple<std::string, double, std::string>, std::vector<const CfdCost*>> levels;
  const std::vector<CfdCost> costs = cfd_costs(report.reference.cases);
  for (const CfdCost& row : costs) levels[{row.shape, -row.reynolds, row.mesh_level}].push_back(&row);
  std::vector<std::vector<const CfdCost*>> groups;
  for (auto& [key, rows] : levels) groups.push_back(rows);
  std::stable_sort(groups.begin(), groups.end(), [](const auto& a, const auto& b) {
    const CfdCost &left = *a.front(), &right = *b.front();
    return std::tuple(left.shape, -left.reynolds, left.cells) < std::tuple(right.shape, -right.reynolds, right.cells);
  });
  for (const auto& rows : groups) {
    const auto middle = [&](auto member) {
      std::vector<double> values;
      for (const CfdCost* row : rows) values.push_back(static_cast<double>(row->*member));
      return median(values);
    };
    std::optional<double> worst;
    for (const CfdCost* row : rows)
      if (row->drag_error) worst = std::max(worst.value_or(0.0), *row->drag_error);
    solver_cost.rows.push_back({{escape(rows.front()->shape), "text"},
                                {reynolds_text(rows.front()->reynolds)},
                                {escape(rows.front()->mesh_level), "text"},
                                {std::to_string(rows.size())},
                                {html::count(middle(&CfdCost::cells))},
                                {number(middle(&CfdCost::iterations), 0)},
                                {number(middle(&CfdCost::mesh_s), 1)},
                                {number(middle(&CfdCost::convert_s), 1)},
                                {number(middle(&CfdCost::solve_s), 1)},
                                {number(middle(&CfdCost::total_s), 1)},
                                {number(worst, 4)}});
  }
  if (!groups.empty()) text += solver_cost.text();

  Table checks{
      .id = "cost-check-table",
      .caption =
          "What <code>dragval plan</code> predicts before a campaign, against what the references took: sums over the cases that ran "
          "to their end, rms of ln(actual / predicted), and the case that is furthest off. CPU times in seconds."};
  checks.head = {{{"", "text"}, {"cases"}, {"predicted"}, {"actual"}, {"ratio"}, {"rms"}, {"worst ratio"}, {"case", "text"}}};
  for (const CostCheck& check : report.cost_checks)
    checks.rows.push_back({{escape(check.quantity), "text"},
                           {std::to_string(check.cases)},
                           {html::count(check.predicted)},
                           {html::count(check.found)},
                           {number(check.ratio(), 2)},
                           {number(check.rms, 2)},
                           {number(check.worst, 2)},
                           {escape(check.worst_case), "text"}});
  if (!report.cost_checks.empty()) text += checks.text();
  return section("cost", "What accuracy costs", text);
}

// --- 8. Provenance ---------------------------------------------------------------------------------------------------------------------

std::string processor() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  return "unknown processor";
}

std::string provenance_section(const Report& report) {
  std::set<std::string> tools, tiers, sources, experiments;
  std::string first, last;
  int usable = 0;
  double cpu = 0.0;
  for (const CaseRecord& record : report.reference.cases) {
    for (const auto& [tool, version] : record.tools) tools.insert(tool + " " + version);
    if (!record.is_experiment()) tiers.insert(record.tier);
    (record.is_experiment() ? experiments : sources).insert(record.source);
    usable += case_record::is_usable(record.status) ? 1 : 0;
    for (const auto& [stage, cost] : record.cost) cpu += cost.cpu_s;
    if (record.finished.empty()) continue;
    first = first.empty() ? record.finished : std::min(first, record.finished);
    last = std::max(last, record.finished);
  }
  const auto joined = [](const std::set<std::string>& words) {
    std::string text;
    for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
    return escape(text);
  };
  char now[32];
  const std::time_t seconds = std::time(nullptr);
  std::strftime(now, sizeof now, "%Y-%m-%d %H:%M UTC", std::gmtime(&seconds));
  Table table{.id = "provenance-table", .caption = "Where the numbers come from."};
  table.head = {{{"", "text"}, {"", "text"}}};
  const auto add = [&](const char* name, const std::string& value) {
    table.rows.push_back({{name, "text"}, {value.empty() ? "\u2013" : value, "text"}});
  };
  add("references", escape(report.source));
  add("runs", fmt::format("{}, {} of them usable, {:.0f} CPU seconds", report.reference.cases.size(), usable, cpu));
  add("solver", joined(sources));
  if (!experiments.empty()) add("experiments", joined(experiments));
  add("tools", joined(tools));
  add("tier of the case matrix", joined(tiers));
  add("solved", first.empty() ? "" : escape(first + " to " + last));
  add("program", "dragval, commit " + escape(report.commit.empty() ? "unknown" : report.commit));
  add("this page", fmt::format("{}; times of the drag model measured on {}", now, escape(processor())));
  return section("provenance", "Provenance", table.text());
}

}  // namespace

std::string report_sections(const Report& report, const std::vector<Sweep>& list, const std::map<std::string, nlohmann::json>& specs,
                            const std::string& bodies) {
  return verdict_section(report, list) + note_section(report) + figures_section(report, list, specs) + bodies + errors_section(report, list) +
         published_section(report) + spin_section(report) + calibration_section(report) + cost_section(report, specs) +
         provenance_section(report);
}

}  // namespace compare
