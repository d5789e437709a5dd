#include "body/regions.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "support/triangle_second_moment.hpp"

namespace dragcore {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr int degree = 8;
constexpr int monomials(int n) { return (n + 1) * (n + 2) / 2; }
constexpr int even = monomials(degree), both = even + monomials(degree + 1);
// Sums that go with each monomial: area, first and second moment of place, normal, place times normal.
constexpr int columns = 1 + 3 + 6 + 3 + 9;

using Basis = Eigen::Matrix<double, both, 1>;
using Sums = Eigen::Matrix<double, both, columns>;

/// Monomials of degree 8, then 9, times the root of their multinomial coefficient: basis(n).basis(m) over the first is (n.m)^8, over the
/// rest (n.m)^9.
Basis basis(const Vector3d& n) {
  static const auto roots = [] {
    std::array<double, both> root{};
    const auto factorial = [](int k) { return std::tgamma(k + 1.0); };
    int at = 0;
    for (const int d : {degree, degree + 1})
      for (int i = 0; i <= d; ++i)
        for (int j = 0; j <= d - i; ++j)
          root[static_cast<std::size_t>(at++)] = std::sqrt(factorial(d) / (factorial(i) * factorial(j) * factorial(d - i - j)));
    return root;
  }();
  std::array<Vector3d, degree + 2> power;
  power[0] = Vector3d::Ones();
  for (std::size_t k = 1; k < power.size(); ++k) power[k] = power[k - 1].cwiseProduct(n);
  Basis values;
  int at = 0;
  for (const int d : {degree, degree + 1})
    for (int i = 0; i <= d; ++i)
      for (int j = 0; j <= d - i; ++j, ++at)
        values[at] = roots[static_cast<std::size_t>(at)] * power[static_cast<std::size_t>(i)].x() * power[static_cast<std::size_t>(j)].y() *
                     power[static_cast<std::size_t>(d - i - j)].z();
  return values;
}

using Row = Eigen::Matrix<double, 1, columns>;

/// A facet's own sums, places from `origin`. Second moments are exact: a triangle's own is (ab ab + ac ac)/18 less the mixed part.
Row sums_of(const RegionFacet& facet, const Vector3d& origin) {
  const Vector3d r = facet.centroid - origin, &n = facet.normal;
  const Matrix3d own = triangle_second_moment(facet.ab, facet.ac);
  const Matrix3d second = r * r.transpose() + own, mixed = r * n.transpose();
  Row row;
  row << 1.0, r.transpose(), second(0, 0), second(0, 1), second(0, 2), second(1, 1), second(1, 2), second(2, 2), n.transpose(),
      mixed.row(0), mixed.row(1), mixed.row(2);
  return facet.area * row;
}

/// @param places   sums weighted by the kernel of places
/// @param normals  those weighted by that of normals: the same of a body
Region region_from(const Row& places, const Row& normals, const Vector3d& normal, double resolution) {
  Region region;
  const double area = places[0];
  if (!(area > 0.0)) return region;
  const Vector3d centre = places.segment<3>(1).transpose() / area;
  Matrix3d second;
  second << places[4], places[5], places[6], places[5], places[7], places[8], places[6], places[8], places[9];
  region.second_moment = second / area - centre * centre.transpose();

  Matrix3d mixed;
  for (int i = 0; i < 3; ++i) mixed.row(i) = normals.segment<3>(13 + 3 * i);
  const Matrix3d covariance = (mixed - centre * normals.segment<3>(10)) / area;  // of place (rows) and normal (columns)
  Eigen::Matrix<double, 3, 2> tangent;
  tangent.col(0) = normal.unitOrthogonal();
  tangent.col(1) = normal.cross(tangent.col(0));
  const Eigen::Matrix2d spread =
      tangent.transpose() * region.second_moment * tangent + resolution * resolution * Eigen::Matrix2d::Identity();
  const Eigen::Matrix2d slope = spread.inverse() * (tangent.transpose() * covariance * tangent);
  region.curvature = tangent * (0.5 * (slope + slope.transpose())) * tangent.transpose();
  return region;
}

}  // namespace

void find_regions(const std::vector<RegionFacet>& facets, bool sheet, double resolution,
                  const std::function<void(std::size_t, const Region&)>& put) {
  if (facets.empty()) return;
  Vector3d origin = Vector3d::Zero(), turning = Vector3d::Zero();
  double area = 0.0;
  for (const RegionFacet& facet : facets) {
    origin += facet.area * facet.centroid;
    area += facet.area;
    turning = turning.cwiseMax((facet.normal - facets.front().normal).cwiseAbs());
  }
  origin /= area;

  // A flat face, and every triangle by itself: all weights are 1.
  if (turning.maxCoeff() < 1e-7) {
    Row sums = Row::Zero();
    for (const RegionFacet& facet : facets) sums += sums_of(facet, origin);
    Region flat = region_from(sums, sums, facets.front().normal, resolution);
    flat.curvature.setZero();
    for (std::size_t i = 0; i < facets.size(); ++i) put(i, flat);
    return;
  }

  // Many facets at a time: products of matrices keep in registers what products of vectors carry to and from memory.
  constexpr Eigen::Index block = 64;
  const auto count = static_cast<Eigen::Index>(facets.size());
  Eigen::Matrix<double, both, Eigen::Dynamic, Eigen::ColMajor, both, block> weights;
  Eigen::Matrix<double, Eigen::Dynamic, columns, Eigen::RowMajor, block, columns> own;
  const auto take = [&](Eigen::Index first) {
    const Eigen::Index n = std::min(block, count - first);
    weights.resize(both, n);
    for (Eigen::Index k = 0; k < n; ++k) weights.col(k) = basis(facets[static_cast<std::size_t>(first + k)].normal);
    own.resize(n, columns);
    return n;
  };
  Sums sums = Sums::Zero();
  for (Eigen::Index first = 0; first < count; first += block) {
    const Eigen::Index n = take(first);
    for (Eigen::Index k = 0; k < n; ++k) own.row(k) = sums_of(facets[static_cast<std::size_t>(first + k)], origin);
    sums.noalias() += weights * own;
  }
  auto by_odd = own;
  for (Eigen::Index first = 0; first < count; first += block) {
    const Eigen::Index n = take(first);
    // Across a sheet whose triangles are wound either way the odd power gives every normal the sign of this one.
    if (sheet) {
      own.noalias() = weights.topRows<even>().transpose() * sums.topRows<even>();
      by_odd.noalias() = weights.bottomRows<both - even>().transpose() * sums.bottomRows<both - even>();
    } else {
      own.noalias() = 0.5 * (weights.transpose() * sums);
    }
    for (Eigen::Index k = 0; k < n; ++k) {
      const auto i = static_cast<std::size_t>(first + k);
      put(i, region_from(own.row(k), sheet ? by_odd.row(k) : own.row(k), facets[i].normal, resolution));
    }
  }
}

}  // namespace dragcore
