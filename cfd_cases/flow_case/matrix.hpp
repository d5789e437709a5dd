#pragma once

#include <dragcore/pose.hpp>
#include <dragcore/shapes.hpp>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "cfd_cases/mesh/mesh_recipe.hpp"

namespace cfd_cases {

/// A matrix file that cannot be used; the message begins with "file:line:column: ".
struct ConfigurationError : std::invalid_argument {
  using std::invalid_argument::invalid_argument;
};

/// Choices of the discretised equations that a matrix may override, each for a sensitivity study. The defaults are the recipe of record.
struct Numerics {
  double relaxation_velocity = 0.85;  ///< under-relaxation factors of SIMPLEC
  double relaxation_pressure = 0.8;
  double relaxation_turbulence = 0.7;
  std::string convection = "linear_upwind";  ///< of the velocity: "linear_upwind", "upwind", "linear", "lust"
  std::string gradient = "unlimited";        ///< "unlimited" or "cell_limited", which differs by up to 20 % on an inclined plate
  double turbulence_intensity = 0.01;        ///< of the undisturbed air
  double viscosity_ratio = 10.0;             ///< eddy viscosity of the undisturbed air / nu
  std::string wall = "spalding";             ///< eddy viscosity on the wall: "spalding" (all y+), "log_law", "low_re" (none, k = 0)

  bool operator==(const Numerics&) const = default;
};

/// When a solution is good enough; see convergence.hpp.
struct StopPolicy {
  int min_iterations = 150;
  int max_iterations = 800;
  int window = 100;          ///< iterations over which all six channels must be flat
  int average = 60;          ///< last iterations of that window, whose mean is the result
  double tolerance = 0.003;  ///< of max(|C_D|, floor): largest spread and drift over the window
  double floor = 0.1;
  double mean_error = 0.01;  ///< of max(|C_D|, floor): largest standard error of the mean of a wake that does not settle
};

/// What is of record for a flow model, where a matrix says nothing else. Transition needs a quiet wind and a wall that is resolved. By it
/// the wake of a smooth body swings by some 5 % for ever, and a mean within 3 % is more than its method is worth.
Numerics numerics_of(const std::string& flow_model);
StopPolicy stop_policy_of(const std::string& flow_model);

/// Angles of docs/conventions.md, in degrees as they stand in the matrix.
struct PoseDegrees {
  double incidence = 0.0, yaw = 0.0, roll = 0.0;
  dragcore::Pose radians() const;
};

/// A steady spin of the body about its centroid.
struct Spin {
  std::string axis;    ///< sum of body axes: "z", "xy", "xyz"; empty: the body is at rest
  double ratio = 0.0;  ///< omega L_ref / U; 0: in still air

  bool in_still_air() const { return !axis.empty() && ratio == 0.0; }
  Eigen::Vector3d direction() const;  ///< unit vector, body frame; zero when at rest
};

/// Time of a time-accurate run, in units of L_ref / U.
struct TimeSpan {
  double step = 0.0125;
  double duration = 20.0;
  double discard = 8.0;  ///< before the mean begins

  bool operator==(const TimeSpan&) const = default;
};

/// One case of a matrix.
struct CaseSpec {
  std::string name;  ///< made by case_name()
  std::string tier;
  dragcore::Shape shape;
  PoseDegrees pose;
  double reynolds = 1e5;
  std::string flow_model = "k_omega_sst";  ///< or "laminar", "k_omega_sst_lm" (transition); in time: "laminar_unsteady", "k_omega_sst_ddes"
  Spin spin;
  TimeSpan time;  ///< of a time-accurate run
  std::string mesh_level = "medium";
  MeshRecipe recipe;       ///< but for the level
  bool half_model = true;  ///< where symmetry allows
  bool turn_wind = false;  ///< the mesh stays with the body and the wind turns, so that poses share a mesh; an octree always does
  std::string variant;     ///< word added to the name where a sweep repeats poses with other numerics
  bool held_out = false;
  Numerics numerics;
  StopPolicy stop;
  int retries = 1;                        ///< rungs of the retry ladder after the first
  double timeout_s = 1800.0;              ///< wall time of one try of the solver [s]
  std::shared_ptr<const CaseSpec> start;  ///< from whose fields the solver starts; empty: from uniform flow

  bool octree() const { return recipe.hexahedra != 0.0; }
  bool o_grid() const { return recipe.first_layer != 0.0; }
  bool mesh_in_body_frame() const { return turn_wind || octree(); }
  PoseDegrees mesh_pose() const { return mesh_in_body_frame() ? PoseDegrees{} : pose; }  ///< of the body in the frame of the mesh
  bool laminar() const { return flow_model == "laminar" || flow_model == "laminar_unsteady"; }
  /// Solved in time: wakes that shed, scale-resolving models, and bodies that spin in a wind.
  bool time_accurate() const { return flow_model == "laminar_unsteady" || flow_model == "k_omega_sst_ddes" || spin.ratio > 0.0; }
};

/// "plate_incidence-030_re-1e5_medium", "cone-apex_angle_deg-30_incidence-000_re-1e2-laminar_fine": parameters that differ from the shape's
/// defaults, angles that are not zero (incidence where all are), spin, Reynolds number, flow model, "octree" or
/// "o-grid", level, variant.
std::string case_name(const CaseSpec& spec);

struct Matrix {
  std::string tier;
  std::filesystem::path file;
  std::vector<CaseSpec> cases;  ///< in the order of the file
};

/// Reads a TOML matrix; docs/adding_a_case.md shows the format.
/// @throws ConfigurationError on a syntax error, an unknown key, a value out of range or of the wrong type, or two equal cases
Matrix parse_matrix(std::string_view text, const std::filesystem::path& file);

/// @param name  a file, or the name of a tier ("smoke", "quick", "reference") in cfd_cases/matrices of the source tree or the working
/// folder
/// @throws ConfigurationError as parse_matrix() does, and when there is no such file (naming the places looked at)
Matrix load_matrix(const std::string& name);

}  // namespace cfd_cases
