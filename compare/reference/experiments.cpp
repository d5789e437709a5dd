#include "compare/reference/experiments.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <dragcore/unknown_word.hpp>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <sstream>
#include <stdexcept>

#include "compare/reference/coefficients.hpp"

namespace compare {
namespace {

using case_record::CaseRecord;

const std::vector<std::string> columns = {"shape",   "parameters", "incidence_deg", "yaw_deg", "roll_deg",   "reynolds",
                                          "area_m2", "length_m",   "C_D",           "u_C_D",   "C_S",        "u_C_S",
                                          "C_L",     "u_C_L",      "C_l",           "u_C_l",   "C_m",        "u_C_m",
                                          "C_n",     "u_C_n",      "held_out",      "source",  "confidence", "remark"};

/// Cells of a line; quotes hold commas, a doubled quote is one.
std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char letter = line[i];
    if (letter == '"' && quoted && i + 1 < line.size() && line[i + 1] == '"')
      cells.back() += line[++i];
    else if (letter == '"')
      quoted = !quoted;
    else if (letter == ',' && !quoted)
      cells.emplace_back();
    else if (letter != '\r')
      cells.back() += letter;
  }
  return cells;
}

std::optional<double> number_from(const std::string& text) {
  double value = 0.0;
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (fault != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

/// One line of the table.
struct Line {
  std::string where;  ///< "table.csv, line 3"
  std::map<std::string, std::string> cells;

  [[noreturn]] void fail(const std::string& what) const { throw std::invalid_argument(where + ": " + what); }

  const std::string& text(const std::string& column) const {
    static const std::string none;
    const auto found = cells.find(column);
    return found == cells.end() ? none : found->second;
  }
  std::optional<double> number(const std::string& column) const {
    if (text(column).empty()) return std::nullopt;
    const auto value = number_from(text(column));
    if (!value) fail(fmt::format("{} is '{}'; a number is needed", column, text(column)));
    return value;
  }
  double positive(const std::string& column, const char* why) const {
    const auto value = number(column);
    if (!value || !(*value > 0.0)) fail(fmt::format("{} is '{}'; a number above 0 is needed: {}", column, text(column), why));
    return *value;
  }
};

dragcore::Shape shape_of(const Line& line, const std::optional<dragcore::MeshBody>& body) {
  if (body && line.text("shape") == body->name) return *body;
  std::map<std::string, double> parameters;
  std::istringstream words(line.text("parameters"));
  for (std::string word; words >> word;) {
    const std::size_t equals = word.find('=');
    const auto value = equals == std::string::npos ? std::nullopt : number_from(word.substr(equals + 1));
    if (!value) line.fail(fmt::format("parameters has '{}'; name=number is needed, as in 'diameter=1 length=2'", word));
    parameters[word.substr(0, equals)] = *value;
  }
  try {
    const dragcore::Shape shape = dragcore::make_shape(line.text("shape"), parameters);
    dragcore::properties(shape);  // refuses what is out of range
    return shape;
  } catch (const std::invalid_argument& fault) {
    line.fail(fault.what());
  }
}

CaseRecord record_from(const Line& line, const std::optional<dragcore::MeshBody>& body) {
  constexpr double deg = std::numbers::pi / 180.0;
  CaseRecord record;
  record.source = line.text("source");
  if (record.source.empty()) line.fail("source is empty; a key of references.bib is needed, or where you measured it");
  record.flow_model = CaseRecord::experiment;
  record.description = nlohmann::json(line.cells).dump();
  record.shape = shape_of(line, body);
  record.pose = {.incidence = deg * line.number("incidence_deg").value_or(0.0),
                 .yaw = deg * line.number("yaw_deg").value_or(0.0),
                 .roll = deg * line.number("roll_deg").value_or(0.0)};
  record.reynolds = line.positive("reynolds", "Re on the reference length of docs/conventions.md");
  record.viscosity = record.speed * dragcore::properties(record.shape).reference_length / record.reynolds;
  record.held_out = line.number("held_out").value_or(0.0) != 0.0;
  record.status = case_record::Status::steady;

  const double force = 0.5 * record.density * record.speed * record.speed * line.positive("area_m2", "the area of the coefficients");
  record.known = null_channels(record);
  bool any = false;
  for (const Channel channel : all_channels) {
    if (channel == Channel::centre_of_pressure) continue;
    const std::string name = symbol(channel);
    const auto value = line.number(name), u = line.number("u_" + name);
    if (value.has_value() != u.has_value())
      line.fail(fmt::format("{0} and u_{0} go together: a number without its uncertainty says nothing", name));
    if (!value) continue;
    if (!(*u > 0.0)) line.fail(fmt::format("u_{} is {:g}; above 0 is needed", name, *u));
    const auto index = static_cast<Eigen::Index>(channel);
    const double scale = index < 3 ? force : force * line.positive("length_m", "the length of the moment coefficients");
    (index < 3 ? record.load.force_pressure[index] : record.load.moment_pressure[index - 3]) = *value * scale;
    record.u_stated[index] = *u * scale;
    record.known[static_cast<std::size_t>(index)] = any = true;
  }
  if (!any) line.fail("no coefficient; C_D and u_C_D at least are needed");
  record.load_last = record.load;
  return record;
}

}  // namespace

std::vector<CaseRecord> read_experiments(std::string_view csv, const std::string& file, const std::optional<dragcore::MeshBody>& body) {
  std::vector<CaseRecord> records;
  std::vector<std::string> names;
  std::istringstream lines{std::string(csv)};
  int number = 0;
  for (std::string text; std::getline(lines, text);) {
    const Line blank{fmt::format("{}, line {}", file, ++number), {}};
    if (text.empty() || text.front() == '#' || text == "\r") continue;
    const std::vector<std::string> cells = cells_of(text);
    if (names.empty()) {
      names = cells;
      for (const std::string& name : names)
        if (std::find(columns.begin(), columns.end(), name) == columns.end()) blank.fail(dragcore::unknown_word("column", name, columns));
      continue;
    }
    if (cells.size() != names.size()) blank.fail(fmt::format("{} cells, the heading has {}", cells.size(), names.size()));
    Line line = blank;
    for (std::size_t i = 0; i < names.size(); ++i)
      if (!cells[i].empty()) line.cells[names[i]] = cells[i];
    records.push_back(record_from(line, body));
  }
  if (records.empty()) throw std::invalid_argument(file + ": no measurement; a line of column names and one line each are needed");
  return records;
}

}  // namespace compare
