#include <Eigen/Geometry>
#include <cmath>
#include <dragcore/fluid_terms.hpp>
#include <numbers>

#include "drag/check.hpp"
#include "support/cross_matrix.hpp"
#include "support/ellipsoid_integrals.hpp"
#include "support/ellipsoid_resistance.hpp"
#include "support/require.hpp"

namespace dragcore {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using std::numbers::pi;

void require_positive(const char* what, double found) {
  require(found > 0.0 && std::isfinite(found), what, found, "it must be finite and greater than 0");
}

/// For the matrices that come back from the caller: one that is not finite would poison the step without a word.
void require_matrix(const char* what, const Matrix6d& found) {
  require(found.allFinite(), what, "not finite", "it must be as the function of that name gives it");
}

Vector3d semi_axes(const Ellipsoid& shape) { return {shape.semi_x, shape.semi_y, shape.semi_z}; }

/// A symmetric 6 x 6 matrix, diagonal in the principal axes about the centre, seen from the reference point: v_centre = V + omega x arm.
Matrix6d about_reference(const PlacedEllipsoid& body, const Vector3d& reference_point, const Vector3d& linear, const Vector3d& angular) {
  const Matrix3d l = body.axes * linear.asDiagonal() * body.axes.transpose(), a = body.axes * angular.asDiagonal() * body.axes.transpose();
  const Matrix3d arm = cross_matrix(body.centre - reference_point);
  Matrix6d matrix;
  matrix << l, -l * arm, arm * l, a - arm * l * arm;
  return 0.5 * (matrix + matrix.transpose());  // symmetric to the bit
}

Vector3d velocity_at(const Vector3d& place, const Motion& motion) {
  return motion.velocity + motion.angular_velocity.cross(place - motion.reference_point);
}

}  // namespace

Wrench magnus_lift(const PlacedEllipsoid& body, const Motion& motion, const Medium& medium, MagnusLaw law) {
  validate(body);
  check_input(motion, medium, {});
  const Vector3d u = motion.wind - velocity_at(body.centre, motion), across = u.cross(motion.angular_velocity);
  const double radius = std::cbrt(semi_axes(body.shape).prod()), speed = u.norm();
  if (!(speed > 0.0)) return {};
  const double spin_ratio = radius * across.norm() / (speed * speed);
  // C_L / S has no singularity at S = 0.
  const double slope = law == MagnusLaw::creeping ? 2.0 : (spin_ratio <= 0.1 ? 1.5 : 0.6 + 0.09 / spin_ratio);
  const Vector3d force = 0.5 * medium.density * pi * radius * radius * radius * slope * across;
  return {force, (body.centre - motion.reference_point).cross(force)};
}

Matrix6d added_mass(const PlacedEllipsoid& body, const Vector3d& reference_point, const Medium& medium) {
  validate(body);
  require_finite("reference_point", reference_point);
  check_input({}, medium, {});
  const Vector3d semi = semi_axes(body.shape);
  const double size = semi.maxCoeff();
  const Vector3d scaled = semi / size;
  // Lamb's integrals over lambda = 1/tau, axes in units of the largest. For axis i, with j and k the other two:
  //   alpha_i = abc int dlambda / ((a_i^2 + lambda) Delta),   gamma_i = abc int dlambda / ((a_j^2 + lambda)(a_k^2 + lambda) Delta),
  //   rest_i  = abc int lambda dlambda / ((a_j^2 + lambda)(a_k^2 + lambda) Delta)
  Vector3d alpha = Vector3d::Zero(), gamma = Vector3d::Zero(), rest = Vector3d::Zero();
  for_each_ellipsoid_node(scaled, [&](double tau, double d_tau, const Vector3d& shrink, double root) {
    const double weight = scaled.prod() * root * std::sqrt(tau) * d_tau;
    const Vector3d pairs(shrink[1] * shrink[2], shrink[2] * shrink[0], shrink[0] * shrink[1]);
    alpha += weight * shrink;
    gamma += weight * tau * pairs;
    rest += weight * pairs;
  });
  const double displaced = medium.density * 4.0 / 3.0 * pi * semi.prod();
  Vector3d mass, inertia;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    // alpha_x + alpha_y + alpha_z = 2, so that Lamb's 2 - alpha_i, which vanishes for a disc, is a sum of positive terms; likewise below.
    mass[i] = displaced * alpha[i] / (alpha[j] + alpha[k]);
    const double difference = (scaled[j] - scaled[k]) * (scaled[j] + scaled[k]);
    inertia[i] = displaced / 5.0 * size * size * difference * difference * gamma[i] / (alpha[i] + 2.0 * rest[i]);
  }
  return about_reference(body, reference_point, mass, inertia);
}

Wrench acceleration_reaction(const Matrix6d& added_mass, const Acceleration& acceleration) {
  require_matrix("added_mass", added_mass);
  require_finite("acceleration.linear", acceleration.linear);
  require_finite("acceleration.angular", acceleration.angular);
  const Vector6d reaction = -added_mass * (Vector6d() << acceleration.linear, acceleration.angular).finished();
  return {reaction.head<3>(), reaction.tail<3>()};
}

Wrench munk_wrench(const Matrix6d& added_mass, const Motion& motion) {
  require_matrix("added_mass", added_mass);
  check_input(motion, {}, {});
  const Vector3d v = motion.velocity - motion.wind, omega = motion.angular_velocity;
  const Vector6d momentum = added_mass * (Vector6d() << v, omega).finished();
  const Vector3d p = momentum.head<3>(), l = momentum.tail<3>();
  // Kirchhoff in the turning frame: F = -dP/dt - omega x P, M = -dL/dt - omega x L - v x P, where dv/dt = a - omega x v; the part with a is
  // the other function.
  const Vector6d turning = added_mass.leftCols<3>() * omega.cross(v);
  return {turning.head<3>() - omega.cross(p), turning.tail<3>() - omega.cross(l) - v.cross(p)};
}

Matrix6d stokes_resistance(const PlacedEllipsoid& body, const Vector3d& reference_point, double viscosity) {
  validate(body);
  require_finite("reference_point", reference_point);
  require_positive("viscosity", viscosity);
  const EllipsoidResistance resistance = ellipsoid_resistance(semi_axes(body.shape));
  return about_reference(body, reference_point, viscosity * resistance.linear, viscosity * resistance.angular);
}

Wrench stokes_wrench(const Matrix6d& stokes_resistance, const Motion& motion) {
  require_matrix("stokes_resistance", stokes_resistance);
  check_input(motion, {}, {});
  const Vector6d wrench = stokes_resistance * (Vector6d() << motion.wind - motion.velocity, -motion.angular_velocity).finished();
  return {wrench.head<3>(), wrench.tail<3>()};
}

namespace {

/// C_D Re / 24, which has a limit at Re = 0.
double over_stokes(double reynolds) {
  // 0.42 / (1 + 42500 Re^-1.16) without a negative power of 0.
  const double power = std::pow(reynolds, 1.16);
  return 1.0 + 0.15 * std::pow(reynolds, 0.687) + 0.42 / 24.0 * reynolds * (power / (power + 42500.0));
}

}  // namespace

double sphere_drag_coefficient(double reynolds) {
  require_positive("Reynolds number", reynolds);
  return 24.0 / reynolds * over_stokes(reynolds);
}

Wrench sphere_drag(const Sphere& sphere, const Vector3d& centre, const Motion& motion, const Medium& medium, double viscosity) {
  properties(sphere);  // throws for a diameter out of range
  require_finite("centre", centre);
  require_positive("viscosity", viscosity);
  check_input(motion, medium, {});
  const Vector3d u = motion.wind - velocity_at(centre, motion);
  const double reynolds = medium.density * u.norm() * sphere.diameter / viscosity;
  const Vector3d force = 3.0 * pi * viscosity * sphere.diameter * over_stokes(reynolds) * u;
  return {force, (centre - motion.reference_point).cross(force)};
}

}  // namespace dragcore
