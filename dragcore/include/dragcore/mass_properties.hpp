#pragma once

#include <dragcore/mesh.hpp>
#include <dragcore/stepping.hpp>

namespace dragcore {

/// Mass and inertia about the centre of mass, and where that lies. Goes as it is wherever MassProperties are asked for.
struct MeshMass : MassProperties {
  Eigen::Vector3d centre_of_mass = Eigen::Vector3d::Zero();  ///< in the frame of the mesh: `Motion::reference_point`, or recentred() [m]
};

/// Of a solid of uniform density inside a closed mesh: exact integrals over the polyhedron. `added` stays zero.
/// A shell inside another and wound inwards is a cavity; where parts overlap, each counts.
/// @param density  of the material [kg/m^3], a mean one for what is hollow: mass over volume
/// @throws std::invalid_argument  as validate(mesh); if the mesh is open, inside out, inconsistently wound or without volume, or the
/// density is not positive: found, needed, what to do; std::overflow_error where a result is beyond the range of numbers
/// @accuracy       rounding, also far from the origin
MeshMass mass_properties(const TriangleMesh& mesh, double density);

/// Of a skin of uniform mass per area and no thickness on every triangle, open or closed: paper, sails, hulls of sheet metal.
/// @param area_density  [kg/m^2]
/// @throws std::invalid_argument  as validate(mesh); if the mesh has no area, or the density is not positive
MeshMass sheet_mass_properties(const TriangleMesh& mesh, double area_density);

/// The mesh moved so that `origin` [m] becomes the origin of its frame: the centre of mass, say, so that Motion::reference_point can stay
/// zero. Axes keep their directions. @throws std::invalid_argument if `origin` is not finite
TriangleMesh recentred(const TriangleMesh& mesh, const Eigen::Vector3d& origin);

/// The same about MeshProperties::centroid: of the volume of a closed mesh, of the area of another. That is the centre of mass of either at
/// uniform density. @throws std::invalid_argument as validate(mesh)
TriangleMesh recentred(const TriangleMesh& mesh);

}  // namespace dragcore
