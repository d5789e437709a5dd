#include <Eigen/LU>
#include <dragcore/body_wind.hpp>

#include "support/require.hpp"

namespace dragcore {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

void validate(const BodyPlacement& place, const Vector3d& reference_point) {
  require_finite("body wind: position", place.position);
  require_finite("body wind: reference_point", reference_point);
  const bool rotation =
      place.rotation.allFinite() && (place.rotation.transpose() * place.rotation).isIdentity(1e-9) && place.rotation.determinant() > 0.0;
  require(rotation, "body wind: rotation", Eigen::Matrix<double, 9, 1>(place.rotation.reshaped()),
          "it must be a rotation: orthonormal columns, determinant +1");
}

}  // namespace

BodyWind::BodyWind(const Wind& wind, const Surface& surface, const BodyPlacement& place, const Vector3d& reference_point,
                   WindSampling sampling, Precision precision)
    : sampling_(sampling) {
  validate(place, reference_point);
  const Matrix3d to_body = place.rotation.transpose();
  const auto in_world = [&](const Vector3d& r) -> Vector3d { return place.rotation * r + place.position; };
  switch (sampling) {
    case WindSampling::constant:
      velocity_ = to_body * wind.velocity(in_world(reference_point));
      break;
    case WindSampling::affine: {
      const WindSample sample = wind.sample(in_world(surface.centre));
      gradient_ = to_body * sample.gradient * place.rotation;
      velocity_ = to_body * sample.velocity + gradient_ * (reference_point - surface.centre);
      break;
    }
    case WindSampling::per_triangle: {
      // The reference point comes last. Lazy: products of so small a matrix are cheapest written out.
      const Eigen::Index triangles = surface.size();
      Eigen::Matrix3Xd points(3, triangles + 1);
      points.leftCols(triangles) = place.rotation.lazyProduct(surface.centroid.matrix().transpose()).colwise() + place.position;
      points.col(triangles) = in_world(reference_point);
      const Eigen::Matrix3Xd velocities = wind.velocities(points, precision);
      per_triangle_.reserve(static_cast<std::size_t>(triangles));
      for (const auto& velocity : velocities.leftCols(triangles).colwise()) per_triangle_.emplace_back(to_body * velocity);
      velocity_ = to_body * velocities.col(triangles);
      break;
    }
  }
}

BodyWind BodyWind::within(const Wind& wind, const Surface& surface, const BodyPlacement& place, const Vector3d& reference_point,
                          double tolerance, Precision precision) {
  validate(place, reference_point);
  require(tolerance >= 0.0, "body wind: tolerance", tolerance, "it must be at least 0 [m/s]");
  const WindVariation variation = wind.variation(place.rotation * surface.centre + place.position, surface.radius);
  // `constant` is sampled at the reference point, which may lie off the ball's centre: both are within the ball, so twice the bound.
  const bool uniform = 2.0 * variation.constant <= tolerance && (reference_point - surface.centre).norm() <= surface.radius;
  const WindSampling chosen = choose_sampling(variation, tolerance);
  return BodyWind(wind, surface, place, reference_point,
                  uniform                            ? WindSampling::constant
                  : chosen == WindSampling::constant ? WindSampling::affine
                                                     : chosen,
                  precision);
}

void BodyWind::apply_to(Motion& motion) const& {
  motion.wind = velocity_;
  motion.wind_gradient = gradient_;
  motion.triangle_wind = per_triangle_;
}

}  // namespace dragcore
