#include <Eigen/Geometry>
#include <cmath>
#include <dragcore/follower.hpp>
#include <string>

#include "support/require.hpp"
#include "wind/batch_kernels.hpp"

namespace dragcore {

using Eigen::Matrix3d;
using Eigen::Vector3d;

void validate(const Follower& follower) {
  const auto positive = [](const char* name, double value) {
    require(
        value > 0.0 && std::isfinite(value), [name] { return std::string("follower: ") + name; }, value,
        "it must be greater than 0 and finite");
  };
  require_finite("follower: gain", follower.gain);
  require(follower.mass >= 0.0 && std::isfinite(follower.mass), "follower: mass", follower.mass, "it must be finite and not negative");
  if (follower.lag == FollowerLag::linear) positive("linear_drag", follower.linear_drag);
  if (follower.lag == FollowerLag::quadratic) {
    positive("drag_area", follower.drag_area);
    positive("density", follower.density);
  }
  require(follower.inertia.allFinite() && (follower.inertia.array() >= 0.0).all(), "follower: inertia", follower.inertia,
          "it must be finite and not negative");
  positive("angular_drag", follower.angular_drag);
}

namespace {

/// @param which  makes the beginning of a message
template <class Which>
void validate_state(const Which& which, const FollowerState& state, const Vector3d& wind) {
  const auto name = [&which](const char* what) { return [&which, what] { return which() + what; }; };
  require_finite(name("wind"), wind);
  require_finite(name("position"), state.position);
  require_finite(name("velocity"), state.velocity);
  require(state.rotation.allFinite() && (state.rotation.transpose() * state.rotation - Matrix3d::Identity()).norm() < 1e-6 &&
              state.rotation.determinant() > 0.0,
          name("determinant of the rotation"), state.rotation.determinant(), "its columns must be orthonormal and right-handed");
}

void validate_duration(double dt) { require(dt >= 0.0 && std::isfinite(dt), "follower: dt", dt, "it must be finite and not negative"); }

/// exp(-dt / tau), with tau = 0 the limit of no lag at all.
double remaining(double dt, double tau) { return tau > 0.0 ? std::exp(-dt / tau) : 0.0; }

void move(const Follower& follower, FollowerState& state, const Vector3d& wind, double dt) {
  Vector3d u = follower.gain * wind, e = state.velocity - u;
  for (int axis = 0; axis < 3; ++axis)
    if (follower.position_locked[static_cast<std::size_t>(axis)]) u[axis] = e[axis] = state.velocity[axis] = 0.0;
  double speed_left = 0.0, drift = 0.0;  // v' = u + e speed_left, r' = r + u dt + e drift
  if (follower.lag == FollowerLag::linear && follower.mass > 0.0) {
    const double x = follower.linear_drag / follower.mass * dt;
    speed_left = std::exp(-x);
    drift = x > 0.0 ? dt * (-std::expm1(-x) / x) : dt;
  } else if (follower.lag == FollowerLag::quadratic && follower.mass > 0.0) {
    const double z = 0.5 * follower.density * follower.drag_area / follower.mass * e.stableNorm() * dt;
    speed_left = 1.0 / (1.0 + z);
    drift = z == 0.0 ? dt : std::isfinite(z) ? dt * (std::log1p(z) / z) : 0.0;
  }
  state.velocity = u + speed_left * e;
  state.position += u * dt + drift * e;
}

void turn(const Follower& follower, FollowerState& state, const Vector3d& wind, double dt) {
  if (follower.facing == Facing::keep || wind.isZero(0.0)) return;
  // The nose is at -x: it looks into the wind when +x points downwind. `aim` is where +x has to go, in body axes.
  Vector3d aim = state.rotation.transpose() * wind.stableNormalized() * (follower.facing == Facing::into_wind ? 1.0 : -1.0);
  const auto [y_locked, z_locked] = follower.turn_locked;
  if (y_locked && z_locked) return;
  if (y_locked) aim[2] = 0.0;
  if (z_locked) aim[1] = 0.0;
  const double across = std::hypot(aim[1], aim[2]);
  if (across == 0.0 && !(aim[0] < 0.0)) return;  // there already, or the aim is along the one axis that is free
  const double angle = std::atan2(across, aim[0]);
  const Vector3d opposite = z_locked ? Vector3d::UnitY() : Vector3d::UnitZ();
  const Vector3d arc = angle * (across > 0.0 ? Vector3d(0.0, -aim[2] / across, aim[1] / across) : opposite);
  const Vector3d left =
      arc.cwiseProduct((follower.inertia / follower.angular_drag).unaryExpr([dt](double tau) { return remaining(dt, tau); }));
  // Go all the way, then come back by what is left: the frame on arrival is the same after one step or many, so any two steps make one.
  const auto rotation = [](const Vector3d& v) -> Matrix3d {
    const double size = v.stableNorm();
    return size > 0.0 ? Eigen::AngleAxisd(size, v / size).toRotationMatrix() : Matrix3d::Identity();
  };
  const Matrix3d turned = state.rotation * rotation(arc) * rotation(-left);
  state.rotation = Eigen::Quaterniond(turned).normalized().toRotationMatrix();  // rounding does not grow over a million steps
}

}  // namespace

FollowerState step(const Follower& follower, const FollowerState& state, const Vector3d& wind, double dt) {
  validate(follower);
  validate_state([] { return std::string("follower: "); }, state, wind);
  validate_duration(dt);
  FollowerState next = state;
  if (dt == 0.0) return next;
  move(follower, next, wind, dt);
  turn(follower, next, wind, dt);
  return next;
}

void step(const Follower& follower, std::span<FollowerState> states, std::span<const Vector3d> winds, double dt) {
  validate(follower);
  validate_duration(dt);
  require(winds.size() == states.size(), "follower: number of winds", winds.size(),
          [&] { return "there are " + std::to_string(states.size()) + " states"; });
  for (std::size_t i = first_doubtful_follower(states, winds); i < states.size(); ++i)
    validate_state([i] { return "follower " + std::to_string(i) + ": "; }, states[i], winds[i]);
  if (dt == 0.0 || step_by_kernel(follower, states, winds, dt)) return;
  for (std::size_t i = 0; i < states.size(); ++i) {
    move(follower, states[i], winds[i], dt);
    turn(follower, states[i], winds[i], dt);
  }
}

}  // namespace dragcore
