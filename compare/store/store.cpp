#include "compare/store/store.hpp"

#include <fmt/format.h>
#include <openssl/evp.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <functional>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>
#include <stdexcept>
#include <type_traits>

#include "compare/store/hdf5.hpp"

namespace compare {
namespace {

using hdf5::Handle;
using hdf5::Meaning;
using hdf5::Number;
using hdf5::Table;
using nlohmann::json;

// Major: readers of an older one would misread. Minor: columns were added (1), the meshes of bodies that are given by triangles (2), what an
// experiment knows and how well (3).
constexpr int schema_major = 1;
constexpr int schema_minor = 3;
const std::string schema_version = fmt::format("{}.{}", schema_major, schema_minor);
constexpr const char* run_schema = "dragval run";
constexpr const char* reference_schema = "dragval reference";

/// A column of numbers of the table of cases: where it is in a CaseRecord and what it means.
struct NumberColumn {
  std::string name;
  Meaning meaning;
  Number number = Number::real;
  Eigen::Index width = 1;
  std::function<void(const CaseRecord&, double*)> get;
  std::function<void(CaseRecord&, const double*)> set;
  int since = 0;  ///< minor version of the schema that brought it; older files have the value of a new record
};

/// @param field  generic accessor: returns a reference to a number or an Eigen vector of a record
template <class Field>
NumberColumn numbers(std::string name, Meaning meaning, Field field) {
  using Value = std::remove_cvref_t<decltype(field(std::declval<CaseRecord&>()))>;
  NumberColumn column{std::move(name), std::move(meaning), Number::real, 1, {}, {}};
  if constexpr (std::is_arithmetic_v<Value>) {
    column.number = std::is_integral_v<Value> ? Number::integer : Number::real;
    column.get = [field](const CaseRecord& record, double* out) { *out = static_cast<double>(field(record)); };
    column.set = [field](CaseRecord& record, const double* in) { field(record) = static_cast<Value>(*in); };
  } else {
    column.width = Value::RowsAtCompileTime;
    column.get = [field](const CaseRecord& record, double* out) { Eigen::Map<Value>{out} = field(record); };
    column.set = [field](CaseRecord& record, const double* in) { field(record) = Eigen::Map<const Value>(in); };
  }
  return column;
}

NumberColumn since(int minor, NumberColumn column) {
  column.since = minor;
  return column;
}

template <class Field>
NumberColumn degrees(std::string name, std::string long_name, Field field) {
  constexpr double deg = std::numbers::pi / 180.0;
  // Rounded to 1e-9 deg, so that a pose read and written again stays the same number.
  return {std::move(name),
          {"deg", std::move(long_name), "", ""},
          Number::real,
          1,
          [field](const CaseRecord& record, double* out) { *out = std::round(field(record) / deg * 1e9) / 1e9; },
          [field](CaseRecord& record, const double* in) { field(record) = *in * deg; }};
}

const std::vector<NumberColumn>& number_columns() {
  static const std::vector<NumberColumn> columns = {
      degrees(
          "incidence", "incidence, positive lifts the nose", [](auto& r) -> auto& { return r.pose.incidence; }),
      degrees(
          "yaw", "yaw, right-handed about z", [](auto& r) -> auto& { return r.pose.yaw; }),
      degrees(
          "roll", "roll, right-handed about x", [](auto& r) -> auto& { return r.pose.roll; }),
      numbers(
          "reynolds", {"1", "Reynolds number on the reference length", "", ""}, [](auto& r) -> auto& { return r.reynolds; }),
      numbers(
          "density", {"kg m-3", "density of the air", "", ""}, [](auto& r) -> auto& { return r.density; }),
      numbers(
          "speed", {"m s-1", "speed of the coefficients: of the undisturbed air, in still air |omega| L_ref", "", ""},
          [](auto& r) -> auto& { return r.speed; }),
      since(1, numbers(
                   "still_air", {"1", "1: there is no wind", "", ""}, [](auto& r) -> auto& { return r.still_air; })),
      since(1, numbers(
                   "angular_velocity", {"rad s-1", "of the body, about its centroid", "wind", ""},
                   [](auto& r) -> auto& { return r.angular_velocity; })),
      numbers(
          "viscosity", {"m2 s-1", "kinematic viscosity", "", ""}, [](auto& r) -> auto& { return r.viscosity; }),
      numbers(
          "held_out", {"1", "1: not to be used for fitting", "", ""}, [](auto& r) -> auto& { return r.held_out; }),
      numbers(
          "force_pressure", {"N", "mean pressure force of the air on the body", "wind", "force_uncertainty"},
          [](auto& r) -> auto& { return r.load.force_pressure; }),
      numbers(
          "force_viscous", {"N", "mean viscous force of the air on the body", "wind", "force_uncertainty"},
          [](auto& r) -> auto& { return r.load.force_viscous; }),
      numbers(
          "moment_pressure", {"N m", "mean moment of the pressure about the centroid", "wind", "moment_uncertainty"},
          [](auto& r) -> auto& { return r.load.moment_pressure; }),
      numbers(
          "moment_viscous", {"N m", "mean moment of the viscous stress about the centroid", "wind", "moment_uncertainty"},
          [](auto& r) -> auto& { return r.load.moment_viscous; }),
      numbers(
          "last_force_pressure", {"N", "pressure force at the last iteration", "wind", ""},
          [](auto& r) -> auto& { return r.load_last.force_pressure; }),
      numbers(
          "last_force_viscous", {"N", "viscous force at the last iteration", "wind", ""},
          [](auto& r) -> auto& { return r.load_last.force_viscous; }),
      numbers(
          "last_moment_pressure", {"N m", "moment of the pressure at the last iteration", "wind", ""},
          [](auto& r) -> auto& { return r.load_last.moment_pressure; }),
      numbers(
          "last_moment_viscous", {"N m", "moment of the viscous stress at the last iteration", "wind", ""},
          [](auto& r) -> auto& { return r.load_last.moment_viscous; }),
      numbers(
          "u_iteration", {"N; N m", "standard uncertainty by remaining drift, of (F_x, F_y, F_z, M_x, M_y, M_z)", "wind", ""},
          [](auto& r) -> auto& { return r.u_iteration; }),
      numbers(
          "u_statistical", {"N; N m", "standard error of the mean of an oscillating flow, of (F, M)", "wind", ""},
          [](auto& r) -> auto& { return r.u_statistical; }),
      numbers(
          "u_null", {"N; N m", "size of the channels that symmetry says are zero, of (F, M)", "wind", ""},
          [](auto& r) -> auto& { return r.u_null; }),
      since(3, numbers(
                   "u_stated", {"N; N m", "standard uncertainty of an experiment, of (F, M)", "wind", ""},
                   [](auto& r) -> auto& { return r.u_stated; })),
      since(3, {"known",
                {"1", "1: this channel of (F, M) is known; 0: nobody measured it, and its 0 means nothing", "wind", ""},
                Number::integer,
                6,
                [](const CaseRecord& r, double* out) { std::copy(r.known.begin(), r.known.end(), out); },
                [](CaseRecord& r, const double* in) { std::transform(in, in + 6, r.known.begin(), [](double k) { return k != 0.0; }); }}),
      numbers(
          "half_model", {"1", "1: solved with a symmetry plane, loads doubled", "", ""}, [](auto& r) -> auto& { return r.half_model; }),
      numbers(
          "iterations", {"1", "iterations of the solver over all attempts", "", ""}, [](auto& r) -> auto& { return r.iterations; }),
      numbers(
          "averaged_over", {"1", "iterations in the averaging window", "", ""}, [](auto& r) -> auto& { return r.averaged_over; }),
      numbers(
          "cells", {"1", "cells of the mesh as solved", "", ""}, [](auto& r) -> auto& { return r.cells; }),
      numbers(
          "surface_area", {"m2", "area of the wall as meshed, whole body", "", ""}, [](auto& r) -> auto& { return r.surface_area; }),
      numbers(
          "surface_volume", {"m3", "volume enclosed by the wall as meshed", "", ""}, [](auto& r) -> auto& { return r.surface_volume; }),
  };
  return columns;
}

std::string checksum_text(const dragcore::MeshBody& body) { return fmt::format("{:016x}", body.checksum); }

struct WordColumn {
  std::string name;
  std::string long_name;
  std::function<std::string(const CaseRecord&)> get;
  std::function<void(CaseRecord&, const std::string&)> set;
};

template <class Field>
WordColumn words(std::string name, std::string long_name, Field field) {
  return {std::move(name), std::move(long_name), [field](const CaseRecord& r) -> std::string { return field(r); },
          [field](CaseRecord& r, const std::string& word) { field(r) = word; }};
}

json attempts_to_json(const std::vector<case_record::Attempt>& attempts) {
  json list = json::array();
  for (const auto& attempt : attempts)
    list.push_back({{"recipe", attempt.recipe}, {"status", case_record::to_string(attempt.status)}, {"reason", attempt.reason}});
  return list;
}

std::vector<case_record::Attempt> attempts_from_json(const json& list) {
  std::vector<case_record::Attempt> attempts;
  for (const json& entry : list) attempts.push_back({entry.at("recipe"), case_record::status_from(entry.at("status")), entry.at("reason")});
  return attempts;
}

const std::vector<WordColumn>& word_columns() {
  static const std::vector<WordColumn> columns = {
      words(
          "name", "case, named by the matrix", [](auto& r) -> auto& { return r.name; }),
      words(
          "key", "SHA-256 of the description", [](auto& r) -> auto& { return r.key; }),
      words(
          "description", "canonical JSON of all that determines the result", [](auto& r) -> auto& { return r.description; }),
      words(
          "source", "what made the reference", [](auto& r) -> auto& { return r.source; }),
      words(
          "tier", "matrix that asked for the case", [](auto& r) -> auto& { return r.tier; }),
      // These two make one value: read_cases() puts them together.
      {"shape", "kind of shape", [](const CaseRecord& r) { return dragcore::kind(r.shape); }, [](CaseRecord&, const std::string&) {}},
      {"shape_parameters", "JSON; lengths in m, angles in deg; of a body in meshes what it measures",
       [](const CaseRecord& r) { return json(dragcore::parameters(r.shape)).dump(); }, [](CaseRecord&, const std::string&) {}},
      words(
          "flow_model", "laminar or turbulence model", [](auto& r) -> auto& { return r.flow_model; }),
      words(
          "mesh_level", "coarse, medium, fine, finest", [](auto& r) -> auto& { return r.mesh_level; }),
      {"status", "how the case ended", [](const CaseRecord& r) { return case_record::to_string(r.status); },
       [](CaseRecord& r, const std::string& word) { r.status = case_record::status_from(word); }},
      words(
          "reason", "why the case is not usable; empty when it is", [](auto& r) -> auto& { return r.reason; }),
      {"attempts", "JSON list of tries: recipe, status, reason", [](const CaseRecord& r) { return attempts_to_json(r.attempts).dump(); },
       [](CaseRecord& r, const std::string& word) { r.attempts = attempts_from_json(json::parse(word)); }},
      {"mesh_quality", "JSON, of checkMesh", [](const CaseRecord& r) { return json(r.mesh_quality).dump(); },
       [](CaseRecord& r, const std::string& word) { r.mesh_quality = json::parse(word).get<std::map<std::string, double>>(); }},
      {"surface_checksum", "FNV-1a of the triangles of the shape; names the group in meshes of a body that is given by them",
       [](const CaseRecord& r) {
         const auto* body = std::get_if<dragcore::MeshBody>(&r.shape);
         return body ? checksum_text(*body) : r.surface_checksum;
       },
       [](CaseRecord& r, const std::string& word) { r.surface_checksum = word; }},
      {"tools", "JSON, versions", [](const CaseRecord& r) { return json(r.tools).dump(); },
       [](CaseRecord& r, const std::string& word) { r.tools = json::parse(word).get<std::map<std::string, std::string>>(); }},
      words(
          "finished", "UTC, ISO 8601", [](auto& r) -> auto& { return r.finished; }),
  };
  return columns;
}

/// Usable cases hold finite numbers only; whatever a diverged one left behind becomes 0.
void fill(const NumberColumn& column, const CaseRecord& record, double* row) {
  column.get(record, row);
  for (Eigen::Index k = 0; k < column.width; ++k) {
    if (std::isfinite(row[k])) continue;
    if (case_record::is_usable(record.status))
      throw std::invalid_argument(fmt::format("{}: '{}' is {} though its status is {}; a usable case needs finite numbers", record.name,
                                              column.name, row[k], case_record::to_string(record.status)));
    row[k] = 0.0;
  }
}

/// Everything about the cases, ready to be written or hashed.
struct CaseTable {
  std::vector<std::pair<const NumberColumn*, Table>> numbers;
  std::vector<std::pair<const WordColumn*, std::vector<std::string>>> words;
  std::vector<std::pair<std::string, Table>> costs;  ///< per stage: CPU and wall seconds
};

/// @param minor  of the schema: columns that came later are left out
CaseTable tabulate(const std::vector<CaseRecord>& cases, int minor = schema_minor) {
  CaseTable table;
  const auto rows = static_cast<Eigen::Index>(cases.size());
  for (const NumberColumn& column : number_columns()) {
    if (column.since > minor) continue;
    Table values(rows, column.width);
    for (Eigen::Index i = 0; i < rows; ++i) fill(column, cases[static_cast<std::size_t>(i)], values.row(i).data());
    table.numbers.emplace_back(&column, std::move(values));
  }
  for (const WordColumn& column : word_columns()) {
    std::vector<std::string> list;
    for (const CaseRecord& record : cases) list.push_back(column.get(record));
    table.words.emplace_back(&column, std::move(list));
  }
  std::set<std::string> stages;
  for (const CaseRecord& record : cases)
    for (const auto& [stage, cost] : record.cost) stages.insert(stage);
  for (const std::string& stage : stages) {
    Table seconds = Table::Zero(rows, 2);
    for (Eigen::Index i = 0; i < rows; ++i)
      if (const auto& cost = cases[static_cast<std::size_t>(i)].cost; cost.contains(stage))
        seconds.row(i) << cost.at(stage).cpu_s, cost.at(stage).wall_s;
    table.costs.emplace_back(stage, std::move(seconds));
  }
  return table;
}

void write_cases(const Handle& file, const std::vector<CaseRecord>& cases) {
  const CaseTable table = tabulate(cases);
  const Handle group = hdf5::create_group(file, "cases");
  for (const auto& [column, list] : table.words) hdf5::write(group, column->name, list, {"none", column->long_name, "", ""});
  for (const auto& [column, values] : table.numbers) hdf5::write(group, column->name, values, column->meaning, column->number);

  // Derived, so that a reader needs none of our formulas: the denominators of the coefficients and what is known of their uncertainty.
  Table reference(static_cast<Eigen::Index>(cases.size()), 2), known(static_cast<Eigen::Index>(cases.size()), 6);
  for (Eigen::Index i = 0; i < reference.rows(); ++i) {
    const CaseRecord& record = cases[static_cast<std::size_t>(i)];
    const dragcore::ShapeProperties body = dragcore::properties(record.shape);
    reference.row(i) << body.reference_area, body.reference_length;
    known.row(i) = record.own_variance().cwiseSqrt();
    if (!known.row(i).allFinite()) known.row(i).setZero();
  }
  hdf5::write(group, "reference_area", reference.col(0), {"m2", "A_ref of the coefficients", "", ""});
  hdf5::write(group, "reference_length", reference.col(1), {"m", "L_ref of the moment coefficients and of Re", "", ""});
  const std::string without = " (iteration, statistics, symmetry, or as an experiment states it; without discretisation)";
  hdf5::write(group, "force_uncertainty", known.leftCols(3), {"N", "standard uncertainty of the total force" + without, "wind", ""});
  hdf5::write(group, "moment_uncertainty", known.rightCols(3), {"N m", "standard uncertainty of the total moment" + without, "wind", ""});
  hdf5::label_rows(group, "name");

  const Handle costs = hdf5::create_group(group, "cost");
  for (const auto& [stage, seconds] : table.costs) {
    hdf5::write(costs, stage + "_cpu", seconds.col(0), {"s", "user and system time of stage " + stage + "; 0: not run", "", ""});
    hdf5::write(costs, stage + "_wall", seconds.col(1), {"s", "wall time of stage " + stage + "; 0: not run", "", ""});
  }
}

/// The distinct bodies among the cases that are given by triangles, by checksum.
std::map<std::string, const dragcore::MeshBody*> meshes_of(const std::vector<CaseRecord>& cases) {
  std::map<std::string, const dragcore::MeshBody*> meshes;
  for (const CaseRecord& record : cases)
    if (const auto* body = std::get_if<dragcore::MeshBody>(&record.shape)) meshes[checksum_text(*body)] = body;
  return meshes;
}

Table vertices_of(const dragcore::TriangleMesh& mesh) {
  Table rows(static_cast<Eigen::Index>(mesh.vertices.size()), 3);
  for (Eigen::Index i = 0; i < rows.rows(); ++i) rows.row(i) = mesh.vertices[static_cast<std::size_t>(i)];
  return rows;
}

Table corners_of(const dragcore::TriangleMesh& mesh) {
  Table rows(static_cast<Eigen::Index>(mesh.triangles.size()), 3);
  for (Eigen::Index i = 0; i < rows.rows(); ++i) rows.row(i) = mesh.triangles[static_cast<std::size_t>(i)].cast<double>();
  return rows;
}

void write_meshes(const Handle& file, const std::vector<CaseRecord>& cases) {
  const Handle all = hdf5::create_group(file, "meshes");
  for (const auto& [checksum, body] : meshes_of(cases)) {
    const Handle group = hdf5::create_group(all, checksum);
    hdf5::write(group, "vertices", vertices_of(*body->mesh), {"m", "from the centroid", "body", ""});
    hdf5::write(group, "triangles", corners_of(*body->mesh), {"1", "rows of vertices, from 0; counterclockwise from outside", "", ""},
                Number::integer);
  }
}

dragcore::TriangleMesh read_triangles(const Handle& group) {
  dragcore::TriangleMesh mesh;
  const Table vertices = hdf5::read_table(group, "vertices"), triangles = hdf5::read_table(group, "triangles");
  if (vertices.cols() != 3 || triangles.cols() != 3)
    throw std::runtime_error("a mesh needs three coordinates a vertex and three corners a triangle");
  for (const auto& row : vertices.rowwise()) mesh.vertices.emplace_back(row.transpose());
  for (const auto& row : triangles.rowwise()) mesh.triangles.emplace_back(row.transpose().cast<int>());
  return mesh;
}

/// Bodies given by triangles are known by their checksum in `meshes`; all others are made of their parameters.
void read_shapes(const Handle& file, int minor, std::vector<CaseRecord>& cases) {
  const Handle group = hdf5::open_group(file, "cases");
  const auto kinds = hdf5::read_words(group, "shape"), parameters = hdf5::read_words(group, "shape_parameters");
  std::map<std::string, dragcore::TriangleMesh> meshes;
  if (minor >= 2) {
    const Handle all = hdf5::open_group(file, "meshes");
    for (const std::string& checksum : hdf5::members(all)) meshes[checksum] = read_triangles(hdf5::open_group(all, checksum));
  }
  for (std::size_t i = 0; i < cases.size(); ++i) {
    const auto of = json::parse(parameters[i]).get<std::map<std::string, double>>();
    const auto mesh = meshes.find(cases[i].surface_checksum);
    if (mesh == meshes.end()) {
      cases[i].shape = dragcore::make_shape(kinds[i], of);
      continue;
    }
    const auto body = dragcore::mesh_body(kinds[i], mesh->second, of.at("reference_area"), of.at("reference_length"));
    if (checksum_text(body) != mesh->first)
      throw std::runtime_error(fmt::format("the triangles of meshes/{} have the checksum {}", mesh->first, checksum_text(body)));
    cases[i].shape = body;
  }
}

int minor_version(const Handle& file) {
  const std::string version = hdf5::read_attribute(file, "schema_version");
  const std::size_t dot = version.find('.');
  return dot == std::string::npos ? 0 : std::atoi(version.c_str() + dot + 1);
}

std::vector<CaseRecord> read_cases(const Handle& file) {
  const int minor = minor_version(file);
  const Handle group = hdf5::open_group(file, "cases");
  std::vector<CaseRecord> cases(hdf5::read_words(group, "name").size());
  const auto check_rows = [&](const std::string& name, std::size_t rows, bool right_width = true) {
    if (rows != cases.size() || !right_width) throw std::runtime_error("dataset cases/" + name + " does not have the form of its table");
  };
  for (const WordColumn& column : word_columns()) {
    const auto list = hdf5::read_words(group, column.name);
    check_rows(column.name, list.size());
    for (std::size_t i = 0; i < list.size(); ++i) column.set(cases[i], list[i]);
  }
  read_shapes(file, minor, cases);
  for (const NumberColumn& column : number_columns()) {
    if (column.since > minor) continue;
    const Table values = hdf5::read_table(group, column.name);
    check_rows(column.name, static_cast<std::size_t>(values.rows()), values.cols() == column.width);
    for (std::size_t i = 0; i < cases.size(); ++i) column.set(cases[i], values.row(static_cast<Eigen::Index>(i)).data());
  }
  const Handle costs = hdf5::open_group(group, "cost");
  const std::string suffix = "_cpu";
  for (const std::string& name : hdf5::members(costs)) {
    if (!name.ends_with(suffix)) continue;
    const std::string stage = name.substr(0, name.size() - suffix.size());
    const Table cpu = hdf5::read_table(costs, name), wall = hdf5::read_table(costs, stage + "_wall");
    check_rows("cost/" + name, static_cast<std::size_t>(std::min(cpu.rows(), wall.rows())));
    for (std::size_t i = 0; i < cases.size(); ++i)
      if (const auto row = static_cast<Eigen::Index>(i); cpu(row) != 0.0 || wall(row) != 0.0) cases[i].cost[stage] = {cpu(row), wall(row)};
  }
  return cases;
}

Table rows_of(const Eigen::Matrix3Xd& columns) { return columns.transpose(); }

void write_surface(const Handle& file, const case_record::SurfaceSample& surface) {
  const Handle group = hdf5::create_group(file, "surface");
  if (surface.centre.cols() == 0) return;
  hdf5::write(group, "centre", rows_of(surface.centre), {"m", "centres of the faces of the wall (of the solved half)", "wind", ""});
  hdf5::write(group, "area_vector", rows_of(surface.area_vector), {"m2", "outward normal times area", "wind", ""});
  hdf5::write(group, "pressure_coefficient", surface.pressure_coefficient, {"1", "C_p at the last iteration", "", ""});
  hdf5::write(group, "friction_coefficient", rows_of(surface.friction_coefficient), {"1", "wall shear stress on the body / q", "wind", ""});
}

case_record::SurfaceSample read_surface(const Handle& file) {
  case_record::SurfaceSample surface;
  const Handle group = hdf5::open_group(file, "surface");
  if (!hdf5::exists(group, "centre")) return surface;
  surface.centre = hdf5::read_table(group, "centre").transpose();
  surface.area_vector = hdf5::read_table(group, "area_vector").transpose();
  surface.pressure_coefficient = hdf5::read_table(group, "pressure_coefficient");
  surface.friction_coefficient = hdf5::read_table(group, "friction_coefficient").transpose();
  return surface;
}

/// Columns of the patch table that are vectors or numbers of a PatchMean.
struct PatchColumn {
  std::string name;
  Meaning meaning;
  double* (*at)(PatchMean&);
  Eigen::Index width;
};

const std::vector<PatchColumn>& patch_columns() {
  static const std::vector<PatchColumn> columns = {
      {"area", {"m2", "area of the patch, whole body", "", ""}, [](PatchMean& p) { return &p.area; }, 1},
      {"centroid", {"m", "centroid of the patch", "body", ""}, [](PatchMean& p) { return p.centroid.data(); }, 3},
      {"area_vector", {"m2", "integral of the outward normal", "body", ""}, [](PatchMean& p) { return p.area_vector.data(); }, 3},
      {"pressure_coefficient", {"1", "mean C_p", "", ""}, [](PatchMean& p) { return &p.pressure_coefficient; }, 1},
      {"friction_coefficient",
       {"1", "mean C_f, stress of the air on the body", "body", ""},
       [](PatchMean& p) { return p.friction_coefficient.data(); },
       3},
      {"pressure_moment",
       {"m3", "integral of C_p (r - centroid) dA", "body", ""},
       [](PatchMean& p) { return p.pressure_moment.data(); },
       3},
      {"pressure_force",
       {"m2", "integral of -C_p n dA: pressure force / q", "body", ""},
       [](PatchMean& p) { return p.pressure_force.data(); },
       3},
  };
  return columns;
}

struct PatchTable {
  Table case_index;
  std::vector<std::string> names;
  std::vector<Table> columns;
};

PatchTable tabulate_patches(const std::vector<std::vector<PatchMean>>& patches) {
  std::size_t rows = 0;
  for (const auto& of_case : patches) rows += of_case.size();
  PatchTable table{Table(static_cast<Eigen::Index>(rows), 1), {}, {}};
  for (const PatchColumn& column : patch_columns()) table.columns.emplace_back(static_cast<Eigen::Index>(rows), column.width);
  Eigen::Index row = 0;
  for (std::size_t i = 0; i < patches.size(); ++i)
    for (PatchMean patch : patches[i]) {
      table.case_index(row) = static_cast<double>(i);
      table.names.push_back(patch.name);
      for (std::size_t k = 0; k < table.columns.size(); ++k)
        table.columns[k].row(row) = Eigen::Map<const Eigen::RowVectorXd>(patch_columns()[k].at(patch), patch_columns()[k].width);
      ++row;
    }
  return table;
}

void write_patches(const Handle& file, const std::vector<std::vector<PatchMean>>& patches) {
  const Handle group = hdf5::create_group(file, "patches");
  const PatchTable table = tabulate_patches(patches);
  if (table.names.empty()) return;
  hdf5::write(group, "case_index", table.case_index, {"1", "row of the case in the table of cases, from 0", "", ""}, Number::integer);
  hdf5::write(group, "name", table.names, {"none", "planar face, or bin of the curved part", "", ""});
  for (std::size_t k = 0; k < table.columns.size(); ++k)
    hdf5::write(group, patch_columns()[k].name, table.columns[k], patch_columns()[k].meaning);
}

std::vector<std::vector<PatchMean>> read_patches(const Handle& file, std::size_t cases) {
  std::vector<std::vector<PatchMean>> patches(cases);
  const Handle group = hdf5::open_group(file, "patches");
  if (!hdf5::exists(group, "name")) return patches;
  const auto names = hdf5::read_words(group, "name");
  const Table case_index = hdf5::read_table(group, "case_index");
  std::vector<PatchMean> rows(names.size());
  for (const PatchColumn& column : patch_columns()) {
    const Table values = hdf5::read_table(group, column.name);
    if (values.rows() != static_cast<Eigen::Index>(rows.size()) || values.cols() != column.width || case_index.rows() != values.rows())
      throw std::runtime_error("dataset patches/" + column.name + " does not have the form of its table");
    for (std::size_t i = 0; i < rows.size(); ++i)
      Eigen::Map<Eigen::RowVectorXd>(column.at(rows[i]), column.width) = values.row(static_cast<Eigen::Index>(i));
  }
  for (std::size_t i = 0; i < rows.size(); ++i) {
    rows[i].name = names[i];
    patches.at(static_cast<std::size_t>(case_index(static_cast<Eigen::Index>(i)))).push_back(rows[i]);
  }
  return patches;
}

/// SHA-256 of all values: says whether two references hold the same, whatever version of HDF5 wrote them.
std::string content_digest(const Reference& reference, int minor = schema_minor) {
  const std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> digest(EVP_MD_CTX_new(), EVP_MD_CTX_free);
  EVP_DigestInit_ex(digest.get(), EVP_sha256(), nullptr);
  const auto add = [&](const void* bytes, std::size_t size) { EVP_DigestUpdate(digest.get(), bytes, size); };
  const auto add_table = [&](const std::string& name, const Table& values) {
    add(name.c_str(), name.size() + 1);
    add(values.data(), static_cast<std::size_t>(values.size()) * sizeof(double));
  };
  const auto add_words = [&](const std::vector<std::string>& list) {
    for (const std::string& word : list) add(word.c_str(), word.size() + 1);
  };
  const CaseTable cases = tabulate(reference.cases, minor);
  for (const auto& [column, values] : cases.numbers) add_table(column->name, values);
  for (const auto& [column, list] : cases.words) add_words(list);
  for (const auto& [stage, seconds] : cases.costs) add_table(stage, seconds);
  for (const auto& [checksum, body] : meshes_of(reference.cases)) {
    add_table(checksum, vertices_of(*body->mesh));
    add_table(checksum, corners_of(*body->mesh));
  }
  const PatchTable patches = tabulate_patches(reference.patches);
  add_table("case_index", patches.case_index);
  add_words(patches.names);
  for (std::size_t k = 0; k < patches.columns.size(); ++k) add_table(patch_columns()[k].name, patches.columns[k]);
  unsigned char hash[EVP_MAX_MD_SIZE];
  unsigned length = 0;
  EVP_DigestFinal_ex(digest.get(), hash, &length);
  std::string hex;
  for (unsigned i = 0; i < length; ++i) hex += fmt::format("{:02x}", hash[i]);
  return hex;
}

std::string utc_now() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text;
}

/// Names the file in errors that only know a dataset, and in those of a table that was damaged inside.
template <class Read>
auto read_file(const std::filesystem::path& path, const char* schema, Read read) {
  const std::scoped_lock lock(hdf5::library_mutex());
  const Handle file = hdf5::open_file(path, schema, schema_major);
  try {
    return read(file);
  } catch (const std::exception& error) {
    throw std::runtime_error(path.string() + " is damaged: " + error.what() +
                             "; restore it from version control, or delete it and run again");
  }
}

}  // namespace

void write_run(const std::filesystem::path& path, const CaseRecord& record) {
  const std::scoped_lock lock(hdf5::library_mutex());
  hdf5::write_file(path, run_schema, schema_version, [&](const Handle& file) {
    write_cases(file, {record});
    write_meshes(file, {record});
    write_surface(file, record.surface);
  });
}

CaseRecord read_run(const std::filesystem::path& path) {
  return read_file(path, run_schema, [](const Handle& file) {
    std::vector<CaseRecord> cases = read_cases(file);
    if (cases.size() != 1) throw std::runtime_error(fmt::format("it holds {} cases, a run holds 1", cases.size()));
    cases.front().surface = read_surface(file);
    return std::move(cases.front());
  });
}

std::vector<CaseRecord> read_runs(const std::filesystem::path& folder) {
  std::vector<CaseRecord> runs;
  if (!std::filesystem::is_directory(folder)) return runs;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (entry.path().extension() == ".h5") runs.push_back(read_run(entry.path()));
  std::sort(runs.begin(), runs.end(),
            [](const CaseRecord& a, const CaseRecord& b) { return std::tie(a.name, a.key) < std::tie(b.name, b.key); });
  return runs;
}

Reference read_reference(const std::filesystem::path& path) {
  return read_file(path, reference_schema, [](const Handle& file) {
    Reference reference{read_cases(file), {}};
    reference.patches = read_patches(file, reference.cases.size());
    // The digest of a newer file covers columns that are not known here.
    const int minor = minor_version(file);
    if (minor <= schema_minor && hdf5::read_attribute(file, "content_sha256") != content_digest(reference, minor))
      throw std::runtime_error("its values are not those that were written (content_sha256 does not fit them)");
    return reference;
  });
}

bool write_reference(const std::filesystem::path& path, const Reference& reference, const std::string& commit) {
  if (reference.cases.empty())
    throw std::invalid_argument("no cases to write to " + path.string() + "; run a matrix first: dragval run quick");
  if (reference.patches.size() != reference.cases.size())
    throw std::invalid_argument(
        fmt::format("{} cases but patches of {}; one entry per case is needed", reference.cases.size(), reference.patches.size()));
  const std::scoped_lock lock(hdf5::library_mutex());
  const std::string digest = content_digest(reference);
  // A file that is there but cannot be read is not ours to overwrite: open_file throws.
  if (std::filesystem::exists(path) &&
      hdf5::read_attribute(hdf5::open_file(path, reference_schema, schema_major), "content_sha256") == digest)
    return false;
  std::map<std::string, std::set<std::string>> tools;
  for (const CaseRecord& record : reference.cases)
    for (const auto& [tool, version] : record.tools) tools[tool].insert(version);
  hdf5::write_file(path, reference_schema, schema_version, [&](const Handle& file) {
    hdf5::write_attribute(file, "content_sha256", digest);
    hdf5::write_attribute(file, "created", utc_now());
    hdf5::write_attribute(file, "commit", commit);
    hdf5::write_attribute(file, "tools", json(tools).dump());
    hdf5::write_attribute(file, "conventions", "docs/conventions.md; wind frame: x downstream, y to starboard, z up; SI");
    write_cases(file, reference.cases);
    write_meshes(file, reference.cases);
    write_patches(file, reference.patches);
  });
  return true;
}

Reference merged(Reference into, const std::vector<CaseRecord>& runs) {
  struct Row {
    CaseRecord record;
    std::vector<PatchMean> patches;
    bool is_run = false;
  };
  std::map<std::string, Row> rows;
  for (std::size_t i = 0; i < into.cases.size(); ++i) {
    Row& row = rows[into.cases[i].name];  // on its own line: the right side of an assignment would move the name away first
    row = {std::move(into.cases[i]), std::move(into.patches.at(i)), false};
  }
  for (const CaseRecord& run : runs) {
    if (const auto found = rows.find(run.name); found != rows.end()) {
      const CaseRecord& row = found->second.record;
      const bool worse = row.key == run.key && case_record::is_usable(row.status) && !case_record::is_usable(run.status);
      const bool older = found->second.is_run && row.finished > run.finished;  // two recipes of one case in the cache: the later one counts
      if (worse || older) continue;
    }
    CaseRecord record = run;
    record.surface = {};
    rows[run.name] = {std::move(record), case_record::is_usable(run.status) ? patch_means(run) : std::vector<PatchMean>{}, true};
  }
  Reference result;
  for (auto& [name, row] : rows) {
    result.cases.push_back(std::move(row.record));
    result.patches.push_back(std::move(row.patches));
  }
  return result;
}

Reference at_rest(const Reference& reference) {
  Reference kept;
  for (std::size_t i = 0; i < reference.cases.size(); ++i) {
    if (reference.cases[i].spins()) continue;
    kept.cases.push_back(reference.cases[i]);
    kept.patches.push_back(reference.patches[i]);
  }
  return kept;
}

std::vector<CaseRecord> spinning(const std::vector<CaseRecord>& cases) {
  std::vector<CaseRecord> kept;
  std::copy_if(cases.begin(), cases.end(), std::back_inserter(kept), [](const CaseRecord& record) { return record.spins(); });
  return kept;
}

}  // namespace compare
