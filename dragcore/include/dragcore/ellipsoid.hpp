#pragma once

#include <dragcore/drag.hpp>
#include <dragcore/shapes.hpp>
#include <vector>

namespace dragcore {

/// An ellipsoid somewhere in the body frame.
struct PlacedEllipsoid {
  Ellipsoid shape{};
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();    ///< [m]
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< columns: directions of semi_x, semi_y, semi_z; a rotation
};

/// @throws std::invalid_argument when a semi-axis is not positive, something is not finite or `axes` is not a rotation: found, needed
void validate(const PlacedEllipsoid& body);

/// An exact ellipsoid prepared once for any number of evaluations, as Surface is for a mesh.
class EllipsoidSurface {
 public:
  /// @param panels_per_quarter  resolution under spin: panels of four points on a quarter turn of a sphere, more on thin bodies. At least 1
  /// @throws std::invalid_argument  as validate(body) does, or for fewer panels than 1
  explicit EllipsoidSurface(const PlacedEllipsoid& body, int panels_per_quarter = 3);

  /// Without spin the integral over the windward half is one integral over tau (docs/ellipsoids.md, eq. 3): 24 points for a sphere, 12 more
  /// for every factor of 7 in the aspect ratio.
  struct FlowNode {
    Eigen::Vector3d shrink;  ///< 1 / (1 + tau a_i^2)
    double force, torque;    ///< weights [m^2], [m^3]
  };
  /// With spin every point of the surface meets its own flow: a product rule whose points crowd where the ellipsoid is strongly curved.
  struct SurfacePoint {
    Eigen::Vector3d place, normal;  ///< from the centre [m]; unit, outward. Principal axes
    double area;                    ///< [m^2]
  };

  PlacedEllipsoid body;
  std::vector<FlowNode> flow_nodes;
  std::vector<SurfacePoint> surface_points;
};

/// Force and torque of the air on an ellipsoid by the local pressure law, integrated over the exact surface: what wrench() of its triangles
/// converges to.
///
/// @return        force [N], torque about `motion.reference_point` [N m], body frame, by term. Zero where u = 0
/// @throws std::invalid_argument  if density is negative, anything is not finite, or the law has more than its polynomials: value found,
/// value needed
/// @accuracy      without spin 1e-12 of the wrench at every incidence and aspect ratio; with spin 1e-3 of it for the default of 3 panels,
/// falling with
///                about the square of their number (docs/ellipsoids.md, tests/dragcore/ellipsoid/test_ellipsoid.cpp). With spin, passive
///                point by point
/// @source        the law is [toskan2020] sec. 2; the reduction to one integral is ours
WrenchByTerm wrench(const EllipsoidSurface& ellipsoid, const Motion& motion, const Medium& medium, const Law& law);

}  // namespace dragcore
