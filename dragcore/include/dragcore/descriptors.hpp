#pragma once

#include <dragcore/surface.hpp>

namespace dragcore {

/// What a flow along one direction meets as a whole: plain sums over the surface of a part, exact for convex ones. Where walls hide others,
/// what is hidden counts as far as Surface::exposure knows. Continuous in the direction.
struct Descriptors {
  double frontal_area = 0.0;  ///< A_f = sum of A c over windward patches [m^2]
  double depth = 0.0;         ///< lambda = volume / A_f^1.5, mean depth over width along the flow; 0 for sheets
  double sharpness =
      0.0;              ///< k in [0, 1], k^4 = sum A c^5 / sum A c: near the largest c of a face of weight. 1 for a face normal to the flow
  double aspect = 1.0;  ///< AR >= 1: ratio of the silhouette's radii of gyration, long over short
  double reached = 1.0;  ///< A_f over the same sum without shadows: 0 in the lee of something else. What recovers behind scales with it
};

/// @param direction  of the air's velocity relative to the body, body frame; its length does not matter
/// @return           as above; all zero (aspect 1) for an empty surface and a direction of length 0
/// @accuracy         rounding; mesh-independent for flat-sided bodies, second order in the triangle size for round ones
/// @cost             one pass over the patches; over the triangles where there is an exposure
Descriptors describe(const Surface& surface, const Eigen::Vector3d& direction, std::size_t part = 0);

/// chi in [0, 1]: how much a triangle's surroundings curve along a tangential direction of length t <= 1 [-].
/// Has no limit at t = 0, where it is 0: the law multiplies it by t^2.
/// 0 on flat faces and along the generators of cones and cylinders, 0.90 on a ball.
double curvature_along(const Surface& surface, Eigen::Index triangle, const Eigen::Vector3d& tangential);

}  // namespace dragcore
