#include "cfd_cases/flow_case/solve.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <fstream>

#include "cfd_cases/flow_case/convergence.hpp"
#include "cfd_cases/flow_case/dictionaries.hpp"
#include "cfd_cases/flow_case/force_history.hpp"
#include "cfd_cases/programs/subprocess.hpp"

namespace cfd_cases {

namespace fs = std::filesystem;
using case_record::CaseRecord;
using case_record::Load;
using case_record::StageCost;
using case_record::Status;
using Eigen::Vector3d;

namespace {

/// Divisions of the triangles whose checksum a record carries.
constexpr int kChecksumDivisions = 16;

/// Force and moment per unit coefficient, and the largest coefficient one can believe in.
struct Scales {
  double force, moment, plausible;

  Channels coefficients(const Load& load) const {
    Channels c;
    c << load.force() / force, load.moment() / moment;
    return c;
  }
  Channels dimensional(const Channels& c) const {
    Channels load;
    load << c.head<3>() * force, c.tail<3>() * moment;
    return load;
  }
};

Scales scales_of(const CaseSpec& spec) {
  const auto p = dragcore::properties(spec.shape);
  const double q = 0.5 * kDensity * kSpeed * kSpeed;
  // No bluff body has more than about 2 on its frontal area, which is at most half of its surface; creeping flow adds 24/Re on the frontal,
  // and for slender bodies more. Arms of moments are at most the longest half extent.
  const double force = (4.0 + 100.0 / spec.reynolds) * std::max(1.0, 0.5 * p.area / p.reference_area);
  return {q * p.reference_area, q * p.reference_area * p.reference_length,
          force * std::max(1.0, 2.0 * p.half_extent.maxCoeff() / p.reference_length)};
}

/// Load of the whole body in the wind frame, from that of the faces that are meshed.
Load whole_load(const Load& meshed, const CaseIdentity& id) {
  const Load whole = whole_body(meshed, id.symmetry);
  return {id.to_wind * whole.force_pressure, id.to_wind * whole.force_viscous, id.to_wind * whole.moment_pressure,
          id.to_wind * whole.moment_viscous};
}

std::vector<Channels> channels_of(const std::vector<ForceSample>& history, const Scales& scales, const CaseIdentity& id) {
  std::vector<Channels> series;
  for (const auto& sample : history) series.push_back(scales.coefficients(whole_load(sample.load, id)));
  return series;
}

Load mean_load(const std::vector<ForceSample>& history, int samples, const CaseIdentity& id) {
  Load mean;
  const double weight = 1.0 / samples;
  for (std::size_t i = history.size() - static_cast<std::size_t>(samples); i < history.size(); ++i) {
    const Load load = whole_load(history[i].load, id);
    mean.force_pressure += weight * load.force_pressure;
    mean.force_viscous += weight * load.force_viscous;
    mean.moment_pressure += weight * load.moment_pressure;
    mean.moment_viscous += weight * load.moment_viscous;
  }
  return mean;
}

/// Size of the channels that the mirror symmetries of body and pose say are zero: what is left in them is noise.
Channels null_channels(const CaseSpec& spec, const Channels& mean) {
  Channels is_null = Channels::Zero();
  const Eigen::Matrix3d to_body = spec.pose.radians().rotation().transpose();
  const Vector3d spin = spec.spin.direction();
  for (const int across : {1, 2}) {
    const Vector3d normal = to_body * Vector3d::Unit(across);
    if (!dragcore::mirror_symmetric(spec.shape, normal) || spin.cross(normal).norm() > 1e-12) continue;
    is_null[across] = 1.0;  // the force across the plane
    is_null[3] = 1.0;       // the moments about the axes in the plane
    is_null[3 + (3 - across)] = 1.0;
  }
  return is_null.cwiseProduct(mean.cwiseAbs());
}

/// The solver's files as they are run. In steady flow gradients are kept from where they are first needed in an iteration to where they are
/// needed again: the same forces to the last digit for a fifth less CPU time (docs/cfd.md). So this is no part of the key, which holds the
/// text of dictionaries(). In time they round differently, which a wake that is resolved does not forget.
std::map<std::string, std::string> files_to_run(const CaseSpec& spec, Symmetry symmetry, Rung rung) {
  auto files = dictionaries(spec, symmetry, rung);
  if (!spec.time_accurate()) files.at("system/fvSolution") += "cache { grad(U); grad(p); grad(k); grad(omega); }\n";
  return files;
}

/// The fields that a solver needs to go on; those of turbulence only where it was modelled.
constexpr const char* kFields[] = {"U", "p", "k", "omega", "nut", "gammaInt", "ReThetat"};

/// The text of a field file from "internalField" up to its boundary.
std::pair<std::size_t, std::size_t> internal_field(const std::string& text, const fs::path& file) {
  const std::size_t from = text.find("internalField"), to = text.find("boundaryField");
  if (from == std::string::npos || to == std::string::npos || to < from)
    throw CaseFailure(fmt::format("{} is no complete field: its start case must be solved again", file.string()));
  return {from, to};
}

bool ended_well(const fs::path& log) {
  std::ifstream in(log, std::ios::ate);
  const auto size = in.tellg();
  in.seekg(std::max<std::streamoff>(0, static_cast<std::streamoff>(size) - 200));
  const std::string tail{std::istreambuf_iterator<char>(in), {}};
  return tail.find("\nEnd\n") != std::string::npos;
}

void add(StageCost& cost, const Outcome& outcome) {
  cost.cpu_s += outcome.cpu_s;
  cost.wall_s += outcome.wall_s;
}

class Solver {
 public:
  Solver(const CaseSpec& spec, const CaseIdentity& identity, const Tools& tools, const Cache& cache, int ranks, bool keep_fields,
         const std::atomic<bool>& cancel, const std::function<void(const Progress&)>& on_progress)
      : spec_(spec),
        id_(identity),
        tools_(tools),
        cache_(cache),
        ranks_(ranks),
        keep_fields_(keep_fields),
        cancel_(cancel),
        on_progress_(on_progress),
        scales_(scales_of(spec)) {}

  CaseRecord solve() {
    CaseRecord record = asked_record(spec_, id_, tools_);
    const fs::path work = cache_.work(id_.key);
    fs::remove_all(work);  // of a run that was killed or failed
    fs::create_directories(work);
    try {
      const Mesh mesh = ensure_mesh(spec_, id_, tools_, cache_, work, cancel_, [&](const char* stage) { on_progress_({stage}); });
      record.cells = mesh.cells;
      record.mesh_quality = mesh.quality;
      record.surface_area = mesh.surface_area;
      record.surface_volume = mesh.surface_volume;
      record.cost = mesh.cost;
      record.attempts = mesh.attempts;
      for (int rung = 0; rung <= spec_.retries; ++rung) {
        const Rung recipe = static_cast<Rung>(rung);
        try_rung(recipe, work / to_string(recipe), mesh, record);
        record.attempts.push_back({to_string(recipe), record.status, record.reason});
        // Time-outs and drift would only be repeated; other relaxation helps against divergence.
        if (record.status != Status::diverged || spec_.time_accurate()) break;
      }
    } catch (const CaseFailure& failure) {
      record.status = Status::failed;
      record.reason = failure.what();
      record.attempts.push_back({record.cells > 0 ? "post" : "mesh", record.status, record.reason});
    }
    if (case_record::is_usable(record.status)) record.reason.clear();
    record.finished = fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)));
    return record;
  }

 private:
  /// Solves with the settings of one rung and fills status, reason and, when usable, the results.
  void try_rung(Rung rung, const fs::path& folder, const Mesh& mesh, CaseRecord& record) {
    write_files(folder, files_to_run(spec_, id_.symmetry, rung));
    fs::create_directories(folder / "constant/polyMesh");
    for (const auto& file : fs::directory_iterator(mesh.poly_mesh))
      fs::create_hard_link(file.path(), folder / "constant/polyMesh" / file.path().filename());
    StageCost& solve = record.cost["solve"];
    if (spec_.start) start_from_fields(folder, solve);
    if (spec_.spin.in_still_air()) {
      require(run(folder, {"topoSet"}, solve), "topoSet", folder);
      spinning_cells(folder);
    }
    if (ranks_ > 1) {
      write_files(folder, {{"system/decomposeParDict", decomposition(ranks_)}});
      require(run(folder, {"decomposePar"}, solve), "decomposePar", folder);
    }

    // The forces decide live: enough is enough, and a divergence is not paid to its end. Every iteration is judged, so that the verdict
    // does not depend on when somebody looks: a busy machine gives the same result to the bit.
    Verdict live;
    std::atomic<bool> halt = false;
    std::size_t judged = 0;
    const auto judge_up_to_now = [&](const std::vector<Channels>& series) {
      while (!live.stop && judged < series.size())
        live = judged_now({series.begin(), series.begin() + static_cast<std::ptrdiff_t>(++judged)}, false);
    };
    const auto watch = [&] {
      if (cancel_) halt = true;
      const auto history = read_forces(folder);
      if (history.empty() || live.stop) return;
      const auto series = channels_of(history, scales_, id_);
      on_progress_({"solve", static_cast<int>(history.size()), series.back()[0]});
      judge_up_to_now(series);
      if (!live.stop) return;
      if (case_record::is_usable(live.status))
        write_files(folder, {{"stop", ""}});
      else
        halt = true;
    };
    on_progress_({"solve"});
    const std::string solver = solver_of(spec_);
    std::vector<std::string> argv{solver};
    // --bind-to none: two mpirun side by side would both bind to the first core.
    if (ranks_ > 1) argv = {"mpirun", "-np", std::to_string(ranks_), "--oversubscribe", "--bind-to", "none", solver, "-parallel"};
    const fs::path log = folder / ("log." + solver);
    const Outcome outcome = run_command(
        {.argv = argv, .folder = folder, .log = log, .timeout_s = spec_.timeout_s, .environment = tools_.environment}, halt, watch);
    add(solve, outcome);
    if (cancel_) throw Interrupted();

    const auto fail = [&](Status status, std::string reason) {
      record.status = status;
      record.reason = std::move(reason);
    };
    const auto history = read_history(folder);
    record.iterations += static_cast<int>(history.size());
    const auto series = channels_of(history, scales_, id_);
    judge_up_to_now(series);
    if (outcome.timed_out)
      return fail(Status::timed_out,
                  fmt::format("stopped after {:.0f} s and {} iterations: raise timeout_s", spec_.timeout_s, history.size()));
    if (live.status == Status::diverged) return fail(Status::diverged, live.reason);
    // 136 = 128 + SIGFPE: the trap for floating point errors is on.
    if (outcome.exit_code == 136) return fail(Status::diverged, fmt::format("floating point failure after {} iterations", history.size()));
    if (outcome.exit_code != 0)
      return fail(Status::failed, fmt::format("{} ended with code {}: {}", argv[0], outcome.exit_code, log_excerpt(log)));
    if (!ended_well(log)) return fail(Status::failed, solver + " returned 0 without reaching its End");
    const Verdict at_end = judged_now(series, true);
    // The last iterations came after the decision to stop; they may not undo it, unless the solution blew up.
    const Verdict& verdict = live.stop && at_end.status != Status::diverged ? live : at_end;
    if (!case_record::is_usable(verdict.status)) return fail(verdict.status, verdict.reason);
    // A wrong patch gives zeros and a mere warning.
    if (history.back().load.force().norm() < 1e-9 * scales_.force)
      return fail(Status::failed, "the forces are zero: the patch 'body' is empty");

    on_progress_({"post", static_cast<int>(history.size()), series.back()[0]});
    finish(folder, history, live.stop ? judged : history.size(), verdict, record);
  }

  /// @param decided  iterations until the decision to stop: the mean ends there, the surface is that of the last one
  void finish(const fs::path& folder, const std::vector<ForceSample>& history, std::size_t decided, const Verdict& verdict,
              CaseRecord& record) {
    StageCost& post = record.cost["post"];
    if (ranks_ > 1) require(run(folder, {"reconstructPar", "-latestTime"}, post), "reconstructPar", folder);
    // A mesh that turns leaves its points in the time folder.
    if (const fs::path moved = last_time_folder(folder) / "polyMesh/points"; fs::exists(moved)) {
      fs::remove(folder / "constant/polyMesh/points");
      fs::copy_file(moved, folder / "constant/polyMesh/points");
    }
    const double cpu = thread_cpu_s();
    const auto began = std::chrono::steady_clock::now();
    try {
      record.surface = read_surface(folder, read_poly_mesh(folder / "constant/polyMesh"), history.back().load, 0.5 * kSpeed * kSpeed);
    } catch (const CaseFailure&) {
      throw;
    } catch (const std::runtime_error& error) {
      throw CaseFailure(error.what());
    }
    for (Eigen::Matrix3Xd* vectors : {&record.surface.centre, &record.surface.area_vector, &record.surface.friction_coefficient})
      *vectors = id_.to_wind * *vectors;
    // The surface of a body that has turned is not that of its pose: what is stored per patch would be of other sides.
    if (spec_.spin.ratio > 0.0) record.surface = {};
    if (keep_fields_) store_fields(last_time_folder(folder));
    record.averaged_over = std::min(verdict.averaged_over, static_cast<int>(decided));
    record.load = mean_load({history.begin(), history.begin() + static_cast<std::ptrdiff_t>(decided)}, record.averaged_over, id_);
    record.load_last = whole_load(history.back().load, id_);
    record.u_iteration = scales_.dimensional(verdict.u_iteration);
    record.u_statistical = scales_.dimensional(verdict.u_statistical);
    record.u_null = scales_.dimensional(null_channels(spec_, scales_.coefficients(record.load)));
    record.status = verdict.status;
    record.reason.clear();
    post.cpu_s += thread_cpu_s() - cpu;
    post.wall_s += std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  }

  Verdict judged_now(const std::vector<Channels>& series, bool ended) const {
    if (!spec_.time_accurate()) return judge(series, spec_.stop, scales_.plausible, ended, spec_.spin.in_still_air());
    return judge_in_time(series, static_cast<std::size_t>(std::lround(spec_.time.discard / spec_.time.step)), scales_.plausible, ended);
  }

  void store_fields(const fs::path& time) {
    const fs::path complete = cache_.work(id_.key) / "fields";
    fs::remove_all(complete);
    fs::create_directories(complete);
    for (const char* field : kFields)
      if (fs::exists(time / field)) fs::copy_file(time / field, complete / field);
    fs::remove_all(cache_.fields(id_.key));
    fs::rename(complete, cache_.fields(id_.key));
  }

  /// Puts the last values of the start case into the initial fields: as they are on the same mesh, by mapFields from another.
  void start_from_fields(const fs::path& folder, StageCost& cost) {
    const fs::path from = cache_.fields(id_.start_key);
    if (!fs::exists(from)) throw CaseFailure(fmt::format("{} left no fields to start from: is it usable?", spec_.start->name));
    const CaseIdentity start = identify(*spec_.start, tools_);
    if (start.mesh_key != id_.mesh_key) {
      const fs::path source = cache_.work(id_.key) / "start";
      fs::remove_all(source);
      write_files(source, dictionaries(*spec_.start, start.symmetry, Rung::standard));
      for (const auto& field : fs::directory_iterator(from))
        fs::copy_file(field.path(), source / "0" / field.path().filename(), fs::copy_options::overwrite_existing);
      fs::create_directories(source / "constant/polyMesh");
      for (const auto& file : fs::directory_iterator(cache_.mesh(start.mesh_key) / "polyMesh"))
        fs::create_hard_link(file.path(), source / "constant/polyMesh" / file.path().filename());
      write_files(
          folder,
          {{"system/mapFieldsDict",
            "FoamFile { version 2.0; format ascii; class dictionary; object mapFieldsDict; }\npatchMap ();\ncuttingPatches ();\n"}});
      return require(run(folder, {"mapFields", fs::absolute(source).string(), "-sourceTime", "0"}, cost), "mapFields", folder);
    }
    for (const char* name : kFields) {
      const fs::path file = folder / "0" / name;
      if (!fs::exists(file) || !fs::exists(from / name)) continue;
      std::string text = contents(file);
      const std::string there = contents(from / name);
      const auto [begin, end] = internal_field(text, file);
      const auto [start_begin, start_end] = internal_field(there, from / name);
      write_files(folder, {{std::string("0/") + name, text.replace(begin, end - begin, there, start_begin, start_end - start_begin)}});
    }
  }

  std::vector<ForceSample> read_history(const fs::path& folder) const {
    try {
      return read_forces(folder);
    } catch (const std::runtime_error& error) {
      throw CaseFailure(error.what());
    }
  }

  Outcome run(const fs::path& folder, std::vector<std::string> argv, StageCost& cost) {
    const fs::path log = folder / ("log." + argv[0]);
    const Outcome outcome = run_command(
        {.argv = std::move(argv), .folder = folder, .log = log, .timeout_s = spec_.timeout_s, .environment = tools_.environment}, cancel_);
    add(cost, outcome);
    return outcome;
  }
  static void require(const Outcome& outcome, const std::string& program, const fs::path& folder) {
    if (outcome.cancelled) throw Interrupted();
    if (outcome.timed_out || outcome.exit_code != 0)
      throw CaseFailure(fmt::format("{} ended with code {}: {}", program, outcome.exit_code, log_excerpt(folder / ("log." + program))));
  }

  const CaseSpec& spec_;
  const CaseIdentity& id_;
  const Tools& tools_;
  const Cache& cache_;
  int ranks_;
  bool keep_fields_;
  const std::atomic<bool>& cancel_;
  const std::function<void(const Progress&)>& on_progress_;
  Scales scales_;
};

}  // namespace

CaseRecord solve_case(const CaseSpec& spec, const CaseIdentity& identity, const Tools& tools, const Cache& cache, int ranks,
                      bool keep_fields, const std::atomic<bool>& cancel, const std::function<void(const Progress&)>& on_progress) {
  return Solver(spec, identity, tools, cache, ranks, keep_fields, cancel, on_progress).solve();
}

CaseRecord asked_record(const CaseSpec& spec, const CaseIdentity& identity, const Tools& tools) {
  CaseRecord record;
  record.name = spec.name;
  record.key = identity.key;
  record.description = identity.description;
  record.source = "openfoam-" + tools.openfoam;
  record.tier = spec.tier;
  record.shape = spec.shape;
  record.pose = spec.pose.radians();
  record.reynolds = spec.reynolds;
  record.flow_model = spec.flow_model;
  record.mesh_level = spec.mesh_level;
  record.held_out = spec.held_out;
  record.density = kDensity;
  record.speed = kSpeed;
  record.viscosity = kinematic_viscosity(spec);
  record.still_air = spec.spin.in_still_air();
  record.angular_velocity = identity.to_wind * flow_of(spec).angular_velocity;
  record.half_model = identity.symmetry != Symmetry::none;
  record.surface_checksum = fmt::format("{:016x}", dragcore::surface_checksum(dragcore::triangulate(spec.shape, kChecksumDivisions)));
  record.tools = tools.versions();
  return record;
}

case_record::SurfaceSample read_surface(const fs::path& case_folder, const PolyMesh& mesh, const Load& meshed_load, double scale) {
  const auto& patch = mesh.patch("body");
  const fs::path time = last_time_folder(case_folder);
  // The wall has zero normal gradient of pressure, so that a face has the value of its cell.
  const Eigen::VectorXd cell_pressure = read_cell_scalars(time / "p", mesh.cells());
  // OpenFOAM's wallShearStress is what the wall does to the air; the air does the opposite to the wall.
  const Eigen::Matrix3Xd shear = -read_patch_vectors(time / "wallShearStress", "body", patch.faces) / scale;
  case_record::SurfaceSample sample{Eigen::Matrix3Xd(3, patch.faces), Eigen::Matrix3Xd(3, patch.faces), Eigen::VectorXd(patch.faces),
                                    shear};
  Vector3d pressure_force = Vector3d::Zero(), viscous_force = Vector3d::Zero();
  for (int i = 0; i < patch.faces; ++i) {
    const FaceGeometry face = face_geometry(mesh, patch.first_face + i);
    sample.pressure_coefficient[i] = cell_pressure[mesh.owner[static_cast<std::size_t>(patch.first_face + i)]] / scale;
    sample.centre.col(i) = face.centre;
    sample.area_vector.col(i) = -face.area_vector;  // out of the body
    pressure_force += kDensity * scale * sample.pressure_coefficient[i] * face.area_vector;
    viscous_force += kDensity * scale * shear.col(i) * face.area_vector.norm();
  }
  // Both sums are over the same faces and the same iteration as the solver's own; ten digits are written, so 1e-3 leaves only real
  // mistakes.
  const double allowed = 1e-3 * meshed_load.force().norm();
  for (const auto& [what, found, needed] : {std::tuple{"pressure", pressure_force, meshed_load.force_pressure},
                                            std::tuple{"shear stress", viscous_force, meshed_load.force_viscous}})
    if (!((found - needed).norm() <= allowed))
      throw CaseFailure(fmt::format("{} on the faces adds up to ({:.5g} {:.5g} {:.5g}), but the force file says ({:.5g} {:.5g} {:.5g})",
                                    what, found.x(), found.y(), found.z(), needed.x(), needed.y(), needed.z()));
  return sample;
}

int spinning_cells(const fs::path& case_folder) {
  const std::string zones = contents(case_folder / "constant/polyMesh/cellZones"), list = "List<label>";
  const std::size_t zone = zones.find("spinning");
  const std::size_t labels = zone == std::string::npos ? zone : zones.find(list, zone);
  const int cells = labels == std::string::npos ? 0 : std::atoi(zones.c_str() + labels + list.size());
  if (cells <= 0)
    throw CaseFailure(
        "topoSet found no cell for the zone 'spinning', so that nothing would turn: the mesh must surround the origin, the body's "
        "centroid");
  return cells;
}

fs::path last_time_folder(const fs::path& case_folder) {
  fs::path newest;
  double latest = 0.0;
  for (const auto& entry : fs::directory_iterator(case_folder)) {
    const std::string name = entry.path().filename();
    double time = 0.0;
    const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), time);
    if (error == std::errc{} && end == name.data() + name.size() && time > latest) {
      latest = time;
      newest = entry.path();
    }
  }
  if (newest.empty()) throw CaseFailure(fmt::format("{} has no time folder: the solver wrote no fields", case_folder.string()));
  return newest;
}

}  // namespace cfd_cases
