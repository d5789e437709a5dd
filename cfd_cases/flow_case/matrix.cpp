#include "cfd_cases/flow_case/matrix.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <dragcore/mesh_file.hpp>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <sstream>

#include "cfd_cases/mesh/mesh_recipe.hpp"
#include "cfd_cases/mesh/o_grid.hpp"

namespace cfd_cases {

namespace fs = std::filesystem;

namespace {

/// Keys of one table, each read once; whatever is left over is unknown.
class Table {
 public:
  Table(const toml::table& table, const fs::path& file) : table_(table), file_(file) {}

  [[noreturn]] static void fail(const fs::path& file, const toml::source_region& at, const std::string& message) {
    throw ConfigurationError(fmt::format("{}:{}:{}: {}", file.string(), at.begin.line, at.begin.column, message));
  }
  [[noreturn]] void fail(const toml::node& at, const std::string& message) const { fail(file_, at.source(), message); }
  [[noreturn]] void fail(const std::string& message) const { fail(table_, message); }

  const toml::node* find(const char* key) {
    known_.emplace_back(key);
    return table_.get(key);
  }
  const toml::table* subtable(const char* key) {
    const auto* node = find(key);
    if (node && !node->is_table()) fail(*node, fmt::format("{} must be a table", key));
    return node ? node->as_table() : nullptr;
  }
  void number(const char* key, double& value, double lowest, double highest) {
    if (const auto* node = find(key)) value = number(*node, key, lowest, highest);
  }
  void integer(const char* key, int& value, int lowest, int highest) {
    const auto* node = find(key);
    if (!node) return;
    if (!node->is_integer()) fail(*node, fmt::format("{} must be a whole number", key));
    value = static_cast<int>(number(*node, key, lowest, highest));
  }
  void flag(const char* key, bool& value) {
    const auto* node = find(key);
    if (!node) return;
    if (!node->is_boolean()) fail(*node, fmt::format("{} must be true or false", key));
    value = *node->value<bool>();
  }
  void word(const char* key, std::string& value, const std::vector<std::string>& allowed = {}) {
    if (const auto* node = find(key)) value = word(*node, key, allowed);
  }
  void words(const char* key, std::vector<std::string>& values, const std::vector<std::string>& allowed) {
    const auto* node = find(key);
    if (!node) return;
    values.clear();
    each(*node, [&](const toml::node& item) { values.push_back(word(item, key, allowed)); });
  }
  /// A number, a list of numbers, or { from, to, step } with both ends included.
  void numbers(const char* key, std::vector<double>& values, double lowest, double highest) {
    const auto* node = find(key);
    if (!node) return;
    values.clear();
    if (const auto* range = node->as_table()) {
      Table ends(*range, file_);
      double from = NAN, to = NAN, step = NAN;
      ends.number("from", from, lowest, highest);
      ends.number("to", to, lowest, highest);
      ends.number("step", step, 1e-6, highest);
      ends.reject_unknown("a range");
      if (std::isnan(from + to + step) || to < from)
        fail(*node, fmt::format("{} needs a range {{ from, to, step }} with from <= to and step > 0", key));
      const double steps = std::round((to - from) / step);
      if (std::abs(from + steps * step - to) > 1e-9 * std::max(1.0, std::abs(to)))
        fail(*node, fmt::format("{}: the step {} does not lead from {} to {}", key, step, from, to));
      for (int i = 0; i <= static_cast<int>(steps); ++i) values.push_back(from + i * step);
    } else {
      each(*node, [&](const toml::node& item) { values.push_back(number(item, key, lowest, highest)); });
    }
    if (values.empty()) fail(*node, fmt::format("{} is an empty list", key));
  }
  void reject_unknown(const std::string& where) const {
    for (const auto& [key, node] : table_)
      if (std::find(known_.begin(), known_.end(), key.str()) == known_.end())
        fail(file_, key.source(), fmt::format("unknown key '{}' in {}: known are {}", key.str(), where, fmt::join(known_, ", ")));
  }

 private:
  template <class Visit>
  static void each(const toml::node& node, Visit visit) {
    if (const auto* list = node.as_array())
      for (const auto& item : *list) visit(item);
    else
      visit(node);
  }
  double number(const toml::node& node, const char* key, double lowest, double highest) const {
    const auto value = node.is_number() ? node.value<double>() : std::nullopt;
    if (!value) fail(node, fmt::format("{} must be a number", key));
    if (!(*value >= lowest && *value <= highest))
      fail(node, fmt::format("{} = {} is out of range: needed {} to {}", key, *value, lowest, highest));
    return *value + 0.0;  // turns -0 into 0, which would otherwise make another key
  }
  std::string word(const toml::node& node, const char* key, const std::vector<std::string>& allowed) const {
    if (!node.is_string()) fail(node, fmt::format("{} must be a string", key));
    std::string value = *node.value<std::string>();
    if (!allowed.empty() && std::find(allowed.begin(), allowed.end(), value) == allowed.end())
      fail(node, fmt::format("{} = \"{}\" is unknown: use {}", key, value, fmt::join(allowed, ", ")));
    return value;
  }

  const toml::table& table_;
  const fs::path& file_;
  std::vector<std::string> known_;
};

/// What a sweep says, before it is multiplied out.
struct Sweep {
  CaseSpec common;
  std::vector<double> incidence{0.0}, yaw{0.0}, roll{0.0}, reynolds{1e5};
  std::vector<std::string> levels{"medium"};
  std::string start;   ///< name of the case that the first one starts from
  bool chain = false;  ///< each case starts from the one before it
  int seeds = 0;       ///< each case on this many meshes of the same sizes, seeds 1, 2, ...; 0: as `common` has it
};

void read_numerics(Table table, Numerics& numerics) {
  table.number("relaxation_velocity", numerics.relaxation_velocity, 0.01, 1.0);
  table.number("relaxation_pressure", numerics.relaxation_pressure, 0.01, 1.0);
  table.number("relaxation_turbulence", numerics.relaxation_turbulence, 0.01, 1.0);
  table.word("convection", numerics.convection, {"linear_upwind", "upwind", "linear", "lust"});
  table.word("gradient", numerics.gradient, {"unlimited", "cell_limited"});
  table.number("turbulence_intensity", numerics.turbulence_intensity, 1e-4, 0.3);
  table.number("viscosity_ratio", numerics.viscosity_ratio, 1e-3, 1000.0);
  table.word("wall", numerics.wall, {"spalding", "log_law", "low_re"});
  table.reject_unknown("[numerics]");
}

void read_recipe(Table table, MeshRecipe& recipe) {
  for (const auto& [name, value] : recipe_lengths(recipe)) table.number(name, *value, 1e-4, 1000.0);
  table.reject_unknown("recipe");
}

void read_time(Table table, TimeSpan& time) {
  table.number("step", time.step, 1e-6, 1.0);
  table.number("duration", time.duration, 1e-3, 1e5);
  table.number("discard", time.discard, 0.0, 1e5);
  table.reject_unknown("time");
}

/// Keys that both [defaults] and a [[sweep]] may hold.
void read_common(Table& table, const fs::path& file, Sweep& sweep) {
  table.numbers("incidence_deg", sweep.incidence, -180.0, 180.0);
  table.numbers("yaw_deg", sweep.yaw, -180.0, 180.0);
  table.numbers("roll_deg", sweep.roll, -180.0, 180.0);
  table.numbers("reynolds", sweep.reynolds, 0.1, 1e9);
  CaseSpec& spec = sweep.common;
  const Numerics usual = numerics_of(spec.flow_model);
  table.word("flow_model", spec.flow_model, {"laminar", "laminar_unsteady", "k_omega_sst", "k_omega_sst_lm", "k_omega_sst_ddes"});
  if (spec.numerics == usual) spec.numerics = numerics_of(spec.flow_model);
  spec.stop.mean_error = stop_policy_of(spec.flow_model).mean_error;
  table.words("mesh", sweep.levels, {"coarse", "medium", "fine", "finest"});
  table.flag("held_out", sweep.common.held_out);
  table.integer("retries", sweep.common.retries, 0, 1);
  table.integer("min_iterations", sweep.common.stop.min_iterations, 10, 100000);
  table.integer("max_iterations", sweep.common.stop.max_iterations, 10, 100000);
  table.number("timeout_s", sweep.common.timeout_s, 0.1, 1e6);
  if (const auto* numerics = table.subtable("numerics")) read_numerics(Table(*numerics, file), sweep.common.numerics);
  if (const auto* time = table.subtable("time")) read_time(Table(*time, file), sweep.common.time);
  if (!(sweep.common.time.discard < sweep.common.time.duration))
    table.fail(fmt::format("time: discard = {} must be below duration = {}", sweep.common.time.discard, sweep.common.time.duration));
}

/// Mesh and motion, which belong to one sweep.
void read_special(Table& table, const fs::path& file, Sweep& sweep) {
  CaseSpec& spec = sweep.common;
  const bool transition = spec.flow_model == "k_omega_sst_lm";
  std::string mesher = transition ? "o_grid" : "polyhedra", air = "box";
  table.word("mesher", mesher, {"polyhedra", "octree", "o_grid"});
  table.word("air", air, {"box", "round"});
  table.flag("turn_wind", spec.turn_wind);
  table.flag("half_model", spec.half_model);
  table.word("spin", spec.spin.axis);
  table.number("spin_ratio", spec.spin.ratio, 1e-3, 1000.0);
  table.flag("chain", sweep.chain);
  table.word("start", sweep.start);
  if (mesher == "octree") spec.recipe = octree_recipe();
  if (mesher == "o_grid") spec.recipe = o_grid_recipe();
  int seed = 0;
  table.integer("mesh_seed", seed, 0, 1000000);
  spec.recipe.seed = seed;
  table.integer("mesh_seeds", sweep.seeds, 1, 1000);
  if (sweep.seeds > 0 && (seed != 0 || !spec.variant.empty() || sweep.chain))
    table.fail("mesh_seeds makes the variants seed-1, seed-2, ... by itself: leave out mesh_seed, variant and chain");
  const bool spins = !spec.spin.axis.empty();
  if (spins && (spec.spin.axis.find_first_not_of("xyz") != std::string::npos || spec.spin.direction().isZero()))
    table.fail(fmt::format("spin = \"{}\" is no axis: use \"x\", \"z\", \"xy\", \"xyz\", ...", spec.spin.axis));
  if (!spins && spec.spin.ratio > 0.0) table.fail("spin_ratio needs spin = \"x\", \"z\", \"xyz\", ...");
  if (spins && mesher == "octree") table.fail("a spinning body needs a round mesh: mesher = \"polyhedra\"");
  if (mesher == "o_grid" && (spins || spec.turn_wind || air == "round"))
    table.fail("an O-grid is round, stands in the wind, and is for bodies at rest: leave out air, turn_wind and spin");
  if (transition && mesher != "o_grid") table.fail("k_omega_sst_lm needs layers at the wall that only mesher = \"o_grid\" has");
  // A box of air has an inlet, which must face the wind; a ball may turn.
  if (air == "round" || spins || (spec.turn_wind && mesher != "octree")) spec.recipe.far_radius = 8.0;
  const MeshRecipe usual = spec.recipe;
  if (const auto* recipe = table.subtable("recipe")) read_recipe(Table(*recipe, file), spec.recipe);
  // The usual case of that name would otherwise be replaced in the files of results.
  const bool unusual = to_json(spec.recipe) != to_json(usual) || spec.numerics != numerics_of(spec.flow_model) || spec.turn_wind ||
                       !spec.half_model || air == "round" || seed != 0 || spec.stop.min_iterations != StopPolicy{}.min_iterations;
  if (unusual && spec.variant.empty())
    table.fail(
        "numerics, recipe, air, turn_wind, half_model, mesh_seed and min_iterations need variant = \"word\", which tells the cases from "
        "the usual ones");
  if (std::holds_alternative<dragcore::MeshBody>(spec.shape) &&
      (mesher != "polyhedra" || air == "round" || spec.turn_wind || spins || seed != 0 || sweep.seeds != 0))
    table.fail(
        "a body of shape = \"mesh\" is solved at rest, meshed by snappyHexMesh in a box of air: leave out mesher, "
        "air, turn_wind, spin, mesh_seed, mesh_seeds");
  for (const std::string& level : sweep.levels) try {
      MeshRecipe recipe = spec.recipe;
      recipe.refinement = refinement_of(level, spec.octree());
      if (spec.octree()) OctreeSizes(spec.shape, recipe, Symmetry::none);  // does it fit?
      if (spec.o_grid()) o_grid_cells(spec.shape, recipe, Symmetry::none);
    } catch (const std::invalid_argument& error) {
      table.fail(error.what());
    }
}

/// The triangles of a file, relative to the matrix; the body's name is that of the file.
dragcore::Shape read_mesh_body(Table& table, const fs::path& matrix) {
  std::string file;
  double area = 0.0, length = 0.0;
  table.word("file", file);
  table.number("reference_area", area, 1e-12, 1e12);
  table.number("reference_length", length, 1e-6, 1e6);
  if (file.empty()) table.fail("shape = \"mesh\" needs file = \"body.stl\", relative to the matrix");
  if (area == 0.0 || length == 0.0)
    table.fail(
        "shape = \"mesh\" needs reference_area [m2] and reference_length [m], the denominators of its coefficients and Reynolds number");
  try {
    return dragcore::mesh_body(fs::path(file).stem().string(), dragcore::read_mesh(matrix.parent_path() / file), area, length);
  } catch (const std::exception& error) {
    table.fail(*table.find("file"), error.what());
  }
}

dragcore::Shape read_shape(Table& table, const toml::table& sweep, const fs::path& matrix) {
  std::string kind;
  table.word("shape", kind);
  if (kind.empty()) table.fail(sweep, "a sweep needs shape = \"plate\", \"box\", \"cone\", ..., or \"mesh\" with a file");
  if (kind == "mesh") return read_mesh_body(table, matrix);
  std::map<std::string, double> parameters;
  const auto* node = table.find("parameters");
  if (node && !node->is_table()) table.fail(*node, "parameters must be a table, such as { diameter = 1, length = 3 }");
  if (node)
    for (const auto& [key, value] : *node->as_table()) {
      if (!value.is_number()) table.fail(value, fmt::format("parameter {} must be a number", key.str()));
      parameters[std::string(key.str())] = *value.value<double>();
    }
  try {
    dragcore::Shape shape = dragcore::make_shape(kind, parameters);
    dragcore::properties(shape);  // checks the ranges
    if (const auto* plate = std::get_if<dragcore::Plate>(&shape); plate && plate->thickness < 0.02 * std::min(plate->chord, plate->span))
      throw std::invalid_argument(fmt::format(
          "plate: thickness = {} cannot be meshed; needed at least 0.02 of its shorter side (0.05 is proven)", plate->thickness));
    return shape;
  } catch (const std::invalid_argument& error) {
    table.fail(node ? *node : static_cast<const toml::node&>(sweep), error.what());
  }
}

/// The case that a sweep names as its start: one of an earlier sweep.
std::shared_ptr<const CaseSpec> started_by(const Sweep& sweep, const Table& table, const Matrix& matrix) {
  if (sweep.start.empty()) return nullptr;
  for (const CaseSpec& spec : matrix.cases)
    if (spec.name == sweep.start) return std::make_shared<const CaseSpec>(spec);
  table.fail(fmt::format("start = \"{}\" is no case of an earlier sweep", sweep.start));
}

std::string angle_text(double degrees) {
  std::string digits = fmt::format("{:g}", std::abs(degrees));
  const auto whole = std::min(digits.find('.'), digits.size());
  if (whole < 3) digits.insert(0, 3 - whole, '0');
  return (degrees < 0.0 ? "n" : "") + digits;
}

/// 100000 -> "1e5", 250 -> "2.5e2"
std::string reynolds_text(double reynolds) {
  const int exponent = static_cast<int>(std::floor(std::log10(reynolds) + 1e-12));
  return fmt::format("{:g}e{}", reynolds / std::pow(10.0, exponent), exponent);
}

}  // namespace

Numerics numerics_of(const std::string& flow_model) {
  if (flow_model != "k_omega_sst_lm") return {};
  return {.relaxation_velocity = 0.8, .relaxation_pressure = 0.7, .turbulence_intensity = 0.001, .viscosity_ratio = 1.0, .wall = "low_re"};
}

StopPolicy stop_policy_of(const std::string& flow_model) {
  StopPolicy policy;
  if (flow_model == "k_omega_sst_lm") policy.mean_error = 0.03;
  return policy;
}

Eigen::Vector3d Spin::direction() const {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const char letter : axis)
    if (letter >= 'x' && letter <= 'z') sum[letter - 'x'] += 1.0;
  return sum.normalized();
}

dragcore::Pose PoseDegrees::radians() const {
  constexpr double radian = std::numbers::pi / 180.0;
  return {.incidence = incidence * radian, .yaw = yaw * radian, .roll = roll * radian};
}

std::string case_name(const CaseSpec& spec) {
  std::string name = dragcore::kind(spec.shape);
  for (const auto& [parameter, value] : dragcore::changed_parameters(spec.shape)) name += fmt::format("-{}-{:g}", parameter, value);
  const bool turned = spec.pose.yaw != 0.0 || spec.pose.roll != 0.0 || spec.spin.in_still_air();
  if (spec.pose.incidence != 0.0 || !turned) name += "_incidence-" + angle_text(spec.pose.incidence);
  if (spec.pose.yaw != 0.0) name += "_yaw-" + angle_text(spec.pose.yaw);
  if (spec.pose.roll != 0.0) name += "_roll-" + angle_text(spec.pose.roll);
  if (!spec.spin.axis.empty()) name += "_spin-" + spec.spin.axis + (spec.spin.ratio > 0.0 ? fmt::format("-{:g}", spec.spin.ratio) : "");
  name += "_re-" + reynolds_text(spec.reynolds);
  if (spec.laminar()) name += "-laminar";
  if (spec.flow_model == "laminar_unsteady") name += "-unsteady";
  if (spec.flow_model == "k_omega_sst_ddes") name += "-ddes";
  if (spec.flow_model == "k_omega_sst_lm") name += "-lm";
  if (spec.octree()) name += "_octree";
  if (spec.o_grid()) name += "_o-grid";
  name += "_" + spec.mesh_level;
  if (!spec.variant.empty()) name += "_" + spec.variant;
  return name;
}

Matrix parse_matrix(std::string_view text, const fs::path& file) {
  toml::table root;
  try {
    root = toml::parse(text, file.string());
  } catch (const toml::parse_error& error) {
    Table::fail(file, error.source(), std::string(error.description()));
  }
  Matrix matrix{.tier = file.stem().string(), .file = file, .cases = {}};
  Table top(root, file);
  top.word("tier", matrix.tier);
  Sweep defaults;
  if (const auto* node = top.find("defaults")) {
    if (!node->is_table()) top.fail(*node, "defaults must be a table");
    Table table(*node->as_table(), file);
    read_common(table, file, defaults);
    table.reject_unknown("[defaults]");
  }
  const auto* sweeps = top.find("sweep");
  top.reject_unknown("the matrix");
  if (!sweeps || !sweeps->is_array_of_tables())
    top.fail(sweeps ? *sweeps : static_cast<const toml::node&>(root), "a matrix needs at least one [[sweep]]");

  std::map<std::string, toml::source_position> seen;
  for (const auto& node : *sweeps->as_array()) {
    const toml::table& entry = *node.as_table();
    Table table(entry, file);
    Sweep sweep = defaults;
    sweep.common.tier = matrix.tier;
    sweep.common.shape = read_shape(table, entry, file);
    table.word("variant", sweep.common.variant);
    read_common(table, file, sweep);
    read_special(table, file, sweep);
    if (entry.contains("time") && !sweep.common.time_accurate())
      table.fail(fmt::format(
          "time belongs to what is solved in time, and flow_model = \"{}\" is steady: use laminar_unsteady, k_omega_sst_ddes or spin_ratio",
          sweep.common.flow_model));
    table.reject_unknown("[[sweep]]");
    for (const auto& level : sweep.levels)
      for (const double reynolds : sweep.reynolds) {
        std::shared_ptr<const CaseSpec> before = started_by(sweep, table, matrix);
        for (const double roll : sweep.roll)
          for (const double yaw : sweep.yaw)
            for (const double incidence : sweep.incidence)
              for (int seed = sweep.seeds > 0 ? 1 : 0; seed <= sweep.seeds; ++seed) {
                CaseSpec spec = sweep.common;
                spec.mesh_level = level;
                spec.reynolds = reynolds;
                spec.recipe = recipe_for(spec.recipe, spec.shape, reynolds);
                spec.pose = {incidence, yaw, roll};
                if (seed > 0) spec.recipe.seed = seed, spec.variant = fmt::format("seed-{}", seed);
                spec.name = case_name(spec);
                const auto [other, is_new] = seen.emplace(spec.name, node.source().begin);
                if (!is_new)
                  table.fail(node, fmt::format("case {} is there already, from line {}; take it out of one sweep, or give one a `variant`",
                                               spec.name, other->second.line));
                spec.start = before;
                if (sweep.chain) before = std::make_shared<const CaseSpec>(spec);
                matrix.cases.push_back(std::move(spec));
              }
      }
  }
  return matrix;
}

Matrix load_matrix(const std::string& name) {
  std::vector<fs::path> places{name};
  if (name.find('/') == std::string::npos && !name.ends_with(".toml")) {
    places = {fs::path(CFD_CASES_SOURCE_DIR) / "matrices" / (name + ".toml"), fs::path("cfd_cases/matrices") / (name + ".toml")};
  }
  for (const auto& place : places) {
    std::ifstream file(place);
    if (!file) continue;
    std::ostringstream text;
    text << file.rdbuf();
    return parse_matrix(text.str(), place);
  }
  std::vector<std::string> looked;
  for (const auto& place : places) looked.push_back(place.string());
  throw ConfigurationError(fmt::format("{}:0:0: no such matrix; give a file or one of smoke, quick, reference (looked for {})", name,
                                       fmt::join(looked, " and ")));
}

}  // namespace cfd_cases
