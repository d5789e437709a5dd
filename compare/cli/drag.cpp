#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <dragcore/descriptors.hpp>
#include <dragcore/expose.hpp>
#include <dragcore/pose.hpp>
#include <dragcore/unknown_word.hpp>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>

#include "compare/cli/body.hpp"
#include "compare/cli/commands.hpp"
#include "compare/reference/coefficients.hpp"
#include "compare/tables/error_table.hpp"
#include "compare/tables/text_grid.hpp"

namespace cli {
namespace {

using Eigen::Vector3d;
using nlohmann::json;

constexpr double deg = std::numbers::pi / 180.0;
constexpr std::array angle_names = {"incidence", "yaw", "roll"};

struct DragOptions {
  BodyOptions body;
  ModelOptions model;
  std::vector<double> wind, spin, centre;
  std::vector<std::string> sweep;
  std::array<double, 3> angles_deg{};  ///< incidence, yaw, roll
  double speed = 10.0, density = dragcore::Medium{}.density, viscosity = 0.0;
  std::optional<double> area, length;
  std::string format = "table";
};

/// One wind, and what the air does to the body in it.
struct Row {
  std::array<double, 3> angles_deg{};
  dragcore::Motion motion;                                  ///< body frame
  dragcore::Wrench wrench;                                  ///< body frame, torque about the moment centre
  double frontal_area = 0.0;                                ///< of the silhouette [m^2]
  std::optional<Eigen::Matrix<double, 6, 1>> coefficients;  ///< wind frame, as docs/conventions.md; empty without wind or area
  std::vector<std::string> validity;
};

struct Result {
  std::vector<Row> rows;
  std::string swept;  ///< name of the angle; empty for one wind
  double area = 0.0, length = 0.0;
  std::string area_is, length_is;
  Vector3d centre = Vector3d::Zero();
  std::string model;
};

Vector3d vector_from(const std::vector<double>& numbers) { return {numbers[0], numbers[1], numbers[2]}; }

dragcore::Pose pose_of(const std::array<double, 3>& angles_deg) {
  return {.incidence = angles_deg[0] * deg, .yaw = angles_deg[1] * deg, .roll = angles_deg[2] * deg};
}

/// "0:90:5" as angles [deg].
std::vector<double> angles_from(const std::string& range) {
  constexpr double most = 10000;
  std::array<double, 3> parts{};
  char rest = 0;
  const bool three = std::sscanf(range.c_str(), "%lf:%lf:%lf%c", &parts[0], &parts[1], &parts[2], &rest) == 3;
  const auto [from, to, step] = parts;
  if (!three || !(std::abs(from) <= 360.0) || !(std::abs(to) <= 360.0) || !(step > 0.0) || !(to >= from))
    throw UsageError(
        fmt::format("--sweep {}: FROM:TO:STEP in degrees is needed, such as 0:90:5, TO not below FROM and STEP above 0", range));
  // The last angle is there although the sum of the steps is off by rounding.
  const double count = std::floor((to - from) / step + 1e-9) + 1.0;
  if (count > most) throw UsageError(fmt::format("--sweep {}: these are {:.0f} angles, at most {:.0f} are possible", range, count, most));
  std::vector<double> angles;
  for (int i = 0; i < static_cast<int>(count); ++i) angles.push_back(from + i * step);
  return angles;
}

/// The poses and winds asked for, without what the air does.
std::vector<Row> winds(const DragOptions& options, const Vector3d& centre, bool posed) {
  Row row;
  row.motion.reference_point = centre;
  if (!options.spin.empty()) row.motion.angular_velocity = vector_from(options.spin);
  if (!options.wind.empty()) {
    row.motion.wind = vector_from(options.wind);
    // The pose without roll whose wind along +x is this one in the body frame: R^T x = (cos a cos b, -sin b, sin a cos b).
    if (const Vector3d along = row.motion.wind.normalized(); along.norm() > 0.5)
      row.angles_deg = {std::atan2(along.z(), along.x()) / deg, std::asin(std::clamp(0.0 - along.y(), -1.0, 1.0)) / deg, 0.0};
    return {row};
  }
  std::vector<Row> rows;
  const auto add = [&](const std::array<double, 3>& angles_deg) {
    row.angles_deg = angles_deg;
    row.motion.wind = pose_of(angles_deg).rotation().transpose() * Vector3d(options.speed, 0.0, 0.0);
    rows.push_back(row);
  };
  if (!options.sweep.empty()) {
    const auto swept = std::find(angle_names.begin(), angle_names.end(), options.sweep[0]) - angle_names.begin();
    for (const double angle : angles_from(options.sweep[1])) {
      std::array<double, 3> angles_deg = options.angles_deg;
      angles_deg[static_cast<std::size_t>(swept)] = angle;
      add(angles_deg);
    }
  } else if (posed) {
    add(options.angles_deg);
  } else {
    rows.push_back(row);  // spin in still air
  }
  return rows;
}

void add_coefficients(Result& result, const DragOptions& options, const Body& body) {
  if (options.area) {
    result.area = *options.area, result.area_is = "as given";
  } else {
    const auto widest = std::max_element(result.rows.begin(), result.rows.end(),
                                         [](const Row& a, const Row& b) { return a.frontal_area < b.frontal_area; });
    result.area = widest->frontal_area;
    result.area_is = "frontal area: the silhouette along the wind";
    if (!result.swept.empty())
      result.area_is += fmt::format("; the largest of the sweep, at {} {:g}°", result.swept,
                                    widest->angles_deg[static_cast<std::size_t>(
                                        std::find(angle_names.begin(), angle_names.end(), result.swept) - angle_names.begin())]);
  }
  result.length = options.length.value_or(body.extents().maxCoeff());
  result.length_is = options.length ? "as given" : "the largest extent of the body";
  // The frontal area of a sheet edge-on to the wind is rounding, and nothing to divide by.
  const double extent = body.extents().maxCoeff();
  if (!options.area && result.area < 1e-9 * extent * extent) result.area = 0.0;
  for (Row& row : result.rows) {
    const double force = 0.5 * options.density * row.motion.wind.squaredNorm() * result.area;
    if (!(force > 0.0) || !(result.length > 0.0)) continue;
    const Eigen::Matrix3d to_wind = pose_of(row.angles_deg).rotation();
    row.coefficients.emplace();
    *row.coefficients << to_wind * row.wrench.force / force, to_wind * row.wrench.torque / (force * result.length);
  }
}

Result evaluate(const DragOptions& options, const Body& body, bool posed) {
  Result result;
  result.swept = options.sweep.empty() ? "" : options.sweep[0];
  result.centre = options.centre.empty() ? body.properties.centroid : vector_from(options.centre);
  const dragcore::Medium medium{.density = options.density, .viscosity = options.viscosity};
  const dragcore::Model model = options.model.model().on(body.surface);
  result.model = options.model.label();
  if (model.law.name != options.model.law)
    result.model += model.sheets ? fmt::format(" (law {}, on parts that are sheets {})", model.law.name, model.sheets->law.name)
                                 : fmt::format(" ({} body: law {})", to_string(body.surface.body_class), model.law.name);
  result.rows = winds(options, result.centre, posed);
  for (Row& row : result.rows) {
    row.wrench = dragcore::wrench(body.surface, row.motion, medium, model).total();
    // Of one convex body its windward sides; anything else by its shadow, since parts may stand behind each other.
    row.frontal_area = row.motion.wind.isZero(0.0) ? 0.0
                       : body.surface.convex       ? dragcore::describe(body.surface, row.motion.wind).frontal_area
                                                   : dragcore::silhouette_area(body.mesh, row.motion.wind);
    row.validity = validity(body, row.motion, medium, model);
  }
  add_coefficients(result, options, body);
  return result;
}

std::string coefficient(const Row& row, Eigen::Index k) {
  if (!row.coefficients) return "";
  const double value = (*row.coefficients)[k];
  return fmt::format("{:.4f}", std::abs(value) < 5e-5 ? 0.0 : value);
}

std::vector<std::string> symbols() {
  std::vector<std::string> list;
  for (const compare::Channel channel : compare::all_channels)
    if (channel != compare::Channel::centre_of_pressure) list.push_back(compare::symbol(channel));
  return list;
}

/// "wind 10.2 m/s at incidence 11.31°, yaw 0°": without what a sweep varies.
std::string wind_text(const Result& result) {
  const Row& row = result.rows.front();
  const double speed = row.motion.wind.norm();
  if (speed == 0.0) return "still air";
  std::string words = fmt::format("wind {:g} m/s", speed);
  for (std::size_t k = 0; k < 3; ++k)
    if (angle_names[k] != result.swept && (row.angles_deg[k] != 0.0 || result.swept.empty()))
      words += fmt::format(", {} {:.4g}°", angle_names[k], row.angles_deg[k] + 0.0);
  return words;
}

std::string table(const Result& result, const DragOptions& options, const Body& body, compare::Format format) {
  const bool markdown = format == compare::Format::markdown;
  const auto grid_text = [&](const compare::TextGrid& grid) { return markdown ? compare::markdown(grid) : compare::aligned(grid, false); };
  const auto line = [&](const std::string& words) { return (markdown ? "* " : "") + words + "\n"; };
  const Vector3d& spin = result.rows.front().motion.angular_velocity;
  const Vector3d& wind = result.rows.front().motion.wind;
  std::string page = line(fmt::format("{}: {}", options.body.file, describe(body.properties)));
  for (const std::string& note : body.notes) page += line("note: " + note);
  for (const std::string& finding : body.findings) page += line("found: " + finding);
  page += line("model: " + result.model);
  page += line(fmt::format("air: {}; density {:g} kg/m^3{}", wind_text(result), options.density,
                           options.viscosity > 0.0 ? fmt::format(", viscosity {:g} Pa s", options.viscosity) : ""));
  if (result.swept.empty())
    page += line(fmt::format("wind in the body frame: {} {} {} m/s", text(wind.x()), text(wind.y()), text(wind.z())));
  if (!spin.isZero()) page += line(fmt::format("spin: {} {} {} rad/s", text(spin.x()), text(spin.y()), text(spin.z())));
  page += line(fmt::format("moment centre: {} {} {} m ({})", text(result.centre.x()), text(result.centre.y()), text(result.centre.z()),
                           options.centre.empty() ? "centroid" : "as given"));
  const bool dimensionless =
      std::any_of(result.rows.begin(), result.rows.end(), [](const Row& row) { return row.coefficients.has_value(); });
  if (dimensionless) {
    page += line(fmt::format("area: {} m^2 ({})", text(result.area), result.area_is));
    page += line(fmt::format("length: {} m ({})", text(result.length), result.length_is));
  } else {
    page += line("no coefficients: they need wind, and --area where the frontal area is 0");
  }
  const std::string first = result.swept.empty() ? "" : result.swept;
  const auto angle = [&](const Row& row) {
    for (std::size_t k = 0; k < 3; ++k)
      if (angle_names[k] == result.swept) return fmt::format("{:g}°", row.angles_deg[k]);
    return std::string();
  };
  if (dimensionless) {
    compare::TextGrid grid;
    std::vector<std::string> head = symbols();
    head.insert(head.begin(), first.empty() ? "wind frame" : first);
    grid.add(head);
    for (const Row& row : result.rows) {
      std::vector<std::string> cells = {angle(row)};
      for (Eigen::Index k = 0; k < 6; ++k) cells.push_back(coefficient(row, k));
      grid.add(cells);
    }
    page += "\n" + grid_text(grid);
  }
  compare::TextGrid grid;
  grid.add({first.empty() ? "body frame" : first, "F_x [N]", "F_y [N]", "F_z [N]", "M_x [N m]", "M_y [N m]", "M_z [N m]"});
  for (const Row& row : result.rows) {
    std::vector<std::string> cells = {angle(row)};
    const double force = row.wrench.force.norm(), arm = body.extents().maxCoeff();
    for (const double value : row.wrench.force) cells.push_back(text(value, force));
    for (const double value : row.wrench.torque) cells.push_back(text(value, force * arm));
    grid.add(cells);
  }
  page += "\n" + grid_text(grid);
  // The same warning on every line of a sweep would drown the others: each once, with where it begins.
  std::vector<std::string> told;
  for (const Row& row : result.rows)
    for (const std::string& words : row.validity)
      if (std::find(told.begin(), told.end(), words) == told.end()) {
        page += line((told.empty() ? "\n" : "") + fmt::format("doubtful{}: {}", first.empty() ? "" : " from " + angle(row), words));
        told.push_back(words);
      }
  return page;
}

std::string csv(const Result& result) {
  std::vector<std::string> head = {"incidence_deg", "yaw_deg",      "roll_deg",  "wind_x_m_s", "wind_y_m_s",
                                   "wind_z_m_s",    "force_x_N",    "force_y_N", "force_z_N",  "torque_x_N_m",
                                   "torque_y_N_m",  "torque_z_N_m", "area_m2",   "length_m",   "frontal_area_m2"};
  for (const std::string& symbol : symbols()) head.push_back(symbol);
  head.push_back("validity");
  std::string page = compare::csv_line(head);
  const auto full = [](double value) { return fmt::format("{:.9g}", value + 0.0); };
  for (const Row& row : result.rows) {
    std::vector<std::string> cells;
    for (const double angle : row.angles_deg) cells.push_back(full(angle));
    for (const Vector3d& vector : {row.motion.wind, row.wrench.force, row.wrench.torque})
      for (const double value : vector) cells.push_back(full(value));
    for (const double value : {result.area, result.length, row.frontal_area}) cells.push_back(full(value));
    for (Eigen::Index k = 0; k < 6; ++k) cells.push_back(row.coefficients ? full((*row.coefficients)[k]) : "");
    cells.push_back(fmt::format("{}", fmt::join(row.validity, " ")));
    page += compare::csv_line(cells);
  }
  return page;
}

json to_json(const Result& result, const DragOptions& options, const Body& body) {
  const auto numbers = [](const Vector3d& v) { return json{v.x(), v.y(), v.z()}; };
  json rows = json::array();
  for (const Row& row : result.rows) {
    json coefficients = nullptr;
    if (row.coefficients) {
      coefficients = json::object();
      const auto names = symbols();
      for (std::size_t k = 0; k < names.size(); ++k) coefficients[names[k]] = (*row.coefficients)[static_cast<Eigen::Index>(k)];
    }
    rows.push_back({{"incidence_deg", row.angles_deg[0]},
                    {"yaw_deg", row.angles_deg[1]},
                    {"roll_deg", row.angles_deg[2]},
                    {"wind_m_s", numbers(row.motion.wind)},
                    {"spin_rad_s", numbers(row.motion.angular_velocity)},
                    {"force_N", numbers(row.wrench.force)},
                    {"torque_N_m", numbers(row.wrench.torque)},
                    {"frontal_area_m2", row.frontal_area},
                    {"coefficients", coefficients},
                    {"validity", row.validity}});
  }
  return {{"file", options.body.file},
          {"unit_m", options.body.unit_m()},
          {"model", result.model},
          {"density_kg_m3", options.density},
          {"viscosity_pa_s", options.viscosity},
          {"moment_centre_m", numbers(result.centre)},
          {"area_m2", result.area},
          {"area_is", result.area_is},
          {"length_m", result.length},
          {"length_is", result.length_is},
          {"notes", body.notes},
          {"findings", body.findings},
          {"rows", rows}};
}

}  // namespace

void add_drag(CLI::App& app, Context&) {
  const auto options = std::make_shared<DragOptions>();
  CLI::App* command = app.add_subcommand("drag", "Force, torque and coefficients of the air on the body in an STL or OBJ file");
  command->footer(
      "The wind is that of the air relative to the body, in the body frame. Poses turn the body in a wind along +x: docs/conventions.md.\n"
      "Force and torque are in the body frame, coefficients in the wind frame.\n"
      "Examples: dragval drag body.stl --unit mm --wind 10 0 2\n"
      "          dragval drag body.stl --sweep yaw 0:90:5 --speed 20 --format csv");
  add_body_options(*command, options->body);
  CLI::Option* wind =
      command->add_option("--wind", options->wind, "Velocity of the air relative to the body, body frame [m/s]")->expected(3);
  CLI::Option* sweep =
      command->add_option("--sweep", options->sweep, "incidence, yaw or roll, and FROM:TO:STEP [deg]")->expected(2)->excludes(wind);
  std::vector<CLI::Option*> pose;
  for (std::size_t k = 0; k < 3; ++k)
    pose.push_back(command->add_option(std::string("--") + angle_names[k], options->angles_deg[k], "Of the body in the wind [deg]")
                       ->check(CLI::Range(-360.0, 360.0))
                       ->excludes(wind));
  pose.push_back(command->add_option("--speed", options->speed, "Of the wind of a pose or a sweep [m/s]")
                     ->check(CLI::PositiveNumber)
                     ->excludes(wind)
                     ->capture_default_str());
  CLI::Option* spin =
      command->add_option("--spin", options->spin, "Angular velocity about the moment centre, body frame [rad/s]")->expected(3);
  command->add_option("--density", options->density, "Of the air [kg/m^3]")->check(CLI::PositiveNumber)->capture_default_str();
  command->add_option("--viscosity", options->viscosity, "Of the air, dynamic, 1.8e-5 at 15 C; 0: not known, for Re >= 1e4 only [Pa s]")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  command->add_option("--centre", options->centre, "Moment centre x y z [m] (default: the centroid)")->expected(3);
  command->add_option("--area", options->area, "Of the coefficients [m^2] (default: the frontal area)")->check(CLI::PositiveNumber);
  command->add_option("--length", options->length, "Of the coefficients [m] (default: the largest extent)")->check(CLI::PositiveNumber);
  add_model_options(*command, options->model);
  command->add_option("--format", options->format, "table, md, csv or json")->capture_default_str();
  command->callback([options, wind, sweep, spin, pose] {
    const bool posed = std::any_of(pose.begin(), pose.end(), [](const CLI::Option* option) { return option->count() > 0; });
    if (wind->count() + sweep->count() + spin->count() == 0 && !posed)
      throw UsageError("drag needs a wind; give --wind 10 0 2, or --speed 10 --yaw 30, or --sweep yaw 0:90:5");
    if (sweep->count() > 0 && std::find(angle_names.begin(), angle_names.end(), options->sweep[0]) == angle_names.end())
      throw UsageError(dragcore::unknown_word("angle of --sweep", options->sweep[0], {angle_names.begin(), angle_names.end()}));
    const compare::Format format = compare::format_from(options->format);
    const Body body = load_body(options->body);
    const Result result = evaluate(*options, body, posed);
    if (format == compare::Format::json)
      std::cout << to_json(result, *options, body).dump(2) << "\n";
    else if (format == compare::Format::csv)
      std::cout << csv(result);
    else
      std::cout << table(result, *options, body, format);
    if (const std::string question = unit_question(options->body, body); !question.empty()) std::cerr << "dragval: " << question << "\n";
  });
}

}  // namespace cli
