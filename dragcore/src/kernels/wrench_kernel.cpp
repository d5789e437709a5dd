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

using D = hn::CappedTag<double, PackedSurface::lanes / 2>;
constexpr D d;
constexpr std::size_t wide = hn::MaxLanes(D());

/// Of an aligned row, in one order whatever the width: the second half onto the first, until one is left.
template <std::size_t lanes>
HWY_INLINE double total(double* lane) {
  std::size_t half = lanes / 2;
  for (; half >= wide; half /= 2)
    for (std::size_t k = 0; k < half; k += wide) hn::Store(hn::Add(hn::Load(d, lane + k), hn::Load(d, lane + k + half)), d, lane + k);
  for (; half > 0; half /= 2)
    for (std::size_t k = 0; k < half; ++k) lane[k] += lane[k + half];
  return lane[0];
}

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
HWY_INLINE Vec3 along(const Vec3& a, V s, const Vec3& b) {
  return {hn::MulAdd(s, b.x, a.x), hn::MulAdd(s, b.y, a.y), hn::MulAdd(s, b.z, a.z)};
}
HWY_INLINE Vec3 times(const Vec3& a, V s) { return {hn::Mul(a.x, s), hn::Mul(a.y, s), hn::Mul(a.z, s)}; }
HWY_INLINE Vec3 set(const Eigen::Vector3f& v) { return {set(v.x()), set(v.y()), set(v.z())}; }
/// Where three arrays stand. Passes keep such in local variables: a store of a vector might change a pointer that lives in memory.
struct Arrays {
  const float *x, *y, *z;
  HWY_INLINE Vec3 at(std::size_t k) const { return {hn::Load(f, x + k), hn::Load(f, y + k), hn::Load(f, z + k)}; }
};
/// And six, of symmetric tensors.
struct Tensors {
  const float *xx, *xy, *xz, *yy, *yz, *zz;
  HWY_INLINE Vec3 apply(std::size_t k, const Vec3& v) const {
    const V a = hn::Load(f, xy + k), b = hn::Load(f, xz + k), c = hn::Load(f, yz + k);
    return {hn::MulAdd(hn::Load(f, xx + k), v.x, hn::MulAdd(a, v.y, hn::Mul(b, v.z))),
            hn::MulAdd(a, v.x, hn::MulAdd(hn::Load(f, yy + k), v.y, hn::Mul(c, v.z))),
            hn::MulAdd(b, v.x, hn::MulAdd(c, v.y, hn::Mul(hn::Load(f, zz + k), v.z)))};
  }
};
/// Of degree four.
struct Polynomial {
  V p0, p1, p2, p3, p4;
  explicit HWY_INLINE Polynomial(const std::array<float, 5>& p)
      : p0(set(p[0])), p1(set(p[1])), p2(set(p[2])), p3(set(p[3])), p4(set(p[4])) {}
  HWY_INLINE V operator()(V c) const { return hn::MulAdd(hn::MulAdd(hn::MulAdd(hn::MulAdd(p4, c, p3), c, p2), c, p1), c, p0); }
};
/// c (1 + e)/(c + e)
struct Saturating {
  V e, one_and_e;
  explicit HWY_INLINE Saturating(float edge) : e(set(edge)), one_and_e(set(1.0f + edge)) {}
  HWY_INLINE V operator()(V c) const { return hn::Div(hn::Mul(c, one_and_e), hn::Add(c, e)); }
};

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
  HWY_ALIGN float shift[3][block];               // of the pillow
  HWY_ALIGN float place[3][block];               // of a point of quadrature
  HWY_ALIGN float arm[3][block];                 // (place + shift) x normal
  HWY_ALIGN float straight[3][block];            // place x normal
  HWY_ALIGN float c[block], s[block], w[block];  // windward pressure: cosine, factor of the normal, normal speed
  HWY_ALIGN float bend[block];                   // chi
  HWY_ALIGN float lee_c[block], lee_s[block], lee_w[block];
  HWY_ALIGN float area[block];      // that stands for the point
  HWY_ALIGN float rules[3][block];  // shares of the three rules, adaptive
};

HWY_INLINE void store(const Vec3& v, float (&arrays)[3][block], std::size_t k) {
  hn::Store(v.x, f, arrays[0] + k), hn::Store(v.y, f, arrays[1] + k), hn::Store(v.z, f, arrays[2] + k);
}

/// Seven sums of one term, lane by lane.
struct Lanes {
  static constexpr std::size_t groups = PackedSurface::lanes / width, rows = 7;
  V force[3][groups], torque[3][groups], power[groups];

  Lanes() {
    for (std::size_t g = 0; g < groups; ++g) {
      for (int axis = 0; axis < 3; ++axis) force[axis][g] = torque[axis][g] = hn::Zero(f);
      power[g] = hn::Zero(f);
    }
  }

  void add_to(double (&sums)[rows][PackedSurface::lanes]) const;
};

void Lanes::add_to(double (&sums)[rows][PackedSurface::lanes]) const {
  const hn::Rebind<float, D> half;
  HWY_ALIGN float lane[PackedSurface::lanes];
  const auto add = [&](double* sum, const V(&row)[groups]) {
    for (std::size_t g = 0; g < groups; ++g) hn::Store(row[g], f, lane + g * width);
    for (std::size_t k = 0; k < PackedSurface::lanes; k += wide)
      hn::Store(hn::Add(hn::Load(d, sum + k), hn::PromoteTo(d, hn::Load(half, lane + k))), d, sum + k);
  };
  for (std::size_t axis = 0; axis < 3; ++axis) {
    add(sums[axis], force[axis]);
    add(sums[axis + 3], torque[axis]);
  }
  add(sums[6], power);
}

/// Which groups of 16 triangles of a block have anything to do with one side.
class Groups {
 public:
  void clear() { count_ = 0; }
  void add(std::size_t first) { first_[count_++] = first; }
  template <class Pass>
  HWY_INLINE void for_each(Pass&& pass) const {
    for (std::size_t i = 0, count = count_; i < count; ++i)
      for (std::size_t k = first_[i]; k < first_[i] + PackedSurface::lanes; k += width) pass(k);
  }
  const std::size_t* begin() const { return first_; }
  const std::size_t* end() const { return first_ + count_; }

 private:
  std::size_t count_ = 0, first_[block / PackedSurface::lanes];
};

class PartSum {
 public:
  PartSum(const PackedSurface& body, const PartTask& task) : body_(body), task_(task), law_(task.law) {}

  void run(TermSums& sums) {
    const PackedSurface::Range slots = body_.part[task_.part];
    for (std::size_t first = slots.first; first < slots.last; first += block) {
      first_ = first;
      count_ = std::min(block, slots.last - first);
      run_block();
    }
    for (std::size_t term = 0; term < sums.size(); ++term)
      if (summed_[term])
        for (std::size_t row = 0; row < Lanes::rows; ++row) sums[term][row] += total<PackedSurface::lanes>(sums_[term][row]);
  }

 private:
  void run_block() {
    all_.clear();
    for (std::size_t k = 0; k < count_; k += PackedSurface::lanes) all_.add(k);
    if (!task_.varies) {
      const Arrays moment = of(body_.moment);
      const bool pulls = law_.leeward || law_.recovery;
      pulls ? uniform<true>() : uniform<false>();
      if (law_.curvature) bend_of_uniform_flow();
      if (task_.pillow > 0.0f) {
        shift(windward_);
        arms_of_uniform_flow();
      }
      pressures(task_.pillow > 0.0f ? of(scratch_.arm) : moment);
      if (pulls) suctions(moment);
      if (law_.friction) friction_of_uniform_flow();
      return;
    }
    if (task_.pillow > 0.0f) shift(all_);
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

  // Of the block at hand.
  Arrays of(const std::array<Aligned<float>, 3>& a) const { return {a[0].data() + first_, a[1].data() + first_, a[2].data() + first_}; }
  static Arrays of(const float (&a)[3][block]) { return {a[0], a[1], a[2]}; }
  Tensors of(const std::array<Aligned<float>, 6>& a) const {
    return {a[0].data() + first_, a[1].data() + first_, a[2].data() + first_,
            a[3].data() + first_, a[4].data() + first_, a[5].data() + first_};
  }
  const float* of(const Aligned<float>& a) const { return a.data() + first_; }

  /// -kappa t M e/sqrt(3 e.M e) over the face
  void shift(const Groups& where) {
    const Vec3 u = set(task_.direction);
    const V kappa = set(-task_.pillow);
    const Arrays normal = of(body_.normal);
    const Tensors second_moment = of(body_.second_moment);
    where.for_each([&](std::size_t k) {
      const Vec3 n = normal.at(k), t = along(u, hn::Neg(dot(u, n)), n), moved = second_moment.apply(k, t);
      const V square = hn::Max(hn::Mul(set(3.0f), dot(t, moved)), set(1e-30f));
      const V factor = hn::Mul(kappa, hn::Sqrt(hn::Div(dot(t, t), square)));
      store(times(along(moved, hn::Neg(dot(moved, n)), n), factor), scratch_.shift, k);
    });
  }

  static HWY_INLINE V slowness(V speed2) { return hn::Div(set(1.0f), hn::Sqrt(hn::Max(speed2, set(1e-30f)))); }

  /// What pressure on one of the two sides is a multiple of: the side that meets the air, or the one that turns away.
  struct Side {
    float *c, *s, *w;   ///< cosine, factor of the normal, normal speed
    const float* back;  ///< null where no back feels the air

    /// @param area  of the point, times speed^2   @return where this side feels anything
    template <bool windward>
    HWY_INLINE hn::Mask<F> store(std::size_t k, V area, V per_speed, V normal_speed) const {
      const auto front = windward ? hn::Gt(normal_speed, hn::Zero(f)) : hn::Lt(normal_speed, hn::Zero(f));
      V felt = back ? hn::Mul(area, hn::IfThenElse(front, set(1.0f), hn::Load(f, back + k))) : hn::IfThenElseZero(front, area);
      const V size = hn::Abs(normal_speed);
      const auto feels = hn::And(hn::Gt(size, hn::Zero(f)), hn::Gt(felt, hn::Zero(f)));
      felt = hn::IfThenElseZero(feels, felt);
      hn::Store(hn::Min(set(1.0f), hn::Mul(size, per_speed)), f, c + k);
      // Along -n where the air comes against n, and along n where it comes from behind: downstream.
      hn::Store(hn::CopySign(felt, hn::Neg(normal_speed)), f, s + k);
      hn::Store(size, f, w + k);
      return feels;
    }
  };
  Side windward() { return {scratch_.c, scratch_.s, scratch_.w, body_.one_sided ? nullptr : of(body_.back)}; }
  Side leeward() { return {scratch_.lee_c, scratch_.lee_s, scratch_.lee_w, body_.one_sided ? nullptr : of(body_.back)}; }

  /// Both sides at once: the cosine is the same.
  template <bool pulls>
  void uniform() {
    const Vec3 u = set(task_.flow);
    const V speed2 = dot(u, u), per_speed = slowness(speed2);
    const Arrays normal = of(body_.normal);
    const float* area = of(body_.share);
    const Side front = windward(), rear = leeward();
    windward_.clear(), leeward_.clear();
    for (const std::size_t first : all_) {
      bool meets = false, turns_away = false;
      for (std::size_t k = first; k < first + PackedSurface::lanes; k += width) {
        const V w = hn::Neg(dot(u, normal.at(k))), felt = hn::Mul(hn::Load(f, area + k), speed2);
        meets |= !hn::AllFalse(f, front.store<true>(k, felt, per_speed, w));
        if constexpr (pulls) turns_away |= !hn::AllFalse(f, rear.store<false>(k, felt, per_speed, w));
      }
      if (meets) windward_.add(first);
      if (turns_away) leeward_.add(first);
    }
  }

  void arms_of_uniform_flow() {
    const Arrays normal = of(body_.normal), moment = of(body_.moment), moved = of(scratch_.shift);
    windward_.for_each([&](std::size_t k) { store(add(moment.at(k), cross(moved.at(k), normal.at(k))), scratch_.arm, k); });
  }

  void bend_of_uniform_flow() {
    const Vec3 u = set(task_.flow);
    const Arrays normal = of(body_.normal);
    const Tensors curvature = of(body_.curvature);
    windward_.for_each([&](std::size_t k) {
      const Vec3 n = normal.at(k);
      bend(k, curvature, n, u, hn::Neg(dot(u, n)));
    });
  }

  /// chi of the flow along the surface
  HWY_INLINE void bend(std::size_t k, const Tensors& curvature, const Vec3& n, const Vec3& u, V w) {
    const Vec3 t = along(u, w, n);
    const V size = dot(t, t), bent = hn::Mul(hn::CopySign(set(1.0f), w), dot(t, curvature.apply(k, t))), square = hn::Mul(bent, bent);
    const V chi = hn::Div(square, hn::MulAdd(hn::Mul(set(0.45f), size), size, hn::Add(square, set(1e-30f))));
    hn::Store(hn::IfThenElseZero(hn::Gt(bent, hn::Zero(f)), chi), f, scratch_.bend + k);
  }

  /// The relative flow at a place.
  struct Flow {
    Vec3 u, x, y, z;  ///< at the origin, and its change along the axes
    Arrays wind;
    bool winds;
    HWY_INLINE Vec3 at(std::size_t k, const Vec3& r) const {
      const Vec3 v = winds ? add(u, wind.at(k)) : u;
      return along(along(along(v, r.x, x), r.y, y), r.z, z);
    }
  };
  Flow flow() const {
    const auto& g = task_.gradient;
    return {set(task_.flow), set(g.col(0)), set(g.col(1)), set(g.col(2)), task_.wind ? of(*task_.wind) : Arrays{}, task_.wind != nullptr};
  }

  /// All that is felt at one point of the rule, on every triangle of the block.
  void at_point(const QuadraturePoint& point, const float* share) {
    const V s = set(static_cast<float>(point.s - 1.0 / 3.0)), t = set(static_cast<float>(point.t - 1.0 / 3.0));
    const V weight = set(static_cast<float>(point.weight));
    const bool centroid = point.weight == 1.0;
    const Arrays place = of(body_.place), edge_ab = of(body_.edge_ab), edge_ac = of(body_.edge_ac);
    const float* area = of(body_.share);
    all_.for_each([&](std::size_t k) {
      Vec3 r = place.at(k);
      if (!centroid) r = along(along(r, s, edge_ab.at(k)), t, edge_ac.at(k));
      store(r, scratch_.place, k);
      V own = hn::Mul(weight, hn::Load(f, area + k));
      if (share) own = hn::Mul(own, hn::Load(f, share + k));
      hn::Store(own, f, scratch_.area + k);
    });
    if (task_.pillow > 0.0f)
      law_.curvature ? varying_windward<true, true>() : varying_windward<true, false>();
    else
      law_.curvature ? varying_windward<false, true>() : varying_windward<false, false>();
    pressures(of(scratch_.arm));
    const bool pulls = law_.leeward || law_.recovery;
    if (pulls && law_.friction)
      straight_at_point<true, true>();
    else if (pulls)
      straight_at_point<true, false>();
    else if (law_.friction)
      straight_at_point<false, true>();
    if (pulls) suctions(of(scratch_.straight));
  }

  template <bool shifted, bool curved>
  void varying_windward() {
    const Flow air = flow();
    const Arrays normal = of(body_.normal), place = of(scratch_.place), moved = of(scratch_.shift);
    const Tensors curvature = of(body_.curvature);
    const float* area = scratch_.area;
    const Side side = windward();
    windward_.clear();
    for (const std::size_t first : all_) {
      bool meets = false;
      for (std::size_t k = first; k < first + PackedSurface::lanes; k += width) {
        Vec3 r = place.at(k);
        if constexpr (shifted) r = add(r, moved.at(k));
        const Vec3 u = air.at(k, r), n = normal.at(k);
        const V w = hn::Neg(dot(u, n)), speed2 = dot(u, u);
        meets |= !hn::AllFalse(f, side.store<true>(k, hn::Mul(hn::Load(f, area + k), speed2), slowness(speed2), w));
        store(cross(r, n), scratch_.arm, k);
        if constexpr (curved) bend(k, curvature, n, u, w);
      }
      if (meets) windward_.add(first);
    }
  }

  /// The terms of windward surface, one pass each.
  void pressures(const Arrays& arm) {
    float* const c_of = scratch_.c;
    float* const s_of = scratch_.s;
    const float* const bend_of = scratch_.bend;
    if (task_.reached) {
      const float* reached = task_.reached + first_;
      windward_.for_each([&](std::size_t k) { hn::Store(hn::Mul(hn::Load(f, s_of + k), hn::LoadU(f, reached + k)), f, s_of + k); });
    }
    if (law_.shelter) {
      const V per_sharpness = set(law_.per_sharpness), rate = set(law_.shelter_rate);
      windward_.for_each([&](std::size_t k) {
        const V x = hn::Max(hn::Zero(f), hn::NegMulAdd(hn::Load(f, c_of + k), per_sharpness, set(1.0f)));
        const V ramp = hn::Div(hn::Mul(x, x), hn::Add(x, set(0.1f)));
        hn::Store(hn::Mul(hn::Load(f, s_of + k), exp_minus(hn::Mul(rate, ramp))), f, s_of + k);
      });
    }
    const Side side = windward();
    sum(Term::windward_pressure, windward_, arm, side, [p = Polynomial(law_.windward_polynomial)](V c, std::size_t) { return p(c); });
    if (law_.base)
      sum(Term::base_suction, windward_, arm, side,
          [suction = set(law_.base_suction), rise = Saturating(law_.base_edge)](V c, std::size_t) {
            return hn::Mul(hn::Mul(suction, rise(c)), hn::Sub(set(2.0f), c));
          });
    if (law_.curvature)
      sum(Term::curvature, windward_, arm, side,
          [suction = set(-law_.curvature_suction), rise = Saturating(0.2f), bend_of](V c, std::size_t k) {
            return hn::Mul(hn::Mul(suction, hn::Load(f, bend_of + k)), hn::Mul(hn::NegMulAdd(c, c, set(1.0f)), rise(c)));
          });
  }

  /// The terms of leeward surface.
  void suctions(const Arrays& arm) {
    const Side side = leeward();
    if (law_.leeward)
      sum(Term::leeward_suction, leeward_, arm, side, [p = Polynomial(law_.leeward_polynomial)](V c, std::size_t) { return p(c); });
    if (law_.recovery)
      sum(Term::rear_recovery, leeward_, arm, side,
          [push = set(-law_.push), rise = Saturating(law_.recovery_edge)](V c, std::size_t) { return hn::Mul(push, rise(c)); });
  }

  static constexpr std::size_t groups = Lanes::groups;

  /// Adds s coefficient(c) times (normal, arm), and its power, to a term.
  template <class Coefficient>
  void sum(Term term, const Groups& where, const Arrays& arm, const Side& side, const Coefficient& coefficient) {
    Lanes lanes;
    const Arrays normal = of(body_.normal);
    for (const std::size_t k : where)
      for (std::size_t g = 0; g < groups; ++g) {
        const std::size_t at = k + g * width;
        const V pressure = hn::Mul(hn::Load(f, side.s + at), coefficient(hn::Load(f, side.c + at), at));
        const Vec3 n = normal.at(at), m = arm.at(at);
        lanes.force[0][g] = hn::MulAdd(pressure, n.x, lanes.force[0][g]);
        lanes.force[1][g] = hn::MulAdd(pressure, n.y, lanes.force[1][g]);
        lanes.force[2][g] = hn::MulAdd(pressure, n.z, lanes.force[2][g]);
        lanes.torque[0][g] = hn::MulAdd(pressure, m.x, lanes.torque[0][g]);
        lanes.torque[1][g] = hn::MulAdd(pressure, m.y, lanes.torque[1][g]);
        lanes.torque[2][g] = hn::MulAdd(pressure, m.z, lanes.torque[2][g]);
        lanes.power[g] = hn::MulAdd(hn::Abs(pressure), hn::Load(f, side.w + at), lanes.power[g]);
      }
    add_lanes(term, lanes);
  }

  void add_lanes(Term term, const Lanes& lanes) {
    const auto index = static_cast<std::size_t>(term);
    if (!summed_[index]) std::fill_n(&sums_[index][0][0], Lanes::rows * PackedSurface::lanes, 0.0);
    summed_[index] = true;
    lanes.add_to(sums_[index]);
  }

  /// Along the surface: of both wetted sides, u + n w each. What goes along u is the same for all triangles and known: see add_part().
  void friction_of_uniform_flow() {
    const Vec3 u = set(task_.flow);
    const V factor = hn::Mul(set(law_.skin_friction), hn::Sqrt(dot(u, u)));
    const Arrays normal = of(body_.normal);
    const float* area = of(body_.share);
    const Side side = leeward();
    all_.for_each([&](std::size_t k) {
      const V w = hn::Neg(dot(u, normal.at(k)));
      V wetted = hn::Load(f, area + k);
      if (side.back) wetted = hn::MulAdd(wetted, hn::Load(f, side.back + k), wetted);
      hn::Store(hn::Mul(hn::Mul(wetted, factor), w), f, side.s + k);
      hn::Store(hn::Neg(hn::Abs(w)), f, side.w + k);  // the power is less than that of drag along u
      hn::Store(set(1.0f), f, side.c + k);
    });
    sum(Term::friction, all_, of(body_.moment), side, [](V one, std::size_t) { return one; });
  }

  /// Where the pressure of leeward surface and friction act: not displaced by the pillow, so that they share a velocity.
  template <bool pulls, bool rubs>
  void straight_at_point() {
    Lanes lanes;
    const Flow air = flow();
    const Arrays normal = of(body_.normal), place = of(scratch_.place);
    const float* area = scratch_.area;
    const Side side = leeward();
    const V skin_friction = set(law_.skin_friction);
    leeward_.clear();
    for (const std::size_t k : all_) {
      bool turns_away = false;
      for (std::size_t g = 0; g < groups; ++g) {
        const std::size_t at = k + g * width;
        const Vec3 r = place.at(at), u = air.at(at, r), n = normal.at(at);
        const V w = hn::Neg(dot(u, n)), speed2 = dot(u, u), own = hn::Load(f, area + at);
        if constexpr (pulls) {
          turns_away |= !hn::AllFalse(f, side.store<false>(at, hn::Mul(own, speed2), slowness(speed2), w));
          store(cross(r, n), scratch_.straight, at);
        }
        if constexpr (rubs) {
          V wetted = hn::Mul(own, skin_friction);
          if (side.back) wetted = hn::MulAdd(wetted, hn::Load(f, side.back + at), wetted);
          const Vec3 drag = times(along(u, w, n), hn::Mul(wetted, hn::Sqrt(speed2))), turn = cross(r, drag);
          lanes.force[0][g] = hn::Add(lanes.force[0][g], drag.x);
          lanes.force[1][g] = hn::Add(lanes.force[1][g], drag.y);
          lanes.force[2][g] = hn::Add(lanes.force[2][g], drag.z);
          lanes.torque[0][g] = hn::Add(lanes.torque[0][g], turn.x);
          lanes.torque[1][g] = hn::Add(lanes.torque[1][g], turn.y);
          lanes.torque[2][g] = hn::Add(lanes.torque[2][g], turn.z);
          lanes.power[g] = hn::Add(lanes.power[g], dot(drag, u));
        }
      }
      if (turns_away) leeward_.add(k);
    }
    if constexpr (rubs) add_lanes(Term::friction, lanes);
  }

  /// Shares of the rules on every triangle; says which of them are needed at all.
  std::array<bool, 3> adapt() {
    V most[3] = {hn::Zero(f), hn::Zero(f), hn::Zero(f)};
    const Flow air = flow();
    const Arrays place = of(body_.place), edge_ab = of(body_.edge_ab), edge_ac = of(body_.edge_ac);
    const V per_length = set(task_.variation);
    all_.for_each([&](std::size_t k) {
      const Vec3 ab = edge_ab.at(k), ac = edge_ac.at(k), u = air.at(k, place.at(k));
      const Vec3 a = add(ab, ac), b = along(ac, set(-2.0f), ab), c = along(ab, set(-2.0f), ac);
      const V radius = hn::Mul(hn::Sqrt(hn::Max(dot(a, a), hn::Max(dot(b, b), dot(c, c)))), set(1.0f / 3.0f));
      const V variation = hn::Mul(radius, per_length), speed = hn::Sqrt(dot(u, u));
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
  std::size_t first_ = 0, count_ = 0;
  Groups all_, windward_, leeward_;
  Scratch scratch_;
  std::array<bool, static_cast<std::size_t>(Term::count)> summed_{};
  HWY_ALIGN double sums_[static_cast<std::size_t>(Term::count)][Lanes::rows][PackedSurface::lanes];  // set where `summed_`
};

void add_part_on_target(const PackedSurface& surface, const PartTask& task, TermSums& sums) { PartSum(surface, task).run(sums); }

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
  const auto all = [&](std::size_t row) { return total<lanes>(sums[row]); };
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

std::vector<std::string> targets() {
  hwy::SetSupportedTargetsForTest(0);
  std::vector<std::string> names;
  for (const int64_t target : hwy::SupportedAndGeneratedTargets()) names.emplace_back(hwy::TargetName(target));
  return names;
}

void force_target(const std::string& name) {
  hwy::SetSupportedTargetsForTest(0);
  if (!name.empty()) {
    int64_t chosen = 0;
    for (const int64_t target : hwy::SupportedAndGeneratedTargets())
      if (name == hwy::TargetName(target)) chosen = target;
    if (chosen == 0) throw std::invalid_argument("kernels: this machine has no target '" + name + "'");
    hwy::SetSupportedTargetsForTest(chosen);
  }
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

}  // namespace dragcore::kernels
#endif
