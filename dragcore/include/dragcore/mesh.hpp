#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

namespace dragcore {

/// Triangles over shared vertices. Body frame, metres; counterclockwise seen from outside, so that the normal points into the air.
struct TriangleMesh {
  std::vector<Eigen::Vector3d> vertices;
  std::vector<Eigen::Vector3i> triangles;
};

/// What a mesh is, found by inspect(). Nothing here is an error: a sheet is open, a scan has slivers.
struct MeshProperties {
  int triangles = 0;
  int degenerate = 0;          ///< by is_degenerate(): they carry no force
  int duplicated = 0;          ///< triangles whose three vertex positions occurred before, in any order
  int boundary_edges = 0;      ///< edges of one triangle only
  int non_manifold_edges = 0;  ///< edges of three or more triangles
  int inconsistent_edges = 0;  ///< edges that both neighbours run through in the same direction
  bool closed = false;         ///< no boundary and no non-manifold edge
  bool consistently_wound = false;
  double hole_area = 0.0;   ///< spanned by the loops of the boundary: 0 when closed, the whole area for a flat sheet [m^2]
  bool encloses = false;    ///< a body: without boundary, or with holes of at most a twentieth of its area. Not so: a sheet
  bool inside_out = false;  ///< a consistently wound body with negative volume: normals point inwards
  double area = 0.0;        ///< [m^2]
  double volume = 0.0;      ///< [m^3], signed, holes capped flat; meaningful for a body
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero();  ///< of the volume when closed, else of the area [m]
};

/// True when the area is below 1e-12 of the square of the longest edge: the normal is then made of rounding errors.
bool is_degenerate(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c);

/// Throws std::invalid_argument when an index is out of range or a coordinate is not finite; the message names the triangle or vertex.
void validate(const TriangleMesh& mesh);

/// Finds the properties of a mesh, joining vertices at exactly equal positions first (STL files repeat them).
/// @throws std::invalid_argument as validate() does
MeshProperties inspect(const TriangleMesh& mesh);

/// A sentence for people: counts, closed or open, and each oddity found.
std::string describe(const MeshProperties& properties);

/// The mesh under r -> linear * r + translation. A reflection (negative determinant) also reverses the winding, so that normals keep
/// pointing outwards; scale may be non-uniform. @throws std::invalid_argument if an entry is not finite.
TriangleMesh transformed(const TriangleMesh& mesh, const Eigen::Matrix3d& linear, const Eigen::Vector3d& translation);

/// The mesh with vertices at exactly equal positions joined. Triangles keep their order and number.
TriangleMesh welded(const TriangleMesh& mesh);

/// 64-bit FNV-1a over the coordinates, rounded to 1e-9 of the largest, and the triangles: the name under which results say which surface
/// they used.
std::uint64_t surface_checksum(const TriangleMesh& mesh);

}  // namespace dragcore
