#pragma once

#include <map>
#include <string>

#include "cfd_cases/flow_case/matrix.hpp"
#include "cfd_cases/mesh/mesh_recipe.hpp"

namespace cfd_cases {

/// Undisturbed air of every case: the coefficients do not depend on either [m/s], [kg/m^3].
inline constexpr double kSpeed = 1.0;
inline constexpr double kDensity = 1.0;

/// nu = U L_ref / Re [m^2/s]
double kinematic_viscosity(const CaseSpec& spec);

/// Rungs of the retry ladder: "standard" takes the factors of the matrix; "cautious" holds them below values at which SIMPLEC has not been
/// seen to diverge, for twice the iterations.
enum class Rung { standard, cautious };
std::string to_string(Rung rung);
Numerics numerics_on(Rung rung, const Numerics& asked);

/// What the air and the body do, in the frame of the mesh.
struct Flow {
  Eigen::Vector3d wind = Eigen::Vector3d::Zero();              ///< [m/s]
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();  ///< [rad/s]
};
Flow flow_of(const CaseSpec& spec);

/// "simpleFoam", or "pimpleFoam" where the case is time-accurate.
std::string solver_of(const CaseSpec& spec);

/// The files of a case but its mesh, by path in the case folder. Patches: inlet, outlet, sides (a box of air) or farfield (a ball, an
/// octree), body and, in a half model, symmetry. A body that spins in still air is solved in its rotating frame (MRF, a ball of cells), one
/// that spins in a wind with a mesh that turns as a whole. The body's force and moment (about the origin, its centroid) are written at
/// every iteration. A file named "stop" in the case folder makes the solver do one more iteration, write its fields and end.
std::map<std::string, std::string> dictionaries(const CaseSpec& spec, Symmetry symmetry, Rung rung);

/// system/decomposeParDict: slices across the wind. Debian's scotch and metis are stubs that abort.
std::string decomposition(int ranks);

}  // namespace cfd_cases
