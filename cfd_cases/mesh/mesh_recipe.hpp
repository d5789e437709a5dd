#pragma once

#include <Eigen/Geometry>
#include <dragcore/pose.hpp>
#include <dragcore/shapes.hpp>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

namespace cfd_cases {

/// Which part of the flow is meshed: all of it, or the half on the positive side of a plane through the centroid in which flow and body are
/// symmetric.
enum class Symmetry { none, plane_y, plane_z };
std::string to_string(Symmetry symmetry);
int halved_axis(Symmetry symmetry);               ///< the axis square to the plane, -1 where there is none
Symmetry symmetry_from(const std::string& word);  ///< @throws std::invalid_argument on an unknown word

/// The symmetry plane that body, pose and spin allow: y = 0 first (poses in incidence), then z = 0 (poses in yaw). A body that spins has
/// one only square to its axis.
/// @param spin_axis  body frame; zero for a body at rest
/// @param to_wind    from the frame of the mesh, whose half is cut along one of its own planes; the identity where it is the wind frame
Symmetry find_symmetry(const dragcore::Shape& shape, const dragcore::Pose& pose, const Eigen::Vector3d& spin_axis = Eigen::Vector3d::Zero(),
                       const Eigen::Matrix3d& to_wind = Eigen::Matrix3d::Identity());

/// The length that all sizes below are multiples of: the second largest extent of the body, that is the shorter side of a plate, the
/// diameter of a body of revolution [m].
double body_scale(const dragcore::Shape& shape);

/// Sizes of the unstructured mesh and of the box of air around the body, in units of body_scale(). `refinement` multiplies every cell size
/// and no distance, so that levels are geometrically similar.
struct MeshRecipe {
  double body_size = 0.05;   ///< tetrahedron edge on the body
  double tip_size = 0.01;    ///< at the point of a cone or teardrop, where faces of body_size would be wider than the body
  double growth = 0.2;       ///< growth of the size per distance from a refined region
  double wake_size = 0.12;   ///< in the box around the body and its near wake
  double wake_margin = 0.4;  ///< of that box beside and in front of the body
  double wake_length = 3.5;  ///< of that box behind the body
  double outer_size = 0.3;   ///< in the second box
  double outer_margin = 1.2;
  double outer_length = 8.5;
  double far_size = 1.6;  ///< largest size
  double upstream = 8.0;  ///< air between the body and the inlet; blockage costs 3 % of C_D at 5 on a cube
  double downstream = 15.0;
  double sideways = 8.0;
  double dual_feature_angle_deg = 60.0;  ///< edges sharper than this stay edges in the polyhedral dual; see kept_feature_angle_deg()
  double refinement = 1.0;

  // What follows is 0 in the recipe of record and then left out of the description, so that a new choice does not rename old cases.
  double far_radius = 0.0;  ///< of a ball of air around the body; 0: the box above
  double seed = 0.0;        ///< of the mesh generator: another mesh of the same sizes
  double hexahedra = 0.0;   ///< 1: an octree of cubes in the body frame instead of polyhedra; bodies with flat sides only
  double wake_rise = 0.0;   ///< of the wake box to the lee side, where mesh and body stay and the wind turns; 0: wake_margin
  double first_layer =
      0.0;  ///< thickness of the first layer of an O-grid (o_grid.hpp), which takes the place of polyhedra; 0: no such grid
};

/// The largest relative error of area and volume that a correct mesh may have: rounding for flat sides, faceting for round ones.
double allowed_surface_error(const dragcore::Shape& shape, const MeshRecipe& recipe);

/// The angle for polyDualMesh, which keeps the edges that turn by more [deg]: `asked`, or 0.9 of the smallest turn between two flat sides
/// of the body where that is not more than `asked` and the dual would bevel it.
double kept_feature_angle_deg(const dragcore::Shape& shape, double asked);

/// The recipe of an octree of cubes around a body with flat sides, for scale-resolving runs: the size on the body fits a plate of
/// thickness 0.05. Levels differ by 2; a cube is content with "coarse", which does not fit such a plate.
MeshRecipe octree_recipe();

/// The recipe of an O-grid around a smooth body at Re 1e5: the first cell's centre is at y+ of about 1, a laminar layer at 60 degrees from
/// the front of a ball has some eight cells.
MeshRecipe o_grid_recipe();

/// The recipe for a body in flow of a Reynolds number. Where viscosity carries the body's presence far, below 50, a box of air has 30 body
/// scales to each side unless something else was asked for: `dragval variants` shows what walls nearer and farther do to a ball at Re 1;
/// coarse cells fill the air. On an ellipsoid the faces are at most 0.3 of its sharpest radius of curvature, so that a flat one keeps its
/// rim.
MeshRecipe recipe_for(MeshRecipe recipe, const dragcore::Shape& shape, double reynolds);

/// Cell size factor of a level: consecutive levels differ by 1.4, which gives 2.2-2.7 times the cells (of an octree by 2). "medium" is 1.
/// @throws std::invalid_argument on an unknown level, listing the known ones
double refinement_of(const std::string& level, bool octree = false);

/// Distance from a point to the surface of the body (exact for flat-sided bodies and bodies of revolution, first order for other
/// ellipsoids); 0 inside. Body frame [m]. @throws std::invalid_argument for a body given by triangles
double distance_to_body(const dragcore::Shape& shape, const Eigen::Vector3d& point_body);

/// Distance to the sharp point of a cone or teardrop [m]; infinite for other shapes.
double distance_to_tip(const dragcore::Shape& shape, const Eigen::Vector3d& point_body);

/// The air that is meshed around a body whose bounding box in its pose is `body`: recipe's distances to the sides, and the plane of
/// symmetry in place of the side that a half model does not have; of a ball of air its bounding box. Frame of the mesh [m].
Eigen::AlignedBox3d air_around(const Eigen::AlignedBox3d& body, double scale, const MeshRecipe& recipe, Symmetry symmetry);

/// The edge length of the tetrahedra as a function of the place alone, so that the half of a symmetric case is the half of its whole:
///
///   h(p) = refinement min(h_body + g d_body, h_tip + g d_tip, h_wake + g d_wake, h_outer + g d_outer, h_far)
///
/// with the distances d of p to the body, its sharp point and the two boxes around it, and the growth g. What the mesher asks at every
/// point and what predicted_cells() integrates are this one function.
class SizeField {
 public:
  /// @param body      bounding box of the body in its pose, frame of the mesh [m]
  /// @param symmetry  says to which side the wind turns, where it does: see MeshRecipe::wake_rise
  SizeField(const dragcore::Shape& shape, const dragcore::Pose& pose, const MeshRecipe& recipe, const Eigen::AlignedBox3d& body,
            Symmetry symmetry);

  double operator()(const Eigen::Vector3d& point) const;  ///< [m]

 private:
  dragcore::Shape shape_;
  MeshRecipe recipe_;
  Eigen::AlignedBox3d body_;
  Eigen::Matrix3d to_body_;
  Eigen::Vector3d lee_;
  double scale_;
};

/// Which cubes of an octree are too large. Body frame.
class OctreeSizes {
 public:
  /// @throws std::invalid_argument  the body has round sides, or its sides are no planes of the finest cubes
  OctreeSizes(const dragcore::Shape& shape, const MeshRecipe& recipe, Symmetry symmetry);
  bool too_large(const Eigen::Vector3d& lower, const Eigen::Vector3d& upper) const;
  bool in_body(const Eigen::Vector3d& point) const { return (point.cwiseAbs().array() < half_.array()).all(); }

 private:
  dragcore::Shape shape_;
  MeshRecipe recipe_;
  double scale_;
  Eigen::Vector3d half_, lee_;
};

/// The grid of cubes of the far size that an octree is refined from, in numbers of cubes from the body's centroid to each side.
struct BaseGrid {
  Eigen::Vector3i below, above;
  double size = 0.0;  ///< [m]
};
BaseGrid base_grid(const dragcore::Shape& shape, const MeshRecipe& recipe, Symmetry symmetry);

/// Half the edges of the body's box, if it is one with flat sides, so that an octree of cubes can fit it. @throws std::invalid_argument
Eigen::Vector3d flat_half_extent(const dragcore::Shape& shape);

/// The lengths and sizes of a recipe by name, for files that change some.
std::vector<std::pair<const char*, double*>> recipe_lengths(MeshRecipe& recipe);

/// Canonical description: part of the key, and the request that the meshing program reads.
nlohmann::json to_json(const MeshRecipe& recipe);
MeshRecipe recipe_from_json(const nlohmann::json& text);
nlohmann::json to_json(const dragcore::Shape& shape);  ///< of a body given by triangles their checksum, from which it is not made again
dragcore::Shape shape_from_json(const nlohmann::json& text);

}  // namespace cfd_cases
