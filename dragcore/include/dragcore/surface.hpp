#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <dragcore/body_class.hpp>
#include <dragcore/mesh.hpp>
#include <dragcore/preparation.hpp>
#include <memory>
#include <numbers>
#include <vector>

namespace dragcore {

class EdgeTable;
namespace kernels {
struct PackedSurface;
}

/// A planar patch: connected triangles in one plane, with the outline and moments that the note's pillow needs.
struct Patch {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  Eigen::Vector3d centroid = Eigen::Vector3d::Zero();
  double area = 0.0;
  Eigen::Matrix3d second_moment = Eigen::Matrix3d::Zero();  ///< integral of (r - centroid)(r - centroid)^T over the patch / area [m^2]
  int part = 0;
  /// Outline, corner to corner, as directed segments that keep the patch on their left seen against the normal; holes included.
  std::vector<std::pair<Eigen::Vector3d, Eigen::Vector3d>> outline;
};

/// How a part resists air so slow that its inertia does not count, Re << 1: as the ellipsoid whose surface has the same second moments
/// (docs/model.md, eq. 15). Exact for ellipsoids and for thin elliptical discs; a cube within 3 %.
struct CreepingResistance {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< centroid of the wetted area [m]
  double wetted = 0.0;                               ///< both sides of sheets [m^2]
  Eigen::Matrix3d drag = Eigen::Matrix3d::Zero();    ///< force = mu drag u, u at `centre`: 6 pi a for a ball [m]
  Eigen::Matrix3d turning = Eigen::Matrix3d::Zero();  ///< torque about `centre` = -mu turning omega: 8 pi a^3 [m^3]
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();  ///< of that torque as traction -mu (spread omega) x (r - centre) [1/m]

  double length() const { return std::sqrt(wetted / std::numbers::pi); }  ///< l of the Reynolds number Re_l: a ball's diameter [m]
};

/// A body or sheet by itself: a shell of the mesh, or several that touch. It has its own class, so its own law, and its own descriptors.
struct Part {
  BodyClass body_class = BodyClass::sheet;
  bool two_sided = true;
  double area = 0.0;                                 ///< of one side [m^2]
  double volume = 0.0;                               ///< of a one-sided body, holes capped flat; 0 of a sheet [m^3]
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< centroid of the area [m]
  double radius = 0.0;                               ///< from `centre` to the farthest corner [m]
  CreepingResistance creeping{};
};

/// Shape and axes of a surface whatever its size, place and triangulation: the second moments (xx, xy, xz, yy, yz, zz) and third moments
/// (xxx, xxy, xxz, xyy, xyz, xzz, yyy, yyz, yzz, zzz) of its area about its centre, over area and powers of radius, and its volume over
/// area and radius.
using ShapeMoments = std::array<double, 17>;

/// A mesh prepared once for any number of evaluations. Its members are to be read: what depends on them is made with them, `packed` above
/// all. Who changes one must `packed.reset()`, and has every sum in double precision from then on.
/// Triangles as structure of arrays (one column per component, contiguous).
/// Triangles without area are dropped: they carry no force.
class Surface {
 public:
  /// Faces of a triangle that feel the air: the outer one of a body, both of a sheet. `automatic` finds out which by prepare(), part by
  /// part; `one` and `two` take the mesh as it is, as one part. Told `one`, walls that are missing feel nothing.
  enum class Sides { automatic = 0, one = 1, two = 2 };

  /// @param mesh  body frame. Told `one`, its triangles are wound outwards
  /// @throws std::invalid_argument  as validate(mesh) does; told `one`, for a mesh that is inside out or inconsistently wound
  explicit Surface(const TriangleMesh& mesh, Sides sides = Sides::automatic);

  /// From what prepare() or expose() made.
  explicit Surface(const Preparation& preparation);

  Eigen::Index size() const { return area.size(); }
  /// Whether both sides of every triangle feel the air.
  bool two_sided() const { return sides == Sides::two; }

  Eigen::ArrayX3d normal;            ///< unit, outward
  Eigen::ArrayX3d centroid;          ///< [m]
  Eigen::ArrayX3d edge_ab, edge_ac;  ///< from the first vertex to the second and third [m]
  Eigen::ArrayXd area;               ///< that the air reaches [m^2]
  Eigen::ArrayXd back;               ///< share of `area` whose back feels the air, too: 0 of bodies, 1 of free sheets
  std::vector<int> part;             ///< index into `parts` of every triangle
  std::vector<Part> parts;
  /// Of the surroundings of every triangle, all that continues it without a sharp edge, weighted by how parallel it is (docs/model.md, eq.
  /// 14): second moment of place per area [m^2] and curvature tensor [1/m], each as xx, xy, xz, yy, yz, zz. Curvature is positive where
  /// convex: 1/R along any tangent of a ball, 0 along the generators of a cylinder and on flat faces.
  Eigen::Array<double, Eigen::Dynamic, 6> second_moment, curvature;
  std::vector<int> patch;  ///< index into `patches` of every triangle
  std::vector<Patch> patches;
  Sides sides = Sides::one;                  ///< `one` or `two` where that holds for all parts, else `automatic`
  std::shared_ptr<const Exposure> exposure;  ///< who stands in whose wind; null where nothing does, or nobody looked
  bool exposed = false;                      ///< somebody looked: expose()
  bool convex = false;                       ///< nothing can stand in anything's wind: one closed convex body, or one flat sheet
  std::vector<Finding> report;               ///< of the preparation

  double total_area = 0.0;                           ///< of one side [m^2]
  double volume = 0.0;                               ///< sum over the parts [m^3]
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< centroid of the area [m]
  double radius = 0.0;                               ///< from `centre` to the farthest corner [m]
  BodyClass body_class = BodyClass::sheet;           ///< of the part with the largest area
  ShapeMoments shape_moments{};                      ///< what tells this body from others

  std::shared_ptr<const kernels::PackedSurface> packed;  ///< all this as the kernels want it; null where the library has none

 private:
  void build(const Preparation& preparation);
  using Triangles = std::vector<Eigen::Vector3i>;
  using Vertices = std::vector<Eigen::Vector3d>;
  void find_patches(const Triangles& triangles, const Vertices& vertices, const EdgeTable& edges);
  void find_parts();
  void find_creeping_resistance();
  void find_classes();
  void find_shape_moments();
  void find_regions(const Triangles& triangles, const EdgeTable& edges);
};

/// A symmetric tensor from its row of six: xx, xy, xz, yy, yz, zz.
template <class Row>
Eigen::Matrix3d symmetric(const Row& row) {
  Eigen::Matrix3d full;
  full << row[0], row[1], row[2], row[1], row[3], row[4], row[2], row[4], row[5];
  return full;
}

}  // namespace dragcore
