#include "compare/cli/calibrate_body.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <csignal>
#include <ctime>
#include <dragcore/calibrated_file.hpp>
#include <dragcore/mesh_file.hpp>
#include <fstream>
#include <iterator>
#include <numbers>
#include <set>
#include <sstream>

#include "cfd_cases/campaign/campaign.hpp"
#include "cfd_cases/flow_case/matrix.hpp"
#include "compare/calibration/residual_map.hpp"
#include "compare/calibration/symmetry.hpp"
#include "compare/cli/body.hpp"
#include "compare/cli/campaign_options.hpp"
#include "compare/reference/case_of_record.hpp"
#include "compare/reference/experiments.hpp"

namespace cli {

namespace {

namespace fs = std::filesystem;
using case_record::CaseRecord;
using Eigen::Vector3d;

using Records = std::vector<std::pair<CaseRecord, CaseRecord::Channels>>;

constexpr double degree = std::numbers::pi / 180.0;
constexpr double first_length = 0.7;  // of the kernel, before any force is known: 40 degrees

std::atomic<bool> stop_calibration = false;

std::string percent(double share) { return fmt::format("{:5.1f}", 100.0 * share); }

void print_row(const std::string& name, const compare::PoseErrors& e) {
  const std::string moment = e.moments > 0 ? percent(e.mean_moment) + " " + percent(e.worst_moment) : "    -     -";
  fmt::print("  {:<40} {} {}   {} {}   {}\n", name, percent(e.mean_force), percent(e.worst_force), percent(e.mean_drag),
             percent(e.worst_drag), moment);
}

std::string degrees_text(const dragcore::Pose& pose) {
  return fmt::format("incidence {:g}, yaw {:g}, roll {:g}", pose.incidence / degree, pose.yaw / degree, pose.roll / degree);
}

void print_table(const compare::ResidualFit& fit) {
  fmt::print("\nErrors in %, mean and worst                  force         C_D           moment\n");
  for (const compare::ModelErrors& model : fit.errors) {
    print_row(model.model + ", these poses", model.seen);
    if (model.unseen) print_row("  each pose left out", *model.unseen);
  }
  fmt::print(
      "Of the larger of the force and 0.3 of the mean force; moments about the centroid of the area also over L_ref. u of the references, "
      "without that of the method: {} % "
      "in the mean.\nForce: {}. Moment: {}.\n",
      percent(fit.mean_u), fit.force_choice, fit.moment_choice);
  if (!fit.pillow) {
    fmt::print("Pillow factor: that of the class; no moment tells.\n");
  } else {
    fmt::print("Pillow factor of this body: {:.2f}, {}\n", fit.pillow->value,
               fit.pillow->interval
                   ? fmt::format("95 % interval {:.2f} to {:.2f}", fit.pillow->interval->first, fit.pillow->interval->second)
                   : "at its bound: no interval");
  }
}

/// A model's file with where it is from.
void write_model(const std::string& file, const compare::ResidualFit& fit, const compare::BodyLoads& body, const std::string& method) {
  const compare::PoseErrors& e = *fit.map().unseen;
  std::string poses;
  for (const compare::PoseLoad& pose : body.poses) poses += (poses.empty() ? "" : ", ") + pose.name;
  dragcore::CalibratedModel model{
      .model = fit.model,
      .error = {e.mean_force, e.worst_force, e.mean_drag, e.worst_drag, e.mean_moment, e.worst_moment, fit.mean_u, e.poses},
      .provenance = {
          {"program", "dragval " + revision()},
          {"method", method},
          {"poses", poses},
          {"reynolds", fmt::format("{:g} on {:g} m", body.reynolds, body.reference_length)},
          {"fit", fmt::format("force: {}; moment: {}; pillow {:.3f}", fit.force_choice, fit.moment_choice, fit.model.pillow.factor)},
          {"date", fmt::format("{:%Y-%m-%d}", fmt::gmtime(std::time(nullptr)))}}};
  dragcore::write_calibrated(file, model);
  fmt::print("{}: read it by dragcore::read_calibrated(), or dragcore_calibrated_read() in C\n", file);
}

void print_next(const compare::BodyLoads& body, const compare::ResidualFit& fit, int count) {
  std::vector<Vector3d> known;
  for (const compare::PoseLoad& pose : body.poses) known.push_back(pose.direction());
  double mean = 0.0;
  for (const compare::PoseLoad& pose : body.poses) mean += pose.load.head<3>().norm() / static_cast<double>(body.poses.size());
  fmt::print("\nLeast sure; the next poses to solve, in degrees, and how unsure the force is there, in % of the mean force\n");
  for (const Vector3d& direction : compare::next_directions(known, body.group, fit.force_length, count))
    fmt::print("  {:<44} {}\n", degrees_text(compare::pose_towards(direction, body.group)), percent(fit.force.spread(direction) / mean));
}

compare::ResidualFit fit_and_print(const compare::BodyLoads& body, const std::string& method, const BodyCalibration& wanted) {
  const compare::ResidualFit fit = compare::fit_residual_map(body, fmt::format("{} poses, {}", body.poses.size(), method));
  print_table(fit);
  print_next(body, fit, wanted.more > 0 ? wanted.more : 6);
  if (!wanted.write.empty()) write_model(wanted.write, fit, body, method);
  return fit;
}

/// How the error on poses that were not solved falls with those that were.
void print_learning(const compare::BodyLoads& body) {
  std::vector<Vector3d> all;
  for (const compare::PoseLoad& pose : body.poses) all.push_back(pose.direction());
  const std::vector<Vector3d> order = compare::next_directions({}, body.group, first_length, static_cast<int>(all.size()) - 1, all);
  fmt::print("\nOf the same poses the first few, spread as a plan would choose them; error of force in the others, in %: mean and worst\n");
  std::set<std::string> chosen;
  compare::BodyLoads some = body;
  some.poses.clear();
  for (const Vector3d& direction : order) {
    const auto pose = std::find_if(body.poses.begin(), body.poses.end(),
                                   [&](const compare::PoseLoad& p) { return p.direction() == direction && !chosen.contains(p.name); });
    if (pose == body.poses.end()) continue;
    chosen.insert(pose->name);
    some.poses.push_back(*pose);
    std::vector<compare::PoseLoad> rest;
    for (const compare::PoseLoad& other : body.poses)
      if (!chosen.contains(other.name)) rest.push_back(other);
    if (some.poses.size() < 3 || rest.empty()) continue;
    const compare::ResidualFit fit = compare::fit_residual_map(some, "some");
    dragcore::Model law = fit.model;
    law.correction.reset();
    const compare::PoseErrors map = compare::pose_errors(body, rest, fit.model), alone = compare::pose_errors(body, rest, law);
    fmt::print("  {:3} poses   residual map {} {}   law {} {}   {}\n", some.poses.size(), percent(map.mean_force), percent(map.worst_force),
               percent(alone.mean_force), percent(alone.worst_force), fit.force_choice);
  }
}

/// With u of mesh, iteration and statistics: that of the method is common to all poses, and no scatter between them.
Records usable(const std::vector<CaseRecord>& records, const std::function<bool(const compare::CaseOfRecord&)>& wanted) {
  Records list;
  for (const compare::CaseOfRecord& one : compare::cases_of_record(records))
    if (case_record::is_usable(one.family.record->status) && one.family.record->known[0] && !one.family.record->spins() && wanted(one))
      list.emplace_back(*one.family.record, one.family.uncertainty.numerical);
  return list;
}

/// Round shapes are cut into few sides: their symmetries are then few.
std::vector<Eigen::Matrix3d> group_of(const dragcore::Shape& shape) {
  const auto* body = std::get_if<dragcore::MeshBody>(&shape);
  return compare::symmetry_group(body ? *body->mesh : dragcore::triangulate(shape, 4));
}

compare::BodyLoads loads_of(const Records& records) {
  const dragcore::Shape& shape = records.front().first.shape;
  return compare::body_loads(compare::prepared_surface(shape, compare::default_divisions(shape)), group_of(shape), records);
}

void print_body(const compare::BodyLoads& body) {
  fmt::print("{} triangles, class {}; {} symmetries, {} of them mirrors; {} poses at Re {:g}\n", body.surface->size(),
             to_string(body.surface->body_class), body.group.size(), compare::mirror_normals(body.group).size(), body.poses.size(),
             body.reynolds);
}

void calibrate_stored(const BodyCalibration& wanted, const SourceOptions& source) {
  const auto all = load(source).reference.cases;
  std::vector<CaseRecord> of_body;
  std::set<std::string> bodies;
  for (const CaseRecord& record : all) {
    std::string body = dragcore::kind(record.shape);  // as names of cases begin
    for (const auto& [parameter, value] : dragcore::changed_parameters(record.shape)) body += fmt::format("-{}-{:g}", parameter, value);
    bodies.insert(body);
    if (body == wanted.stored && std::abs(std::log(record.reynolds / wanted.reynolds)) < 0.01) of_body.push_back(record);
  }
  const Records records = usable(of_body, [](const compare::CaseOfRecord&) { return true; });
  if (records.empty())
    throw UsageError(
        fmt::format("no usable case of '{}' at Re {:g}; there are: {}", wanted.stored, wanted.reynolds, fmt::join(bodies, ", ")));
  const compare::BodyLoads body = loads_of(records);
  print_body(body);
  fit_and_print(body, "stored references", wanted);
  print_learning(body);
}

dragcore::MeshBody body_from(const BodyCalibration& wanted) {
  BodyOptions options{.file = wanted.mesh, .unit = wanted.unit};
  const Body body = load_body(options);
  for (const std::string& finding : body.findings) fmt::print(stderr, "{}\n", finding);
  if (const std::string question = unit_question(options, body); !question.empty()) throw UsageError(question);
  const double area = wanted.area > 0.0 ? wanted.area : *std::max_element(body.silhouette.begin(), body.silhouette.end());
  const double length = wanted.length > 0.0 ? wanted.length : std::sqrt(area);
  std::string name = fs::path(wanted.mesh).stem().string();
  for (char& letter : name) {
    letter = static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
    if (!std::isalnum(static_cast<unsigned char>(letter)) && letter != '-' && letter != '.') letter = '-';  // '_' parts the names of cases
  }
  return dragcore::mesh_body(name, dragcore::prepare(dragcore::read_mesh_file(wanted.mesh, options.unit_m()).mesh).mesh, area, length);
}

std::string sweep_text(const dragcore::MeshBody& body, const dragcore::Pose& pose) {
  return fmt::format(
      "\n[[sweep]]\nshape = \"mesh\"\nfile = \"{}.stl\"\nreference_area = {}\nreference_length = {}\nincidence_deg = {:.1f}\nyaw_deg = "
      "{:.1f}\n"
      "roll_deg = {:.1f}\n",
      body.name, body.measured.reference_area, body.measured.reference_length, pose.incidence / degree, pose.yaw / degree,
      pose.roll / degree);
}

/// The matrix of a body's poses, beside its triangles in the cache: what `dragval run` takes, too. Poses are added to it, none is taken
/// away.
struct PoseMatrix {
  fs::path file;
  std::vector<Vector3d> directions;
  std::string text;

  PoseMatrix(const BodyCalibration& wanted, const dragcore::MeshBody& body) {
    const fs::path folder = fs::path(wanted.cache) / "calibrate";
    fs::create_directories(folder);
    file = folder / fmt::format("{}-re-{:g}.toml", body.name, wanted.reynolds);
    keep_triangles(folder / (body.name + ".stl"), body, wanted.mesh);
    if (std::ifstream in(file); in) {
      text = {std::istreambuf_iterator<char>(in), {}};
      std::set<std::string> seen;
      for (const cfd_cases::CaseSpec& spec : cfd_cases::load_matrix(file.string()).cases) {
        const dragcore::Pose pose = spec.pose.radians();
        if (seen.insert(degrees_text(pose)).second) directions.push_back(pose.rotation().row(0).transpose());
      }
      return;
    }
    std::string levels;
    std::istringstream words(wanted.levels);
    for (std::string word; std::getline(words, word, ',');) levels += (levels.empty() ? "\"" : ", \"") + word + "\"";
    text = fmt::format(
        "# Made by dragval calibrate --mesh {}; it adds poses at the end.\ntier = \"calibrate\"\n\n[defaults]\nreynolds = {}\nflow_model = "
        "\"{}\"\nmesh = [{}]\nmax_iterations = 1500\ntimeout_s = 7200\n",
        wanted.mesh, wanted.reynolds, wanted.reynolds < 1e4 ? "laminar" : "k_omega_sst", levels);
  }

  /// Triangles under a name that poses were planned for stay those.
  void keep_triangles(const fs::path& stl, const dragcore::MeshBody& body, const std::string& mesh) const {
    const auto bytes = [](const fs::path& path) {
      std::ifstream in(path, std::ios::binary);
      return std::string{std::istreambuf_iterator<char>(in), {}};
    };
    const fs::path now = stl.string() + ".partial";
    dragcore::write_stl(now, *body.mesh);
    if (fs::exists(file) && fs::exists(stl) && bytes(now) != bytes(stl)) {
      fs::remove(now);
      throw UsageError(fmt::format("{}: other triangles than {}, for which {} has poses; rename the mesh, or give it a --cache of its own",
                                   mesh, stl.string(), file.string()));
    }
    fs::rename(now, stl);
  }

  void add(const std::vector<Vector3d>& more, const dragcore::MeshBody& body, const std::vector<Eigen::Matrix3d>& group) {
    if (more.empty()) return;
    for (const Vector3d& direction : more) {
      text += sweep_text(body, compare::pose_towards(direction, group));
      directions.push_back(direction);
    }
    cfd_cases::parse_matrix(text, file);  // what it would refuse is never written
    const fs::path partial = file.string() + ".partial";
    if (!(std::ofstream(partial) << text).flush()) throw EnvironmentError(fmt::format("{} cannot be written", file.string()));
    fs::rename(partial, file);
  }
};

std::vector<cfd_cases::PlannedCase> planned_cases(const PoseMatrix& matrix, const BodyCalibration& wanted, const cfd_cases::Tools& tools) {
  return cfd_cases::plan(cfd_cases::load_matrix(matrix.file.string()), tools, {wanted.cache}, run_store());
}

Records solved(const std::vector<cfd_cases::PlannedCase>& cases) {
  std::vector<CaseRecord> records;
  for (const cfd_cases::PlannedCase& one : cases)
    if (one.cached) records.push_back(*one.cached);
  return usable(records, [](const compare::CaseOfRecord&) { return true; });
}

std::string command_line(const BodyCalibration& wanted) {
  std::string line = "dragval calibrate --mesh " + wanted.mesh;
  if (!wanted.unit.empty()) line += " --unit " + wanted.unit;
  if (wanted.area > 0.0) line += fmt::format(" --area {:g}", wanted.area);
  if (wanted.length > 0.0) line += fmt::format(" --length {:g}", wanted.length);
  return line + fmt::format(" --reynolds {:g} --cache {}{}", wanted.reynolds, wanted.cache,
                            wanted.write.empty() ? "" : " --write " + wanted.write);
}

void calibrate_mesh(const BodyCalibration& wanted, Context& context) {
  const cfd_cases::Tools tools = cfd_cases::find_tools();
  const dragcore::MeshBody body = body_from(wanted);
  const std::vector<Eigen::Matrix3d> group = group_of(body);
  PoseMatrix matrix(wanted, body);
  const auto missing = [&](const std::vector<cfd_cases::PlannedCase>& cases) {
    return std::count_if(cases.begin(), cases.end(), [&](const auto& one) { return one.to_solve(wanted.retry_failed); });
  };
  // More poses only when those that were planned are solved: a command that was interrupted and is given again goes on.
  const int known = static_cast<int>(matrix.directions.size());
  double length = first_length;
  int count = std::max(0, wanted.poses - known);
  if (wanted.more > 0 && known > 0) {
    const auto cases = planned_cases(matrix, wanted, tools);
    count = missing(cases) == 0 ? wanted.more : 0;
    if (const Records found = solved(cases); count > 0 && found.size() >= 3)
      length = compare::fit_residual_map(loads_of(found), "").force_length;
  }
  matrix.add(compare::next_directions(matrix.directions, group, length, count), body, group);

  auto cases = planned_cases(matrix, wanted, tools);
  const cfd_cases::PredictedSum sum = cfd_cases::predicted_sum(cases);
  fmt::print("{}: A_ref {:.4g} m^2, L_ref {:.4g} m; {} symmetries; {} poses, {} cases in {}, {} to solve: {:.0f} ± {:.0f} CPU s\n",
             body.name, body.measured.reference_area, body.measured.reference_length, group.size(), matrix.directions.size(), cases.size(),
             matrix.file.string(), missing(cases), sum.cpu_s, sum.uncertainty);
  for (const auto& one : cases)
    fmt::print("  {:<70} {}\n", one.spec.name,
               one.cached ? case_record::to_string(one.cached->status)
                          : fmt::format("{:6.0f} cells {:6.0f} CPU s", one.estimate.cells, one.predicted_cpu_s));
  if (wanted.dry_run) return;
  if (missing(cases) > 0) {
    std::fflush(stdout);
    std::signal(SIGINT, [](int) { stop_calibration = true; });
    std::signal(SIGTERM, [](int) { stop_calibration = true; });
    const auto result = cfd_cases::run_campaign(cases, tools, {wanted.cache}, run_store(),
                                                {.jobs = wanted.jobs, .retry_failed = wanted.retry_failed}, stop_calibration);
    for (const CaseRecord& record : result.unusable)
      fmt::print(stderr, "{}: {}, {}: left out\n", record.name, case_record::to_string(record.status), record.reason);
    if (result.interrupted) {
      fmt::print("Interrupted; to go on: {}\n", command_line(wanted));
      context.exit_code = exit_code::run_failed;
      return;
    }
    cases = planned_cases(matrix, wanted, tools);
  }
  const Records records = solved(cases);
  if (records.size() < 3)
    throw EnvironmentError(
        fmt::format("{} of {} poses have a usable case, but at least 3 are needed; `dragval explain NAME --matrix {}` says why",
                    records.size(), matrix.directions.size(), matrix.file.string()));
  double cpu_s = 0.0;
  for (const auto& one : cases)
    if (one.cached)
      for (const auto& [stage, cost] : one.cached->cost) cpu_s += cost.cpu_s;
  const compare::BodyLoads loads = loads_of(records);
  print_body(loads);
  fmt::print("CPU time of all cases: {:.0f} s{}\n", cpu_s,
             wanted.levels.find(',') == std::string::npos ? "; one mesh level: u lacks the error of the mesh" : "");
  fit_and_print(loads, fmt::format("OpenFOAM {}, {}, meshes {}", tools.openfoam, records.front().first.flow_model, wanted.levels), wanted);
  fmt::print("To go on: {} --more {}\n", command_line(wanted), wanted.more > 0 ? wanted.more : 6);
}

void calibrate_table(const BodyCalibration& wanted) {
  std::ifstream file(wanted.table, std::ios::binary);
  if (!file) throw EnvironmentError(fmt::format("{} cannot be read; name a CSV table of measurements", wanted.table));
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  std::optional<dragcore::MeshBody> body;
  if (!wanted.mesh.empty()) body = body_from(wanted);
  Records records;
  for (CaseRecord& record : compare::read_experiments(text, wanted.table, body)) {
    const double degrees = 1.0 / degree;
    record.name = fmt::format("incidence {:g}, yaw {:g}, roll {:g}", degrees * record.pose.incidence, degrees * record.pose.yaw,
                              degrees * record.pose.roll);
    const CaseRecord::Channels u = record.own_variance().cwiseSqrt();
    records.emplace_back(std::move(record), u);
  }
  const CaseRecord& first = records.front().first;
  for (const auto& [record, u] : records) {
    if (dragcore::kind(record.shape) != dragcore::kind(first.shape) ||
        dragcore::parameters(record.shape) != dragcore::parameters(first.shape))
      throw UsageError(fmt::format("{}: {} and {} are two bodies; a table of one is needed", wanted.table, dragcore::kind(first.shape),
                                   dragcore::kind(record.shape)));
    if (std::abs(std::log(record.reynolds / first.reynolds)) > std::log(3.0))
      throw UsageError(fmt::format("{}: Re {:g} and {:g}; one map is of one Reynolds number, within a factor of 3", wanted.table,
                                   first.reynolds, record.reynolds));
  }
  const compare::BodyLoads loads = loads_of(records);
  print_body(loads);
  fit_and_print(loads, "measured, " + first.source, wanted);
}

}  // namespace

namespace {

/// Before hours are spent: numbers that are none, and a file in the place of the result that is something else.
void check_before_work(const BodyCalibration& wanted) {
  for (const auto& [name, value] :
       {std::pair("--reynolds", wanted.reynolds), std::pair("--area", wanted.area), std::pair("--length", wanted.length)})
    if (!std::isfinite(value)) throw UsageError(fmt::format("{} {}: a finite number is needed", name, value));
  if (wanted.write.empty() || !std::filesystem::exists(wanted.write)) return;
  try {
    dragcore::read_calibrated(wanted.write);
  } catch (const std::exception&) {
    throw UsageError(fmt::format("--write {}: that is there already and no calibrated model, which alone is replaced; choose another name",
                                 wanted.write));
  }
}

}  // namespace

void calibrate_body(const BodyCalibration& wanted, const SourceOptions& source, Context& context) {
  check_before_work(wanted);
  if (!wanted.stored.empty()) return calibrate_stored(wanted, source);
  if (!wanted.table.empty()) return calibrate_table(wanted);
  calibrate_mesh(wanted, context);
}

}  // namespace cli
