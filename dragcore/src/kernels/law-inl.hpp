// What one point of a surface feels, in vectors of one instruction set: of many triangles in one flow, or of one triangle in many.
#if defined(DRAGCORE_LAW_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef DRAGCORE_LAW_INL
#undef DRAGCORE_LAW_INL
#else
#define DRAGCORE_LAW_INL
#endif

#include "kernels/lanes-inl.hpp"
#include "kernels/wrench_kernel.hpp"

HWY_BEFORE_NAMESPACE();
namespace dragcore::kernels::HWY_NAMESPACE {

// Effects of a kernel, known when it is compiled: one that is off costs no instruction.
constexpr unsigned two_sided = 1, pillow = 2, base = 4, shelter = 8, curvature = 16, windward_kernels = 32;
// And two_sided: of what the pillow does not displace. `viscous` takes the place of `friction`: their codes together stand for the first.
constexpr unsigned leeward = 2, recovery = 4, friction = 8, viscous = 16, straight_kernels = 32;
constexpr unsigned either_friction(unsigned on) { return on & viscous ? on & ~friction : on; }

inline unsigned windward_effects(const ResolvedLaw& law, bool has_two_sides) {
  return (has_two_sides ? two_sided : 0u) | (law.pillow ? pillow : 0u) | (law.base ? base : 0u) | (law.shelter ? shelter : 0u) |
         (law.curvature ? curvature : 0u);
}
inline unsigned straight_effects(const ResolvedLaw& law, bool has_two_sides) {
  return (has_two_sides ? two_sided : 0u) | (law.leeward ? leeward : 0u) | (law.recovery ? recovery : 0u) | (law.friction ? friction : 0u) |
         (law.viscous ? viscous : 0u);
}

/// A law in registers, the same for all lanes or each lane's own.
struct LawLanes {
  Polynomial windward, leeward;
  V base_rise, base_edge;  ///< B h (1 + epsilon)
  V shelter_rate, per_sharpness;
  V curvature_rise;                ///< -1.2 m
  V recovery_rise, recovery_edge;  ///< minus the push, times 1 + e
  V skin_friction, pillow_factor;
  V layer, layer_curvature;
  explicit HWY_INLINE LawLanes(const ResolvedLaw& law)
      : windward(law.windward_polynomial),
        leeward(law.leeward_polynomial),
        base_rise(set(law.base_suction * (1.0f + law.base_edge))),
        base_edge(set(law.base_edge)),
        shelter_rate(set(law.shelter_rate)),
        per_sharpness(set(law.per_sharpness)),
        curvature_rise(set(-1.2f * law.curvature_suction)),
        recovery_rise(set(-law.push * (1.0f + law.recovery_edge))),
        recovery_edge(set(law.recovery_edge)),
        skin_friction(set(law.skin_friction)),
        pillow_factor(set(law.pillow_factor)),
        layer(set(law.layer)),
        layer_curvature(set(law.layer_curvature)) {}
};

constexpr float tiny = 1e-30f;
/// Below the line of what vanishes with the tangential part of the flow: small enough not to be felt, and of a size that products can bear.
constexpr float small = 1e-14f;

struct Ratio {
  V above, below;
};
/// Chi of the flow along the surface as numerator and denominator. Both are divided by the square of `t`, which may be small.
/// @param side  its sign: which side of the surface
template <unsigned on, class At>
HWY_INLINE Ratio bend(const Row (&tensor)[6], At at, const Vec3& t, V size, V side) {
  V bent = dot(t, apply(tensor, at, t));
  if constexpr (on & two_sided) bent = hn::Xor(bent, hn::And(side, hn::Set(f, -0.0f)));
  bent = hn::Max(bent, hn::Zero(f));
  const V square = hn::Mul(bent, bent);
  return {square, hn::MulAdd(hn::Mul(set(0.45f), size), size, hn::Add(square, set(small)))};
}

/// Coefficients of windward surface, eq. 2, 7, 9 and 10: what each term is times the area that is left to it.
struct Windward {
  V sheltered;  ///< area
  V pressure, base_suction, curvature;
};
/// @param area  that feels the pressure
/// @param size  square of the tangential part of the flow, as a share of all: 1 - c^2
/// @param bent  chi; what is below the line is worked in with the other divisions
template <unsigned on>
HWY_INLINE Windward windward(const LawLanes& law, V area, V c, V size, const Ratio& bent) {
  // The last of them is the first to be known: that of the ramp, which most waits for.
  constexpr std::size_t based = 0, curved = (on & base) != 0, ramped = curved + ((on & curvature) ? 2 : 0),
                        count = ramped + ((on & shelter) != 0);
  V below[count + 1];
  V x = c;
  if constexpr (on & shelter) {
    x = hn::Max(hn::Zero(f), hn::NegMulAdd(c, law.per_sharpness, set(1.0f)));
    below[ramped] = hn::Add(x, set(0.1f));
  }
  if constexpr (on & base) below[based] = hn::Add(c, law.base_edge);
  if constexpr (on & curvature) below[curved] = hn::Add(c, set(0.2f)), below[curved + 1] = bent.below;
  invert<count>(below);
  Windward result{area, law.windward(c), c, c};
  if constexpr (on & base) result.base_suction = hn::Mul(hn::Mul(law.base_rise, below[based]), hn::Mul(c, hn::Sub(set(2.0f), c)));
  if constexpr (on & curvature)
    result.curvature =
        hn::Mul(hn::Mul(hn::Mul(law.curvature_rise, c), hn::Mul(bent.above, size)), hn::Mul(below[curved], below[curved + 1]));
  if constexpr (on & shelter) result.sheltered = hn::Mul(area, exp_minus(hn::Mul(law.shelter_rate, hn::Mul(hn::Mul(x, x), below[ramped]))));
  return result;
}

/// Rear recovery of leeward surface, eq. 8.
HWY_INLINE V rear_recovery(const LawLanes& law, V c) { return hn::Div(hn::Mul(c, law.recovery_rise), hn::Add(c, law.recovery_edge)); }

/// Area of the side of a triangle that meets the air, signed like the normal speed w; or, `leeward`, of the side that turns away.
/// @return  where either is anything
template <unsigned on, bool away, class At>
HWY_INLINE M felt(const Group& group, At at, V share, V w, V& area) {
  const V zero = hn::Zero(f);
  const M front = away ? hn::Lt(w, zero) : hn::Gt(w, zero);
  if constexpr (on & two_sided) {
    area = hn::Mul(share, hn::IfThenElse(front, set(1.0f), at(group.back)));
    area = hn::IfThenElseZero(hn::Ne(w, zero), hn::CopySign(area, w));
    return hn::Ne(area, zero);
  } else {
    area = hn::IfThenElseZero(front, away ? hn::Neg(share) : share);
    return front;
  }
}

/// |w| of the side that is felt: what the other one gets must only be a number.
template <unsigned on, bool away>
HWY_INLINE V normal_speed(V w) {
  return on & two_sided ? hn::Abs(w) : hn::Max(away ? hn::Neg(w) : w, hn::Zero(f));
}
HWY_INLINE V cosine(V w, V speed2) { return hn::Min(set(1.0f), hn::Div(w, hn::Sqrt(hn::Max(speed2, set(tiny))))); }

// One triangle, or one point of it. Each calls visit(coefficient or Windward, normal, moment of the normal, ...) where anything is felt.

/// In a flow along the unit vector u, the same everywhere.
template <unsigned on, class At, class Visit>
HWY_INLINE void uniform_windward_at(const LawLanes& law, const Group& group, At at, V share, const Vec3& u, const Visit& visit) {
  const Vec3 n = vector(group.normal, at);
  const V w = hn::Neg(dot(u, n));
  V area;
  if (hn::AllFalse(f, felt<on, false>(group, at, share, w, area))) return;
  Vec3 moment = vector(group.moment, at);
  const V c = normal_speed<on, false>(w);
  V size = c;
  Ratio bent{c, c};
  if constexpr ((on & (pillow | curvature)) != 0) {
    const Vec3 t = along(u, w, n);
    size = dot(t, t);
    if constexpr (on & curvature) bent = bend<on>(group.curvature, at, t, size, w);
    // Displaced by -kappa t M e/sqrt(3 e.M e) over the face, eq. 6; what of M e is along the normal has no moment about it.
    if constexpr (on & pillow) {
      const Vec3 moved = apply(group.second_moment, at, t);
      const V square = hn::MulAdd(set(3.0f), dot(t, moved), set(small));
      moment = along(moment, hn::Mul(hn::Neg(law.pillow_factor), hn::Sqrt(hn::Div(size, square))), cross(moved, n));
    }
  }
  visit(windward<on>(law, area, c, size, bent), n, moment, w);
}

/// Calls visit(area, coefficient of leeward suction, of rear recovery, ...): what is off is not a number to be used.
template <unsigned on, class At, class Visit>
HWY_INLINE void uniform_leeward_at(const LawLanes& law, const Group& group, At at, V share, const Vec3& u, const Visit& visit) {
  const Vec3 n = vector(group.normal, at);
  const V w = hn::Neg(dot(u, n));
  V area;
  if (hn::AllFalse(f, felt<on, true>(group, at, share, w, area))) return;
  const V c = normal_speed<on, true>(w);
  visit(area, on & leeward ? law.leeward(c) : c, on & recovery ? rear_recovery(law, c) : c, n, vector(group.moment, at), w);
}

/// Displacement of the pressure on a triangle, -kappa t M e/sqrt(3 e.M e) over the face: eq. 6.
/// @param u  unit: of the flow at the centre
template <class At>
HWY_INLINE Vec3 pillow_shift(V kappa, const Group& group, At at, const Vec3& u) {
  const Vec3 n = vector(group.normal, at), t = along(u, hn::Neg(dot(u, n)), n), moved = apply(group.second_moment, at, t);
  const V square = hn::Max(hn::Mul(set(3.0f), dot(t, moved)), set(tiny));
  const V factor = hn::Mul(hn::Neg(kappa), hn::Sqrt(hn::Div(dot(t, t), square)));
  return times(along(moved, hn::Neg(dot(moved, n)), n), factor);
}

/// At a place r that air of velocity u meets.
template <unsigned on, class At, class Visit>
HWY_INLINE void windward_at(const LawLanes& law, const Group& group, At at, V share, const Vec3& n, const Vec3& r, const Vec3& u,
                            const Visit& visit) {
  const V w = hn::Neg(dot(u, n)), speed2 = dot(u, u);
  V area;
  if (hn::AllFalse(f, felt<on, false>(group, at, hn::Mul(share, speed2), w, area))) return;
  const V c = cosine(normal_speed<on, false>(w), speed2);
  Ratio bent{c, c};
  if constexpr (on & curvature) {
    const Vec3 t = along(u, w, n);
    bent = bend<on>(group.curvature, at, t, dot(t, t), w);
  }
  visit(windward<on>(law, area, c, hn::NegMulAdd(c, c, set(1.0f)), bent), n, cross(r, n), w);
}

/// Friction of the boundary layer, eq. 16: (1 + h)(1 + g chi) of one side, or the sum of both, times its scale.
/// @param t  tangential part of the flow
template <unsigned on, class At>
HWY_INLINE V layer(const LawLanes& law, const Group& group, At at, const Vec3& t, V w, V speed2) {
  const V one = set(1.0f), steep = hn::Mul(set(1.5f), w);
  const V h = hn::Div(steep, hn::Sqrt(hn::Max(hn::MulAdd(steep, steep, speed2), set(tiny))));
  const V size = dot(t, t), line = hn::Mul(set(0.45f), size), bent = dot(t, apply(group.curvature, at, t));
  // Of the two sides one is hollow, or both are flat.
  const auto grown = [&](V square) {
    const V chi = hn::Div(square, hn::Max(hn::MulAdd(line, size, square), set(tiny)));
    return hn::MulAdd(law.layer_curvature, chi, one);
  };
  const V front_bent = hn::Max(bent, hn::Zero(f)), front = hn::Mul(hn::Add(one, h), grown(hn::Mul(front_bent, front_bent)));
  if constexpr (on & two_sided) {
    const V back_bent = hn::Min(bent, hn::Zero(f)), back = hn::Mul(hn::Sub(one, h), grown(hn::Mul(back_bent, back_bent)));
    return hn::Mul(law.layer, hn::MulAdd(at(group.back), back, front));
  } else {
    return hn::Mul(law.layer, front);
  }
}

/// What the pillow does not displace: rub(wetted area times coefficient and speed, tangential velocity), and visit() as
/// uniform_leeward_at().
template <unsigned on, class At, class Rub, class Visit>
HWY_INLINE void straight_at(const LawLanes& law, const Group& group, At at, V share, const Vec3& n, const Vec3& r, const Vec3& u,
                            const Rub& rub, const Visit& visit) {
  const V w = hn::Neg(dot(u, n)), speed2 = dot(u, u);
  if constexpr (on & friction) {
    V wetted = hn::Mul(share, law.skin_friction);
    if constexpr (on & two_sided) wetted = hn::MulAdd(wetted, at(group.back), wetted);
    rub(hn::Mul(wetted, hn::Sqrt(speed2)), along(u, w, n));
  }
  if constexpr (on & viscous) {
    const Vec3 t = along(u, w, n);
    rub(hn::Mul(hn::Mul(share, layer<on>(law, group, at, t, w, speed2)), hn::Sqrt(hn::Sqrt(speed2))), t);
  }
  if constexpr ((on & (leeward | recovery)) != 0) {
    V area;
    if (hn::AllFalse(f, felt<on, true>(group, at, hn::Mul(share, speed2), w, area))) return;
    const V c = cosine(normal_speed<on, true>(w), speed2);
    visit(area, on & leeward ? law.leeward(c) : c, on & recovery ? rear_recovery(law, c) : c, n, cross(r, n), w);
  }
}

/// A point of a triangle rule from the centroid: along the two edges, and its share of the area.
struct PointLanes {
  V s, t, weight;
  explicit HWY_INLINE PointLanes(const QuadraturePoint& point)
      : s(set(static_cast<float>(point.s - 1.0 / 3.0))),
        t(set(static_cast<float>(point.t - 1.0 / 3.0))),
        weight(set(static_cast<float>(point.weight))) {}
  template <class At>
  HWY_INLINE Vec3 of(const GroupPlace& place, At at) const {
    return along(along(vector(place.place, at), s, vector(place.edge_ab, at)), t, vector(place.edge_ac, at));
  }
};

/// Six sums: force, and torque.
struct Sum {
  V force[3], torque[3];
  HWY_INLINE Sum() {
    for (int axis = 0; axis < 3; ++axis) force[axis] = torque[axis] = hn::Zero(f);
  }
  /// Of a pressure on an area that is signed like the normal speed: it acts against the normal where the air comes along it.
  HWY_INLINE void press(V pressure, const Vec3& normal, const Vec3& moment) {
    force[0] = hn::NegMulAdd(pressure, normal.x, force[0]), torque[0] = hn::NegMulAdd(pressure, moment.x, torque[0]);
    force[1] = hn::NegMulAdd(pressure, normal.y, force[1]), torque[1] = hn::NegMulAdd(pressure, moment.y, torque[1]);
    force[2] = hn::NegMulAdd(pressure, normal.z, force[2]), torque[2] = hn::NegMulAdd(pressure, moment.z, torque[2]);
  }
  HWY_INLINE void rub(V wetted, const Vec3& tangential, const Vec3& place) {
    const Vec3 turn = cross(place, tangential);
    force[0] = hn::MulAdd(wetted, tangential.x, force[0]), torque[0] = hn::MulAdd(wetted, turn.x, torque[0]);
    force[1] = hn::MulAdd(wetted, tangential.y, force[1]), torque[1] = hn::MulAdd(wetted, turn.y, torque[1]);
    force[2] = hn::MulAdd(wetted, tangential.z, force[2]), torque[2] = hn::MulAdd(wetted, turn.z, torque[2]);
  }
};

/// What a secant matrix is the sum of: wrench = S y, y the generalised velocity of the air relative to the body at its origin.
struct SecantLanes {
  V normal[6], mixed[9], moment[6];             ///< k n n^T, k n m^T, k m m^T of pressures k (n.u) along n, with m their moment
  V rubbed, rubbed_first[3], rubbed_second[6];  ///< k, k r, k r r^T of friction k u
  Sum given;                                    ///< of what pushes, which no positive matrix can have
  V given_power;

  HWY_INLINE SecantLanes() {
    const auto zero = [](V* first, std::size_t count) {
      for (std::size_t k = 0; k < count; ++k) first[k] = hn::Zero(f);
    };
    zero(normal, 6), zero(mixed, 9), zero(moment, 6), zero(&rubbed, 1), zero(rubbed_first, 3), zero(rubbed_second, 6),
        zero(&given_power, 1);
  }
  HWY_INLINE static void square(V (&sum)[6], V k, const Vec3& a) {
    const Vec3 b = times(a, k);
    sum[0] = hn::MulAdd(b.x, a.x, sum[0]), sum[1] = hn::MulAdd(b.x, a.y, sum[1]), sum[2] = hn::MulAdd(b.x, a.z, sum[2]);
    sum[3] = hn::MulAdd(b.y, a.y, sum[3]), sum[4] = hn::MulAdd(b.y, a.z, sum[4]), sum[5] = hn::MulAdd(b.z, a.z, sum[5]);
  }
  HWY_INLINE void dyad(V k, const Vec3& n, const Vec3& m) {
    square(normal, k, n), square(moment, k, m);
    const Vec3 b = times(n, k);
    mixed[0] = hn::MulAdd(b.x, m.x, mixed[0]), mixed[1] = hn::MulAdd(b.x, m.y, mixed[1]), mixed[2] = hn::MulAdd(b.x, m.z, mixed[2]);
    mixed[3] = hn::MulAdd(b.y, m.x, mixed[3]), mixed[4] = hn::MulAdd(b.y, m.y, mixed[4]), mixed[5] = hn::MulAdd(b.y, m.z, mixed[5]);
    mixed[6] = hn::MulAdd(b.z, m.x, mixed[6]), mixed[7] = hn::MulAdd(b.z, m.y, mixed[7]), mixed[8] = hn::MulAdd(b.z, m.z, mixed[8]);
  }
  /// A pressure on an area that is signed like the normal speed w.
  HWY_INLINE void press(V pressure, const Vec3& n, const Vec3& m, V w) {
    dyad(hn::Div(hn::Abs(pressure), hn::Max(hn::Abs(w), set(tiny))), n, m);
  }
  HWY_INLINE void push(V pressure, const Vec3& n, const Vec3& m, V w) {
    given.press(pressure, n, m);
    given_power = hn::NegMulAdd(pressure, w, given_power);
  }
  HWY_INLINE void rub(V k, const Vec3& n, const Vec3&, const Vec3& r, const Vec3&) {
    dyad(hn::Neg(k), n, cross(r, n));
    rubbed = hn::Add(rubbed, k);
    rubbed_first[0] = hn::MulAdd(k, r.x, rubbed_first[0]);
    rubbed_first[1] = hn::MulAdd(k, r.y, rubbed_first[1]);
    rubbed_first[2] = hn::MulAdd(k, r.z, rubbed_first[2]);
    square(rubbed_second, k, r);
  }
  /// Calls visit(row, sum) for each of them, in the order of SecantSums.
  template <class Visit>
  HWY_INLINE void for_each(const Visit& visit) const {
    std::size_t row = 0;
    const auto all = [&](const V* sums, std::size_t count) {
      for (std::size_t k = 0; k < count; ++k) visit(row++, sums[k]);
    };
    all(normal, 6), all(mixed, 9), all(moment, 6), all(&rubbed, 1), all(rubbed_first, 3), all(rubbed_second, 6);
    all(given.force, 3), all(given.torque, 3), all(&given_power, 1);
  }
};

/// Gives sums that tell what holds a body back, press(), from what pushes it, push(), the terms of one side.
template <unsigned on, class Sums>
HWY_INLINE void add_windward(Sums& sums, const Windward& here, const Vec3& n, const Vec3& m, V w) {
  V holds = here.pressure;
  if constexpr (on & base) holds = hn::Add(holds, here.base_suction);
  sums.press(hn::Mul(here.sheltered, holds), n, m, w);
  if constexpr (on & curvature) sums.push(hn::Mul(here.sheltered, here.curvature), n, m, w);
}
template <unsigned on, class Sums>
HWY_INLINE void add_leeward(Sums& sums, V area, V pull, V push, const Vec3& n, const Vec3& m, V w) {
  if constexpr (on & leeward) sums.press(hn::Mul(area, pull), n, m, w);
  if constexpr (on & recovery) sums.push(hn::Mul(area, push), n, m, w);
}

}  // namespace dragcore::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
