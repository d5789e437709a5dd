#include "kernels/instance_kernel.hpp"

#include <dragcore/pillow.hpp>
#include <limits>

#include "kernels/secant_kernel.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/instance_kernel.cpp"
#include <hwy/foreach_target.h>

#include "kernels/blocks-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace dragcore::kernels::HWY_NAMESPACE {

namespace {

/// As many bodies as a vector has lanes, each in its own flow. Velocities in units of each body's speed, lengths of the shape's size.
struct Bodies {
  const InstanceTask& task;
  LawLanes law;
  Vec3 arm, flow, x, y, z;  ///< flow at the origin, and its change along the axes
  Vec3 direction;
  V speed, sound;  ///< sound: 1 where the speed is a number that single precision can square
  V travel;        ///< of the flow at the origin

  Bodies(const InstanceTask& given, const InstanceMotions& motions, std::size_t lane) : task(given), law(given.law) {
    const Many at{lane};
    // Lengths in units of the size from here on, so that what turns is a speed: a huge body turns by little.
    const V size = set(task.size), per_size = set(1.0f / task.size), half = set(0.5f);
    const Vec3 spin = times(vector(motions.spin, at), size);
    V g[3][3];
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t k = 0; k < 3; ++k) g[i][k] = hn::Mul(size, at(motions.gradient[3 * i + k]));
    // The gradient of the relative flow, G - [omega], column by column.
    x = {g[0][0], hn::Sub(g[1][0], spin.z), hn::Add(g[2][0], spin.y)};
    y = {hn::Add(g[0][1], spin.z), g[1][1], hn::Sub(g[2][1], spin.x)};
    z = {hn::Sub(g[0][2], spin.y), hn::Add(g[1][2], spin.x), g[2][2]};
    arm = times(vector(motions.arm, at), per_size);
    flow = along(along(along(vector(motions.flow, at), arm.x, x), arm.y, y), arm.z, z);
    V strain = hn::Zero(f);
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t k = 0; k < 3; ++k) {
        const V s = hn::Mul(half, hn::Add(g[i][k], g[k][i]));
        strain = hn::MulAdd(s, s, strain);
      }
    const Vec3 turning{hn::NegMulAdd(half, hn::Sub(g[2][1], g[1][2]), spin.x), hn::NegMulAdd(half, hn::Sub(g[0][2], g[2][0]), spin.y),
                       hn::NegMulAdd(half, hn::Sub(g[1][0], g[0][1]), spin.z)};
    const V variation = hn::Add(hn::Sqrt(strain), hn::Sqrt(dot(turning, turning)));
    travel = hn::Sqrt(dot(flow, flow));
    speed = hn::Add(travel, variation);
    const M in_range = hn::And(hn::And(hn::Gt(speed, set(1e-12f)), hn::Lt(speed, set(1e12f))), hn::Lt(dot(arm, arm), set(1e12f)));
    sound = hn::IfThenElseZero(in_range, set(1.0f));
    speed = hn::IfThenElse(in_range, speed, set(1.0f));
    const V per_speed = hn::Div(set(1.0f), speed), per_travel = hn::Div(set(1.0f), hn::Max(travel, set(tiny)));
    direction = times(flow, per_travel);
    flow = times(flow, per_speed), x = times(x, per_speed), y = times(y, per_speed), z = times(z, per_speed);
    travel = hn::Mul(travel, per_speed);
    const V turned = hn::Mul(variation, per_speed), travel2 = hn::Mul(travel, travel);
    const V directed = hn::Div(travel2, hn::MulAdd(turned, turned, travel2));
    law.pillow_factor = hn::Mul(set(task.law.pillow_factor), directed);
    if (task.law.viscous) {
      law.layer = hn::Mul(law.layer, hn::Sqrt(per_speed));
      // Eq. 17.
      const V root = hn::Sqrt(hn::Max(hn::Mul(travel, speed), set(tiny)));
      const V kappa = hn::Min(set(static_cast<float>(largest_tilt)), hn::Add(set(task.law.pillow_factor), hn::Div(set(task.pillow_gain), root)));
      if (task.pillow_gain > 0.0f) law.pillow_factor = hn::Mul(kappa, directed);
    }
    describe(directed);
  }

  /// What of the law depends on the flow, eq. 7 to 12.
  void describe(V directed) {
    if (!task.described) return;
    V frontal = hn::Zero(f), sharp = hn::Zero(f);
    const PackedSurface::Range range = task.surface->parts[0].uniform;
    for (std::size_t g = range.first; g < range.last; ++g)
      for (std::size_t k = 0; k < lanes; ++k) {
        const Group& group = task.surface->uniform_groups()[g];
        if (!(group.share[k] > 0.0f)) continue;
        V c = hn::Neg(dot(direction, vector(group.normal, One{k})));
        c = task.whole_silhouette ? hn::Abs(c) : hn::Max(c, hn::Zero(f));
        const V met = hn::Mul(c, set(group.share[k])), square = hn::Mul(c, c);
        frontal = hn::Add(frontal, met);
        sharp = hn::MulAdd(met, hn::Mul(square, square), sharp);
      }
    const V fourth = hn::Min(set(1.0f), hn::Div(sharp, hn::Max(frontal, set(tiny))));
    law.shelter_rate = hn::Mul(hn::Mul(directed, set(task.shelter)), fourth);
    law.per_sharpness = hn::Div(set(1.0f), hn::Max(hn::Sqrt(hn::Sqrt(fourth)), set(1e-6f)));
    const V depth = hn::MulAdd(set(task.recovery_depth), hn::Mul(frontal, hn::Sqrt(frontal)), set(task.volume + tiny));
    const V push = hn::Mul(hn::Mul(directed, set(task.recovery)), hn::Div(set(task.volume), depth));
    law.recovery_rise = hn::Mul(hn::Neg(push), hn::Add(law.recovery_edge, set(1.0f)));
  }

  HWY_INLINE Vec3 flow_at(const Vec3& r) const { return along(along(along(flow, r.x, x), r.y, y), r.z, z); }
};

/// What holds a body back, and what pushes it.
struct WrenchLanes {
  Sum taken, given;
  V taken_power, given_power;
  HWY_INLINE WrenchLanes() : taken_power(hn::Zero(f)), given_power(hn::Zero(f)) {}
  HWY_INLINE void rub(V k, const Vec3&, const Vec3& t, const Vec3& r, const Vec3& u) {
    taken.rub(k, t, r);
    taken_power = hn::MulAdd(k, dot(t, u), taken_power);
  }
  HWY_INLINE void press(V pressure, const Vec3& n, const Vec3& m, V w) {
    taken.press(pressure, n, m);
    taken_power = hn::MulAdd(pressure, w, taken_power);
  }
  HWY_INLINE void push(V pressure, const Vec3& n, const Vec3& m, V w) {
    given.press(pressure, n, m);
    given_power = hn::NegMulAdd(pressure, w, given_power);
  }
};

template <class Sums>
using Kernel = void (*)(const Bodies& bodies, Sums& sums);

/// Calls visit(group, lane) for every triangle of a range.
template <class Visit>
HWY_INLINE void for_each_triangle(const Group* groups, PackedSurface::Range range, const Visit& visit) {
  for (std::size_t g = range.first; g < range.last; ++g)
    for (std::size_t k = 0; k < lanes; ++k)
      if (groups[g].share[k] > 0.0f) visit(g, One{k});
}

template <class Sums, unsigned on>
void uniform_windward(const Bodies& bodies, Sums& result) {
  Sums sums = result;
  const Group* groups = bodies.task.surface->uniform_groups();
  for_each_triangle(groups, bodies.task.surface->parts[0].uniform, [&](std::size_t g, One at) {
    uniform_windward_at<on>(bodies.law, groups[g], at, at(groups[g].share), bodies.direction,
                            [&](const Windward& here, const Vec3& n, const Vec3& m, V w) { add_windward<on>(sums, here, n, m, w); });
  });
  result = sums;
}

template <class Sums, unsigned on>
void uniform_straight(const Bodies& bodies, Sums& result) {
  Sums sums = result;
  const Group* groups = bodies.task.surface->uniform_groups();
  for_each_triangle(groups, bodies.task.surface->parts[0].uniform, [&](std::size_t g, One at) {
    uniform_leeward_at<on>(
        bodies.law, groups[g], at, at(groups[g].share), bodies.direction,
        [&](V area, V pull, V push, const Vec3& n, const Vec3& m, V w) { add_leeward<on>(sums, area, pull, push, n, m, w); });
  });
  result = sums;
}

template <class Sums, unsigned on>
void varying_windward(const Bodies& bodies, Sums& result) {
  Sums sums = result;
  const PackedSurface& surface = *bodies.task.surface;
  const auto points = quadrature_rule(bodies.task.quadrature);
  for_each_triangle(surface.groups.data(), surface.parts[0].groups, [&](std::size_t g, One at) {
    const Group& group = surface.groups[g];
    const Vec3 n = vector(group.normal, at);
    Vec3 shift = n;
    if constexpr (on & pillow) shift = pillow_shift(bodies.law.pillow_factor, group, at, bodies.direction);
    for (const QuadraturePoint& quadrature_point : points) {
      const PointLanes point(quadrature_point);
      Vec3 r = point.of(surface.places[g], at);
      if constexpr (on & pillow) r = add(r, shift);
      windward_at<on>(bodies.law, group, at, hn::Mul(at(group.share), point.weight), n, r, bodies.flow_at(r),
                      [&](const Windward& here, const Vec3&, const Vec3& m, V w) { add_windward<on>(sums, here, n, m, w); });
    }
  });
  result = sums;
}

template <class Sums, unsigned on>
void varying_straight(const Bodies& bodies, Sums& result) {
  Sums sums = result;
  const PackedSurface& surface = *bodies.task.surface;
  const auto points = quadrature_rule(bodies.task.quadrature);
  for_each_triangle(surface.groups.data(), surface.parts[0].groups, [&](std::size_t g, One at) {
    const Group& group = surface.groups[g];
    const Vec3 n = vector(group.normal, at);
    for (const QuadraturePoint& quadrature_point : points) {
      const PointLanes point(quadrature_point);
      const Vec3 r = point.of(surface.places[g], at), u = bodies.flow_at(r);
      straight_at<on>(
          bodies.law, group, at, hn::Mul(at(group.share), point.weight), n, r, u,
          [&](V wetted, const Vec3& t) { sums.rub(wetted, n, t, r, u); },
          [&](V area, V pull, V push, const Vec3&, const Vec3& m, V w) { add_leeward<on>(sums, area, pull, push, n, m, w); });
    }
  });
  result = sums;
}

template <class Sums>
struct Tables {
  template <unsigned on>
  struct UniformWindward {
    static constexpr Kernel<Sums> kernel = uniform_windward<Sums, on>;
  };
  template <unsigned on>
  struct UniformStraight {
    static constexpr Kernel<Sums> kernel = uniform_straight<Sums, (on & ~(friction | viscous))>;
  };
  template <unsigned on>
  struct VaryingWindward {
    static constexpr Kernel<Sums> kernel = varying_windward<Sums, on>;
  };
  template <unsigned on>
  struct VaryingStraight {
    static constexpr Kernel<Sums> kernel = varying_straight<Sums, either_friction(on)>;
  };
};

/// Runs the two kernels that a law calls for.
template <class Sums>
void sum(const Bodies& bodies, const Kernel<Sums>* windwards, const Kernel<Sums>* straights, bool rubs, Sums& sums) {
  const ResolvedLaw& law = bodies.task.law;
  const bool has_two_sides = bodies.task.surface->parts[0].two_sided;
  windwards[windward_effects(law, has_two_sides)](bodies, sums);
  if (law.leeward || law.recovery || rubs) straights[straight_effects(law, has_two_sides)](bodies, sums);
}

/// EnergyBalance::gain_share(), in single or double precision.
template <class Tag, class Numbers = hn::Vec<Tag>>
HWY_INLINE Numbers gain_share(Tag tag, Numbers taken, Numbers given) {
  using Number = hn::TFromD<Tag>;
  const Numbers one = hn::Set(tag, Number{1}), bound = hn::Mul(hn::Set(tag, static_cast<Number>(largest_gain)), taken);
  const Numbers low = hn::Min(given, bound), high = hn::Max(given, bound);
  const Numbers x = hn::Div(low, hn::Max(high, hn::Set(tag, std::numeric_limits<Number>::min())));
  const Numbers x2 = hn::Mul(x, x), x4 = hn::Mul(x2, x2);
  const Numbers held = hn::Div(one, hn::Sqrt(hn::Sqrt(hn::Sqrt(hn::MulAdd(x4, x4, one)))));  // (1 + x^8)^(-1/8)
  return hn::IfThenElse(hn::Le(given, bound), held, hn::Mul(x, held));
}

}  // namespace

void instance_wrenches_on_target(const InstanceTask& task, const InstanceMotions& motions, bool varies, InstanceWrenches& result) {
  using All = Tables<WrenchLanes>;
  static constexpr auto uniform_windwards = kernels_of<Kernel<WrenchLanes>, All::UniformWindward>(AllWindward());
  static constexpr auto uniform_straights = kernels_of<Kernel<WrenchLanes>, All::UniformStraight>(AllStraight());
  static constexpr auto varying_windwards = kernels_of<Kernel<WrenchLanes>, All::VaryingWindward>(AllWindward());
  static constexpr auto varying_straights = kernels_of<Kernel<WrenchLanes>, All::VaryingStraight>(AllStraight());
  for (std::size_t lane = 0; lane < lanes; lane += width) {
    const Bodies bodies(task, motions, lane);
    WrenchLanes sums;
    V scale = set(1.0f);
    if (varies) {
      sum(bodies, varying_windwards.data(), varying_straights.data(), task.law.friction || task.law.viscous, sums);
      if (task.law.viscous) {  // what creeping flow takes
        const V per_speed = hn::Div(set(1.0f), bodies.speed), creeping = hn::Mul(hn::Load(f, motions.creeping_power + lane), per_speed);
        sums.taken_power = hn::MulAdd(hn::Mul(creeping, per_speed), per_speed, sums.taken_power);
      }
    } else {
      sum(bodies, uniform_windwards.data(), uniform_straights.data(), false, sums);
      if (task.law.friction) {
        const PackedSurface::Part& part = task.surface->parts[0];
        const auto apply_matrix = [&](const Eigen::Matrix3d& m) {
          const auto row = [&](Eigen::Index i) {
            const auto at = [&](Eigen::Index k) { return set(static_cast<float>(m(i, k))); };
            return hn::Mul(bodies.law.skin_friction, dot({at(0), at(1), at(2)}, bodies.direction));
          };
          return Vec3{row(0), row(1), row(2)};
        };
        const Vec3 drag = apply_matrix(part.friction_force), turn = apply_matrix(part.friction_torque);
        sums.taken_power = hn::Add(sums.taken_power, dot(drag, bodies.direction));
        const V all[6] = {drag.x, drag.y, drag.z, turn.x, turn.y, turn.z};
        for (std::size_t axis = 0; axis < 3; ++axis) {
          sums.taken.force[axis] = hn::Add(sums.taken.force[axis], all[axis]);
          sums.taken.torque[axis] = hn::Add(sums.taken.torque[axis], all[axis + 3]);
        }
      }
      scale = hn::Mul(bodies.travel, bodies.travel);  // in units of its own dynamic pressure so far
    }
    const V share = task.law.curvature || task.law.recovery ? gain_share(f, sums.taken_power, sums.given_power) : hn::Zero(f);
    V force[3], torque[3];
    for (std::size_t axis = 0; axis < 3; ++axis) {
      force[axis] = hn::Mul(scale, hn::MulAdd(share, sums.given.force[axis], sums.taken.force[axis]));
      torque[axis] = hn::Mul(scale, hn::MulAdd(share, sums.given.torque[axis], sums.taken.torque[axis]));
    }
    const Vec3 moved = add({torque[0], torque[1], torque[2]}, cross(bodies.arm, {force[0], force[1], force[2]}));
    store({force[0], force[1], force[2]}, result.force, lane), store(moved, result.torque, lane);
    hn::Store(hn::Mul(bodies.speed, bodies.sound), f, result.speed + lane);
  }
}

// ---- steps: small matrices, each lane its own

namespace {

HWY_INLINE W sum_of_products(const W* a, const W* b, std::size_t count) {
  W sum = hn::Mul(a[0], b[0]);
  for (std::size_t k = 1; k < count; ++k) sum = hn::MulAdd(a[k], b[k], sum);
  return sum;
}
HWY_INLINE W wide_set(double value) { return hn::Set(d, value); }

/// Symmetric, six by six.
struct Matrix6 {
  W at[6][6];
  HWY_INLINE void apply(const W (&v)[6], W (&result)[6]) const {
    for (std::size_t i = 0; i < 6; ++i) result[i] = sum_of_products(at[i], v, 6);
  }
};

/// Solves a x = b for a positive definite matrix: a = L D L^T.
HWY_INLINE void solve(Matrix6& a, W (&x)[6]) {
  W inverse[6];
  for (std::size_t k = 0; k < 6; ++k) {
    inverse[k] = hn::Div(wide_set(1.0), a.at[k][k]);
    for (std::size_t i = k + 1; i < 6; ++i) {
      const W factor = hn::Mul(a.at[i][k], inverse[k]);
      for (std::size_t j = k + 1; j <= i; ++j) a.at[i][j] = hn::NegMulAdd(factor, a.at[j][k], a.at[i][j]);
      x[i] = hn::NegMulAdd(factor, x[k], x[i]);
    }
  }
  for (std::size_t i = 6; i-- > 0;) {
    x[i] = hn::Mul(x[i], inverse[i]);
    for (std::size_t k = i + 1; k < 6; ++k) x[i] = hn::NegMulAdd(hn::Mul(a.at[k][i], inverse[i]), x[k], x[i]);
  }
}

/// a x = b for three by three, by cofactors.
HWY_INLINE void solve3(const W (&a)[3][3], const W (&b)[3], W (&x)[3]) {
  W cofactor[3][3];
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t i1 = (i + 1) % 3, i2 = (i + 2) % 3, k1 = (k + 1) % 3, k2 = (k + 2) % 3;
      cofactor[i][k] = hn::MulSub(a[i1][k1], a[i2][k2], hn::Mul(a[i1][k2], a[i2][k1]));
    }
  const W inverse = hn::Div(wide_set(1.0), sum_of_products(a[0], cofactor[0], 3));
  for (std::size_t k = 0; k < 3; ++k)
    x[k] = hn::Mul(inverse, hn::MulAdd(b[0], cofactor[0][k], hn::MulAdd(b[1], cofactor[1][k], hn::Mul(b[2], cofactor[2][k]))));
}

constexpr std::size_t in_six[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};

HWY_INLINE W at_wide(const InstanceSteps::Wide& row, std::size_t lane) { return hn::Load(d, row + lane); }

/// Inertia that a body can have, mass above 0: all minors of the first are positive, and those of the moments about planes not negative.
HWY_INLINE hn::Mask<D> sound_mass(const InstanceSteps& steps, std::size_t lane) {
  W i[6];
  for (std::size_t k = 0; k < 6; ++k) i[k] = at_wide(steps.inertia[k], lane);
  const W zero = hn::Zero(d), trace = hn::Add(i[0], hn::Add(i[3], i[5])), half = hn::Mul(trace, wide_set(0.5 + 1e-6));
  const auto positive = [&](W xx, W xy, W xz, W yy, W yz, W zz) {
    const W minor = hn::MulSub(xx, yy, hn::Mul(xy, xy));
    const W determinant = hn::MulAdd(xx, hn::MulSub(yy, zz, hn::Mul(yz, yz)),
                                     hn::MulSub(xz, hn::MulSub(xy, yz, hn::Mul(yy, xz)), hn::Mul(xy, hn::MulSub(xy, zz, hn::Mul(yz, xz)))));
    return hn::And(hn::Gt(xx, zero), hn::And(hn::Gt(minor, zero), hn::Gt(determinant, zero)));
  };
  const W mass = at_wide(steps.mass, lane);
  return hn::And(hn::And(hn::Gt(mass, zero), hn::Lt(mass, wide_set(1e300))),
                 hn::And(positive(i[0], i[1], i[2], i[3], i[4], i[5]), positive(hn::Sub(half, i[0]), hn::Neg(i[1]), hn::Neg(i[2]),
                                                                                hn::Sub(half, i[3]), hn::Neg(i[4]), hn::Sub(half, i[5]))));
}

HWY_INLINE void cross3(const W (&a)[3], const W (&b)[3], W (&x)[3]) {
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
    x[i] = hn::MulSub(a[j], b[k], hn::Mul(a[k], b[j]));
  }
}

/// gyroscopic_spin(). A turn whose square is beyond all numbers leaves none.
HWY_INLINE void turn_by_inertia(InstanceSteps& steps, std::size_t lane) {
  W spin[3], inertia[6];
  for (std::size_t i = 0; i < 3; ++i) spin[i] = at_wide(steps.spin[i], lane);
  for (std::size_t k = 0; k < 6; ++k) inertia[k] = at_wide(steps.inertia[k], lane);
  // I = C C^T, the diagonal by its inverse.
  const W one = wide_set(1.0);
  const auto inverse_root = [one](W square) { return hn::Div(one, hn::Sqrt(square)); };
  const W d0 = inverse_root(inertia[0]), c10 = hn::Mul(inertia[1], d0), c20 = hn::Mul(inertia[2], d0);
  const W d1 = inverse_root(hn::NegMulAdd(c10, c10, inertia[3])), c21 = hn::Mul(hn::NegMulAdd(c10, c20, inertia[4]), d1);
  const W d2 = inverse_root(hn::NegMulAdd(c21, c21, hn::NegMulAdd(c20, c20, inertia[5])));
  const W c00 = hn::Div(one, d0), c11 = hn::Div(one, d1), c22 = hn::Div(one, d2);
  const W y[3] = {hn::MulAdd(c00, spin[0], hn::MulAdd(c10, spin[1], hn::Mul(c20, spin[2]))),
                  hn::MulAdd(c11, spin[1], hn::Mul(c21, spin[2])), hn::Mul(c22, spin[2])};
  const W rate = hn::Mul(wide_set(0.25 * steps.dt), hn::Mul(d0, hn::Mul(d1, d2)));
  W change[3] = {hn::Zero(d), hn::Zero(d), hn::Zero(d)};
  for (int iteration = 0; iteration < 4; ++iteration) {
    W twice[3], q[3], sine[3], across[3], over[3];
    for (std::size_t i = 0; i < 3; ++i) twice[i] = hn::Mul(rate, hn::MulAdd(wide_set(2.0), y[i], change[i]));
    // C^T C times it
    const W m0 = hn::Mul(c00, twice[0]), m1 = hn::MulAdd(c10, twice[0], hn::Mul(c11, twice[1])),
            m2 = hn::MulAdd(c20, twice[0], hn::MulAdd(c21, twice[1], hn::Mul(c22, twice[2])));
    q[0] = hn::MulAdd(c00, m0, hn::MulAdd(c10, m1, hn::Mul(c20, m2)));
    q[1] = hn::MulAdd(c11, m1, hn::Mul(c21, m2)), q[2] = hn::Mul(c22, m2);
    const W scale = hn::Div(wide_set(2.0), hn::Add(one, sum_of_products(q, q, 3)));
    for (std::size_t i = 0; i < 3; ++i) sine[i] = hn::Mul(scale, q[i]);
    cross3(sine, y, across), cross3(q, across, over);
    for (std::size_t i = 0; i < 3; ++i) change[i] = hn::Add(across[i], over[i]);
  }
  const W turned2 = hn::Mul(d2, change[2]), turned1 = hn::Mul(d1, hn::NegMulAdd(c21, turned2, change[1])),
          turned0 = hn::Mul(d0, hn::NegMulAdd(c10, turned1, hn::NegMulAdd(c20, turned2, change[0])));
  hn::Store(hn::Add(spin[0], turned0), d, steps.spin[0] + lane), hn::Store(hn::Add(spin[1], turned1), d, steps.spin[1] + lane);
  hn::Store(hn::Add(spin[2], turned2), d, steps.spin[2] + lane);
}

/// Sums of `Secant` in double, of half the bodies of a vector at once.
struct SecantRows {
  alignas(64) Row row[38];
  HWY_INLINE W operator()(std::size_t k, std::size_t lane) const {
    const hn::Rebind<float, D> half;
    return hn::PromoteTo(d, hn::Load(half, row[k] + lane));
  }
};

}  // namespace

void instance_steps_on_target(const InstanceTask& task, InstanceMotions& motions, InstanceSteps& steps) {
  using All = Tables<SecantLanes>;
  static constexpr auto windwards = kernels_of<Kernel<SecantLanes>, All::VaryingWindward>(AllWindward());
  static constexpr auto straights = kernels_of<Kernel<SecantLanes>, All::VaryingStraight>(AllStraight());
  for (std::size_t lane = 0; lane < lanes; lane += wide) turn_by_inertia(steps, lane);
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (std::size_t lane = 0; lane < lanes; ++lane)
      motions.spin[axis][lane] = steps.turns ? static_cast<float>(steps.spin[axis][lane]) : 0.0f;
  SecantRows sums;
  alignas(64) Row speed, sound, arm[3];
  for (std::size_t lane = 0; lane < lanes; lane += width) {
    const Bodies bodies(task, motions, lane);
    SecantLanes secant;
    sum(bodies, windwards.data(), straights.data(), task.law.friction || task.law.viscous, secant);
    secant.for_each([&](std::size_t row, V value) { hn::Store(value, f, sums.row[row] + lane); });
    hn::Store(bodies.speed, f, speed + lane), hn::Store(bodies.sound, f, sound + lane);
    store(bodies.arm, arm, lane);
  }
  const hn::Rebind<float, D> half;
  const auto promoted = [&](const Row& row, std::size_t lane) { return hn::PromoteTo(d, hn::Load(half, row + lane)); };
  const W dt = wide_set(steps.dt), size = wide_set(task.size), zero = hn::Zero(d);
  for (std::size_t lane = 0; lane < lanes; lane += wide) {
    const auto at = [&](std::size_t row) { return sums(row, lane); };
    const W v = promoted(speed, lane), unit = hn::Mul(wide_set(steps.half_density * steps.area), v);
    // About the origin, in the kernel's units: force by velocity, force by spin, torque by spin.
    W ff[3][3], ft[3][3], tt[3][3];
    const W first[3] = {at(22), at(23), at(24)};
    const W second_trace = hn::Add(at(25), hn::Add(at(28), at(30)));
    const W turn[3][3] = {{zero, hn::Neg(first[2]), first[1]}, {first[2], zero, hn::Neg(first[0])}, {hn::Neg(first[1]), first[0], zero}};
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t k = 0; k < 3; ++k) {
        ff[i][k] = i == k ? hn::Add(at(in_six[i][k]), at(21)) : at(in_six[i][k]);
        ft[i][k] = hn::Sub(at(6 + 3 * i + k), turn[i][k]);
        tt[i][k] = hn::Sub(at(15 + in_six[i][k]), at(25 + in_six[i][k]));
        if (i == k) tt[i][k] = hn::Add(tt[i][k], second_trace);
      }
    // As fast_secant().
    const W rounding = wide_set(SecantSums::rounding), force_trace = hn::Add(ff[0][0], hn::Add(ff[1][1], ff[2][2])),
            torque_trace = hn::Add(tt[0][0], hn::Add(tt[1][1], tt[2][2]));
    for (std::size_t i = 0; i < 3; ++i) {
      ff[i][i] = hn::MulAdd(rounding, force_trace, ff[i][i]);
      tt[i][i] = hn::MulAdd(rounding, torque_trace, tt[i][i]);
    }
    if (task.law.viscous) {
      const W per_unit = hn::Div(wide_set(1.0), unit), per_size = wide_set(1.0 / static_cast<double>(task.size));
      const auto creeping = [&](std::size_t i, std::size_t k) { return hn::Mul(per_unit, wide_set(steps.creeping[i][k])); };
      for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t k = 0; k < 3; ++k) {
          ff[i][k] = hn::Add(ff[i][k], creeping(i, k));
          ft[i][k] = hn::MulAdd(per_size, creeping(i, k + 3), ft[i][k]);
          tt[i][k] = hn::MulAdd(hn::Mul(per_size, per_size), creeping(i + 3, k + 3), tt[i][k]);
        }
    }
    // About the centre of mass: with A = [arm], S_tf = S_tf + A S_ff, S_tt = S_tt + A S_ft + S_tf A^T + A S_ff A^T, in units of the size.
    const W a[3] = {promoted(arm[0], lane), promoted(arm[1], lane), promoted(arm[2], lane)};
    const auto crossed = [&](const W& x, const W& y, const W& z, W(&result)[3]) {
      result[0] = hn::MulSub(a[1], z, hn::Mul(a[2], y)), result[1] = hn::MulSub(a[2], x, hn::Mul(a[0], z)),
      result[2] = hn::MulSub(a[0], y, hn::Mul(a[1], x));
    };
    W moved_ft[3][3];  // S_ft + S_ff A^T: row by row, arm x row of S_ff
    for (std::size_t i = 0; i < 3; ++i) {
      W row[3];
      crossed(ff[i][0], ff[i][1], ff[i][2], row);
      for (std::size_t k = 0; k < 3; ++k) moved_ft[i][k] = hn::Add(ft[i][k], row[k]);
    }
    W moved_tt[3][3];
    for (std::size_t i = 0; i < 3; ++i) {  // S_tt + S_tf A^T: arm x row of S_tf = column of S_ft
      W row[3];
      crossed(ft[0][i], ft[1][i], ft[2][i], row);
      for (std::size_t k = 0; k < 3; ++k) moved_tt[i][k] = hn::Add(tt[i][k], row[k]);
    }
    for (std::size_t k = 0; k < 3; ++k) {  // + A (S_ft + S_ff A^T)
      W column[3];
      crossed(moved_ft[0][k], moved_ft[1][k], moved_ft[2][k], column);
      for (std::size_t i = 0; i < 3; ++i) moved_tt[i][k] = hn::Add(moved_tt[i][k], column[i]);
    }
    Matrix6 s;
    const W unit_size = hn::Mul(unit, size), unit_size2 = hn::Mul(unit_size, size);
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t k = 0; k < 3; ++k) {
        s.at[i][k] = hn::Mul(unit, ff[i][k]);
        s.at[i][k + 3] = s.at[k + 3][i] = hn::Mul(unit_size, moved_ft[i][k]);
        s.at[i + 3][k + 3] = hn::Mul(unit_size2, moved_tt[i][k]);
      }
    W y[6], felt[6];  // relative to the air; and what of it is felt
    for (std::size_t i = 0; i < 3; ++i) {
      y[i] = felt[i] = at_wide(steps.velocity[i], lane);
      y[i + 3] = at_wide(steps.spin[i], lane);
      felt[i + 3] = steps.turns ? y[i + 3] : zero;
    }
    if (task.law.curvature || task.law.recovery) {
      // As resistance(): Broyden's update, by what pushes.
      W held_back[6];
      s.apply(felt, held_back);
      const W taken_power = sum_of_products(held_back, felt, 6), to_newton = hn::Mul(unit, v);
      const W given_power = hn::Mul(hn::Mul(to_newton, v), at(37));
      const W share = hn::Mul(to_newton, gain_share(d, taken_power, given_power));
      W force[3] = {at(31), at(32), at(33)}, torque[3], total[6];
      crossed(force[0], force[1], force[2], torque);
      for (std::size_t i = 0; i < 3; ++i) {
        total[i] = hn::NegMulAdd(share, force[i], held_back[i]);  // both against the air: minus the wrench
        total[i + 3] = hn::NegMulAdd(hn::Mul(share, size), hn::Add(at(34 + i), torque[i]), held_back[i + 3]);
      }
      const W power = sum_of_products(total, felt, 6);
      const auto some = hn::And(hn::Gt(given_power, zero), hn::And(hn::Gt(power, zero), hn::Gt(taken_power, zero)));
      const W per_power = hn::IfThenElseZero(some, hn::Div(wide_set(1.0), power)),
              per_taken = hn::IfThenElseZero(some, hn::Div(wide_set(1.0), taken_power));
      for (std::size_t i = 0; i < 6; ++i)
        for (std::size_t k = 0; k <= i; ++k) {
          const W less = hn::Mul(hn::Mul(held_back[i], held_back[k]), per_taken), more = hn::Mul(hn::Mul(total[i], total[k]), per_power);
          s.at[i][k] = s.at[k][i] = hn::Add(s.at[i][k], hn::IfThenElseZero(some, hn::Sub(more, less)));
        }
    }
    // step_secant_implicit(): (M + dt S) x = M y + dt external.
    const W mass = at_wide(steps.mass, lane);
    W x[6], stiff = zero;
    Matrix6 left;
    W inertia[3][3], per_inertia = zero;
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t k = 0; k < 3; ++k) inertia[i][k] = at_wide(steps.inertia[in_six[i][k]], lane);
    for (std::size_t i = 0; i < 3; ++i) {
      W unit_vector[3] = {zero, zero, zero}, column[3];
      unit_vector[i] = wide_set(1.0);
      solve3(inertia, unit_vector, column);
      per_inertia = hn::Add(per_inertia, column[i]);
      x[i] = hn::MulAdd(dt, at_wide(steps.external[i], lane), hn::Mul(mass, y[i]));
      x[i + 3] = hn::MulAdd(dt, at_wide(steps.external[i + 3], lane), sum_of_products(inertia[i], y + 3, 3));
    }
    for (std::size_t i = 0; i < 6; ++i)
      for (std::size_t k = 0; k < 6; ++k) left.at[i][k] = hn::Mul(dt, s.at[i][k]);
    for (std::size_t i = 0; i < 3; ++i) {
      stiff = hn::Add(stiff, hn::Add(hn::Div(left.at[i][i], mass), hn::Mul(left.at[i + 3][i + 3], per_inertia)));
      left.at[i][i] = hn::Add(left.at[i][i], mass);
      for (std::size_t k = 0; k < 3; ++k) left.at[i + 3][k + 3] = hn::Add(left.at[i + 3][k + 3], inertia[i][k]);
    }
    solve(left, x);
    W finite = zero;
    for (std::size_t i = 0; i < 6; ++i) {
      hn::Store(x[i], d, steps.result[i] + lane);
      finite = hn::MulAdd(x[i], zero, finite);
    }
    const auto good = hn::And(hn::And(sound_mass(steps, lane), hn::Lt(stiff, wide_set(1e4))),
                              hn::And(hn::Eq(finite, zero), hn::Gt(promoted(sound, lane), zero)));
    hn::Store(hn::IfThenElseZero(good, wide_set(1.0)), d, steps.sound + lane);
  }
}

}  // namespace dragcore::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace dragcore::kernels {

HWY_EXPORT(instance_wrenches_on_target);
HWY_EXPORT(instance_steps_on_target);

void instance_wrenches(const InstanceTask& task, const InstanceMotions& motions, bool varies, InstanceWrenches& result) {
  HWY_DYNAMIC_DISPATCH(instance_wrenches_on_target)(task, motions, varies, result);
}

void instance_steps(const InstanceTask& task, InstanceMotions& motions, InstanceSteps& steps) {
  HWY_DYNAMIC_DISPATCH(instance_steps_on_target)(task, motions, steps);
}

}  // namespace dragcore::kernels
#endif
