#include "cfd_cases/flow_case/case_mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>
#include <thread>

#include "cfd_cases/flow_case/dictionaries.hpp"
#include "cfd_cases/mesh/o_grid.hpp"
#include "cfd_cases/mesh/poly_mesh.hpp"
#include "cfd_cases/mesh/snappy.hpp"
#include "cfd_cases/programs/subprocess.hpp"

namespace cfd_cases {

namespace fs = std::filesystem;
using case_record::StageCost;

namespace {

/// gmshToFoam and polyDualMesh call every patch a "patch", subsetMesh a new one "empty"; wall functions need the wall, the half model its
/// symmetry.
void name_patch_types(const fs::path& boundary) {
  std::string text = contents(boundary);
  text = std::regex_replace(text, std::regex(R"((body\s*\{\s*type\s+)\w+)"), "$1wall");
  text = std::regex_replace(text, std::regex(R"((symmetry\s*\{\s*type\s+)\w+)"), "$1symmetry");
  text = std::regex_replace(text, std::regex(R"(\s*(physicalType\s+\w+|inGroups\s+1\(empty\));)"), "");
  std::ofstream(boundary) << text;
}

struct Stages {
  const fs::path& folder;
  const Tools& tools;
  const std::atomic<bool>& cancel;
  std::map<std::string, StageCost>& cost;

  /// @throws CaseFailure with the log's excerpt, Interrupted
  /// @param timeout_s  a mesh of 100,000 cells takes half a minute; nothing here should take 20
  fs::path run(const char* stage, std::vector<std::string> argv, double timeout_s = 1200.0) {
    const std::string program = fs::path(argv[0]).filename();
    const fs::path log = folder / ("log." + program);
    const Outcome outcome = run_command(
        {.argv = std::move(argv), .folder = folder, .log = log, .timeout_s = timeout_s, .environment = tools.environment}, cancel);
    cost[stage].cpu_s += outcome.cpu_s;
    cost[stage].wall_s += outcome.wall_s;
    if (outcome.cancelled) throw Interrupted();
    if (outcome.timed_out) throw CaseFailure(fmt::format("{} did not end within {:.0f} s", program, timeout_s));
    if (outcome.exit_code != 0) throw CaseFailure(fmt::format("{} ended with code {}: {}", program, outcome.exit_code, log_excerpt(log)));
    return log;
  }
};

std::map<std::string, double> read_quality(const std::string& log) {
  std::map<std::string, double> quality;
  for (const auto& [name, pattern] : {std::pair{"max_non_orthogonality_deg", R"(non-orthogonality Max: ([0-9.eE+-]+))"},
                                      std::pair{"max_skewness", R"(Max skewness = ([0-9.eE+-]+))"},
                                      std::pair{"max_aspect_ratio", R"(Max aspect ratio = ([0-9.eE+-]+))"}}) {
    std::smatch match;
    if (!std::regex_search(log, match, std::regex(pattern))) throw CaseFailure(fmt::format("checkMesh printed no {}", name));
    quality[name] = std::stod(match[1]);
  }
  return quality;
}

/// Halves cubes until none is larger than the size field asks for, then takes the body out. Body frame.
void refine_octree(const CaseSpec& spec, const CaseIdentity& identity, Stages& stages, const fs::path& poly_mesh) try {
  const OctreeSizes sizes(spec.shape, identity.recipe, identity.symmetry);
  for (;;) {
    std::vector<int> too_large;
    const auto extents = cell_extents(read_poly_mesh(poly_mesh));
    for (std::size_t cell = 0; cell < extents.size(); ++cell)
      if (sizes.too_large(extents[cell].lower, extents[cell].upper)) too_large.push_back(static_cast<int>(cell));
    if (too_large.empty()) break;
    write_cell_set(poly_mesh, "refine", too_large);
    stages.run("convert", {"refineHexMesh", "-overwrite", "refine"});
  }
  const Eigen::Vector3d half = flat_half_extent(spec.shape);
  std::vector<int> air;
  const auto extents = cell_extents(read_poly_mesh(poly_mesh));
  for (std::size_t cell = 0; cell < extents.size(); ++cell)
    if (((0.5 * (extents[cell].lower + extents[cell].upper)).cwiseAbs().array() > half.array()).any())
      air.push_back(static_cast<int>(cell));
  write_cell_set(poly_mesh, "air", air);
  stages.run("convert", {"subsetMesh", "air", "-overwrite", "-patch", "body"});
  // The history of the refinement is of another mesh now.
  for (const char* file : {"cellLevel", "pointLevel", "level0Edge", "refinementHistory", "cellZones", "faceZones", "pointZones", "sets"})
    fs::remove_all(poly_mesh / file);
} catch (const std::invalid_argument& error) {
  throw CaseFailure(error.what());
}

void measure(const PolyMesh& made, Symmetry symmetry, Mesh& mesh) {
  const PatchExtent extent = patch_extent(made, "body");
  const double halves = symmetry == Symmetry::none ? 1.0 : 2.0;
  mesh.cells = made.cells();
  mesh.surface_area = halves * extent.area;
  mesh.surface_volume = halves * extent.volume;
}

/// What checkMesh found wrong, empty when it is fine; fills the quality.
std::string check_mesh(Stages& stages, Mesh& mesh) {
  const std::string log = contents(stages.run("convert", {"checkMesh"}));
  mesh.quality = read_quality(log);
  if (log.find("Mesh OK") != std::string::npos) return {};
  std::string faults;
  std::istringstream lines(log);
  for (std::string line; std::getline(lines, line);)
    if (line.find("***") != std::string::npos) faults += (faults.empty() ? "" : "; ") + line.substr(line.find("***") + 3);
  return faults.empty() ? "checkMesh did not print Mesh OK" : faults;
}

/// A body given by triangles, in an empty folder. Returns what is wrong with the mesh, empty when it is fine.
std::string make_snappy_mesh(const dragcore::MeshBody& body, const CaseSpec& spec, MeshRecipe recipe, Symmetry symmetry, Stages stages,
                             Mesh& mesh, const std::function<void(const char*)>& on_stage) try {
  auto files = dictionaries(spec, symmetry, Rung::standard);
  std::erase_if(files, [](const auto& file) { return file.first.starts_with("0/"); });  // no patches for them yet
  files.merge(snappy_files(body, spec.mesh_pose().radians(), recipe, symmetry));
  write_files(stages.folder, files);
  on_stage("mesh");
  stages.run("mesh", {"surfaceFeatureExtract"});
  stages.run("mesh", {"blockMesh"});
  // 30,000 cells take 5 s; one that takes twelve times as long will not end.
  const double cells = snappy_cells(body, spec.mesh_pose().radians(), recipe, symmetry);
  stages.run("mesh", {"snappyHexMesh", "-overwrite"}, 60.0 * std::max(1.0, cells / 30000.0));
  on_stage("convert");
  const fs::path poly_mesh = stages.folder / "constant/polyMesh";
  for (const char* file : {"cellLevel", "pointLevel", "level0Edge", "surfaceIndex", "cellZones", "faceZones", "pointZones", "sets"})
    fs::remove_all(poly_mesh / file);  // renumberMesh would have to carry them along
  stages.run("convert", {"renumberMesh", "-overwrite"});
  name_patch_types(poly_mesh / "boundary");
  const PolyMesh made = read_poly_mesh(poly_mesh);
  if (const std::string fault = snappy_fault(body, recipe, symmetry, made); !fault.empty()) return fault;
  measure(made, symmetry, mesh);
  return check_mesh(stages, mesh);
} catch (const CaseFailure&) {
  throw;
} catch (const std::runtime_error& error) {
  throw CaseFailure(error.what());
}

/// An O-grid, in a folder that has its dictionaries. Returns what is wrong with it, empty when it is fine.
std::string make_o_grid(const CaseSpec& spec, const MeshRecipe& recipe, Symmetry symmetry, Stages stages, Mesh& mesh,
                        const std::function<void(const char*)>& on_stage) try {
  on_stage("mesh");
  const double cpu = thread_cpu_s();
  const auto began = std::chrono::steady_clock::now();
  const PolyMesh made = o_grid(spec.shape, spec.mesh_pose().radians(), recipe, symmetry);
  const fs::path poly_mesh = stages.folder / "constant/polyMesh";
  write_poly_mesh(poly_mesh, made);
  name_patch_types(poly_mesh / "boundary");
  measure(made, symmetry, mesh);
  stages.cost["mesh"].cpu_s += thread_cpu_s() - cpu;
  stages.cost["mesh"].wall_s += std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  on_stage("convert");
  stages.run("convert", {"renumberMesh", "-overwrite"});
  return check_mesh(stages, mesh);
} catch (const std::invalid_argument& error) {
  throw CaseFailure(error.what());
}

/// One try at the mesh in an empty folder. Returns what checkMesh found wrong, empty when it is fine.
std::string make_mesh(const CaseSpec& spec, const CaseIdentity& identity, double size_factor, Stages stages, Mesh& mesh,
                      const std::function<void(const char*)>& on_stage) {
  const fs::path& folder = stages.folder;
  if (const auto* body = std::get_if<dragcore::MeshBody>(&spec.shape)) {
    MeshRecipe recipe = identity.recipe;
    recipe.refinement *= size_factor;
    return make_snappy_mesh(*body, spec, recipe, identity.symmetry, stages, mesh, on_stage);
  }
  auto request = nlohmann::json::parse(identity.mesh_description);
  request["recipe"]["refinement"] = identity.recipe.refinement * size_factor;
  auto files = dictionaries(spec, identity.symmetry, Rung::standard);
  // No fields: polyDualMesh would read them before their patches have their types.
  std::erase_if(files, [](const auto& file) { return file.first.starts_with("0/"); });
  files["request.json"] = request.dump(1) + "\n";
  write_files(folder, files);
  if (spec.o_grid()) {
    MeshRecipe recipe = identity.recipe;
    recipe.refinement *= size_factor;
    return make_o_grid(spec, recipe, identity.symmetry, stages, mesh, on_stage);
  }

  on_stage("mesh");
  stages.run("mesh", {stages.tools.cfd_mesh.string(), "request.json", "body.msh"});
  on_stage("convert");
  const fs::path poly_mesh = folder / "constant/polyMesh";
  stages.run("convert", {"gmshToFoam", "body.msh"});
  name_patch_types(poly_mesh / "boundary");
  if (spec.octree())
    refine_octree(spec, identity, stages, poly_mesh);
  else
    stages.run("convert", {"polyDualMesh", fmt::format("{}", identity.recipe.dual_feature_angle_deg), "-overwrite"});
  name_patch_types(poly_mesh / "boundary");
  stages.run("convert", {"renumberMesh", "-overwrite"});
  try {
    PolyMesh dual = read_poly_mesh(poly_mesh);
    if (!spec.octree() && lift_edge_cells(dual, "body") > 0) write_points(poly_mesh, dual.points);
    measure(dual, identity.symmetry, mesh);
  } catch (const std::runtime_error& error) {
    throw CaseFailure(error.what());
  }
  return check_mesh(stages, mesh);
}

void require_shape(const CaseSpec& spec, const MeshRecipe& recipe, const Mesh& mesh) {
  if (std::holds_alternative<dragcore::MeshBody>(spec.shape)) return;  // snappy_fault() has seen to it
  const auto exact = dragcore::properties(spec.shape);
  const double allowed = allowed_surface_error(spec.shape, recipe);
  for (const auto& [what, found, needed] :
       {std::tuple{"area", mesh.surface_area, exact.area}, std::tuple{"volume", mesh.surface_volume, exact.volume}})
    if (!(std::abs(found - needed) <= allowed * needed))
      throw CaseFailure(
          fmt::format("the meshed surface has {} {:.6g}, but the {} has {:.6g} (allowed error {:.2g}): the mesh is not of this shape", what,
                      found, dragcore::kind(spec.shape), needed, allowed));
}

nlohmann::json to_json(const Mesh& mesh) {
  nlohmann::json text{
      {"cells", mesh.cells}, {"quality", mesh.quality}, {"surface_area_m2", mesh.surface_area}, {"surface_volume_m3", mesh.surface_volume}};
  for (const auto& [stage, cost] : mesh.cost) text["cost"][stage] = {{"cpu_s", cost.cpu_s}, {"wall_s", cost.wall_s}};
  text["refused"] = nlohmann::json::array();
  for (const auto& attempt : mesh.attempts) text["refused"].push_back({{"recipe", attempt.recipe}, {"reason", attempt.reason}});
  return text;
}

Mesh stored_mesh(const fs::path& folder) {
  const auto text = nlohmann::json::parse(contents(folder / "mesh.json"));
  Mesh mesh{.poly_mesh = folder / "polyMesh",
            .cells = text.at("cells"),
            .quality = text.at("quality").get<std::map<std::string, double>>(),
            .surface_area = text.at("surface_area_m2"),
            .surface_volume = text.at("surface_volume_m3"),
            .cost = {},
            .attempts = {}};
  for (const auto& [stage, cost] : text.at("cost").items()) mesh.cost[stage] = {cost.at("cpu_s"), cost.at("wall_s")};
  for (const auto& refused : text.at("refused"))
    mesh.attempts.push_back({refused.at("recipe"), case_record::Status::failed, refused.at("reason")});
  return mesh;
}

}  // namespace

double thread_cpu_s() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

void Cache::make_folders() const {
  for (const char* folder : {"runs", "mesh", "work", "lock", "fields"}) fs::create_directories(root / folder);
}

Mesh ensure_mesh(const CaseSpec& spec, const CaseIdentity& identity, const Tools& tools, const Cache& cache, const fs::path& work,
                 const std::atomic<bool>& cancel, const std::function<void(const char*)>& on_stage) {
  const fs::path target = cache.mesh(identity.mesh_key);
  FileLock lock(cache.lock("mesh-" + identity.mesh_key));
  while (!lock.try_again()) {
    if (cancel) throw Interrupted();
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
  }
  if (fs::exists(target / "mesh.json")) return stored_mesh(target);

  Mesh mesh;
  const fs::path folder = work / "mesh";
  std::string faults;
  for (const double factor : kSizeFactors) {
    if (spec.octree() && factor != 1.0) break;  // cubes fit the body at this size only
    fs::remove_all(folder);
    faults = make_mesh(spec, identity, factor, {folder, tools, cancel, mesh.cost}, mesh, on_stage);
    if (faults.empty()) break;
    mesh.attempts.push_back({fmt::format("mesh, sizes x {}", factor), case_record::Status::failed, faults});
  }
  if (!faults.empty())
    throw CaseFailure(fmt::format("the mesh was refused at {} sizes; the last time: {}", std::size(kSizeFactors), faults));
  require_shape(spec, identity.recipe, mesh);

  const fs::path complete = work / "mesh_complete";
  fs::remove_all(complete);
  fs::create_directories(complete / "polyMesh");
  for (const char* file : {"points", "faces", "owner", "neighbour", "boundary"})
    fs::rename(folder / "constant/polyMesh" / file, complete / "polyMesh" / file);
  write_files(complete, {{"mesh.json", to_json(mesh).dump(1) + "\n"}, {"description.json", identity.mesh_description + "\n"}});
  fs::remove_all(target);
  fs::rename(complete, target);
  fs::remove_all(folder);
  mesh.poly_mesh = target / "polyMesh";
  return mesh;
}

std::string contents(const fs::path& file) {
  std::ifstream in(file);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

void write_files(const fs::path& folder, const std::map<std::string, std::string>& files) {
  for (const auto& [path, text] : files) {
    fs::create_directories((folder / path).parent_path());
    std::ofstream out(folder / path, std::ios::binary);
    out << text;
    if (!out.flush()) throw std::runtime_error(fmt::format("cannot write {}: is the disk full?", (folder / path).string()));
  }
}

std::string log_excerpt(const fs::path& log) {
  std::istringstream lines(contents(log));
  std::vector<std::string> tail;
  bool fatal = false;
  for (std::string line; std::getline(lines, line);) {
    if (!fatal && line.find("FATAL") != std::string::npos) {
      fatal = true;
      tail.clear();
    }
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    tail.push_back(line.substr(line.find_first_not_of(" \t")));
    if (!fatal && tail.size() > 5) tail.erase(tail.begin());
    if (fatal && tail.size() == 8) break;
  }
  std::string text;
  for (const auto& line : tail) text += (text.empty() ? "" : " | ") + line;
  return text.empty() ? "its log is empty" : text;
}

}  // namespace cfd_cases
