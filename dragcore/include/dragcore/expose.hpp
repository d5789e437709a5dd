#pragma once

#include <Eigen/Core>
#include <array>
#include <dragcore/preparation.hpp>

namespace dragcore {

// Component dragcore::exposure: rays by Embree, which the library itself does not need.

struct ExposeOptions {
  /// Corners of the sphere of directions: 42, 162 or 642, evenly spread; 0 takes 642 and adds to them where shadows change fast.
  int directions = 0;
  double rays = 6e6;  ///< about as many look from directions, fewer of which are taken where they would cost more
  int threads = 0;    ///< 0: as many as the machine has cores. The result does not depend on it
};

/// Finds by rays what the wind reaches of bodies and sheets, and from which directions.
///   1. Points are spread over every side that can feel air, more of them on the large triangles of a coarse mesh.
///   2. A point that no direction reaches is hidden; bodies whose skins lie in each other count one of them. What is left of each triangle
///      becomes `wetted`; triangles of which nothing is left go.
///   3. Closed bodies that touch or overlap become one part; those that merely stand in each other's wind do not.
///   4. Of what is left, the share that each direction reaches becomes `exposure`; null where all of it is reached from everywhere. Of more
///      than 4096 triangles, neighbours that face alike share one.
///   5. Half-way between two directions their mean is held against what is reached there. Where the windward area is more than 2 % off,
///      that becomes a direction, too, down to 1 degree between them. Shadows that are narrower still, of thin bars, are hit or missed.
/// A convex body costs no ray, and what was exposed before is returned as it is.
/// @accuracy  shares of a coarse mesh to about 1 % in the directions looked at; between them Exposure::residual says how far off the
///            windward area may be. Body and wind turned together, the force of a quadrotor varies by 14 %, of a frame of thin bars by
///            59 % (bench/exposure_spread). Two sheets nearer than 1e-5 of the size to each other both feel the wind. Walls of narrow gaps count as hidden, so that their bodies lose volume. Gaps and steps below 1e-4 of
///            a triangle or 1e-5 of the mesh's size are not seen
/// @cost      processor time: 0.1 to 1.5 s up to 100,000 triangles, 4 to 8 s for a million (bench/preparation_cost)
/// @throws std::invalid_argument  for options out of range; std::runtime_error when Embree fails
Preparation expose(Preparation prepared, const ExposeOptions& options = {});

/// Area of the shadow that a mesh casts along a direction, by a grid of 512 x 512 parallel rays [m^2].
/// @param direction  any length but 0
/// @accuracy  0.5 %
double silhouette_area(const TriangleMesh& mesh, const Eigen::Vector3d& direction);

struct WindwardRatio {
  Eigen::Vector3d direction;  ///< unit, from the body to where the wind comes from
  double summed;              ///< sum of A c over all triangles that face it [m^2]
  double silhouette;          ///< what one sees from there [m^2]
};

/// How much of the windward area of a mesh stands behind other parts of it: along +x, -x, +y, -y, +z, -z. Equal for a convex body.
std::array<WindwardRatio, 6> windward_over_silhouette(const Preparation& before);

}  // namespace dragcore
