#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <set>
#include <tuple>

#include "compare/cost/answers.hpp"
#include "compare/peers/correlations.hpp"
#include "compare/report/report.hpp"
#include "compare/report/report_sweep.hpp"
#include "compare/tables/correlation_table.hpp"

// Vega-Lite specifications. A colour means the same in every figure: palette of Okabe and Ito, distinct to colour-blind readers and in
// print.

namespace compare {
namespace {

using nlohmann::json;

constexpr const char* openfoam = "OpenFOAM \u00b1 2u";
constexpr const char* openfoam_point = "OpenFOAM";  // where no bar is drawn
constexpr const char* published = "published";

json base() {
  return {{"$schema", "https://vega.github.io/schema/vega-lite/v6.json"},
          {"background", "white"},
          {"config",
           {{"font", "system-ui, 'Segoe UI', Helvetica, Arial, sans-serif"},
            {"axis",
             {{"labelFontSize", 11},
              {"titleFontSize", 12},
              {"titleFontWeight", "normal"},
              {"gridColor", "#e4e4e4"},
              {"domainColor", "#555"},
              {"tickColor", "#555"}}},
            {"legend",
             {{"orient", "bottom"},
              {"labelFontSize", 12},
              {"titleFontSize", 12},
              {"titleFontWeight", "normal"},
              {"symbolStrokeWidth", 2},
              {"columnPadding", 18},
              {"titleOrient", "left"},
              {"labelLimit", 320},
              {"layout", {{"bottom", {{"anchor", "start"}, {"margin", 36}}}}}}},
            {"view", {{"stroke", "#bbb"}}}}}};
}

json quantitative(const char* field, const json& title) { return {{"field", field}, {"type", "quantitative"}, {"title", title}}; }

/// The quantity of a panel, written above its y axis: at the same height in all panels, whatever the labels of the axis.
json panel_axis(const std::string& title) {
  return {{"title", title}, {"titleAngle", 0}, {"titleAlign", "left"}, {"titleBaseline", "bottom"},
          {"titleX", 0},    {"titleY", -10},   {"titleFontSize", 13},  {"titleFontWeight", 600}};
}

/// One scale for all figures; `names` are those that this one shows. Laws are lines, or rings where they are points.
json series_colour(const std::vector<std::string>& names, const char* law_symbol = "stroke") {
  static const std::map<std::string, std::string> colours = {
      {"note's law", "#0072b2"}, {"consistent law", "#e69f00"}, {"calibrated law", "#009e73"}, {"law by class", "#cc79a7"},
      {openfoam, "#000000"},     {openfoam_point, "#000000"},   {published, "#d55e00"}};
  json range = json::array();
  for (const std::string& name : names) range.push_back(colours.at(name));
  const std::string symbol =
      fmt::format("datum.value == 'published' ? 'diamond' : test(/^OpenFOAM/, datum.value) ? 'circle' : '{}'", law_symbol);
  const std::string size = fmt::format("datum.value == 'published' ? 110 : test(/^OpenFOAM/, datum.value) ? 50 : {}",
                                       std::string(law_symbol) == "stroke" ? 200 : 60);
  const auto computed = [](const std::string& expression) { return json{{"value", {{"signal", expression}}}}; };
  const json symbols = {{"shape", computed(symbol)},
                        {"size", computed(size)},
                        {"fill", computed("test(/^OpenFOAM/, datum.value) ? '#000000' : 'transparent'")},
                        {"strokeWidth", {{"value", 2}}},
                        {"strokeDash", {{"value", json::array()}}},
                        {"opacity", {{"value", 1}}}};
  return {{"field", "series"},
          {"type", "nominal"},
          {"title", nullptr},
          {"scale", {{"domain", names}, {"range", range}}},
          {"legend", {{"encoding", {{"symbols", symbols}}}}}};
}

std::vector<std::string> law_names(const Report& report) {
  std::vector<std::string> names;
  for (const ReportedModel& model : report.models)
    if (model.pillow == "none") names.push_back(model.law);
  return names;
}

json pillow_dash() {
  return {{"field", "pillow"},
          {"type", "nominal"},
          {"title", "pillow"},
          {"scale", {{"domain", {"none", "patch", "tilt"}}, {"range", {json::array({1, 0}), json::array({7, 3}), json::array({2, 2})}}}},
          {"legend", {{"symbolType", "stroke"}, {"symbolStrokeColor", "#444"}, {"symbolSize", 500}}}};
}

std::vector<double> fine_angles(const Sweep& sweep, const std::vector<const ErrorRow*>& rows) {
  constexpr double step = 2.5;  // [deg]: a tenth of a law's shortest feature, the half wave of sin 2 angle
  const double first = sweep.angle_of(*rows.front()), last = sweep.angle_of(*rows.back());
  std::vector<double> angles;
  for (double angle = first; angle < last - 1e-9; angle += step) angles.push_back(angle);
  angles.push_back(last);
  return angles;
}

/// What the models of a report say along a sweep.
struct Curves {
  std::vector<double> angles;                       ///< [deg], the same for all panels of the sweep: every pose has a C_D
  std::vector<std::vector<Coefficients>> of_model;  ///< at every angle; empty for the pillow per triangle
};

Curves curves_along(const Report& report, const Sweep& sweep) {
  Curves curves{fine_angles(sweep, rows_of(report.models.front().table, sweep, Channel::drag)), {}};
  for (const ReportedModel& model : report.models) {
    // The form per triangle depends on the triangulation: a curve of it would be one of the mesh. It has its rows in the tables.
    curves.of_model.emplace_back();
    if (model.pillow == "triangle") continue;
    ModelChoice drawn = model.choice;
    drawn.model.precision = dragcore::Precision::single;  // nobody sees 1e-6 of a line
    curves.of_model.back() = coefficients_along(sweep, drawn, curves.angles);
  }
  return curves;
}

/// Layers of one coefficient against orientation.
/// @param with_pillow  one line for every pillow form, told apart by dashes; else one per law
json sweep_panel(const Report& report, const Sweep& sweep, const Curves& curves, Channel channel, const std::string& title,
                 bool with_pillow, int width, int height) {
  const auto rows = rows_of(report.models.front().table, sweep, channel);
  const std::vector<double>& angles = curves.angles;
  json lines = json::array(), points = json::array(), measured = json::array(), literature = json::array();
  for (std::size_t m = 0; m < report.models.size(); ++m) {
    const ReportedModel& model = report.models[m];
    const std::vector<Coefficients>& curve = curves.of_model[m];
    if (!with_pillow && model.pillow != "none") continue;
    for (std::size_t i = 0; i < curve.size(); ++i)
      if (const auto value = curve[i][channel])
        lines.push_back({{"angle", angles[i]}, {"value", *value}, {"series", model.law}, {"pillow", model.pillow}});
  }
  for (const ErrorRow* row : rows) {
    const double angle = sweep.angle_of(*row);
    if (row->cfd)
      (row->flow_model == CaseRecord::experiment ? measured : points)
          .push_back({{"angle", angle},
                      {"value", *row->cfd},
                      {"low", *row->cfd - 2 * row->u},
                      {"high", *row->cfd + 2 * row->u},
                      {"u", row->u},
                      {"case", row->case_name},
                      {"series", row->flow_model == CaseRecord::experiment ? published : openfoam}});
    if (row->published)
      literature.push_back(
          {{"angle", angle}, {"value", row->published->value}, {"source", row->published->citation}, {"series", published}});
  }
  const double range = angles.back() - angles.front();
  json x = quantitative("angle", sweep.angle + " [\u00b0]");
  x["scale"] = {{"domain", {angles.front(), angles.back()}}, {"nice", false}, {"padding", 8}};
  x["axis"] = {{"values", json::array()}, {"grid", true}};
  for (double tick = angles.front(); tick <= angles.back() + 1e-9; tick += range > 100 ? 30 : 15) x["axis"]["values"].push_back(tick);
  std::vector<std::string> names = law_names(report);
  names.insert(names.end(), {openfoam, published});
  const json colour = series_colour(names);
  json y = quantitative("value", nullptr), low = quantitative("low", nullptr);
  y["axis"] = low["axis"] = panel_axis(title);

  json line_encoding = {{"x", x}, {"y", y}, {"color", colour}};
  line_encoding["detail"] = {{"field", "pillow"}};
  if (with_pillow) line_encoding["strokeDash"] = pillow_dash();
  const json hint = {{{"field", "case"}}, {{"field", "value"}, {"format", ".4f"}}, {{"field", "u"}, {"format", ".4f"}}};
  const json source_hint = {{{"field", "source"}}, {{"field", "value"}, {"format", ".3f"}}};
  json layers = json::array({{{"data", {{"values", lines}}}, {"mark", {{"type", "line"}, {"strokeWidth", 2}}}, {"encoding", line_encoding}},
                             {{"data", {{"values", points}}},
                              {"mark", {{"type", "rule"}, {"strokeWidth", 1.5}}},
                              {"encoding", {{"x", x}, {"y", low}, {"y2", {{"field", "high"}}}, {"color", colour}}}},
                             {{"data", {{"values", points}}},
                              {"mark", {{"type", "point"}, {"fill", "black"}, {"size", 40}, {"opacity", 1}}},
                              {"encoding", {{"x", x}, {"y", y}, {"color", colour}, {"tooltip", hint}}}}});
  const json diamond = {{"type", "point"}, {"shape", "diamond"}, {"size", 110}, {"strokeWidth", 2}, {"opacity", 1}};
  if (!measured.empty()) {
    layers.push_back({{"data", {{"values", measured}}},
                      {"mark", {{"type", "rule"}, {"strokeWidth", 1.5}}},
                      {"encoding", {{"x", x}, {"y", low}, {"y2", {{"field", "high"}}}, {"color", colour}}}});
    layers.push_back(
        {{"data", {{"values", measured}}}, {"mark", diamond}, {"encoding", {{"x", x}, {"y", y}, {"color", colour}, {"tooltip", hint}}}});
  }
  if (!literature.empty())
    layers.push_back({{"data", {{"values", literature}}},
                      {"mark", diamond},
                      {"encoding", {{"x", x}, {"y", y}, {"color", colour}, {"tooltip", source_hint}}}});
  return {{"width", width}, {"height", height}, {"layer", layers}};
}

json sweep_figure(const Report& report, const Sweep& sweep, const Curves& curves) {
  json spec = base();
  spec["hconcat"] = json::array();
  for (const Channel channel : {Channel::drag, sweep.force, sweep.moment})
    spec["hconcat"].push_back(sweep_panel(report, sweep, curves, channel, symbol(channel), channel == sweep.moment, 310, 240));
  spec["spacing"] = 64;
  spec["bounds"] = "flush";  // panels of one width and height, whatever their labels
  spec["resolve"] = {{"scale", {{"color", "shared"}}}};
  return spec;
}

/// C_D of every shape with a curve, for a page that has room for one figure.
json drag_figure(const Report& report, const std::map<const Sweep*, Curves>& curves, const std::vector<Sweep>& list) {
  json spec = base();
  spec["hconcat"] = json::array();
  for (const Sweep& sweep : list) {
    if (!sweep.curve) continue;
    const std::string body = sweep.title.substr(0, sweep.title.find(" at "));
    const std::string title = "C_D, " + body + (sweep.detail.empty() ? "" : ", " + sweep.detail);
    spec["hconcat"].push_back(sweep_panel(report, sweep, curves.at(&sweep), Channel::drag, title, false, 250, 230));
  }
  spec["spacing"] = 50;
  spec["bounds"] = "flush";
  spec["resolve"] = {{"scale", {{"color", "shared"}}}};
  return spec;
}

/// C_D against the Reynolds number, from creeping flow to beyond the drag crisis: everything that is known of four bodies.
json reynolds_figure(const Report& report) {
  struct Body {
    const char* title;
    dragcore::Shape shape;
    dragcore::Pose pose;
  };
  const std::array<Body, 4> bodies = {{{"C_D, ball", dragcore::Sphere{}, {}},
                                       {"C_D, cube, face-on", dragcore::Box{}, {}},
                                       {"C_D, disc, face-on", dragcore::Cylinder{.diameter = 1.0, .length = 0.05}, {}},
                                       {"C_D, plate at 30\u00b0", dragcore::Plate{}, {.incidence = std::numbers::pi / 6.0}}}};
  constexpr double lowest = 0.1, highest = 1e6, highest_correlated = 1e4;
  constexpr double drag_crisis = 3e5;  // of a smooth ball: its layer turns turbulent, its wake shrinks, and no law here knows
  constexpr int per_decade = 8;
  const std::string law = law_label("by class");
  const std::vector<CaseOfRecord> cases = cases_of_record(report.reference.cases);

  json x = quantitative("re", "Re");
  x["scale"] = {{"type", "log"}, {"domain", {lowest, highest}}, {"nice", false}};
  x["axis"] = {{"values", {0.1, 1, 10, 100, 1e3, 1e4, 1e5, 1e6}},
               {"labelFlush", false},
               {"labelExpr", "datum.value < 1000 ? format(datum.value, '~g') : '1e' + round(log(datum.value) / LN10)"}};
  json x_from = x;
  x_from["field"] = "from";
  const json colour = series_colour({law, openfoam, published});
  json spec = base();
  spec["concat"] = json::array();
  spec["columns"] = 2;
  bool any = false;
  for (const Body& body : bodies) {
    CaseRecord at;
    at.shape = body.shape, at.pose = body.pose;
    const auto flows_at = [&](double reynolds) {
      at.reynolds = reynolds;
      at.viscosity = at.speed * dragcore::properties(at.shape).reference_length / reynolds;
    };
    json lines = json::array(), correlated = json::array(), solved = json::array(), other = json::array(), measured = json::array();
    for (int i = 0; i <= 7 * per_decade; ++i) {
      flows_at(lowest * std::pow(10.0, static_cast<double>(i) / per_decade));
      const dragcore::Wrench wrench = predict(at, ModelChoice::recommended()).total();
      lines.push_back({{"re", at.reynolds}, {"value", *coefficients(at, wrench.force, wrench.torque)[Channel::drag]}, {"series", law}});
      if (at.reynolds > 1.001 * highest_correlated) continue;
      for (std::size_t k = 0; k < peers::correlations().size(); ++k)
        if (const auto value = correlated_drag(at, k))
          correlated.push_back({{"re", at.reynolds}, {"value", *value}, {"correlation", peers::correlations()[k].name}});
    }
    const auto add = [&](json& list, double reynolds, double value, double u, const std::string& name, const char* series) {
      // A logarithmic axis has no place for a bar that ends below zero.
      list.push_back({{"re", reynolds},
                      {"value", value},
                      {"low", std::max(value - 2.0 * u, 0.3 * value)},
                      {"high", value + 2.0 * u},
                      {"u", u},
                      {"case", name},
                      {"series", series}});
    };
    for (const CaseOfRecord& chosen : cases) {
      flows_at(chosen.family.record->reynolds);
      at.flow_model = chosen.family.record->flow_model;
      if (!same_question(at, *chosen.family.record)) continue;
      std::vector<const CaseFamily*> families = {&chosen.family};
      for (const CaseFamily& alternative : chosen.alternatives) families.push_back(&alternative);
      for (const CaseFamily* family : families) {
        const CaseRecord& record = *family->record;
        const auto drag = coefficients(record)[Channel::drag];
        if (!case_record::is_usable(record.status) || !drag) continue;
        const bool of_record = family == &chosen.family;
        add(record.is_experiment() ? measured
            : of_record            ? solved
                                   : other,
            record.reynolds, *drag, family->uncertainty.total[0] / coefficient_scales(record)[0], record.name,
            record.is_experiment() ? published : openfoam);
        any = true;
      }
    }
    at.flow_model.clear();
    for (const PublishedEntry& entry : published_entries()) {
      const double from = std::max(entry.cases.reynolds.first, lowest), to = std::min(entry.cases.reynolds.second, highest);
      flows_at(std::sqrt(from * to));
      if (entry.quantity != "C_D" || !(from <= to) || !entry.fits(at)) continue;
      const PublishedValue value = entry.on_reference_area(at);
      add(measured, at.reynolds, value.value, value.uncertainty, value.citation, published);
      measured.back().update({{"from", from}, {"to", to}});
    }
    json y = quantitative("value", nullptr);
    y["scale"] = {{"type", "log"}};
    y["axis"] = panel_axis(body.title);
    y["axis"].update({{"format", "~g"}, {"tickCount", 6}});
    json low = y;
    low["field"] = "low";
    const json hint = {{{"field", "case"}},
                       {{"field", "re"}, {"format", "~g"}},
                       {{"field", "value"}, {"format", ".3f"}},
                       {{"field", "u"}, {"format", ".3f"}}};
    json dash = {{"field", "correlation"},
                 {"type", "nominal"},
                 {"title", "correlations"},
                 {"scale",
                  {{"domain", json::array()},
                   {"range", {json::array({8, 3}), json::array({2, 2}), json::array({6, 2, 1, 2}), json::array({1, 0})}}}},
                 {"legend", {{"symbolType", "stroke"}, {"symbolStrokeColor", "#777"}, {"symbolSize", 500}, {"columns", 2}}}};
    json layers = json::array();
    const auto layer = [&](const json& values, const json& mark, const json& encoding) {
      if (!values.empty()) layers.push_back({{"data", {{"values", values}}}, {"mark", mark}, {"encoding", encoding}});
    };
    for (const peers::Correlation& correlation : peers::correlations()) dash["scale"]["domain"].push_back(correlation.name);
    if (std::holds_alternative<dragcore::Sphere>(body.shape)) {
      const json crisis = json::array({{{"from", drag_crisis}, {"to", highest}, {"name", "drag crisis"}}});
      layer(crisis, {{"type", "rect"}, {"color", "#dddddd"}, {"opacity", 0.6}}, {{"x", x_from}, {"x2", {{"field", "to"}}}});
      layer(crisis, {{"type", "text"}, {"align", "right"}, {"dx", -4}, {"fontSize", 11}, {"y", 12}},
            {{"x", x_from}, {"text", {{"field", "name"}}}});
    }
    layer(correlated, {{"type", "line"}, {"color", "#777777"}, {"strokeWidth", 1.3}}, {{"x", x}, {"y", y}, {"strokeDash", dash}});
    layer(lines, {{"type", "line"}, {"strokeWidth", 2}}, {{"x", x}, {"y", y}, {"color", colour}});
    const json bar = {{"type", "rule"}, {"strokeWidth", 1.5}};
    for (const json* points : {&other, &solved, &measured})
      layer(*points, bar, {{"x", x}, {"y", low}, {"y2", {{"field", "high"}}}, {"color", colour}});
    json ranges = json::array();
    for (const json& point : measured)
      if (point.contains("from")) ranges.push_back(point);
    layer(ranges, bar, {{"x", x_from}, {"x2", {{"field", "to"}}}, {"y", y}, {"color", colour}});
    const json encoding = {{"x", x}, {"y", y}, {"color", colour}, {"tooltip", hint}};
    layer(other, {{"type", "point"}, {"fill", "white"}, {"size", 40}, {"opacity", 1}}, encoding);
    layer(solved, {{"type", "point"}, {"fill", "black"}, {"size", 40}, {"opacity", 1}}, encoding);
    layer(measured, {{"type", "point"}, {"shape", "diamond"}, {"size", 80}, {"strokeWidth", 2}, {"opacity", 1}, {"fill", "white"}},
          encoding);
    spec["concat"].push_back({{"width", 460}, {"height", 270}, {"layer", layers}});
  }
  if (!any) return nullptr;
  spec["spacing"] = 60;
  spec["bounds"] = "flush";
  spec["resolve"] = {{"scale", {{"color", "shared"}, {"strokeDash", "shared"}}}};
  return spec;
}

/// Mean C_p of planar faces against the cosine of their angle to the flow: where on the body a law is wrong.
json face_pressure_figure(const Report& report) {
  constexpr double edge = 0.1;  // of A_ref: smaller faces are the edges of plates, which live in the wake of their neighbours
  json lines = json::array(), points = json::array(), shapes = json::array();
  for (const ReportedModel& model : report.models) {
    if (model.pillow != "none" || model.choice.by_class) continue;  // by class is no curve of c alone
    for (int i = -50; i <= 50; ++i) {
      const double c = i / 50.0;
      const double pressure =
          c > 0 ? dragcore::evaluate(model.choice.model.law.windward, c) : -dragcore::evaluate(model.choice.model.law.leeward, -c);
      lines.push_back({{"c", c}, {"pressure", pressure}, {"series", model.law}});
    }
  }
  std::set<std::string> of_record;
  for (const ErrorRow& row : report.models.front().table.rows) of_record.insert(row.case_name);
  for (std::size_t i = 0; i < std::min(report.reference.cases.size(), report.reference.patches.size()); ++i) {
    const CaseRecord& record = report.reference.cases[i];
    if (!of_record.contains(record.name) || !case_record::is_usable(record.status) || flow_class(record) == "laminar") continue;
    const dragcore::ShapeProperties body = dragcore::properties(record.shape);
    for (const PatchMean& patch : report.reference.patches[i]) {
      if (patch.name.starts_with("curved") || patch.area < edge * body.reference_area) continue;
      const double c = -(record.pose.rotation() * patch.area_vector).x() / patch.area;
      const std::string shape = shape_label(record.shape);
      if (std::find(shapes.begin(), shapes.end(), shape) == shapes.end()) shapes.push_back(shape);
      points.push_back({{"c", c},
                        {"pressure", patch.pressure_coefficient},
                        {"series", openfoam_point},
                        {"body", shape},
                        {"case", record.name},
                        {"face", patch.name}});
    }
  }
  json spec = base();
  if (points.empty()) return nullptr;
  json x = quantitative("c", "c, cosine between the face's outward normal and the oncoming flow (windward > 0)");
  x["scale"] = {{"domain", {-1, 1}}};
  std::vector<std::string> names = law_names(report);
  names.push_back(openfoam_point);
  const json y = quantitative("pressure", "mean pressure coefficient C_p"), colour = series_colour(names);
  const json hint = {
      {{"field", "case"}}, {{"field", "face"}}, {{"field", "c"}, {"format", ".3f"}}, {{"field", "pressure"}, {"format", ".3f"}}};
  spec["width"] = 720;
  spec["height"] = 330;
  spec["layer"] = json::array({{{"data", {{"values", lines}}},
                                {"mark", {{"type", "line"}, {"strokeWidth", 2}}},
                                {"encoding", {{"x", x}, {"y", y}, {"color", colour}}}},
                               {{"data", {{"values", points}}},
                                {"mark", {{"type", "point"}, {"size", 60}, {"strokeWidth", 1.5}, {"opacity", 0.9}}},
                                {"encoding",
                                 {{"x", x},
                                  {"y", y},
                                  {"color", colour},
                                  {"shape",
                                   {{"field", "body"},
                                    {"type", "nominal"},
                                    {"title", "body"},
                                    {"scale", {{"domain", shapes}, {"range", {"cross", "square", "triangle-up", "circle", "diamond"}}}},
                                    {"legend", {{"symbolStrokeColor", "#000"}, {"symbolFillColor", "transparent"}}}}},
                                  {"tooltip", hint}}}}});
  return spec;
}

/// Error against CPU time, from one drag coefficient to CFD: of the force, of C_D and of torque.
json cost_figure(const Report& report) {
  struct Panel {
    const char* title;
    double RmsErrors::*error;
    int width;
  };
  constexpr std::array<Panel, 3> panels = {
      {{"rms error of the force", &RmsErrors::relative, 520}, {"of C_D", &RmsErrors::drag, 190}, {"of C_M", &RmsErrors::torque, 190}}};
  const Ladder& ladder = report.cost;
  if (ladder.rungs.empty()) return nullptr;
  const std::vector<const Rung*> front = pareto_front(ladder.rungs);
  double low = 1e-7, high = 1.0;
  for (const Rung& rung : ladder.rungs) low = std::min(low, rung.seconds), high = std::max(high, rung.seconds);
  low = std::pow(10.0, std::floor(std::log10(low))), high = std::pow(10.0, std::ceil(std::log10(high) + 0.3));
  json x = quantitative("seconds", "CPU time of one evaluation");
  x["scale"] = {{"type", "log"}, {"domain", {low, high}}, {"nice", false}};
  x["axis"] = {
      {"values", json::array()},
      {"labelFlush", false},
      {"labelExpr",
       "datum.value < 0.9e-6 ? format(datum.value*1e9, 'd')+' ns' : datum.value < 0.9e-3 ? format(datum.value*1e6, 'd')+' \u00b5s' : "
       "datum.value < 0.9 ? format(datum.value*1e3, 'd')+' ms' : format(datum.value, ',d')+' s'"}};
  const json colour = {
      {"field", "kind"},
      {"type", "nominal"},
      {"title", nullptr},
      {"scale", {{"domain", {"constant", "engine", "law", "CFD"}}, {"range", {"#e69f00", "#d55e00", "#0072b2", "#000000"}}}},
      {"legend", {{"symbolType", "circle"}, {"symbolFillColor", "transparent"}}}};
  const json hint = {{{"field", "rung"}},
                     {{"field", "triangles"}, {"title", "triangles, cells"}, {"format", ",.0f"}},
                     {{"field", "time"}},
                     {{"field", "error"}, {"format", ".3f"}},
                     {{"field", "poses"}}};
  json spec = base();
  spec["hconcat"] = json::array();
  for (const Panel& panel : panels) {
    const bool main = panel.error == &RmsErrors::relative;
    json points = json::array(), line = json::array();
    double lowest = 1.0, highest = 0.0;
    const auto point = [&](const Rung& rung) {
      return json{{"seconds", rung.seconds},     {"error", rung.errors.*panel.error}, {"kind", rung.kind},  {"rung", rung.name},
                  {"triangles", rung.triangles}, {"time", time_text(rung.seconds)},   {"poses", rung.poses}};
    };
    for (const Rung& rung : ladder.rungs) {
      if (!(rung.errors.*panel.error > 0.0)) continue;  // no place on a logarithmic axis
      points.push_back(point(rung));
      lowest = std::min(lowest, rung.errors.*panel.error), highest = std::max(highest, rung.errors.*panel.error);
    }
    for (const Rung* rung : front) line.push_back(point(*rung));
    const double u = ladder.uncertainty.*panel.error, bottom = 0.7 * std::min(lowest, u);
    json y = quantitative("error", nullptr);
    y["scale"] = {{"type", "log"}, {"domain", {bottom, 1.3 * highest}}, {"nice", false}};
    y["axis"] = panel_axis(panel.title);
    y["axis"].update({{"format", main ? "~%" : "~g"}, {"tickCount", 6}});
    json own_x = x;
    for (double tick = low; tick < 1.1 * high; tick *= 10)
      if (std::lround(std::log10(tick)) % (main ? 2 : 4) == 0) own_x["axis"]["values"].push_back(tick);
    const auto layer = [](const json& values, const json& mark, const json& encoding) {
      return json{{"data", {{"values", values}}}, {"mark", mark}, {"encoding", encoding}};
    };
    const json band = json::array({{{"low", bottom}, {"high", u}}});
    json low_y = y;
    low_y["field"] = "low";
    json layers =
        json::array({layer(band, {{"type", "rect"}, {"color", "#dddddd"}, {"opacity", 0.6}}, {{"y", low_y}, {"y2", {{"field", "high"}}}}),
                     layer(line, {{"type", "line"}, {"interpolate", "step-after"}, {"color", "#888888"}, {"strokeWidth", 1.5}},
                           {{"x", own_x}, {"y", y}}),
                     layer(points, {{"type", "point"}, {"size", 45}, {"strokeWidth", 1.6}, {"opacity", 1}},
                           {{"x", own_x}, {"y", y}, {"color", colour}, {"tooltip", hint}})});
    if (main) {
      // Names beside their points, none on top of another of the front: to the right of what is cheap, to the left of what is dear.
      std::vector<const Rung*> named;
      for (const Rung* rung : front)
        if (named.empty() || rung->errors.relative < 0.85 * named.back()->errors.relative) named.push_back(rung);
      for (const Rung& rung : ladder.rungs)
        if (std::find(named.begin(), named.end(), &rung) == named.end() &&
            (rung.kind == "engine" || rung.name == "k_omega_sst_ddes, medium"))
          named.push_back(&rung);
      json cheap = json::array(), dear = json::array();
      for (const Rung* rung : named) (rung->kind == "CFD" ? dear : cheap).push_back(point(*rung));
      for (const auto& [values, align, dx, dy] : {std::tuple(cheap, "left", 6, -6), std::tuple(dear, "right", -6, 10)})
        layers.push_back(layer(values, {{"type", "text"}, {"align", align}, {"dx", dx}, {"dy", dy}, {"fontSize", 10.5}},
                               {{"x", own_x}, {"y", y}, {"text", {{"field", "rung"}}}}));
    }
    spec["hconcat"].push_back({{"width", panel.width}, {"height", 320}, {"layer", layers}});
  }
  spec["spacing"] = 50;
  spec["bounds"] = "flush";
  spec["resolve"] = {{"scale", {{"color", "shared"}}}};
  return spec;
}

}  // namespace

std::map<std::string, json> figures(const Report& report) {
  const std::vector<Sweep> list = sweeps(report);
  std::map<std::string, json> found;
  std::map<const Sweep*, Curves> curves;
  for (const Sweep& sweep : list)
    if (sweep.curve) {
      curves[&sweep] = curves_along(report, sweep);
      found["sweep-" + sweep.slug()] = sweep_figure(report, sweep, curves.at(&sweep));
    }
  if (!found.empty()) found["drag_against_orientation"] = drag_figure(report, curves, list);
  for (auto& [name, spec] : {std::pair{"cost", cost_figure(report)}, std::pair{"face_pressure", face_pressure_figure(report)},
                             std::pair{"drag_against_reynolds", reynolds_figure(report)}})
    if (!spec.is_null()) found[name] = spec;
  return found;
}

}  // namespace compare
