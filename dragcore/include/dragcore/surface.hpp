#pragma once

#include <Eigen/Core>
#include <dragcore/body_class.hpp>
#include <dragcore/mesh.hpp>
#include <vector>

namespace dragcore {

/// A planar patch: connected triangles in one plane, with the outline and moments that the pillow effect needs.
struct Patch {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero();
  double area = 0.0;
  Eigen::Matrix3d second_moment = Eigen::Matrix3d::Zero();  ///< integral of (r - centroid)(r - centroid)^T over the patch / area [m^2]
  /// Outline, corner to corner, as directed segments that keep the patch on their left seen against the normal; holes included.
  std::vector<std::pair<Eigen::Vector3d, Eigen::Vector3d>> outline;
};

/// A mesh prepared once for any number of evaluations. Triangles as structure of arrays (one column per component, contiguous).
/// Triangles without area are dropped: they carry no force.
class Surface {
 public:
  /// Faces of a triangle that feel the air: the outer one of a body, both of a sheet. `automatic` finds out which it is:
  /// MeshProperties::encloses. A body with larger holes (a car without its floor, say) counts as a sheet unless told, and then its far
  /// walls feel the wind from inside. Told `one`, it is a body whose missing walls feel nothing: close it where the wind may come from
  /// there.
  enum class Sides { automatic = 0, one = 1, two = 2 };

  /// @param mesh  body frame; a body's triangles are wound outwards
  /// @throws std::invalid_argument  as validate(mesh) does; for a one-sided mesh that is inside out or inconsistently wound: the message
  /// says how to repair it
  explicit Surface(const TriangleMesh& mesh, Sides sides = Sides::automatic);

  Eigen::Index size() const { return area.size(); }
  bool two_sided() const { return sides == Sides::two; }

  Eigen::ArrayX3d normal;            ///< unit, outward
  Eigen::ArrayX3d centroid;          ///< [m]
  Eigen::ArrayX3d edge_ab, edge_ac;  ///< from the first vertex to the second and third [m]
  Eigen::ArrayXd area;               ///< [m^2]
  /// Curvature tensor of the surroundings of every triangle, from the dihedral angles of its smooth edges (below 50 degrees): xx, xy, xz,
  /// yy, yz, zz, positive where convex [1/m]. 1/R along any tangent of a ball, 0 along the generators of a cylinder and on flat faces.
  Eigen::Array<double, Eigen::Dynamic, 6> curvature;
  std::vector<int> patch;  ///< index into `patches` of every triangle
  std::vector<Patch> patches;
  Sides sides = Sides::one;  ///< never `automatic`

  double total_area = 0.0;                           ///< of one side [m^2]
  double volume = 0.0;                               ///< of a one-sided body, holes capped flat; 0 of a sheet [m^3]
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< centroid of the area [m]
  double radius = 0.0;                               ///< from `centre` to the farthest corner [m]
  BodyClass body_class = BodyClass::sheet;           ///< as found; overwrite it where you know better: only law_for() reads it
};

}  // namespace dragcore
