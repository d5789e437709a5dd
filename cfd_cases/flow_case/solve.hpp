#pragma once

#include <atomic>
#include <compare/case_record/case_record.hpp>
#include <functional>
#include <string>

#include "cfd_cases/flow_case/case_mesh.hpp"
#include "cfd_cases/mesh/poly_mesh.hpp"

namespace cfd_cases {

/// What a case is doing: stage "mesh", "convert", "solve", "post"; iteration and C_D while it solves.
struct Progress {
  std::string stage;
  int iteration = 0;
  double drag_coefficient = 0.0;
};

/// Meshes and solves one case in cache.work(key) and returns its record, whatever its status: a failure of the case is a result, too.
/// @param ranks        MPI ranks of the solver; they are not part of the key
/// @param keep_fields  leave the last fields in cache.fields(key), for cases that start from them
/// @throws Interrupted when `cancel` becomes true, std::runtime_error when the machine fails (no space, no rights)
case_record::CaseRecord solve_case(const CaseSpec& spec, const CaseIdentity& identity, const Tools& tools, const Cache& cache, int ranks,
                                   bool keep_fields, const std::atomic<bool>& cancel,
                                   const std::function<void(const Progress&)>& on_progress);

/// A record of what was asked, without a result: for whoever knows better why there is none.
case_record::CaseRecord asked_record(const CaseSpec& spec, const CaseIdentity& identity, const Tools& tools);

/// Pressure and shear on the faces of the patch "body" from the last time folder of a case, checked against the load of that iteration (of
/// the meshed faces): the sums of p dA and of the shear must give its pressure and its viscous force to 1e-3 of the force.
/// @param scale  U^2 / 2, which turns OpenFOAM's kinematic pressure into C_p
/// @throws CaseFailure when they do not, or the fields are incomplete
case_record::SurfaceSample read_surface(const std::filesystem::path& case_folder, const PolyMesh& mesh,
                                        const case_record::Load& meshed_load, double scale);

/// How many cells of the mesh turn with the body: those of the zone that topoSet made. @throws CaseFailure when there are none, for then
/// the rotating frame idles and the solver still returns 0
int spinning_cells(const std::filesystem::path& case_folder);

/// Newest time folder of a case with results. @throws CaseFailure when there is none
std::filesystem::path last_time_folder(const std::filesystem::path& case_folder);

}  // namespace cfd_cases
