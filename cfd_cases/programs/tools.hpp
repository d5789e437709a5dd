#pragma once

#include <filesystem>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

namespace cfd_cases {

/// Something outside the program is missing; the message says what and how to mend it.
struct EnvironmentFault : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The programs that make a case, and their versions, which are part of every key.
struct Tools {
  std::filesystem::path cfd_mesh;
  std::map<std::string, std::string> environment;  ///< for OpenFOAM and Open MPI
  std::string openfoam;                            ///< "1912"
  std::string gmsh;                                ///< "4.8.4"

  std::map<std::string, std::string> versions() const { return {{"gmsh", gmsh}, {"openfoam", openfoam}}; }
};

/// @param cfd_mesh  the meshing program; when empty, `cfd_mesh` beside the running program
/// @throws EnvironmentFault naming every tool that is missing, with the fix of each
Tools find_tools(std::filesystem::path cfd_mesh = {});

/// One line of `dragval doctor`.
struct Check {
  std::string name;
  bool good = false;
  bool needed = true;  ///< false: only some options need it
  std::string found;
  std::string fix;  ///< empty when good
};

/// OpenFOAM's programs and their etc folder, gmsh, MPI, cores, and space for `cache`.
std::vector<Check> examine(const std::filesystem::path& cache, std::filesystem::path cfd_mesh = {});

}  // namespace cfd_cases
