#include "kernels/wrench_kernel.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <stdexcept>

// This file is compiled once for every instruction set; the best one that the machine has is taken at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/wrench_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace dragcore::kernels::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

constexpr std::size_t block = 256;  // triangles whose intermediate results stay in the first cache

using F = hn::CappedTag<float, PackedSurface::lanes>;
using V = hn::Vec<F>;
constexpr F f;
constexpr std::size_t width = hn::MaxLanes(F());

struct Vec3 {
  V x, y, z;
};

HWY_INLINE V set(float value) { return hn::Set(f, value); }
HWY_INLINE V dot(const Vec3& a, const Vec3& b) { return hn::MulAdd(a.x, b.x, hn::MulAdd(a.y, b.y, hn::Mul(a.z, b.z))); }
HWY_INLINE Vec3 cross(const Vec3& a, const Vec3& b) {
  return {hn::MulSub(a.y, b.z, hn::Mul(a.z, b.y)), hn::MulSub(a.z, b.x, hn::Mul(a.x, b.z)), hn::MulSub(a.x, b.y, hn::Mul(a.y, b.x))};
}
HWY_INLINE Vec3 add(const Vec3& a, const Vec3& b) { return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)}; }
/// a + s b
HWY_INLINE Vec3 along(const Vec3& a, V s, const Vec3& b) { return {hn::MulAdd(s, b.x, a.x), hn::MulAdd(s, b.y, a.y), hn::MulAdd(s, b.z, a.z)}; }
HWY_INLINE Vec3 times(const Vec3& a, V s) { return {hn::Mul(a.x, s), hn::Mul(a.y, s), hn::Mul(a.z, s)}; }
HWY_INLINE Vec3 set(const Eigen::Vector3f& v) { return {set(v.x()), set(v.y()), set(v.z())}; }
HWY_INLINE Vec3 load(const std::array<Aligned<float>, 3>& arrays, std::size_t k) {
  return {hn::Load(f, arrays[0].data() + k), hn::Load(f, arrays[1].data() + k), hn::Load(f, arrays[2].data() + k)};
}
/// A symmetric tensor times a vector.
HWY_INLINE Vec3 apply(const std::array<Aligned<float>, 6>& tensor, std::size_t k, const Vec3& v) {
  const V xx = hn::Load(f, tensor[0].data() + k), xy = hn::Load(f, tensor[1].data() + k), xz = hn::Load(f, tensor[2].data() + k);
  const V yy = hn::Load(f, tensor[3].data() + k), yz = hn::Load(f, tensor[4].data() + k), zz = hn::Load(f, tensor[5].data() + k);
  return {hn::MulAdd(xx, v.x, hn::MulAdd(xy, v.y, hn::Mul(xz, v.z))), hn::MulAdd(xy, v.x, hn::MulAdd(yy, v.y, hn::Mul(yz, v.z))),
          hn::MulAdd(xz, v.x, hn::MulAdd(yz, v.y, hn::Mul(zz, v.z)))};
}
HWY_INLINE V polynomial(const std::array<float, 5>& p, V c) {
  return hn::MulAdd(hn::MulAdd(hn::MulAdd(hn::MulAdd(set(p[4]), c, set(p[3])), c, set(p[2])), c, set(p[1])), c, set(p[0]));
}
/// c (1 + e)/(c + e)
HWY_INLINE V saturating(V c, float e) { return hn::Div(hn::Mul(c, set(1.0f + e)), hn::Add(c, set(e))); }

/// exp(-x) for x >= 0, within 2e-7: the same bits on every target with fused products.
HWY_INLINE V exp_minus(V x) {
  const V z = hn::Max(hn::Neg(x), set(-80.0f));
  const V n = hn::Round(hn::Mul(z, set(1.44269504f)));
  const V y = hn::MulAdd(n, set(2.12194440e-4f), hn::MulAdd(n, set(-0.693359375f), z));  // |y| <= log(2)/2, log(2) in two parts
  V p = set(1.0f / 720.0f);
  p = hn::MulAdd(p, y, set(1.0f / 120.0f));
  p = hn::MulAdd(p, y, set(1.0f / 24.0f));
  p = hn::MulAdd(p, y, set(1.0f / 6.0f));
  p = hn::MulAdd(p, y, set(0.5f));
  p = hn::MulAdd(p, y, set(1.0f));
  p = hn::MulAdd(p, y, set(1.0f));
  const hn::RebindToSigned<F> i;
  return hn::BitCast(f, hn::Add(hn::BitCast(i, p), hn::ShiftLeft<23>(hn::ConvertTo(i, n))));
}

/// Intermediate results of one block.
struct Scratch {
  HWY_ALIGN float shift[3][block];             // of the pillow
  HWY_ALIGN float place[3][block];             // of a point of quadrature
  HWY_ALIGN float arm[3][block];               // (place + shift) x normal
  HWY_ALIGN float straight[3][block];          // place x normal
  HWY_ALIGN float c[block], s[block], w[block];  // windward pressure: cosine, factor of the normal, normal speed
  HWY_ALIGN float bend[block];                 // chi
  HWY_ALIGN float lee_c[block], lee_s[block], lee_w[block];
  HWY_ALIGN float area[block];                 // that stands for the point
  HWY_ALIGN float rules[3][block];             // shares of the three rules, adaptive
};

HWY_INLINE Vec3 load(const float (&arrays)[3][block], std::size_t k) {
  return {hn::Load(f, arrays[0] + k), hn::Load(f, arrays[1] + k), hn::Load(f, arrays[2] + k)};
}
HWY_INLINE void store(const Vec3& v, float (&arrays)[3][block], std::size_t k) {
  hn::Store(v.x, f, arrays[0] + k), hn::Store(v.y, f, arrays[1] + k), hn::Store(v.z, f, arrays[2] + k);
}

/// 16 lanes of float as one double, in one order whatever the width.
HWY_INLINE double total(const float* lane) {
  double sum[PackedSurface::lanes];
  for (std::size_t k = 0; k < PackedSurface::lanes; ++k) sum[k] = lane[k];
  for (std::size_t half = PackedSurface::lanes / 2; half > 0; half /= 2)
    for (std::size_t k = 0; k < half; ++k) sum[k] += sum[k + half];
  return sum[0];
}

class PartSum {
 public:
  PartSum(const PackedSurface& body, const PartTask& task, TermSums& sums) : body_(body), task_(task), law_(task.law), sums_(sums) {}

  void run() {
    const PackedSurface::Range slots = body_.part[task_.part];
    for (std::size_t first = slots.first; first < slots.last; first += block) {
      first_ = first;
      count_ = std::min(block, slots.last - first);
      run_block();
    }
  }

 private:
  void run_block() {
    if (task_.pillow > 0.0f) shift();
    if (!task_.varies) {
      const float* area = body_.share.data() + first_;
      const Arrays moment{body_.moment[0].data() + first_, body_.moment[1].data() + first_, body_.moment[2].data() + first_};
      task_.pillow > 0.0f ? uniform_windward<true>(area) : uniform_windward<false>(area);
      pressures(task_.pillow > 0.0f ? arrays(scratch_.arm) : moment);
      if (law_.leeward || law_.recovery) {
        uniform_leeward(area);
        suctions(moment);
      }
      return;
    }
    const auto rule = [&](Quadrature order, const float* share) {
      for (const QuadraturePoint& point : quadrature_rule(order)) at_point(point, share);
    };
    if (task_.quadrature != Quadrature::adaptive) {
      rule(task_.quadrature, nullptr);
      return;
    }
    const std::array<bool, 3> some = adapt();
    if (some[0]) rule(Quadrature::one, scratch_.rules[0]);
    if (some[1]) rule(Quadrature::three, scratch_.rules[1]);
    if (some[2]) rule(Quadrature::six, scratch_.rules[2]);
  }

  struct Arrays {
    const float *x, *y, *z;
  };
  static Arrays arrays(const float (&a)[3][block]) { return {a[0], a[1], a[2]}; }

  template <class Pass>
  HWY_INLINE void for_each(Pass&& pass) const {
    for (std::size_t k = 0; k < count_; k += width) pass(k, first_ + k);
  }

  HWY_INLINE Vec3 normal(std::size_t slot) const { return load(body_.normal, slot); }

  /// -kappa t M e/sqrt(3 e.M e) over the face
  void shift() {
    const Vec3 u = set(task_.direction);
    const V kappa = set(-task_.pillow);
    for_each([&](std::size_t k, std::size_t slot) {
      const Vec3 n = normal(slot);
      const Vec3 t = along(u, hn::Neg(dot(u, n)), n), moved = apply(body_.second_moment, slot, t);
      const V square = hn::Max(hn::Mul(set(3.0f), dot(t, moved)), set(1e-30f));
      const V factor = hn::Mul(kappa, hn::Sqrt(hn::Div(dot(t, t), square)));
      store(times(along(moved, hn::Neg(dot(moved, n)), n), factor), scratch_.shift, k);
    });
  }

  /// From speed^2 and normal speed w: what pressure on windward surface and on leeward surface is a multiple of.
  template <bool windward>
  HWY_INLINE void side(std::size_t k, std::size_t slot, const float* area, V speed2, V w) {
    const auto front = windward ? hn::Gt(w, hn::Zero(f)) : hn::Lt(w, hn::Zero(f));
    V felt = hn::Mul(hn::Load(f, area + k), speed2);
    felt = body_.one_sided ? hn::IfThenElseZero(front, felt)
                           : hn::Mul(felt, hn::IfThenElse(front, set(1.0f), hn::Load(f, body_.back.data() + slot)));
    const V size = hn::Abs(w);
    felt = hn::IfThenElseZero(hn::Gt(size, hn::Zero(f)), felt);
    const V c = hn::Min(set(1.0f), hn::Div(size, hn::Sqrt(hn::Max(speed2, set(1e-30f)))));
    // Along -n where the air comes against n, and along n where it comes from behind: downstream.
    const V s = hn::CopySign(felt, hn::Neg(w));
    hn::Store(c, f, (windward ? scratch_.c : scratch_.lee_c) + k);
    hn::Store(s, f, (windward ? scratch_.s : scratch_.lee_s) + k);
    hn::Store(size, f, (windward ? scratch_.w : scratch_.lee_w) + k);
  }

  template <bool shifted>
  void uniform_windward(const float* area) {
    const Vec3 u = set(task_.flow);
    const V speed2 = dot(u, u);
    for_each([&](std::size_t k, std::size_t slot) {
      const Vec3 n = normal(slot);
      side<true>(k, slot, area, speed2, hn::Neg(dot(u, n)));
      if constexpr (shifted) store(add(load(body_.moment, slot), cross(load(scratch_.shift, k), n)), scratch_.arm, k);
    });
    if (law_.curvature)
      for_each([&](std::size_t k, std::size_t slot) { bend(k, slot, u, hn::Neg(dot(u, normal(slot)))); });
    if (law_.friction) friction_of_uniform_flow(area);
  }

  void uniform_leeward(const float* area) {
    const Vec3 u = set(task_.flow);
    const V speed2 = dot(u, u);
    for_each([&](std::size_t k, std::size_t slot) { side<false>(k, slot, area, speed2, hn::Neg(dot(u, normal(slot)))); });
  }

  /// chi of the flow along the surface
  HWY_INLINE void bend(std::size_t k, std::size_t slot, const Vec3& u, V w) {
    const Vec3 n = normal(slot), t = along(u, w, n);
    const V size = dot(t, t), turning = hn::CopySign(set(1.0f), w), bent = hn::Mul(turning, dot(t, apply(body_.curvature, slot, t)));
    const V square = hn::Mul(bent, bent);
    const V chi = hn::Div(square, hn::MulAdd(hn::Mul(set(0.45f), size), size, hn::Add(square, set(1e-30f))));
    hn::Store(hn::IfThenElseZero(hn::Gt(bent, hn::Zero(f)), chi), f, scratch_.bend + k);
  }

  HWY_INLINE Vec3 velocity(std::size_t slot, const Vec3& r) const {
    const auto& g = task_.gradient;
    Vec3 u = set(task_.flow);
    if (task_.wind) u = add(u, load(*task_.wind, slot));
    u = along(u, r.x, Vec3{set(g(0, 0)), set(g(1, 0)), set(g(2, 0))});
    u = along(u, r.y, Vec3{set(g(0, 1)), set(g(1, 1)), set(g(2, 1))});
    return along(u, r.z, Vec3{set(g(0, 2)), set(g(1, 2)), set(g(2, 2))});
  }

  /// All that is felt at one point of the rule, on every triangle of the block.
  void at_point(const QuadraturePoint& point, const float* share) {
    const V s = set(static_cast<float>(point.s - 1.0 / 3.0)), t = set(static_cast<float>(point.t - 1.0 / 3.0));
    const V weight = set(static_cast<float>(point.weight));
    for_each([&](std::size_t k, std::size_t slot) {
      Vec3 r = load(body_.place, slot);
      if (point.weight != 1.0) r = along(along(r, s, load(body_.edge_ab, slot)), t, load(body_.edge_ac, slot));
      store(r, scratch_.place, k);
      V area = hn::Mul(weight, hn::Load(f, body_.share.data() + slot));
      if (share) area = hn::Mul(area, hn::Load(f, share + k));
      hn::Store(area, f, scratch_.area + k);
    });
    task_.pillow > 0.0f ? varying_windward<true>() : varying_windward<false>();
    pressures(arrays(scratch_.arm));
    if (law_.leeward || law_.recovery) {
      for_each([&](std::size_t k, std::size_t slot) {
        const Vec3 r = load(scratch_.place, k), u = velocity(slot, r), n = normal(slot);
        side<false>(k, slot, scratch_.area, dot(u, u), hn::Neg(dot(u, n)));
        store(cross(r, n), scratch_.straight, k);
      });
      suctions(arrays(scratch_.straight));
    }
    if (law_.friction) friction_at_point();
  }

  template <bool shifted>
  void varying_windward() {
    for_each([&](std::size_t k, std::size_t slot) {
      Vec3 r = load(scratch_.place, k);
      if constexpr (shifted) r = add(r, load(scratch_.shift, k));
      const Vec3 u = velocity(slot, r), n = normal(slot);
      const V w = hn::Neg(dot(u, n));
      side<true>(k, slot, scratch_.area, dot(u, u), w);
      store(cross(r, n), scratch_.arm, k);
      if (law_.curvature) bend(k, slot, u, w);
    });
  }

  /// The terms of windward surface, one pass each.
  void pressures(const Arrays& arm) {
    if (task_.reached)
      for_each([&](std::size_t k, std::size_t slot) {
        hn::Store(hn::Mul(hn::Load(f, scratch_.s + k), hn::LoadU(f, task_.reached + slot)), f, scratch_.s + k);
      });
    if (law_.shelter)
      for_each([&](std::size_t k, std::size_t) {
        const V x = hn::Max(hn::Zero(f), hn::NegMulAdd(hn::Load(f, scratch_.c + k), set(law_.per_sharpness), set(1.0f)));
        const V ramp = hn::Div(hn::Mul(x, x), hn::Add(x, set(0.1f)));
        hn::Store(hn::Mul(hn::Load(f, scratch_.s + k), exp_minus(hn::Mul(set(law_.shelter_rate), ramp))), f, scratch_.s + k);
      });
    sum(Term::windward_pressure, arm, scratch_.c, scratch_.s, scratch_.w, [&](V c, std::size_t) { return polynomial(law_.windward_polynomial, c); });
    if (law_.base)
      sum(Term::base_suction, arm, scratch_.c, scratch_.s, scratch_.w, [&](V c, std::size_t) {
        return hn::Mul(hn::Mul(set(law_.base_suction), saturating(c, law_.base_edge)), hn::Sub(set(2.0f), c));
      });
    if (law_.curvature)
      sum(Term::curvature, arm, scratch_.c, scratch_.s, scratch_.w, [&](V c, std::size_t k) {
        const V along_surface = hn::NegMulAdd(c, c, set(1.0f));
        return hn::Mul(hn::Mul(set(-law_.curvature_suction), hn::Load(f, scratch_.bend + k)), hn::Mul(along_surface, saturating(c, 0.2f)));
      });
  }

  /// The terms of leeward surface.
  void suctions(const Arrays& arm) {
    if (law_.leeward)
      sum(Term::leeward_suction, arm, scratch_.lee_c, scratch_.lee_s, scratch_.lee_w,
          [&](V c, std::size_t) { return polynomial(law_.leeward_polynomial, c); });
    if (law_.recovery)
      sum(Term::rear_recovery, arm, scratch_.lee_c, scratch_.lee_s, scratch_.lee_w,
          [&](V c, std::size_t) { return hn::Mul(set(-law_.push), saturating(c, law_.recovery_edge)); });
  }

  static constexpr std::size_t groups = PackedSurface::lanes / width;

  /// Adds s coefficient(c) times (normal, arm), and its power, to a term.
  template <class Coefficient>
  void sum(Term term, const Arrays& arm, const float* c, const float* s, const float* w, Coefficient&& coefficient) {
    V force[3][groups], torque[3][groups], power[groups];
    for (std::size_t g = 0; g < groups; ++g) {
      for (int axis = 0; axis < 3; ++axis) force[axis][g] = torque[axis][g] = hn::Zero(f);
      power[g] = hn::Zero(f);
    }
    for (std::size_t k = 0; k < count_; k += PackedSurface::lanes) {
      HWY_UNROLL(4)
      for (std::size_t g = 0; g < groups; ++g) {
        const std::size_t at = k + g * width;
        const V pressure = hn::Mul(hn::Load(f, s + at), coefficient(hn::Load(f, c + at), at));
        const Vec3 n = normal(first_ + at);
        force[0][g] = hn::MulAdd(pressure, n.x, force[0][g]);
        force[1][g] = hn::MulAdd(pressure, n.y, force[1][g]);
        force[2][g] = hn::MulAdd(pressure, n.z, force[2][g]);
        torque[0][g] = hn::MulAdd(pressure, hn::Load(f, arm.x + at), torque[0][g]);
        torque[1][g] = hn::MulAdd(pressure, hn::Load(f, arm.y + at), torque[1][g]);
        torque[2][g] = hn::MulAdd(pressure, hn::Load(f, arm.z + at), torque[2][g]);
        power[g] = hn::MulAdd(hn::Abs(pressure), hn::Load(f, w + at), power[g]);
      }
    }
    add_sums(term, force, torque, power);
  }

  void add_sums(Term term, const V (&force)[3][groups], const V (&torque)[3][groups], const V (&power)[groups]) {
    HWY_ALIGN float lane[PackedSurface::lanes];
    auto& sums = sums_[static_cast<std::size_t>(term)];
    const auto add = [&](std::size_t row, const V(&sum)[groups]) {
      for (std::size_t g = 0; g < groups; ++g) hn::Store(sum[g], f, lane + g * width);
      sums[row] += total(lane);
    };
    for (std::size_t axis = 0; axis < 3; ++axis) {
      add(axis, force[axis]);
      add(axis + 3, torque[axis]);
    }
    add(6, power);
  }

  /// Along the surface: of both wetted sides, u + n w each. What goes along u is the same for all triangles and known: see add_part().
  void friction_of_uniform_flow(const float* area) {
    const Vec3 u = set(task_.flow);
    const V factor = hn::Mul(set(law_.skin_friction), hn::Sqrt(dot(u, u)));
    for_each([&](std::size_t k, std::size_t slot) {
      const V w = hn::Neg(dot(u, normal(slot)));
      V wetted = hn::Load(f, area + k);
      if (!body_.one_sided) wetted = hn::MulAdd(wetted, hn::Load(f, body_.back.data() + slot), wetted);
      hn::Store(hn::Mul(hn::Mul(wetted, factor), w), f, scratch_.lee_s + k);
      hn::Store(hn::Neg(hn::Abs(w)), f, scratch_.lee_w + k);  // the power is less than that of drag along u
    });
    const Arrays moment{body_.moment[0].data() + first_, body_.moment[1].data() + first_, body_.moment[2].data() + first_};
    sum(Term::friction, moment, scratch_.lee_s, scratch_.lee_s, scratch_.lee_w, [&](V, std::size_t) { return set(1.0f); });
  }

  void friction_at_point() {
    V force[3][groups], torque[3][groups], power[groups];
    for (std::size_t g = 0; g < groups; ++g) {
      for (int axis = 0; axis < 3; ++axis) force[axis][g] = torque[axis][g] = hn::Zero(f);
      power[g] = hn::Zero(f);
    }
    for (std::size_t k = 0; k < count_; k += PackedSurface::lanes)
      for (std::size_t g = 0; g < groups; ++g) {
        const std::size_t at = k + g * width, slot = first_ + at;
        const Vec3 r = load(scratch_.place, at), u = velocity(slot, r), n = normal(slot);
        V wetted = hn::Mul(hn::Load(f, scratch_.area + at), set(law_.skin_friction));
        if (!body_.one_sided) wetted = hn::MulAdd(wetted, hn::Load(f, body_.back.data() + slot), wetted);
        const Vec3 drag = times(along(u, hn::Neg(dot(u, n)), n), hn::Mul(wetted, hn::Sqrt(dot(u, u)))), turn = cross(r, drag);
        force[0][g] = hn::Add(force[0][g], drag.x), force[1][g] = hn::Add(force[1][g], drag.y), force[2][g] = hn::Add(force[2][g], drag.z);
        torque[0][g] = hn::Add(torque[0][g], turn.x), torque[1][g] = hn::Add(torque[1][g], turn.y), torque[2][g] = hn::Add(torque[2][g], turn.z);
        power[g] = hn::Add(power[g], dot(drag, u));
      }
    add_sums(Term::friction, force, torque, power);
  }

  /// Shares of the rules on every triangle; says which of them are needed at all.
  std::array<bool, 3> adapt() {
    V most[3] = {hn::Zero(f), hn::Zero(f), hn::Zero(f)};
    for_each([&](std::size_t k, std::size_t slot) {
      const Vec3 ab = load(body_.edge_ab, slot), ac = load(body_.edge_ac, slot), u = velocity(slot, load(body_.place, slot));
      const Vec3 a = add(ab, ac), b = along(ac, set(-2.0f), ab), c = along(ab, set(-2.0f), ac);
      const V radius = hn::Mul(hn::Sqrt(hn::Max(dot(a, a), hn::Max(dot(b, b), dot(c, c)))), set(1.0f / 3.0f));
      const V variation = hn::Mul(radius, set(task_.variation)), speed = hn::Sqrt(dot(u, u));
      const auto rise = [&](float low, float high) {
        const V range = hn::Max(hn::Mul(speed, set(high - low)), set(1e-30f));
        const V y = hn::Min(set(1.0f), hn::Div(hn::Max(hn::Zero(f), hn::NegMulAdd(speed, set(low), variation)), range));
        return hn::Mul(hn::Mul(y, y), hn::NegMulAdd(set(2.0f), y, set(3.0f)));
      };
      const V three = rise(0.002f, 0.004f), six = rise(0.5f, 1.0f);
      const V shares[3] = {hn::Sub(set(1.0f), three), hn::Mul(three, hn::Sub(set(1.0f), six)), hn::Mul(three, six)};
      for (std::size_t rule = 0; rule < 3; ++rule) {
        hn::Store(shares[rule], f, scratch_.rules[rule] + k);
        most[rule] = hn::Max(most[rule], shares[rule]);
      }
    });
    std::array<bool, 3> some;
    for (std::size_t rule = 0; rule < 3; ++rule) some[rule] = !hn::AllTrue(f, hn::Eq(most[rule], hn::Zero(f)));
    return some;
  }

  const PackedSurface& body_;
  const PartTask& task_;
  const ResolvedLaw& law_;
  TermSums& sums_;
  std::size_t first_ = 0, count_ = 0;
  Scratch scratch_;
};

void add_part_on_target(const PackedSurface& surface, const PartTask& task, TermSums& sums) { PartSum(surface, task, sums).run(); }

using D = hn::CappedTag<double, PackedSurface::lanes / 2>;
constexpr D d;
constexpr std::size_t wide = hn::MaxLanes(D());

void silhouette_on_target(const PackedSurface& surface, PackedSurface::Range range, const Eigen::Vector3d& direction, bool two_sided,
                          const double* reached, SilhouetteSums& result) {
  using W = hn::Vec<D>;
  constexpr std::size_t lanes = PackedSurface::lanes / 2, rows = 12, turns = lanes / wide;
  const PackedSurface::Facets& facets = surface.facets;
  HWY_ALIGN double sums[rows][lanes] = {};
  const W x = hn::Set(d, -direction.x()), y = hn::Set(d, -direction.y()), z = hn::Set(d, -direction.z());
  // One turn for every vector that fits into the lanes: each lane sees the same facets in the same order, whatever the width.
  for (std::size_t turn = 0; turn < turns; ++turn) {
    W sum[rows];
    for (W& row : sum) row = hn::Zero(d);
    for (std::size_t k = range.first + turn * wide; k < range.last; k += lanes) {
      const auto at = [k](const Aligned<double>& array) { return hn::Load(d, array.data() + k); };
      W c = hn::MulAdd(x, at(facets.normal[0]), hn::MulAdd(y, at(facets.normal[1]), hn::Mul(z, at(facets.normal[2]))));
      c = two_sided ? hn::Abs(c) : hn::Max(c, hn::Zero(d));
      const W whole = hn::Mul(c, at(facets.area)), c2 = hn::Mul(c, c);
      const W weight = reached ? hn::Mul(whole, hn::LoadU(d, reached + k)) : whole;
      sum[0] = hn::Add(sum[0], whole);
      sum[1] = hn::Add(sum[1], weight);
      sum[2] = hn::MulAdd(weight, hn::Mul(c2, c2), sum[2]);
      for (std::size_t row = 0; row < 3; ++row) sum[3 + row] = hn::MulAdd(weight, at(facets.first[row]), sum[3 + row]);
      for (std::size_t row = 0; row < 6; ++row) sum[6 + row] = hn::MulAdd(weight, at(facets.second[row]), sum[6 + row]);
    }
    for (std::size_t row = 0; row < rows; ++row) hn::Store(sum[row], d, sums[row] + turn * wide);
  }
  const auto all = [&](std::size_t row) {
    double* sum = sums[row];
    for (std::size_t half = lanes / 2; half > 0; half /= 2)
      for (std::size_t k = 0; k < half; ++k) sum[k] += sum[k + half];
    return sum[0];
  };
  result.whole = all(0), result.frontal = all(1), result.sharp = all(2);
  for (Eigen::Index row = 0; row < 3; ++row) result.first[row] = all(3 + static_cast<std::size_t>(row));
  const double xx = all(6), xy = all(7), xz = all(8), yy = all(9), yz = all(10), zz = all(11);
  result.second << xx, xy, xz, xy, yy, yz, xz, yz, zz;
}

}  // namespace dragcore::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace dragcore::kernels {

HWY_EXPORT(add_part_on_target);
HWY_EXPORT(silhouette_on_target);

void add_part(const PackedSurface& surface, const PartTask& task, TermSums& sums) {
  HWY_DYNAMIC_DISPATCH(add_part_on_target)(surface, task, sums);
  if (!task.law.friction || task.varies) return;
  // Friction in uniform flow: what goes along u is the same on all wetted surface.
  auto& friction = sums[static_cast<std::size_t>(Term::friction)];
  const Eigen::Vector3d u = task.flow.cast<double>(), drag = static_cast<double>(task.law.skin_friction) * u.norm() * u;
  const Eigen::Vector3d torque = surface.wetted_moment[task.part].cross(drag);
  friction[6] += surface.wetted[task.part] * drag.dot(u);
  for (std::size_t k = 0; k < 3; ++k) {
    friction[k] += surface.wetted[task.part] * drag[static_cast<Eigen::Index>(k)];
    friction[k + 3] += torque[static_cast<Eigen::Index>(k)];
  }
}

SilhouetteSums silhouette(const PackedSurface& surface, PackedSurface::Range facets, const Eigen::Vector3d& direction, bool two_sided,
                          const double* reached) {
  SilhouetteSums result;
  HWY_DYNAMIC_DISPATCH(silhouette_on_target)(surface, facets, direction, two_sided, reached, result);
  result.whole *= surface.area, result.frontal *= surface.area, result.sharp *= surface.area;
  result.first *= surface.area * surface.size, result.second *= surface.area * surface.size * surface.size;
  return result;
}

namespace {

int64_t everything() { return hwy::SupportedTargets() & HWY_TARGETS; }

}  // namespace

std::vector<std::string> targets() {
  hwy::SetSupportedTargetsForTest(0);
  std::vector<std::string> names;
  for (const int64_t target : hwy::SupportedAndGeneratedTargets()) names.emplace_back(hwy::TargetName(target));
  return names;
}

void force_target(const std::string& name) {
  hwy::SetSupportedTargetsForTest(0);
  int64_t chosen = everything();
  if (!name.empty()) {
    chosen = 0;
    for (const int64_t target : hwy::SupportedAndGeneratedTargets())
      if (name == hwy::TargetName(target)) chosen = target;
    if (chosen == 0) throw std::invalid_argument("kernels: this machine has no target '" + name + "'");
    hwy::SetSupportedTargetsForTest(chosen);
  }
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

}  // namespace dragcore::kernels
#endif
