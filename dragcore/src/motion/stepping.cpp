#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <dragcore/stepping.hpp>
#include <stdexcept>
#include <string>

#include "drag/check.hpp"
#include "drag/corrected_flow.hpp"
#include "drag/energy_balance.hpp"
#include "drag/secant.hpp"
#include "support/cross_matrix.hpp"

namespace dragcore {

namespace {

Vector6d generalised(const Eigen::Vector3d& linear, const Eigen::Vector3d& angular) { return (Vector6d() << linear, angular).finished(); }

/// Velocity of the body relative to the air, 6 components.
Vector6d relative(const Motion& motion) { return generalised(motion.velocity - motion.wind, motion.angular_velocity); }

/// What a step is given beside the mass properties. A NaN must not pass quietly into the state of a game.
void check_step(double dt, bool finite) {
  if (!finite) throw std::invalid_argument("step: motion, resistance and external wrench must be finite");
  if (!(dt >= 0.0) || !std::isfinite(dt))
    throw std::invalid_argument("step: dt = " + std::to_string(dt) + " s, but it must be finite and not negative");
}

/// And what it gives.
Vector6d finite(const Vector6d& velocity) {
  if (!velocity.allFinite())
    throw std::overflow_error("step: the new velocity is not finite; dt, resistance or external wrench is orders of magnitude too large");
  return velocity;
}

/// A local force as a generalised one, about the reference point.
Vector6d generalised_force(const LocalForce& local) {
  const Eigen::Vector3d force = local.force();
  return generalised(force, local.place.cross(force));
}

/// Whether a change of spin can change the wrench.
bool feels_spin(const Model& model) { return model.effects.has(Effect::spin) && instrument::built(Effect::spin); }

}  // namespace

Matrix6d MassProperties::matrix() const {
  if (!(mass > 0.0) || !std::isfinite(mass))
    throw std::invalid_argument("body: mass = " + std::to_string(mass) + " kg, but it must be finite and greater than 0");
  if (!inertia.allFinite() || !inertia.isApprox(inertia.transpose(), 1e-9) || inertia.llt().info() != Eigen::Success)
    throw std::invalid_argument(
        "body: inertia must be set, finite, symmetric and positive definite; a flat body has a positive moment about every axis");
  if (const Eigen::Vector3d moments = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(inertia, Eigen::EigenvaluesOnly).eigenvalues();
      moments[2] > (moments[0] + moments[1]) * (1 + 1e-6))
    throw std::invalid_argument("body: inertia has principal moments " + std::to_string(moments[0]) + ", " + std::to_string(moments[1]) +
                                ", " + std::to_string(moments[2]) + " kg m^2, but of no body is one larger than the sum of the others");
  Matrix6d m = Matrix6d::Zero();
  m.topLeftCorner<3, 3>() = mass * Eigen::Matrix3d::Identity();
  m.bottomRightCorner<3, 3>() = inertia;
  if (added.isZero(0.0)) return m;
  const double rounding = 1e-9 * added.cwiseAbs().maxCoeff();
  if (!added.allFinite() || !added.isApprox(added.transpose(), 1e-9) ||
      Eigen::SelfAdjointEigenSolver<Matrix6d>(added, Eigen::EigenvaluesOnly).eigenvalues()[0] < -rounding)
    throw std::invalid_argument("body: added mass must be finite, symmetric and positive semidefinite, as added_mass() gives it");
  return m + added;
}

Eigen::Vector3d gyroscopic_spin(const MassProperties& body, const Eigen::Vector3d& angular_velocity, double dt) {
  check_step(dt, angular_velocity.allFinite());
  const Eigen::Matrix3d inertia = body.matrix().bottomRightCorner<3, 3>();
  // With I = C C^T and y = C^T w, energy is |y|^2/2, and the midpoint rule I (w' - w) = dt L x (w' + w)/2 becomes y' - y = q x (y' + y)
  // with q = dt/2 C^T L/det C: a rotation by 2 atan|q|. So energy stays, whatever L is and however large q; with L = I (w + w')/2 the size
  // of L does, too. Units of inertia drop out of q: those of its trace keep det C a number.
  const auto factored = Eigen::Matrix3d(inertia / inertia.trace()).llt();
  const Eigen::Matrix3d C = factored.matrixL(), turn = C.transpose() * C;
  const double rate = 0.25 * dt / C.diagonal().prod();
  const Eigen::Vector3d y = C.transpose() * angular_velocity;
  Eigen::Vector3d change = Eigen::Vector3d::Zero();
  for (int iteration = 0; iteration < 4; ++iteration) {
    const Eigen::Vector3d q = turn * (2.0 * y + change), axis = q.stableNormalized(), across = axis.cross(y);
    const double tangent = rate * q.stableNorm();  // of half the angle; its square may be beyond all numbers
    const double sine = 2.0 / (tangent + 1.0 / tangent), one_less_cosine = 2.0 / (1.0 + 1.0 / tangent / tangent);
    change = sine * across + one_less_cosine * axis.cross(across);
  }
  return angular_velocity + factored.matrixU().solve(change);
}

namespace {

/// In double precision, triangle by triangle.
Secant full_secant(const Surface& surface, const Motion& motion, const Medium& medium, const Model& model) {
  Secant secant;
  const auto add = [&](const LocalForce& local, const Eigen::Vector3d& direction, double factor) {
    secant.taken.selfadjointView<Eigen::Lower>().rankUpdate(generalised(direction, local.place.cross(direction)), factor);
  };
  for_each_local_force(
      surface, motion, medium, model,
      [&](const LocalForce& local) {
        if (local.coefficient.value < 0.0) {
          secant.given += generalised_force(local);
          secant.given_power += std::abs(local.force().dot(local.u));
          return;
        }
        const double factor = local.half_rho_area * local.speed * local.coefficient.value;
        if (local.is_friction()) {  // factor * (tangential projector) * u
          const Eigen::Vector3d tangent = local.normal.unitOrthogonal();
          add(local, tangent, factor);
          add(local, local.normal.cross(tangent), factor);
        } else {  // pressure over normal velocity, times the dyad of the normal
          // A law that jumps edge-on has a pressure where that velocity is next to nothing: no more than the kernels, which stop at 1e-30.
          add(local, local.normal, factor / std::max(local.c, 1e-30));
        }
      },
      feels_spin(model));
  for_each_creeping_flow(surface, motion, medium, model, [&](const Part& part, const CreepingFlow& creeping) {
    secant.taken.triangularView<Eigen::Lower>() += creeping.matrix(part);
  });
  secant.taken.triangularView<Eigen::StrictlyUpper>() = secant.taken.transpose();
  return secant;
}

}  // namespace

Matrix6d resistance(const Surface& surface, const Motion& motion, const Medium& medium, const Model& model) {
  check_input(surface, motion, medium, model);
  const std::optional<Secant> fast = fast_secant(surface, motion, medium, model);
  const Secant secant = fast ? *fast : full_secant(surface, motion, medium, model);
  Matrix6d s = secant.taken;
  const ActiveEffects active(motion, model);
  // In a wind that varies, power against the wind at the reference point may be anything, and S v is not the wrench anyway: wind_excess()
  // has what pushes too.
  if ((secant.given_power > 0.0 || is_corrected(model)) && !active.has<Effect::wind_variation>()) {
    // What pushes, and what corrects, has no secant matrix of its own that is not negative. Broyden's update (BFGS) turns S into the
    // nearest one that is positive and whose product with the relative velocity is the whole wrench: (total . velocity) is its power, which
    // the energy balances keep positive.
    Vector6d velocity = -relative(motion);
    if (!active.has<Effect::spin>()) velocity.tail<3>().setZero();  // not felt
    EnergyBalance balance;
    balance.add(velocity.dot(s * velocity), secant.given_power);
    Vector6d total = s * velocity + balance.gain_share() * secant.given;
    if (is_corrected(model)) {
      const Wrench more = CorrectedFlow(surface, motion, medium, model).beside({total.head<3>(), total.tail<3>()});
      total += generalised(more.force, more.torque);
    }
    // On a root of S the update is a projection: no rounding error makes the result negative, however many digits cancel near edge-on.
    const auto factors = s.ldlt();
    Matrix6d root = factors.matrixL();
    root = factors.transpositionsP().transpose() * Matrix6d(root * factors.vectorD().cwiseMax(0.0).cwiseSqrt().asDiagonal());
    const Vector6d felt = root.transpose() * velocity;
    if (const double power = total.dot(velocity); power > 0.0 && felt.norm() > 0.0) {
      root -= (root * felt.normalized()) * felt.normalized().transpose();
      s.setZero();
      s.selfadjointView<Eigen::Lower>().rankUpdate(root).rankUpdate(Vector6d(total / std::sqrt(power)));
      s.triangularView<Eigen::StrictlyUpper>() = s.transpose();
    }
  }
  check_result(s.allFinite(), model);
  return s;
}

Vector6d wind_excess(const Wrench& total, const Matrix6d& resistance, const Motion& motion) {
  return generalised(total.force, total.torque) + resistance * relative(motion);
}

namespace {

/// By central differences: a table costs next to nothing beside the sums over triangles. Its share is held fixed.
Matrix6d correction_jacobian(const Surface& surface, const Motion& motion, const Medium& medium, const Model& model) {
  Model alone = model;
  alone.effects = alone.effects.without(Effect::correction);
  const double share = CorrectedFlow(surface, motion, medium, model).share(wrench(surface, motion, medium, alone).total());
  const double size = (motion.wind - motion.velocity).norm() + motion.angular_velocity.norm() * surface.radius;
  Matrix6d slopes = Matrix6d::Zero();
  if (!(size > 0.0) || !(surface.radius > 0.0)) return slopes;
  for (Eigen::Index k = 0; k < 6; ++k) {
    // 1e-4 of the speed: its square, and the rounding of 1e-16 over it, are below 1e-8.
    const double step = 1e-4 * size / (k < 3 ? 1.0 : surface.radius);
    const auto at = [&](double change) {
      Motion moved = motion;
      (k < 3 ? moved.velocity : moved.angular_velocity)[k % 3] += change;
      const Wrench found = CorrectedFlow(surface, moved, medium, model).wrench(share);
      return generalised(found.force, found.torque);
    };
    slopes.col(k) = (at(step) - at(-step)) / (2.0 * step);
  }
  return slopes;
}

}  // namespace

Matrix6d force_jacobian(const Surface& surface, const Motion& motion, const Medium& medium, const Model& model) {
  check_input(surface, motion, medium, model);
  Matrix6d taken = Matrix6d::Zero(), given = taken;
  EnergyBalance balance;
  for_each_local_force(
      surface, motion, medium, model,
      [&](const LocalForce& local) {
        balance.add(local);
        const double value = local.coefficient.value, rate = local.coefficient.slope, c = local.c;
        Eigen::Matrix3d by_velocity;  // d force / d u
        if (local.is_friction()) {
          const Eigen::Matrix3d projector = Eigen::Matrix3d::Identity() - local.normal * local.normal.transpose();
          const Eigen::Vector3d tangential = projector * local.u;
          by_velocity = local.half_rho_area * value *
                        (local.speed * projector + local.growth * tangential * local.u.transpose() / local.speed);
          // |u| dc/du = e - c u/|u|.
          if (rate != 0.0)
            by_velocity += local.half_rho_area * rate * tangential * (local.downstream() - c / local.speed * local.u).transpose();
        } else {
          // Size g = |u|^2 C(c), c = |u.n|/|u|: dg/du = (2 C - c C') u + |u| C' e, with e the unit vector along which |u.n| grows.
          const Eigen::Vector3d e = local.downstream();
          by_velocity = local.half_rho_area * e * ((2.0 * value - c * rate) * local.u + local.speed * rate * e).transpose();
        }
        // du = -dV - domega x r = -dV + r x domega, and the torque is r x force.
        const Eigen::Matrix3d arm = cross_matrix(local.place);
        Matrix6d& sum = value < 0.0 ? given : taken;
        sum.topLeftCorner<3, 3>() -= by_velocity;
        sum.topRightCorner<3, 3>() += by_velocity * arm;
        sum.bottomLeftCorner<3, 3>() -= arm * by_velocity;
        sum.bottomRightCorner<3, 3>() += arm * by_velocity * arm;
      },
      feels_spin(model));
  for_each_creeping_flow(surface, motion, medium, model, [&](const Part& part, const CreepingFlow& creeping) {
    balance.add(creeping.power(part), 0.0);
    taken -= creeping.matrix(part);
  });
  if (balance.has_gain()) taken += balance.gain_share() * given;
  if (is_corrected(model)) taken += correction_jacobian(surface, motion, medium, model);
  if (!feels_spin(model)) taken.rightCols<3>().setZero();
  check_result(taken.allFinite(), model);
  return taken;
}

Vector6d step_secant_implicit(const Matrix6d& resistance, const MassProperties& body, const Motion& motion, const Vector6d& external,
                              double dt) {
  check_step(dt, resistance.allFinite() && relative(motion).allFinite() && external.allFinite());
  const Matrix6d mass = body.matrix();
  // In velocities relative to the air, so that the wind's own speed costs no digits.
  const auto factored = mass.llt();
  Vector6d moved;
  if (dt * factored.solve(resistance).trace() < 1e4) {
    moved = (mass + dt * resistance).ldlt().solve(mass * relative(motion) + dt * external);
  } else {
    // So stiff that rounding errors of the drag outweigh the mass, and the solve above may gain energy where there is little drag. Along
    // the axes of the drag, in units of the root of the mass, every component shrinks or stays.
    const Matrix6d root = factored.matrixL(), left = factored.matrixL().solve(resistance),
                   drag = factored.matrixL().solve(left.transpose());
    const Eigen::SelfAdjointEigenSolver<Matrix6d> axes(drag);
    const Vector6d shrink = (1.0 + dt * axes.eigenvalues().cwiseMax(0.0).array()).inverse();
    const Vector6d pushed = root.transpose() * relative(motion) + dt * factored.matrixL().solve(external);
    moved = factored.matrixU().solve(axes.eigenvectors() * shrink.cwiseProduct(axes.eigenvectors().transpose() * pushed));
  }
  return finite(moved + generalised(motion.wind, Eigen::Vector3d::Zero()));
}

Vector6d step_scalar_implicit(const Matrix6d& resistance, const MassProperties& body, const Motion& motion, const Vector6d& external,
                              double dt) {
  check_step(dt, resistance.allFinite() && relative(motion).allFinite() && external.allFinite());
  const auto factored = body.matrix().llt();
  const double trace = factored.solve(resistance).trace();
  const Vector6d wrench = external - resistance * relative(motion);
  return finite(generalised(motion.velocity, motion.angular_velocity) + dt / (1.0 + dt * trace) * factored.solve(wrench));
}

double impulse_share(const Wrench& wrench, const MassProperties& body, const Motion& motion, double dt) {
  check_step(dt, wrench.force.allFinite() && wrench.torque.allFinite() && relative(motion).allFinite());
  const Vector6d whole = generalised(wrench.force, wrench.torque);
  const double size = whole.cwiseAbs().maxCoeff();
  if (!(size > 0.0)) return 1.0;
  // Per unit of wrench, so that no square of an impulse leaves the range of numbers.
  const Vector6d unit = whole / size;
  const double work = -unit.dot(relative(motion)), growth = dt * size * unit.dot(body.matrix().llt().solve(unit));
  if (!(growth > 0.0)) return work >= 0.0 ? 1.0 : 0.0;
  const double share = work / growth;
  return share > 0.0 ? std::min(share, 1.0) : 0.0;
}

}  // namespace dragcore
