#include <dragcore/stepping.hpp>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "pressure_points.hpp"

namespace dragcore {

namespace {

Vector6d generalised(const Eigen::Vector3d& linear, const Eigen::Vector3d& angular) { return (Vector6d() << linear, angular).finished(); }

/// Velocity of the body relative to the air, 6 components.
Vector6d relative(const Motion& motion) { return generalised(motion.velocity - motion.wind, motion.angular_velocity); }

/// What a step is given beside the mass properties. A NaN must not pass quietly into the state of a game.
void check_step(double dt, bool finite) {
  if (!finite) throw std::invalid_argument("step: motion, resistance and external wrench must be finite");
  if (!(dt >= 0.0) || !std::isfinite(dt)) throw std::invalid_argument("step: dt = " + std::to_string(dt) + " s, but it must be finite and not negative");
}

double slope(const Law::Polynomial& polynomial, double c) {
  double sum = 0.0;
  for (std::size_t k = polynomial.size() - 1; k > 0; --k) sum = sum * c + static_cast<double>(k) * polynomial[k];
  return sum;
}

}  // namespace

Matrix6d MassProperties::matrix() const {
  if (!(mass > 0.0) || !std::isfinite(mass)) throw std::invalid_argument("mass = " + std::to_string(mass) + " kg, but it must be finite and greater than 0");
  if (!inertia.allFinite() || !inertia.isApprox(inertia.transpose(), 1e-9) || inertia.llt().info() != Eigen::Success)
    throw std::invalid_argument("inertia must be finite, symmetric and positive definite; a flat body has a small but positive moment about every axis");
  Matrix6d m = Matrix6d::Zero();
  m.topLeftCorner<3, 3>() = mass * Eigen::Matrix3d::Identity();
  m.bottomRightCorner<3, 3>() = inertia;
  return m;
}

Matrix6d resistance(const Surface& surface, const Motion& motion, const Medium& medium, const Model& model) {
  check_input(motion, medium, model);
  Matrix6d s = Matrix6d::Zero();
  for_each_pressure_point(surface, motion, medium, model, [&s](const PressurePoint& point) {
    // Force = secant * (u.n) n: pressure over normal velocity, times the dyad of the point's unit wrench.
    const Vector6d unit = generalised(point.normal, point.place.cross(point.normal));
    s.selfadjointView<Eigen::Lower>().rankUpdate(unit, point.size() / (point.c * point.speed));
  });
  s.triangularView<Eigen::StrictlyUpper>() = s.transpose();
  return s;
}

Matrix6d force_jacobian(const Surface& surface, const Motion& motion, const Medium& medium, const Model& model) {
  check_input(motion, medium, model);
  Matrix6d jacobian = Matrix6d::Zero();
  for_each_pressure_point(surface, motion, medium, model, [&jacobian](const PressurePoint& point) {
    // Size g = |u|^2 C(c), c = |u.n|/|u|: dg/du = (2 C - c C') u + |u| C' e, with e the unit vector along which |u.n| grows.
    const double value = evaluate(*point.law, point.c), rate = slope(*point.law, point.c);
    const Eigen::Vector3d outward = point.downstream();
    const Eigen::Vector3d gradient = point.half_rho_area * ((2.0 * value - point.c * rate) * point.u + point.speed * rate * outward);
    // du = -(dV + domega x place): gradient . du = -(gradient . dV + (place x gradient) . domega).
    jacobian -= generalised(outward, point.place.cross(outward)) * generalised(gradient, point.place.cross(gradient)).transpose();
  });
  return jacobian;
}

Vector6d step_secant_implicit(const Matrix6d& resistance, const MassProperties& body, const Motion& motion, const Vector6d& external, double dt) {
  check_step(dt, resistance.allFinite() && relative(motion).allFinite() && external.allFinite());
  const Matrix6d mass = body.matrix();
  // In velocities relative to the air, so that the wind's own speed costs no digits.
  const Vector6d moved = (mass + dt * resistance).ldlt().solve(mass * relative(motion) + dt * external);
  return moved + generalised(motion.wind, Eigen::Vector3d::Zero());
}

Vector6d step_scalar_implicit(const Matrix6d& resistance, const MassProperties& body, const Motion& motion, const Vector6d& external, double dt) {
  check_step(dt, resistance.allFinite() && relative(motion).allFinite() && external.allFinite());
  const auto factored = body.matrix().llt();
  const double trace = factored.solve(resistance).trace();
  const Vector6d wrench = external - resistance * relative(motion);
  return generalised(motion.velocity, motion.angular_velocity) + dt / (1.0 + dt * trace) * factored.solve(wrench);
}

double impulse_share(const Wrench& wrench, const MassProperties& body, const Motion& motion, double dt) {
  check_step(dt, wrench.force.allFinite() && wrench.torque.allFinite() && relative(motion).allFinite());
  const Vector6d impulse = dt * generalised(wrench.force, wrench.torque);
  const double work = -impulse.dot(relative(motion)), growth = impulse.dot(body.matrix().llt().solve(impulse));
  return growth > 0.0 ? std::clamp(work / growth, 0.0, 1.0) : (work >= 0.0 ? 1.0 : 0.0);
}

}  // namespace dragcore
