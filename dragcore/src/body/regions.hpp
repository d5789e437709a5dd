#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

namespace dragcore {

/// A triangle as its region sees it.
struct RegionFacet {
  Eigen::Vector3d normal, centroid, ab, ac;
  double area;
};

/// What surrounds a triangle: the part of a smooth component whose normals are near its own.
struct Region {
  Eigen::Matrix3d second_moment = Eigen::Matrix3d::Zero();  ///< of place about the region's centroid, per area [m^2]
  Eigen::Matrix3d curvature =
      Eigen::Matrix3d::Zero();  ///< slope of the normal over place, in the tangent plane; positive where convex [1/m]
};

/// Regions of the triangles of one component, each from all of it, weighted by how parallel the normals are:
///
///   K(x) = x^8 (1 + x)/2,  x = n_i.n_j      (x^8 for a sheet, which has no outside)
///
/// K is 1 for parallel faces, a half at 23 degrees, 0.05 at 45, below 0.02 beyond 60. So a flat face sees all of itself and nothing else, a
/// ball a cap around each point, and noise in the normals no more than a little less weight: nothing here switches. As K is a polynomial,
/// the sums over j split into 100 moments of the component (symmetric tensors of the normal) that serve every i: cost N, not N^2. The
/// moments do not depend on the order of triangles nor, on flat faces, on how they are cut, and turn with the body.
///
/// The curvature is the regression of normals on places over the region: exact on balls and cylinders, 0 on flat faces; of noise only what
/// does not average out.
///
/// @param resolution  lengths below which nothing is called curved [m]
/// @param put         called with the number of every facet and its region, in their order: all at once would be 150 bytes each
void find_regions(const std::vector<RegionFacet>& facets, bool sheet, double resolution,
                  const std::function<void(std::size_t, const Region&)>& put);

}  // namespace dragcore
