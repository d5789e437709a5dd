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
constexpr unsigned leeward = 2, recovery = 4, friction = 8, straight_kernels = 16;  // and two_sided: of what the pillow does not displace

inline unsigned windward_effects(const ResolvedLaw& law, bool has_two_sides) {
  return (has_two_sides ? two_sided : 0u) | (law.pillow ? pillow : 0u) | (law.base ? base : 0u) | (law.shelter ? shelter : 0u) |
         (law.curvature ? curvature : 0u);
}
inline unsigned straight_effects(const ResolvedLaw& law, bool has_two_sides) {
  return (has_two_sides ? two_sided : 0u) | (law.leeward ? leeward : 0u) | (law.recovery ? recovery : 0u) | (law.friction ? friction : 0u);
}

/// A law in registers, the same for all lanes or each lane's own.
struct LawLanes {
  Polynomial windward, leeward;
  V base_suction, base_edge, shelter_rate, per_sharpness, curvature_suction, push, recovery_edge, skin_friction, pillow_factor;
  explicit HWY_INLINE LawLanes(const ResolvedLaw& law)
      : windward(law.windward_polynomial),
        leeward(law.leeward_polynomial),
        base_suction(set(law.base_suction)),
        base_edge(set(law.base_edge)),
        shelter_rate(set(law.shelter_rate)),
        per_sharpness(set(law.per_sharpness)),
        curvature_suction(set(law.curvature_suction)),
        push(set(law.push)),
        recovery_edge(set(law.recovery_edge)),
        skin_friction(set(law.skin_friction)),
        pillow_factor(set(law.pillow_factor)) {}
};

constexpr float tiny = 1e-30f;

/// Coefficients of windward surface, eq. 2, 7, 9 and 10.
struct Windward {
  V pressure, base_suction, curvature;
};
template <unsigned on>
HWY_INLINE Windward windward(const LawLanes& law, V c, V chi) {
  constexpr std::size_t ramped = 0, based = (on & shelter) != 0, curved = based + ((on & base) != 0),
                        count = curved + ((on & curvature) != 0);
  V below[count + 1];
  V x = c;
  if constexpr (on & shelter) {
    x = hn::Max(hn::Zero(f), hn::NegMulAdd(c, law.per_sharpness, set(1.0f)));
    below[ramped] = hn::Add(x, set(0.1f));
  }
  if constexpr (on & base) below[based] = hn::Add(c, law.base_edge);
  if constexpr (on & curvature) below[curved] = hn::Add(c, set(0.2f));
  invert<count>(below);
  Windward result{law.windward(c), c, c};
  if constexpr (on & base) {
    const V rise = hn::Mul(hn::Mul(c, hn::Add(law.base_edge, set(1.0f))), below[based]);
    result.base_suction = hn::Mul(hn::Mul(law.base_suction, rise), hn::Sub(set(2.0f), c));
  }
  if constexpr (on & curvature) {
    const V rise = hn::Mul(hn::Mul(c, set(1.2f)), below[curved]);
    result.curvature = hn::Mul(hn::Mul(hn::Neg(law.curvature_suction), chi), hn::Mul(hn::NegMulAdd(c, c, set(1.0f)), rise));
  }
  if constexpr (on & shelter) {
    const V sheltered = exp_minus(hn::Mul(law.shelter_rate, hn::Mul(hn::Mul(x, x), below[ramped])));
    result.pressure = hn::Mul(result.pressure, sheltered);
    if constexpr (on & base) result.base_suction = hn::Mul(result.base_suction, sheltered);
    if constexpr (on & curvature) result.curvature = hn::Mul(result.curvature, sheltered);
  }
  return result;
}

/// Rear recovery of leeward surface, eq. 8.
HWY_INLINE V rear_recovery(const LawLanes& law, V c) {
  const V rise = hn::Div(hn::Mul(c, hn::Add(law.recovery_edge, set(1.0f))), hn::Add(c, law.recovery_edge));
  return hn::Mul(hn::Neg(law.push), rise);
}

/// Chi of the flow along the surface as numerator and denominator. Both are divided by the square of `t`, which may be small.
/// @param side  its sign: which side of the surface
struct Ratio {
  V above, below;
};
template <unsigned on>
HWY_INLINE Ratio bend(const Row (&tensor)[6], std::size_t lane, const Vec3& t, V size, V side) {
  V bent = dot(t, apply(tensor, lane, t));
  if constexpr (on & two_sided) bent = hn::Xor(bent, hn::And(side, hn::Set(f, -0.0f)));
  bent = hn::Max(bent, hn::Zero(f));
  const V square = hn::Mul(bent, bent);
  return {square, hn::MulAdd(hn::Mul(set(0.45f), size), size, hn::Add(square, set(tiny)))};
}

/// Area of the side of a triangle that meets the air, signed like the normal speed w; or, `leeward`, of the side that turns away.
/// @return  where either is anything
template <unsigned on, bool away>
HWY_INLINE M felt(const Group& group, std::size_t lane, V share, V w, V& area) {
  const V zero = hn::Zero(f);
  const M front = away ? hn::Lt(w, zero) : hn::Gt(w, zero);
  if constexpr (on & two_sided) {
    area = hn::Mul(share, hn::IfThenElse(front, set(1.0f), load(group.back + lane)));
    area = hn::IfThenElseZero(hn::Ne(w, zero), hn::CopySign(area, w));
    return hn::Ne(area, zero);
  } else {
    area = hn::IfThenElseZero(front, away ? hn::Neg(share) : share);
    return front;
  }
}

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
  HWY_INLINE void act(const Vec3& drag, const Vec3& place) {
    const Vec3 turn = cross(place, drag);
    force[0] = hn::Add(force[0], drag.x), torque[0] = hn::Add(torque[0], turn.x);
    force[1] = hn::Add(force[1], drag.y), torque[1] = hn::Add(torque[1], turn.y);
    force[2] = hn::Add(force[2], drag.z), torque[2] = hn::Add(torque[2], turn.z);
  }
};

}  // namespace dragcore::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
