#pragma once

#include <atomic>
#include <compare/case_record/case_record.hpp>
#include <filesystem>
#include <functional>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "cfd_cases/flow_case/case_key.hpp"
#include "cfd_cases/programs/tools.hpp"

namespace cfd_cases {

/// The user asked to end; nothing is recorded for the case at hand.
struct Interrupted : std::runtime_error {
  Interrupted() : std::runtime_error("interrupted") {}
};

/// A case cannot be solved: becomes its `reason` with status `failed`.
struct CaseFailure : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Folders of the cache. Everything in them appears by a rename, when it is complete.
struct Cache {
  std::filesystem::path root;

  std::filesystem::path run(const std::string& key) const { return root / "runs" / (key + ".h5"); }
  std::filesystem::path mesh(const std::string& mesh_key) const { return root / "mesh" / mesh_key; }
  std::filesystem::path work(const std::string& key) const { return root / "work" / key; }
  std::filesystem::path fields(const std::string& key) const { return root / "fields" / key; }  ///< of a finished case others start from
  std::filesystem::path lock(const std::string& key) const { return root / "lock" / key; }
  void make_folders() const;
};

/// A mesh of the cache and what was measured on it.
struct Mesh {
  std::filesystem::path poly_mesh;  ///< folder with points, faces, owner, neighbour, boundary
  int cells = 0;
  std::map<std::string, double> quality;               ///< of checkMesh
  double surface_area = 0.0;                           ///< of the whole body [m^2]
  double surface_volume = 0.0;                         ///< [m^3]
  std::map<std::string, case_record::StageCost> cost;  ///< "mesh" and "convert", of the day it was made
  std::vector<case_record::Attempt> attempts;          ///< sizes that checkMesh refused
};

/// Takes the mesh from the cache, or makes it in `work` and puts it there: cfd_mesh, gmshToFoam, polyDualMesh, renumberMesh, checkMesh;
/// snappyHexMesh for a body given by triangles; an O-grid by o_grid(). Of two callers who need the same mesh the second waits for the
/// first.
/// @param on_stage  told "mesh" and "convert" when they begin
/// @throws CaseFailure when a tool fails, checkMesh refuses all sizes, cubes do not fit the body, or area and volume of the wall are not
/// those of the shape
/// @throws Interrupted when `cancel` becomes true
Mesh ensure_mesh(const CaseSpec& spec, const CaseIdentity& identity, const Tools& tools, const Cache& cache,
                 const std::filesystem::path& work, const std::atomic<bool>& cancel, const std::function<void(const char*)>& on_stage);

/// Writes files by their path in `folder`, making folders as needed.
void write_files(const std::filesystem::path& folder, const std::map<std::string, std::string>& files);

/// CPU time of this thread so far [s], for what is computed here and not by a program.
double thread_cpu_s();

/// A file as text; empty when it cannot be read.
std::string contents(const std::filesystem::path& file);

/// The lines of a log that say what went wrong: from OpenFOAM's "FATAL" on, else the last ones.
std::string log_excerpt(const std::filesystem::path& log);

}  // namespace cfd_cases
