#include "cfd_cases/programs/tools.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>
#include <regex>
#include <thread>

#include "cfd_cases/programs/subprocess.hpp"

namespace cfd_cases {

namespace fs = std::filesystem;

namespace {

constexpr const char* kInstallFoam = "apt-get install openfoam";

std::map<std::string, std::string> tool_environment() {
  const char* project = std::getenv("WM_PROJECT_DIR");
  // Debian's OpenFOAM finds its etc folder only through this variable. Open MPI refuses to run as root unless told twice.
  std::map<std::string, std::string> environment{{"WM_PROJECT_DIR", project && *project ? project : "/usr/share/openfoam"}};
  if (geteuid() == 0) environment.insert({{"OMPI_ALLOW_RUN_AS_ROOT", "1"}, {"OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1"}});
  // A solver makes and drops fields in every iteration. By default glibc maps each anew and gives it back, and the kernel zeroes its pages
  // again: a part of the CPU time that docs/cfd.md measures. Keeping the memory changes no result and is no part of a key.
  environment.insert(
      {{"MALLOC_MMAP_THRESHOLD_", "1073741824"}, {"MALLOC_TRIM_THRESHOLD_", "2147483647"}, {"MALLOC_TOP_PAD_", "134217728"}});
  return environment;
}

fs::path beside_this_program(const char* name) {
  std::error_code none;
  return fs::read_symlink("/proc/self/exe", none).parent_path() / name;
}

std::string first_match(const std::string& text, const char* pattern) {
  std::smatch match;
  return std::regex_search(text, match, std::regex(pattern)) ? match[1].str() : std::string();
}

Check check_foam_programs() {
  Check check{.name = "OpenFOAM programs"};
  std::string missing;
  for (const char* program : {"gmshToFoam", "polyDualMesh", "surfaceFeatureExtract", "blockMesh", "snappyHexMesh", "renumberMesh",
                              "checkMesh", "simpleFoam", "decomposePar", "reconstructPar"})
    if (find_program(program).empty()) missing += std::string(missing.empty() ? "" : ", ") + program;
  check.good = missing.empty();
  check.found = check.good ? find_program("simpleFoam").parent_path().string() : "not on PATH: " + missing;
  if (!check.good) check.fix = kInstallFoam;
  return check;
}

Check check_foam_etc(const std::map<std::string, std::string>& environment) {
  const fs::path control = fs::path(environment.at("WM_PROJECT_DIR")) / "etc/controlDict";
  Check check{.name = "OpenFOAM etc folder", .good = fs::exists(control), .found = control.string()};
  if (!check.good) {
    check.found += " is missing";
    check.fix = std::string(kInstallFoam) + ", or set WM_PROJECT_DIR to the folder that holds etc/controlDict";
  }
  return check;
}

}  // namespace

std::vector<Check> examine(const fs::path& cache, fs::path cfd_mesh) {
  const auto environment = tool_environment();
  std::vector<Check> checks{check_foam_programs(), check_foam_etc(environment)};
  const bool foam = checks[0].good && checks[1].good;

  Check version{.name = "OpenFOAM version"};
  if (foam) version.found = first_match(output_of({"simpleFoam", "-help"}, environment), R"(Using: OpenFOAM-\S*\s*\(?(\w+))");
  version.good = !version.found.empty();
  if (!version.good) {
    version.found = "unknown";
    version.fix = std::string("simpleFoam -help does not run; ") + kInstallFoam;
  }
  checks.push_back(version);

  if (cfd_mesh.empty()) cfd_mesh = beside_this_program("cfd_mesh");
  Check gmsh{.name = "gmsh, through cfd_mesh"};
  gmsh.found = first_match(output_of({cfd_mesh.string(), "--version"}, environment), R"((\S+))");
  gmsh.good = !gmsh.found.empty();
  if (!gmsh.good) {
    gmsh.found = cfd_mesh.string() + " does not run";
    gmsh.fix = "apt-get install libgmsh-dev, then build the target cfd_mesh";
  }
  checks.push_back(gmsh);

  const fs::path mpirun = find_program("mpirun");
  checks.push_back({.name = "MPI",
                    .good = !mpirun.empty(),
                    .needed = false,
                    .found = mpirun.empty() ? "no mpirun on PATH (only --ranks needs it)" : mpirun.string(),
                    .fix = mpirun.empty() ? "apt-get install openmpi-bin" : ""});

  const unsigned cores = std::max(1u, std::thread::hardware_concurrency());
  checks.push_back({.name = "processor cores", .good = true, .needed = false, .found = fmt::format("{}: run with -j {}", cores, cores)});

  // A case folder takes about 6 MB per 10,000 cells; 2 GB carry the quick tier with everything kept.
  fs::path existing = fs::absolute(cache);
  while (!fs::exists(existing) && existing.has_relative_path()) existing = existing.parent_path();
  const double gigabytes = static_cast<double>(fs::space(existing).available) / 1e9;
  Check disk{.name = "disk space", .good = gigabytes > 2.0, .found = fmt::format("{:.1f} GB free at {}", gigabytes, existing.string())};
  if (!disk.good) disk.fix = "free at least 2 GB, or choose another folder with --cache";
  checks.push_back(disk);
  return checks;
}

Tools find_tools(fs::path cfd_mesh) {
  cfd_mesh = cfd_mesh.empty() ? beside_this_program("cfd_mesh") : fs::absolute(cfd_mesh);  // it is run from other folders
  std::string faults;
  Tools tools{.cfd_mesh = cfd_mesh, .environment = tool_environment(), .openfoam = {}, .gmsh = {}};
  for (const Check& check : examine(".", cfd_mesh)) {
    if (!check.good && check.needed) faults += fmt::format("\n  {}: {}. Fix: {}", check.name, check.found, check.fix);
    if (check.name == "OpenFOAM version") tools.openfoam = check.found;
    if (check.name == "gmsh, through cfd_mesh") tools.gmsh = check.found;
  }
  if (!faults.empty()) throw EnvironmentFault("cases cannot be solved here:" + faults);
  return tools;
}

}  // namespace cfd_cases
