#pragma once

// The one thing a source of references (OpenFOAM here; a wind tunnel, another solver) and the comparison share. Plain data, no file format:
// compare/store writes it, docs/results.md describes it on disk. Frames, signs and units: docs/conventions.md.

#include <Eigen/Core>
#include <array>
#include <dragcore/pose.hpp>
#include <dragcore/shapes.hpp>
#include <map>
#include <string>
#include <vector>

namespace case_record {

/// How a case ended. Only `steady` and `statistically_steady` carry coefficients that are compared.
enum class Status {
  steady,                ///< all six channels flat over the window and free of drift
  statistically_steady,  ///< oscillates about a mean without drift: averaged, u_stat is its standard error
  drifting,              ///< the limit of iterations came first
  diverged,              ///< floating point failure, or coefficients outside what is physically plausible
  timed_out,
  failed,  ///< a tool failed, or its output was not acceptable (mesh check, force balance)
};
std::string to_string(Status status);
Status status_from(const std::string& word);  ///< @throws std::invalid_argument on an unknown word
inline bool is_usable(Status status) { return status == Status::steady || status == Status::statistically_steady; }

/// Force [N] and moment about the body's centroid [N m] of the air on the whole body (a half model counts double), wind frame.
struct Load {
  Eigen::Vector3d force_pressure = Eigen::Vector3d::Zero();
  Eigen::Vector3d force_viscous = Eigen::Vector3d::Zero();
  Eigen::Vector3d moment_pressure = Eigen::Vector3d::Zero();
  Eigen::Vector3d moment_viscous = Eigen::Vector3d::Zero();

  Eigen::Vector3d force() const { return force_pressure + force_viscous; }
  Eigen::Vector3d moment() const { return moment_pressure + moment_viscous; }
};

/// Faces of the body's surface with what the air does to them; wind frame, at the last iteration. A half model lists its half.
struct SurfaceSample {
  Eigen::Matrix3Xd centre;       ///< [m]
  Eigen::Matrix3Xd area_vector;  ///< normal out of the body times area [m^2]
  Eigen::VectorXd pressure_coefficient;
  Eigen::Matrix3Xd friction_coefficient;  ///< wall shear stress of the air on the body / q
};

/// One try at solving a case: the rung of the retry ladder and how it went.
struct Attempt {
  std::string recipe;  ///< "standard", "cautious", ...
  Status status = Status::failed;
  std::string reason;
};

/// Cost of one stage: "mesh" (gmsh), "convert" (gmshToFoam, polyDualMesh, renumberMesh, checkMesh), "solve", "post".
struct StageCost {
  double cpu_s = 0.0;  ///< user + system time of the processes
  double wall_s = 0.0;
};

/// One case: what was asked, what came out, how sure, and what it cost.
struct CaseRecord {
  // What was asked.
  std::string name;         ///< made from the matrix: "plate_incidence-030_re-1e5_medium"
  std::string key;          ///< SHA-256 of `description`
  std::string description;  ///< canonical JSON of all that determines the result
  std::string source;       ///< "openfoam-1912"; of an experiment its key in references.bib
  std::string tier;
  dragcore::Shape shape;  ///< a MeshBody carries its triangles
  dragcore::Pose pose;
  double reynolds = 0.0;
  std::string flow_model;  ///< "laminar", "k_omega_sst", "k_omega_sst_lm" (transition); in time: "laminar_unsteady", "k_omega_sst_ddes"
                           ///< (scale-resolving); `experiment`
  std::string mesh_level;  ///< "coarse", "medium", "fine", "finest"; empty for an experiment
  bool held_out = false;   ///< not to be used for fitting
  double density = 1.0;    ///< [kg/m^3]
  double speed = 1.0;      ///< of the coefficients [m/s]: that of the undisturbed air, or |omega| L_ref of a body that spins in still air
  bool still_air = false;  ///< no wind at all
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();  ///< of the body, about its centroid; wind frame [rad/s]
  double viscosity = 0.0;                                      ///< kinematic [m^2/s]

  // What came out.
  Status status = Status::failed;
  std::string reason;  ///< empty when usable
  std::vector<Attempt> attempts;
  Load load;       ///< mean over the averaging window
  Load load_last;  ///< at the last iteration, the one `surface` belongs to
  SurfaceSample surface;
  std::array<bool, 6> known = {true, true, true, true, true, true};  ///< of (F, M): an experiment may have measured the drag alone. What
                                                                     ///< is not known is 0 in `load` and means nothing
  bool half_model = false;
  int iterations = 0;     ///< of the solver, over all attempts
  int averaged_over = 0;  ///< iterations in the window of `load`

  // How sure: standard uncertainties of (F_x, F_y, F_z) [N] and (M_x, M_y, M_z) [N m]. Discretisation is assessed by compare, over mesh
  // levels.
  using Channels = Eigen::Matrix<double, 6, 1>;
  Channels u_iteration = Channels::Zero();    ///< remaining drift
  Channels u_statistical = Channels::Zero();  ///< standard error of the mean of an oscillating flow
  Channels u_null = Channels::Zero();         ///< size of the channels that symmetry says are zero
  Channels u_stated = Channels::Zero();       ///< of an experiment, all of its u: as its source states it, or as judged

  // What it cost and with what.
  int cells = 0;
  std::map<std::string, double> mesh_quality;  ///< of checkMesh: "max_non_orthogonality_deg", "max_skewness", "max_aspect_ratio"
  double surface_area = 0.0;                   ///< of the wall as meshed, whole body [m^2]
  double surface_volume = 0.0;                 ///< enclosed by the wall as meshed, whole body [m^3]
  std::string surface_checksum;                ///< dragcore::surface_checksum of the triangles dragcore makes of the shape, hexadecimal
  std::map<std::string, StageCost> cost;
  std::map<std::string, std::string> tools;  ///< "openfoam": "1912", "gmsh": "4.8.4"
  std::string finished;                      ///< UTC, ISO 8601

  bool spins() const { return !angular_velocity.isZero(); }

  /// Measured, not solved: without mesh, surface and cost. Its load is whole: which part is viscous nobody knows, and all of it is under
  /// pressure.
  static constexpr const char* experiment = "experiment";
  bool is_experiment() const { return flow_model == experiment; }
  bool knows_force() const { return known[0] && known[1] && known[2]; }
  bool knows_moment() const { return known[3] && known[4] && known[5]; }

  /// Variance of (F, M) as far as a single record knows it: without the mesh and the method.
  Channels own_variance() const {
    return u_iteration.cwiseAbs2() + u_statistical.cwiseAbs2() + u_null.cwiseAbs2() + u_stated.cwiseAbs2();
  }
};

}  // namespace case_record
