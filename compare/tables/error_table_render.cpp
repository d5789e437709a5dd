#include <fmt/color.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>

#include "compare/tables/error_table.hpp"
#include "compare/tables/text_grid.hpp"
#include "compare/tables/truth_table.hpp"

namespace compare {
namespace {

using case_record::CaseRecord;
using nlohmann::json;
std::string percent(const std::optional<double>& ratio) { return ratio ? number_text(100.0 * *ratio, "{:+.1f} %") : ""; }

std::string verdict(const ErrorRow& row) {
  // Without the part of the mesh 2u is a lower bound, and so is the evidence.
  if (row.verdict) {
    const std::string word = *row.verdict != Verdict::resolved ? "noise" : row.discretisation_assessed ? "resolved" : "resolved*";
    return word + (row.other_branch ? fmt::format("; two branches, other {:.3f}", *row.other_branch) : "");
  }
  // A usable case may have no centre of pressure: that is no verdict on it.
  const bool usable = row.status == "steady" || row.status == "statistically_steady";
  if (usable) return row.cfd ? "" : row.reason;
  return row.status + (row.reason.empty() ? "" : ": " + row.reason);
}

std::string orientation(const ErrorRow& row) {
  std::string text;
  for (const auto& [name, angle] : {std::pair{"incidence", row.incidence_deg}, {"yaw", row.yaw_deg}, {"roll", row.roll_deg}})
    if (std::abs(angle) > 1e-9) text += fmt::format("{}{} {:g}°", text.empty() ? "" : ", ", name, angle);
  return text.empty() ? "0°" : text;
}

/// What is no steady solution says what it is.
std::string method_word(const ErrorRow& row) {
  if (row.flow_model == CaseRecord::experiment) return ", experiment";
  if (row.flow_model.ends_with("_lm")) return ", transition";
  if (row.flow_model.ends_with("_unsteady")) return ", in time";
  return row.flow_model != row.flow_class ? ", scale-resolving" : "";
}

bool held_out(const std::vector<const ErrorRow*>& rows) {
  return std::all_of(rows.begin(), rows.end(), [](const ErrorRow* row) { return row->held_out; });
}

TextGrid rows_grid(const std::vector<const ErrorRow*>& rows) {
  const bool all_held_out = held_out(rows);  // then the heading says so
  TextGrid grid;
  grid.add({"orientation", "", "model", "reference", "u", "error", "relative", "verdict", "published", "to it", "doubts"});
  std::string previous;
  for (const ErrorRow* row : rows) {
    const std::string where = row->status == "missing"
                                  ? row->case_name
                                  : orientation(*row) + method_word(*row) + (row->held_out && !all_held_out ? ", held out" : "");
    const bool usable = row->cfd || row->status == "steady" || row->status == "statistically_steady";
    const fmt::text_style style = !usable                             ? fg(fmt::terminal_color::red)
                                  : row->verdict == Verdict::resolved ? fg(fmt::terminal_color::yellow)
                                                                      : fmt::text_style{};
    const std::string u = row->cfd ? number_text(row->u, "{:.3g}") + (row->discretisation_assessed ? "" : "*") : "";
    std::string to_published;
    if (row->published && row->cfd) to_published = percent((*row->cfd - row->published->value) / row->published->value);
    grid.add({where == previous ? "" : where, row->status == "missing" ? "" : symbol(row->channel), number_text(row->model),
              number_text(row->cfd), u, number_text(row->error, "{:+.3f}"), percent(row->relative_error), verdict(*row),
              row->published ? number_text(row->published->value) : "", to_published, where == previous ? "" : row->doubts},
             style);
    previous = where;
  }
  return grid;
}

/// Rms errors of the whole table, a line per group of totals.
TextGrid totals_grid(const std::vector<ErrorSummary>& totals) {
  TextGrid grid;
  std::vector<std::string> head = {"rms error of", "cases", "beyond 2u"};
  for (const Channel channel : all_channels)
    if (std::any_of(totals.begin(), totals.end(), [&](const ErrorSummary& s) { return s.channel == channel; }))
      head.push_back(symbol(channel));
  grid.add(head);
  for (auto first = totals.begin(); first != totals.end();) {
    const auto last = std::find_if(first, totals.end(), [&](const ErrorSummary& s) { return s.group != first->group; });
    // Every case has a C_D, and C_D comes first.
    std::vector<std::string> cells = {first->group, std::to_string(first->n), fmt::format("{} in C_D", first->resolved)};
    for (std::size_t k = 3; k < head.size(); ++k) {
      const auto found = std::find_if(first, last, [&](const ErrorSummary& s) { return symbol(s.channel) == head[k]; });
      cells.push_back(found == last ? "" : number_text(found->rms));
    }
    grid.add(cells);
    first = last;
  }
  return grid;
}

TextGrid summary_grid(const std::vector<ErrorSummary>& summaries) {
  TextGrid grid;
  grid.add({"group", "", "n", "bias", "rms", "rms rel.", "worst", "resolved", "bias factor", "scatter", "worst case"});
  for (const ErrorSummary& s : summaries)
    grid.add({s.group, symbol(s.channel), std::to_string(s.n),
              number_text(s.bias, "{:+.3f}") + (s.bias_half_width ? " ± " + number_text(s.bias_half_width) : ""), number_text(s.rms),
              s.rms_relative ? number_text(100.0 * *s.rms_relative, "{:.1f} %") : "", number_text(s.worst, "{:+.3f}"),
              fmt::format("{}/{}", s.resolved, s.n), number_text(s.bias_factor), number_text(s.scatter), s.worst_case});
  return grid;
}

/// For a terminal: the name of each group on a line of its own, for it is longer than all its numbers.
std::string summary_text(const std::vector<ErrorSummary>& summaries, bool colour) {
  TextGrid grid = summary_grid(summaries);
  for (std::vector<std::string>& row : grid.rows) row.front().clear();
  std::istringstream lines(aligned(grid, colour));
  std::string text, line;
  std::getline(lines, line);
  text += line + "\n";
  for (std::size_t i = 0; std::getline(lines, line); ++i) {
    if (i == 0 || summaries[i].group != summaries[i - 1].group) text += summaries[i].group + "\n";
    text += line + "\n";
  }
  return text;
}

std::string csv(const ErrorTable& table) {
  std::string text =
      "case,shape,incidence_deg,yaw_deg,roll_deg,reynolds,flow_model,mesh_level,held_out,status,channel,model,cfd,u,"
      "u_numerical,discretisation_assessed,other_branch,error,relative_error,verdict,published,citation,reason,doubts\n";
  for (const ErrorRow& row : table.rows) {
    const auto full = [](const std::optional<double>& value) { return number_text(value, "{:.9g}"); };
    const std::vector<std::string> cells = {row.case_name,
                                            row.shape,
                                            full(row.incidence_deg),
                                            full(row.yaw_deg),
                                            full(row.roll_deg),
                                            full(row.reynolds),
                                            row.flow_model,
                                            row.mesh_level,
                                            row.held_out ? "1" : "0",
                                            row.status,
                                            row.status == "missing" ? "" : symbol(row.channel),
                                            full(row.model),
                                            full(row.cfd),
                                            row.cfd ? full(row.u) : "",
                                            row.cfd ? full(row.u_numerical) : "",
                                            row.discretisation_assessed ? "1" : "0",
                                            full(row.other_branch),
                                            full(row.error),
                                            full(row.relative_error),
                                            row.verdict ? verdict(row) : "",
                                            row.published ? full(row.published->value) : "",
                                            row.published ? row.published->citation : "",
                                            row.reason,
                                            row.doubts};
    text += csv_line(cells);
  }
  return text;
}

}  // namespace

Format format_from(const std::string& word) {
  if (word == "table") return Format::table;
  if (word == "md") return Format::markdown;
  if (word == "csv") return Format::csv;
  if (word == "json") return Format::json;
  throw std::invalid_argument("unknown format '" + word + "'; known: table, md, csv, json");
}

json to_json(const ErrorTable& table) {
  json result = {{"model", table.model_name}, {"compared", table.compared}, {"notes", table.notes}};
  result["doubts"] = {{"beyond_25_percent", {{"cases", table.doubts.large}, {"doubted", table.doubts.doubted_large}}},
                      {"within_10_percent", {{"cases", table.doubts.small}, {"doubted", table.doubts.doubted_small}}}};
  result["rows"] = result["totals"] = result["summaries"] = json::array();
  for (const ErrorRow& row : table.rows)
    result["rows"].push_back({{"case", row.case_name},
                              {"family", row.family},
                              {"shape", row.shape},
                              {"incidence_deg", row.incidence_deg},
                              {"yaw_deg", row.yaw_deg},
                              {"roll_deg", row.roll_deg},
                              {"reynolds", row.reynolds},
                              {"flow_model", row.flow_model},
                              {"mesh_level", row.mesh_level},
                              {"held_out", row.held_out},
                              {"status", row.status},
                              {"reason", row.reason},
                              {"doubts", row.doubts},
                              {"channel", row.status == "missing" ? json(nullptr) : json(symbol(row.channel))},
                              {"model", optional_json(row.model)},
                              {"cfd", optional_json(row.cfd)},
                              {"u", row.cfd ? json(row.u) : json(nullptr)},
                              {"u_numerical", row.cfd ? json(row.u_numerical) : json(nullptr)},
                              {"other_branch", optional_json(row.other_branch)},
                              {"discretisation_assessed", row.discretisation_assessed},
                              {"error", optional_json(row.error)},
                              {"relative_error", optional_json(row.relative_error)},
                              {"verdict", row.verdict ? json(verdict(row)) : json(nullptr)},
                              {"published", row.published ? json(row.published->value) : json(nullptr)},
                              {"citation", row.published ? json(row.published->citation) : json(nullptr)}});
  for (const auto& [name, list] : {std::pair{"totals", &table.totals}, {"summaries", &table.summaries}})
    for (const ErrorSummary& s : *list)
      result[name].push_back({{"group", s.group},
                              {"channel", symbol(s.channel)},
                              {"n", s.n},
                              {"bias", s.bias},
                              {"bias_half_width_95", optional_json(s.bias_half_width)},
                              {"rms", s.rms},
                              {"rms_relative", optional_json(s.rms_relative)},
                              {"worst", s.worst},
                              {"worst_case", s.worst_case},
                              {"resolved", s.resolved},
                              {"bias_factor", optional_json(s.bias_factor)},
                              {"scatter", optional_json(s.scatter)}});
  result["published"] = to_json(table.published);
  return result;
}

std::string render(const ErrorTable& table, Format format, bool colour) {
  if (format == Format::csv) return csv(table);
  if (format == Format::json) return to_json(table).dump(2) + "\n";
  const bool terminal = format == Format::table;
  const auto block = [&](const std::string& title, const TextGrid& grid) {
    if (!terminal) return "### " + title + "\n\n" + markdown(grid) + "\n";
    return (colour ? fmt::format(fmt::emphasis::bold, "{}", title) : title) + "\n" + aligned(grid, colour) + "\n";
  };
  std::string text =
      "error = model - CFD. u: one standard uncertainty of the CFD, the part of its method included.\n"
      "u*: without the part of the mesh, which one mesh alone does not show. resolved: |error| > 2u.\n\n";
  if (!table.totals.empty())
    text += block(fmt::format("{}: {} cases compared", table.model_name, table.compared), totals_grid(table.totals));
  if (table.doubts.large + table.doubts.small > 0)
    text += fmt::format(
        "Doubts (dragcore::Validity) are raised for {} of {} cases whose force is off by more than 25 %, and for {} of {} within 10 %.\n\n",
        table.doubts.doubted_large, table.doubts.large, table.doubts.doubted_small, table.doubts.small);
  const std::string by_group = "Errors by group; bias with its 95 % interval";
  text += terminal
              ? (colour ? fmt::format(fmt::emphasis::bold, "{}", by_group) : by_group) + "\n" + summary_text(table.summaries, colour) + "\n"
              : block(by_group, summary_grid(table.summaries));
  for (auto first = table.rows.begin(); first != table.rows.end();) {
    std::vector<const ErrorRow*> family;
    auto row = first;
    for (; row != table.rows.end() && row->family == first->family; ++row) family.push_back(&*row);
    text +=
        block(fmt::format("{}{} (model: {})", first->family, held_out(family) ? ", held out" : "", table.model_name), rows_grid(family));
    first = row;
  }
  if (!table.published.empty())
    text += block("The CFD against published values, on the reference area of docs/conventions.md", truth_grid(table.published));
  for (const std::string& note : table.notes) text += (terminal ? "" : "* ") + note + "\n";
  return text;
}

}  // namespace compare
