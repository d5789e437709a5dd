#include "wind/batch_kernels.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

// This file is compiled once for every instruction set; the best one that the machine has is taken at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "wind/batch_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// After the line that chooses the set.
#include <hwy/contrib/math/math-inl.h>

HWY_BEFORE_NAMESPACE();
namespace dragcore::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<double, 8>;
constexpr D d;
constexpr std::size_t wide = hn::MaxLanes(D()), block = 8;  // `block` whatever the width: tails fill up to it
using V = hn::Vec<D>;

constexpr double pi = std::numbers::pi;

HWY_INLINE V set(double value) { return hn::Set(d, value); }

// Gusts.

/// sin(2 pi x^p) for 0 < x < 1: as in gust.cpp.
HWY_INLINE V sine_of_power(V x, double p) {
  V power = x;  // less a whole number
  if (p != 1.0) {
    const V exponent = hn::Mul(set(p), hn::Log(d, x));
    power = hn::IfThenElse(hn::Gt(exponent, set(-0.5)), hn::Expm1(d, exponent), hn::Exp(d, hn::Max(exponent, set(-700.0))));
  }
  return hn::Sin(d, hn::Mul(set(2.0 * pi), hn::Sub(power, hn::Round(power))));
}

HWY_INLINE V factor(const Gust& gust, V time) {
  const V x = hn::Div(hn::Sub(time, set(gust.start)), set(gust.duration)), one = set(1.0);
  const auto during = hn::And(hn::Gt(x, hn::Zero(d)), hn::Lt(x, one));
  const V y = hn::IfThenElse(during, x, set(0.5));
  V profile = hn::Zero(d);
  switch (gust.profile) {
    case GustProfile::note:
      profile = hn::Neg(hn::Mul(sine_of_power(y, gust.exponent), hn::Sin(d, hn::Mul(set(0.5 * pi), y))));
      break;
    case GustProfile::smooth_ended:
      profile = hn::Neg(hn::Mul(sine_of_power(y, gust.exponent), hn::Sin(d, hn::Mul(set(pi), hn::Min(y, hn::Sub(one, y))))));
      break;
    case GustProfile::one_minus_cosine: {
      const V half = hn::Sin(d, hn::Mul(set(pi), y));
      profile = hn::Mul(half, half);
    }
  }
  return hn::Add(set(gust.rest), hn::Mul(set(gust.amplitude), hn::IfThenElseZero(during, profile)));
}

void gust_factors_on_target(const Gust& gust, std::span<const double> times, std::span<double> factors) {
  const std::size_t count = times.size(), whole = count / wide * wide;
  for (std::size_t k = 0; k < whole; k += wide) hn::StoreU(factor(gust, hn::LoadU(d, times.data() + k)), d, factors.data() + k);
  if (whole == count) return;
  HWY_ALIGN double rest[wide] = {};
  std::copy_n(times.data() + whole, count - whole, rest);
  hn::Store(factor(gust, hn::Load(d, rest)), d, rest);
  std::copy_n(rest, count - whole, factors.data() + whole);
}

struct Vec3 {
  V x, y, z;
};

// Turbulence.

/// @param alike  all components have one length, and so one cosine
template <bool alike>
HWY_INLINE Vec3 sum_of_waves_at(const Waves& waves, const Vec3& place) {
  constexpr double turn = 2.0 * pi;
  const V per_turn[3] = {set(1.0 / (turn * waves.lengths[0])), set(1.0 / (turn * waves.lengths[1])), set(1.0 / (turn * waves.lengths[2]))};
  V sum[3] = {hn::Zero(d), hn::Zero(d), hn::Zero(d)};
  for (std::size_t n = 0; n < waves.count; ++n) {
    const double* k = waves.wavevectors + 3 * n;
    const V phase = set(waves.phases[n] / turn);
    const V along = hn::MulAdd(set(k[0]), place.x, hn::MulAdd(set(k[1]), place.y, hn::Mul(set(k[2]), place.z)));
    const auto cosine = [&](V scale) {
      const V turns = hn::MulAdd(along, scale, phase);  // whole ones do not matter, however many
      return hn::Cos(d, hn::Mul(set(turn), hn::Sub(turns, hn::Round(turns))));
    };
    const V shared = cosine(per_turn[0]);
    for (std::size_t i = 0; i < 3; ++i)
      sum[i] = hn::MulAdd(set(waves.amplitudes[3 * n + i]), alike || i == 0 ? shared : cosine(per_turn[i]), sum[i]);
  }
  return {sum[0], sum[1], sum[2]};
}

void sum_of_waves_on_target(const Waves& waves, const double* points, std::size_t count, double* sums) {
  const bool alike = waves.lengths[0] == waves.lengths[1] && waves.lengths[0] == waves.lengths[2];
  HWY_ALIGN double part[3 * wide] = {};
  for (std::size_t first = 0; first < count; first += wide) {
    const std::size_t here = 3 * std::min(wide, count - first);
    std::copy_n(points + 3 * first, here, part);
    Vec3 place;
    hn::LoadInterleaved3(d, part, place.x, place.y, place.z);
    const Vec3 sum = alike ? sum_of_waves_at<true>(waves, place) : sum_of_waves_at<false>(waves, place);
    hn::StoreInterleaved3(sum.x, sum.y, sum.z, d, part);
    std::copy_n(part, here, sums + 3 * first);
  }
}

// Followers.

HWY_INLINE V dot(const Vec3& a, const Vec3& b) { return hn::MulAdd(a.x, b.x, hn::MulAdd(a.y, b.y, hn::Mul(a.z, b.z))); }
HWY_INLINE Vec3 cross(const Vec3& a, const Vec3& b) {
  return {hn::MulSub(a.y, b.z, hn::Mul(a.z, b.y)), hn::MulSub(a.z, b.x, hn::Mul(a.x, b.z)), hn::MulSub(a.x, b.y, hn::Mul(a.y, b.x))};
}
HWY_INLINE Vec3 times(V s, const Vec3& a) { return {hn::Mul(s, a.x), hn::Mul(s, a.y), hn::Mul(s, a.z)}; }
/// a + s b
HWY_INLINE Vec3 along(const Vec3& a, V s, const Vec3& b) {
  return {hn::MulAdd(s, b.x, a.x), hn::MulAdd(s, b.y, a.y), hn::MulAdd(s, b.z, a.z)};
}
/// Length, for numbers of any size.
HWY_INLINE V length(const Vec3& a) {
  const V largest = hn::Max(hn::Abs(a.x), hn::Max(hn::Abs(a.y), hn::Abs(a.z)));
  const V unit = hn::Max(largest, set(std::numeric_limits<double>::min()));
  const Vec3 scaled{hn::Div(a.x, unit), hn::Div(a.y, unit), hn::Div(a.z, unit)};
  return hn::Mul(unit, hn::Sqrt(dot(scaled, scaled)));
}

/// By columns.
struct Mat3 {
  Vec3 x, y, z;
  HWY_INLINE Vec3 operator*(const Vec3& v) const { return along(along(times(v.z, z), v.y, y), v.x, x); }
  HWY_INLINE Mat3 operator*(const Mat3& m) const { return {*this * m.x, *this * m.y, *this * m.z}; }
  HWY_INLINE Vec3 transposed_times(const Vec3& v) const { return {dot(x, v), dot(y, v), dot(z, v)}; }
};

/// Turns by an angle about the axis (0, y, z), of length 1.
HWY_INLINE Mat3 rotation(V y, V z, V angle) {
  const V c = hn::Cos(d, angle), s = hn::Sin(d, angle), t = hn::Sub(set(1.0), c);
  const V sy = hn::Mul(s, y), sz = hn::Mul(s, z), tyz = hn::Mul(t, hn::Mul(y, z));
  return {{c, sz, hn::Neg(sy)}, {hn::Neg(sz), hn::MulAdd(t, hn::Mul(y, y), c), tyz}, {sy, tyz, hn::MulAdd(t, hn::Mul(z, z), c)}};
}

/// Angle of the direction (x, y) with y >= 0 to the axis x, not both 0.
HWY_INLINE V angle_of(V y, V x) {
  const V acute = hn::Atan(d, hn::Div(y, hn::Abs(x)));
  return hn::IfThenElse(hn::Lt(x, hn::Zero(d)), hn::Sub(set(pi), acute), acute);
}

/// A block of states and winds, number by number.
struct Rows {
  static constexpr std::size_t numbers = 18;  // position, velocity, rotation by columns, wind
  HWY_ALIGN double row[numbers][block];

  /// What fills up is the last one again. Rotations only where they are needed.
  void load(const FollowerState* states, const Eigen::Vector3d* winds, std::size_t count, bool rotations) {
    for (std::size_t k = 0; k < block; ++k) {
      const FollowerState& state = states[std::min(k, count - 1)];
      const Eigen::Vector3d& wind = winds[std::min(k, count - 1)];
      for (std::size_t i = 0; i < 3; ++i)
        row[i][k] = state.position.data()[i], row[3 + i][k] = state.velocity.data()[i], row[15 + i][k] = wind.data()[i];
      if (rotations)
        for (std::size_t i = 0; i < 9; ++i) row[6 + i][k] = state.rotation.data()[i];
    }
  }
  void save(FollowerState* states, std::size_t count, bool rotations) const {
    for (std::size_t k = 0; k < count; ++k) {
      for (std::size_t i = 0; i < 3; ++i) states[k].position.data()[i] = row[i][k], states[k].velocity.data()[i] = row[3 + i][k];
      if (rotations)
        for (std::size_t i = 0; i < 9; ++i) states[k].rotation.data()[i] = row[6 + i][k];
    }
  }
  HWY_INLINE Vec3 at(std::size_t i, std::size_t k) const {
    return {hn::Load(d, row[i] + k), hn::Load(d, row[i + 1] + k), hn::Load(d, row[i + 2] + k)};
  }
  HWY_INLINE Mat3 rotation_at(std::size_t k) const { return {at(6, k), at(9, k), at(12, k)}; }
  HWY_INLINE void put(const Vec3& v, std::size_t i, std::size_t k) {
    hn::Store(v.x, d, row[i] + k), hn::Store(v.y, d, row[i + 1] + k), hn::Store(v.z, d, row[i + 2] + k);
  }
};

/// What is the same for all followers of a kind: (W8) to (W10) of docs/wind.md.
class FollowerStep {
 public:
  FollowerStep(const Follower& follower, double dt) : follower_(follower), dt_(dt) {
    for (std::size_t axis = 0; axis < 3; ++axis) free_[axis] = follower.position_locked[axis] ? 0.0 : 1.0;
    if (follower.mass > 0.0 && follower.lag == FollowerLag::linear) {
      const double x = follower.linear_drag / follower.mass * dt;
      speed_left_ = std::exp(-x);
      drift_ = x > 0.0 ? dt * (-std::expm1(-x) / x) : dt;
    }
    quadratic_ = follower.mass > 0.0 && follower.lag == FollowerLag::quadratic;
    if (quadratic_) shrink_ = 0.5 * follower.density * follower.drag_area / follower.mass;
    turns_ = follower.facing != Facing::keep && !(follower.turn_locked[0] && follower.turn_locked[1]);
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const double tau = follower.inertia[static_cast<Eigen::Index>(axis) + 1] / follower.angular_drag;
      left_[axis] = tau > 0.0 ? std::exp(-dt / tau) : 0.0;
    }
  }

  void run(std::span<FollowerState> states, std::span<const Eigen::Vector3d> winds) const {
    Rows rows;
    for (std::size_t first = 0; first < states.size(); first += block) {
      const std::size_t count = std::min(block, states.size() - first);
      rows.load(states.data() + first, winds.data() + first, count, turns_);
      for (std::size_t k = 0; k < block; k += wide) {
        move(rows, k);
        if (turns_) turn(rows, k);
      }
      rows.save(states.data() + first, count, turns_);
    }
  }

 private:
  HWY_INLINE void move(Rows& rows, std::size_t k) const {
    const Vec3 free{set(free_[0]), set(free_[1]), set(free_[2])}, wind = rows.at(15, k), velocity = rows.at(3, k);
    const V gain = set(follower_.gain), dt = set(dt_);
    const Vec3 u{hn::Mul(free.x, hn::Mul(gain, wind.x)), hn::Mul(free.y, hn::Mul(gain, wind.y)), hn::Mul(free.z, hn::Mul(gain, wind.z))};
    const Vec3 e{hn::MulSub(free.x, velocity.x, u.x), hn::MulSub(free.y, velocity.y, u.y), hn::MulSub(free.z, velocity.z, u.z)};
    V speed_left = set(speed_left_), drift = set(drift_);
    if (quadratic_) {
      const V z = hn::Mul(hn::Mul(set(shrink_), length(e)), dt), one = set(1.0);
      const auto finite = hn::Lt(z, set(std::numeric_limits<double>::infinity())), some = hn::Gt(z, hn::Zero(d));
      const V usable = hn::IfThenElse(hn::And(finite, some), z, one);
      speed_left = hn::IfThenElseZero(finite, hn::Div(one, hn::Add(one, z)));
      drift = hn::IfThenElseZero(finite, hn::Mul(dt, hn::IfThenElse(some, hn::Div(hn::Log1p(d, usable), usable), one)));
    }
    rows.put(along(u, speed_left, e), 3, k);
    rows.put(along(along(rows.at(0, k), dt, u), drift, e), 0, k);
  }

  HWY_INLINE void turn(Rows& rows, std::size_t k) const {
    const V zero = hn::Zero(d), tiny = set(std::numeric_limits<double>::min());
    const Mat3 body = rows.rotation_at(k);
    const Vec3 wind = rows.at(15, k);
    const V speed = length(wind), sign = set(follower_.facing == Facing::into_wind ? 1.0 : -1.0), per = hn::Max(speed, tiny);
    Vec3 aim = body.transposed_times(
        {hn::Div(hn::Mul(sign, wind.x), per), hn::Div(hn::Mul(sign, wind.y), per), hn::Div(hn::Mul(sign, wind.z), per)});
    const auto [y_locked, z_locked] = follower_.turn_locked;
    if (y_locked) aim.z = zero;
    if (z_locked) aim.y = zero;
    // The axis of the arc, (0, -aim.z, aim.y): of any length at all.
    const V larger = hn::Max(hn::Abs(aim.y), hn::Abs(aim.z)), unit = hn::IfThenElse(hn::Gt(larger, zero), larger, set(1.0));
    const V p = hn::Div(aim.y, unit), q = hn::Div(aim.z, unit), size = hn::Sqrt(hn::MulAdd(p, p, hn::Mul(q, q)));
    const V across = hn::Mul(larger, size), per_size = hn::Max(size, set(0.5));
    const auto beside = hn::Gt(across, zero);
    const V y = hn::IfThenElse(beside, hn::Neg(hn::Div(q, per_size)), set(z_locked ? 1.0 : 0.0));
    const V z = hn::IfThenElse(beside, hn::Div(p, per_size), set(z_locked ? 0.0 : 1.0));
    const auto moves = hn::And(hn::Gt(speed, zero), hn::Or(beside, hn::Lt(aim.x, zero)));
    const V angle = hn::IfThenElseZero(moves, angle_of(across, hn::IfThenElse(moves, aim.x, set(1.0))));
    // All the way, and back by what is left.
    const V left_y = hn::Mul(hn::Mul(angle, set(left_[0])), y), left_z = hn::Mul(hn::Mul(angle, set(left_[1])), z);
    const V left = hn::Sqrt(hn::MulAdd(left_y, left_y, hn::Mul(left_z, left_z)));
    const auto some = hn::Gt(left, zero);
    const V per_left = hn::IfThenElse(some, left, set(1.0));
    const Mat3 back = rotation(hn::IfThenElse(some, hn::Div(left_y, per_left), zero),
                               hn::IfThenElse(some, hn::Div(left_z, per_left), set(1.0)), hn::Neg(left));
    const Mat3 turned = body * (rotation(y, z, angle) * back);
    // R (3 - R^T R)/2 is a rotation again: rounding does not grow over a million steps.
    const V half = set(-0.5), three_halves = set(1.5);
    const auto correct = [&](const Vec3& column) {
      return along(times(three_halves, column), half, turned * turned.transposed_times(column));
    };
    const auto keep = [&](const Vec3& then, const Vec3& now, std::size_t i) {
      rows.put({hn::IfThenElse(moves, then.x, now.x), hn::IfThenElse(moves, then.y, now.y), hn::IfThenElse(moves, then.z, now.z)}, i, k);
    };
    keep(correct(turned.x), body.x, 6), keep(correct(turned.y), body.y, 9), keep(correct(turned.z), body.z, 12);
  }

  const Follower& follower_;
  double dt_, speed_left_ = 0.0, drift_ = 0.0;  // v' = u + e speed_left, r' = r + u dt + e drift
  bool quadratic_ = false, turns_ = false;
  double shrink_ = 0.0;
  double free_[3], left_[2];
};

void step_on_target(const Follower& follower, std::span<FollowerState> states, std::span<const Eigen::Vector3d> winds, double dt) {
  FollowerStep(follower, dt).run(states, winds);
}

std::size_t first_doubtful_on_target(std::span<const FollowerState> states, std::span<const Eigen::Vector3d> winds) {
  Rows rows;
  for (std::size_t first = 0; first < states.size(); first += block) {
    rows.load(states.data() + first, winds.data() + first, std::min(block, states.size() - first), true);
    for (std::size_t k = 0; k < block; k += wide) {
      V all = hn::Zero(d);  // stays zero of finite numbers
      for (const auto& row : rows.row) all = hn::MulAdd(hn::Zero(d), hn::Load(d, row + k), all);
      const Mat3 r = rows.rotation_at(k);
      const V xx = hn::Sub(dot(r.x, r.x), set(1.0)), yy = hn::Sub(dot(r.y, r.y), set(1.0)), zz = hn::Sub(dot(r.z, r.z), set(1.0));
      const V xy = dot(r.x, r.y), yz = dot(r.y, r.z), zx = dot(r.z, r.x);
      const V once = hn::MulAdd(xx, xx, hn::MulAdd(yy, yy, hn::Mul(zz, zz))),
              twice = hn::MulAdd(xy, xy, hn::MulAdd(yz, yz, hn::Mul(zx, zx)));
      const auto sound = hn::And(hn::Lt(hn::MulAdd(set(2.0), twice, once), set(0.99e-12)), hn::Gt(dot(cross(r.x, r.y), r.z), hn::Zero(d)));
      if (!hn::AllTrue(d, hn::And(sound, hn::Eq(all, hn::Zero(d))))) return first;
    }
  }
  return states.size();
}

}  // namespace dragcore::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace dragcore {

HWY_EXPORT(gust_factors_on_target);
HWY_EXPORT(step_on_target);
HWY_EXPORT(sum_of_waves_on_target);
HWY_EXPORT(first_doubtful_on_target);

bool gust_factors_by_kernel(const Gust& gust, std::span<const double> times, std::span<double> factors) {
  HWY_DYNAMIC_DISPATCH(gust_factors_on_target)(gust, times, factors);
  return true;
}

bool step_by_kernel(const Follower& follower, std::span<FollowerState> states, std::span<const Eigen::Vector3d> winds, double dt) {
  HWY_DYNAMIC_DISPATCH(step_on_target)(follower, states, winds, dt);
  return true;
}

bool sum_of_waves(const Waves& waves, const double* points, std::size_t count, double* sums) {
  HWY_DYNAMIC_DISPATCH(sum_of_waves_on_target)(waves, points, count, sums);
  return true;
}

std::size_t first_doubtful_follower(std::span<const FollowerState> states, std::span<const Eigen::Vector3d> winds) {
  return HWY_DYNAMIC_DISPATCH(first_doubtful_on_target)(states, winds);
}

}  // namespace dragcore
#endif
