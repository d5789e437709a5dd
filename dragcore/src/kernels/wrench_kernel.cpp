#include "kernels/wrench_kernel.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "kernels/in_chunks.hpp"

// This file is compiled once for every instruction set; the best one that the machine has is taken at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/wrench_kernel.cpp"
#include <hwy/foreach_target.h>

#include "kernels/law-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace dragcore::kernels::HWY_NAMESPACE {

constexpr std::size_t block = 32;  // groups that are summed in float

/// Rows of sums in double: six for each of three terms, and two of power.
struct Sums {
  static constexpr std::size_t powers = 18, rows = 20;
  alignas(64) double row[rows][lanes / 2] = {};
  HWY_INLINE void add(std::size_t first, const Sum& sum, std::size_t lane) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      add_to(row[first + axis], sum.force[axis], lane);
      add_to(row[first + 3 + axis], sum.torque[axis], lane);
    }
  }
};

/// Groups in one flow.
struct Air {
  const PartTask* task;
  const Group* groups;
  const GroupPlace* places = nullptr;
  Rows share{};  ///< area that feels the pressure of windward surface, or the rest
  const Row (*shift)[3] = nullptr;
  std::size_t first_shift = 0;  ///< group of the first of them
  std::span<const QuadraturePoint> points{};
};
using Kernel = void (*)(const Air& air, std::size_t first, std::size_t last, Sums& sums);

// ---- a flow that is the same everywhere: in units of its own dynamic pressure

template <unsigned on>
void uniform_windward(const Air& air, std::size_t first, std::size_t last, Sums& sums) {
  const LawLanes law(air.task->law);
  const Vec3 u = set(air.task->direction);
  for (std::size_t lane = 0; lane < lanes; lane += width) {
    Sum pressure, suction, curved;
    for (std::size_t g = first; g < last; ++g) {
      const Group& group = air.groups[g];
      const Vec3 n = load(group.normal, lane);
      const V w = hn::Neg(dot(u, n));
      V area;
      if (hn::AllFalse(f, felt<on, false>(group, lane, load(air.share.first + g * air.share.stride + lane), w, area))) continue;
      const V c = hn::Min(set(1.0f), on & two_sided ? hn::Abs(w) : hn::Max(w, hn::Zero(f)));
      Vec3 moment = load(group.moment, lane);
      V chi = c;
      if constexpr ((on & (pillow | curvature)) != 0) {
        const Vec3 t = along(u, w, n);
        const V size = dot(t, t);
        V below[2];  // of chi and of the pillow
        Ratio bent{c, c};
        Vec3 moved = t;
        if constexpr (on & curvature) bent = bend<on>(group.curvature, lane, t, size, w), below[0] = hn::Max(bent.below, set(1e-15f));
        if constexpr (on & pillow) {
          moved = apply(group.second_moment, lane, t);
          below[(on & curvature) != 0] = hn::Max(hn::Mul(set(3.0f), dot(t, moved)), set(1e-15f));
        }
        invert<((on & curvature) != 0) + ((on & pillow) != 0)>(below);
        if constexpr (on & curvature) chi = hn::Mul(bent.above, below[0]);
        // Displaced by -kappa t M e/sqrt(3 e.M e) over the face, eq. 6; what of M e is along the normal has no moment about it.
        if constexpr (on & pillow)
          moment =
              along(moment, hn::Neg(hn::Mul(law.pillow_factor, hn::Sqrt(hn::Mul(size, below[(on & curvature) != 0])))), cross(moved, n));
      }
      const Windward felt_here = windward<on>(law, c, chi);
      pressure.press(hn::Mul(area, felt_here.pressure), n, moment);
      if constexpr (on & base) suction.press(hn::Mul(area, felt_here.base_suction), n, moment);
      if constexpr (on & curvature) curved.press(hn::Mul(area, felt_here.curvature), n, moment);
    }
    sums.add(0, pressure, lane);
    if constexpr (on & base) sums.add(6, suction, lane);
    if constexpr (on & curvature) sums.add(12, curved, lane);
  }
}

template <unsigned on>
void uniform_straight(const Air& air, std::size_t first, std::size_t last, Sums& sums) {
  const LawLanes law(air.task->law);
  const Vec3 u = set(air.task->direction);
  for (std::size_t lane = 0; lane < lanes; lane += width) {
    Sum pulled, pushed;
    for (std::size_t g = first; g < last; ++g) {
      const Group& group = air.groups[g];
      const Vec3 n = load(group.normal, lane);
      const V w = hn::Neg(dot(u, n));
      V area;
      if (hn::AllFalse(f, felt<on, true>(group, lane, load(air.share.first + g * air.share.stride + lane), w, area))) continue;
      const V c = hn::Min(set(1.0f), on & two_sided ? hn::Abs(w) : hn::Max(hn::Neg(w), hn::Zero(f)));
      const Vec3 moment = load(group.moment, lane);
      if constexpr (on & leeward) pulled.press(hn::Mul(area, law.leeward(c)), n, moment);
      if constexpr (on & recovery) pushed.press(hn::Mul(area, rear_recovery(law, c)), n, moment);
    }
    if constexpr (on & leeward) sums.add(0, pulled, lane);
    if constexpr (on & recovery) sums.add(6, pushed, lane);
  }
}

// ---- a flow that varies: in units of the dynamic pressure of one speed

/// The relative flow by place.
struct Flow {
  Vec3 x, y, z;  ///< change along the axes
  const Row (*origin)[3];
  std::size_t stride;
  HWY_INLINE Vec3 at(std::size_t g, std::size_t lane, const Vec3& r) const {
    return along(along(along(load(origin[g * stride], lane), r.x, x), r.y, y), r.z, z);
  }
};
/// The flow at the origin as a row of equal numbers.
struct Everywhere {
  alignas(64) Row row[1][3];
  explicit HWY_INLINE Everywhere(const Eigen::Vector3f& u) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (std::size_t lane = 0; lane < lanes; lane += width) hn::Store(set(u[static_cast<Eigen::Index>(axis)]), f, row[0][axis] + lane);
  }
};
HWY_INLINE Flow flow_of(const PartTask& task, const Everywhere& everywhere) {
  const auto& g = task.gradient;
  return {set(g.col(0)), set(g.col(1)), set(g.col(2)), task.wind ? task.wind : everywhere.row, task.wind ? 1u : 0u};
}

/// A point of a triangle rule from the centroid: along the two edges, and its share of the area.
struct PointLanes {
  V s, t, weight;
  explicit HWY_INLINE PointLanes(const QuadraturePoint& point)
      : s(set(static_cast<float>(point.s - 1.0 / 3.0))),
        t(set(static_cast<float>(point.t - 1.0 / 3.0))),
        weight(set(static_cast<float>(point.weight))) {}
  HWY_INLINE Vec3 of(const GroupPlace& place, std::size_t lane) const {
    return along(along(load(place.place, lane), s, load(place.edge_ab, lane)), t, load(place.edge_ac, lane));
  }
};

HWY_INLINE V cosine(V w, V speed2) { return hn::Min(set(1.0f), hn::Div(w, hn::Sqrt(hn::Max(speed2, set(tiny))))); }

template <unsigned on>
void varying_windward(const Air& air, std::size_t first, std::size_t last, Sums& sums) {
  const PartTask& task = *air.task;
  const LawLanes law(task.law);
  const Everywhere everywhere(task.flow);
  const Flow flow = flow_of(task, everywhere);
  for (std::size_t lane = 0; lane < lanes; lane += width) {
    Sum pressure, suction, curved;
    V taken = hn::Zero(f), given = hn::Zero(f);
    for (std::size_t g = first; g < last; ++g) {
      const Group& group = air.groups[g];
      const Vec3 n = load(group.normal, lane);
      const V share = load(air.share.first + g * air.share.stride + lane);
      for (const QuadraturePoint& quadrature_point : air.points) {
        const PointLanes point(quadrature_point);
        Vec3 r = point.of(air.places[g], lane);
        if constexpr (on & pillow) r = add(r, load(air.shift[g - air.first_shift], lane));
        const Vec3 u = flow.at(g, lane, r);
        const V w = hn::Neg(dot(u, n)), speed2 = dot(u, u);
        V area;
        if (hn::AllFalse(f, felt<on, false>(group, lane, hn::Mul(hn::Mul(share, point.weight), speed2), w, area))) continue;
        const V c = cosine(on & two_sided ? hn::Abs(w) : hn::Max(w, hn::Zero(f)), speed2);
        V chi = c;
        if constexpr (on & curvature) {
          const Vec3 t = along(u, w, n);
          const Ratio bent = bend<on>(group.curvature, lane, t, dot(t, t), w);
          chi = hn::Div(bent.above, bent.below);
        }
        const Windward felt_here = windward<on>(law, c, chi);
        const Vec3 moment = cross(r, n);
        V takes = felt_here.pressure;
        pressure.press(hn::Mul(area, felt_here.pressure), n, moment);
        if constexpr (on & base) {
          suction.press(hn::Mul(area, felt_here.base_suction), n, moment);
          takes = hn::Add(takes, felt_here.base_suction);
        }
        const V work = hn::Mul(area, w);
        taken = hn::MulAdd(work, takes, taken);
        if constexpr (on & curvature) {
          curved.press(hn::Mul(area, felt_here.curvature), n, moment);
          given = hn::NegMulAdd(work, felt_here.curvature, given);
        }
      }
    }
    sums.add(0, pressure, lane);
    if constexpr (on & base) sums.add(6, suction, lane);
    if constexpr (on & curvature) sums.add(12, curved, lane);
    add_to(sums.row[Sums::powers], taken, lane);
    if constexpr (on & curvature) add_to(sums.row[Sums::powers + 1], given, lane);
  }
}

template <unsigned on>
void varying_straight(const Air& air, std::size_t first, std::size_t last, Sums& sums) {
  const PartTask& task = *air.task;
  const LawLanes law(task.law);
  const Everywhere everywhere(task.flow);
  const Flow flow = flow_of(task, everywhere);
  for (std::size_t lane = 0; lane < lanes; lane += width) {
    Sum pulled, pushed, rubbed;
    V taken = hn::Zero(f), given = hn::Zero(f);
    for (std::size_t g = first; g < last; ++g) {
      const Group& group = air.groups[g];
      const Vec3 n = load(group.normal, lane);
      const V share = load(air.share.first + g * air.share.stride + lane);
      for (const QuadraturePoint& quadrature_point : air.points) {
        const PointLanes point(quadrature_point);
        const Vec3 r = point.of(air.places[g], lane), u = flow.at(g, lane, r);
        const V w = hn::Neg(dot(u, n)), speed2 = dot(u, u), own = hn::Mul(share, point.weight);
        if constexpr (on & friction) {
          V wetted = hn::Mul(own, law.skin_friction);
          if constexpr (on & two_sided) wetted = hn::MulAdd(wetted, load(group.back + lane), wetted);
          const Vec3 drag = times(along(u, w, n), hn::Mul(wetted, hn::Sqrt(speed2)));
          rubbed.act(drag, r);
          taken = hn::Add(taken, dot(drag, u));
        }
        if constexpr ((on & (leeward | recovery)) != 0) {
          V area;
          if (hn::AllFalse(f, felt<on, true>(group, lane, hn::Mul(own, speed2), w, area))) continue;
          const V c = cosine(on & two_sided ? hn::Abs(w) : hn::Max(hn::Neg(w), hn::Zero(f)), speed2), work = hn::Mul(area, w);
          const Vec3 moment = cross(r, n);
          if constexpr (on & leeward) {
            const V pull = law.leeward(c);
            pulled.press(hn::Mul(area, pull), n, moment);
            taken = hn::MulAdd(work, pull, taken);
          }
          if constexpr (on & recovery) {
            const V push = rear_recovery(law, c);
            pushed.press(hn::Mul(area, push), n, moment);
            given = hn::NegMulAdd(work, push, given);
          }
        }
      }
    }
    if constexpr (on & leeward) sums.add(0, pulled, lane);
    if constexpr (on & recovery) sums.add(6, pushed, lane);
    if constexpr (on & friction) sums.add(12, rubbed, lane);
    add_to(sums.row[Sums::powers], taken, lane);
    if constexpr (on & recovery) add_to(sums.row[Sums::powers + 1], given, lane);
  }
}

// ---- one kernel for each set of effects

template <template <unsigned> class Make, unsigned... on>
constexpr std::array<Kernel, sizeof...(on)> table(std::integer_sequence<unsigned, on...>) {
  return {Make<on>::kernel...};
}
template <unsigned on>
struct UniformWindward {
  static constexpr Kernel kernel = uniform_windward<on>;
};
template <unsigned on>
struct VaryingWindward {
  static constexpr Kernel kernel = varying_windward<on>;
};
template <unsigned on>
struct UniformStraight {
  static constexpr Kernel kernel = uniform_straight<(on & ~friction)>;  // its sum is known beforehand
};
template <unsigned on>
struct VaryingStraight {
  static constexpr Kernel kernel = varying_straight<on>;
};
using AllWindward = std::make_integer_sequence<unsigned, windward_kernels>;
using AllStraight = std::make_integer_sequence<unsigned, straight_kernels>;

/// Displacement of the pressure, -kappa t M e/sqrt(3 e.M e) over the face: eq. 6.
void shifts(const PartTask& task, std::size_t first, std::size_t last, Row (*shift)[3]) {
  const Vec3 u = set(task.direction);
  const V kappa = set(-task.law.pillow_factor);
  for (std::size_t g = first; g < last; ++g)
    for (std::size_t lane = 0; lane < lanes; lane += width) {
      const Group& group = task.surface->groups[g];
      const Vec3 n = load(group.normal, lane), t = along(u, hn::Neg(dot(u, n)), n), moved = apply(group.second_moment, lane, t);
      const V square = hn::Max(hn::Mul(set(3.0f), dot(t, moved)), set(tiny));
      const V factor = hn::Mul(kappa, hn::Sqrt(hn::Div(dot(t, t), square)));
      const Vec3 tangential = times(along(moved, hn::Neg(dot(moved, n)), n), factor);
      hn::Store(tangential.x, f, shift[g - first][0] + lane);
      hn::Store(tangential.y, f, shift[g - first][1] + lane);
      hn::Store(tangential.z, f, shift[g - first][2] + lane);
    }
}

/// Shares of the rules on every triangle, times its area; says which rules are needed at all.
std::array<bool, 3> adapt(const PartTask& task, std::size_t first, std::size_t last, Row (*shares)[block]) {
  V most[3] = {hn::Zero(f), hn::Zero(f), hn::Zero(f)};
  const Everywhere everywhere(task.flow);
  const Flow flow = flow_of(task, everywhere);
  const V per_length = set(task.variation);
  for (std::size_t g = first; g < last; ++g)
    for (std::size_t lane = 0; lane < lanes; lane += width) {
      const GroupPlace& place = task.surface->places[g];
      const Vec3 ab = load(place.edge_ab, lane), ac = load(place.edge_ac, lane), u = flow.at(g, lane, load(place.place, lane));
      const Vec3 a = add(ab, ac), b = along(ac, set(-2.0f), ab), c = along(ab, set(-2.0f), ac);
      const V radius = hn::Mul(hn::Sqrt(hn::Max(dot(a, a), hn::Max(dot(b, b), dot(c, c)))), set(1.0f / 3.0f));
      const V variation = hn::Mul(radius, per_length), speed = hn::Sqrt(dot(u, u)), own = load(task.surface->groups[g].share + lane);
      const auto rise = [&](float low, float high) {
        const V range = hn::Max(hn::Mul(speed, set(high - low)), set(tiny));
        const V y = hn::Min(set(1.0f), hn::Div(hn::Max(hn::Zero(f), hn::NegMulAdd(speed, set(low), variation)), range));
        return hn::Mul(hn::Mul(y, y), hn::NegMulAdd(set(2.0f), y, set(3.0f)));
      };
      const V three = rise(0.002f, 0.004f), six = rise(0.5f, 1.0f);
      const V rule_shares[3] = {hn::Sub(set(1.0f), three), hn::Mul(three, hn::Sub(set(1.0f), six)), hn::Mul(three, six)};
      for (std::size_t rule = 0; rule < 3; ++rule) {
        hn::Store(hn::Mul(own, rule_shares[rule]), f, shares[rule][g - first] + lane);
        most[rule] = hn::Max(most[rule], rule_shares[rule]);
      }
    }
  std::array<bool, 3> some;
  for (std::size_t rule = 0; rule < 3; ++rule) some[rule] = !hn::AllTrue(f, hn::Eq(most[rule], hn::Zero(f)));
  return some;
}

/// Shares of the areas that the wind reaches.
void reach(const PartTask& task, std::size_t first, std::size_t last, Rows share, Row* reached) {
  for (std::size_t g = first; g < last; ++g)
    for (std::size_t lane = 0; lane < lanes; lane += width)
      hn::Store(hn::Mul(load(share.first + g * share.stride + lane), hn::LoadU(f, task.reached + g * lanes + lane)), f,
                reached[g - first] + lane);
}

/// Rows that stand for the groups from `first` on.
Rows rows_from(const Row* row, std::size_t first) { return {row[0] - first * lanes, lanes}; }

void part_sums_on_target(const PartTask& task, std::size_t first, std::size_t last, PartSums& result) {
  static constexpr auto uniform_windwards = table<UniformWindward>(AllWindward());
  static constexpr auto varying_windwards = table<VaryingWindward>(AllWindward());
  static constexpr auto uniform_straights = table<UniformStraight>(AllStraight());
  static constexpr auto varying_straights = table<VaryingStraight>(AllStraight());
  const PackedSurface& surface = *task.surface;
  const bool has_two_sides = surface.parts[task.part].two_sided;
  const unsigned windward_on = windward_effects(task.law, has_two_sides), straight_on = straight_effects(task.law, has_two_sides);
  const bool pulls = task.law.leeward || task.law.recovery, straight = task.varies ? pulls || task.law.friction : pulls;
  const Kernel windward_kernel = (task.varies ? varying_windwards : uniform_windwards)[windward_on];
  const Kernel straight_kernel = (task.varies ? varying_straights : uniform_straights)[straight_on];
  Air air{.task = &task, .groups = task.varies ? surface.groups.data() : surface.uniform_groups(), .places = surface.places.data()};
  const Rows whole{air.groups[0].share, sizeof(Group) / sizeof(float)};
  Sums windward_sums, straight_sums;
  alignas(64) Row shift[block][3], shares[3][block], reached[block];
  for (std::size_t begin = first; begin < last; begin += block) {
    const std::size_t end = std::min(begin + block, last);
    const auto with = [&](Rows share) {
      air.share = share;
      if (straight) straight_kernel(air, begin, end, straight_sums);
      if (task.reached) reach(task, begin, end, share, reached), air.share = rows_from(reached, begin);
      windward_kernel(air, begin, end, windward_sums);
    };
    if (!task.varies) {
      with(whole);
      continue;
    }
    if (task.law.pillow) shifts(task, begin, end, shift), air.shift = shift, air.first_shift = begin;
    if (task.quadrature != Quadrature::adaptive) {
      air.points = quadrature_rule(task.quadrature);
      with(whole);
      continue;
    }
    const std::array<bool, 3> some = adapt(task, begin, end, shares);
    for (std::size_t rule = 0; rule < 3; ++rule)
      if (some[rule]) {
        air.points = quadrature_rule(std::array{Quadrature::one, Quadrature::three, Quadrature::six}[rule]);
        with(rows_from(shares[rule], begin));
      }
  }
  const auto take = [&](Term term, Sums& sums, std::size_t row) {
    for (std::size_t k = 0; k < 6; ++k) result.terms[static_cast<std::size_t>(term)][k] = total<lanes / 2>(sums.row[row + k]);
  };
  take(Term::windward_pressure, windward_sums, 0);
  if (task.law.base) take(Term::base_suction, windward_sums, 6);
  if (task.law.curvature) take(Term::curvature, windward_sums, 12);
  if (task.law.leeward) take(Term::leeward_suction, straight_sums, 0);
  if (task.law.recovery) take(Term::rear_recovery, straight_sums, 6);
  if (!task.varies) return;
  if (task.law.friction) take(Term::friction, straight_sums, 12);
  const auto power = [&](std::size_t row) {
    return total<lanes / 2>(windward_sums.row[Sums::powers + row]) + total<lanes / 2>(straight_sums.row[Sums::powers + row]);
  };
  result.taken = power(0), result.given = power(1);
}

void seen_on_target(const PackedSurface& surface, const PackedSurface::Range& range, const Eigen::Vector3f& direction, bool two_sides,
                    Seen& result) {
  const Vec3 u = set(direction);
  alignas(64) double sums[2][lanes / 2] = {};
  const Group* const groups = surface.uniform_groups();
  for (std::size_t begin = range.first; begin < range.last; begin += block)
    for (std::size_t lane = 0; lane < lanes; lane += width) {
      V frontal = hn::Zero(f), sharp = hn::Zero(f);
      for (std::size_t g = begin; g < std::min(begin + block, range.last); ++g) {
        V c = hn::Neg(dot(u, load(groups[g].normal, lane)));
        c = two_sides ? hn::Abs(c) : hn::Max(c, hn::Zero(f));
        const V met = hn::Mul(c, load(groups[g].share + lane)), square = hn::Mul(c, c);
        frontal = hn::Add(frontal, met);
        sharp = hn::MulAdd(met, hn::Mul(square, square), sharp);
      }
      add_to(sums[0], frontal, lane), add_to(sums[1], sharp, lane);
    }
  result = {total<lanes / 2>(sums[0]), total<lanes / 2>(sums[1])};
}

void silhouette_on_target(const PackedSurface& surface, PackedSurface::Range range, const Eigen::Vector3d& direction, bool two_sides,
                          const double* reached, SilhouetteSums& result) {
  constexpr std::size_t row_lanes = lanes / 2, rows = 12, turns = row_lanes / wide;
  const PackedSurface::Facets& facets = surface.facets;
  alignas(64) double sums[rows][row_lanes] = {};
  const W x = hn::Set(d, -direction.x()), y = hn::Set(d, -direction.y()), z = hn::Set(d, -direction.z());
  // One turn for every vector that fits into the lanes: each lane sees the same facets in the same order, whatever the width.
  for (std::size_t turn = 0; turn < turns; ++turn) {
    W sum[rows];
    for (W& row : sum) row = hn::Zero(d);
    for (std::size_t k = range.first + turn * wide; k < range.last; k += row_lanes) {
      const auto at = [k](const Aligned<double>& array) { return hn::Load(d, array.data() + k); };
      W c = hn::MulAdd(x, at(facets.normal[0]), hn::MulAdd(y, at(facets.normal[1]), hn::Mul(z, at(facets.normal[2]))));
      c = two_sides ? hn::Abs(c) : hn::Max(c, hn::Zero(d));
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
  const auto all = [&](std::size_t row) { return total<row_lanes>(sums[row]); };
  result.whole = all(0), result.frontal = all(1), result.sharp = all(2);
  for (Eigen::Index row = 0; row < 3; ++row) result.first[row] = all(3 + static_cast<std::size_t>(row));
  const double xx = all(6), xy = all(7), xz = all(8), yy = all(9), yz = all(10), zz = all(11);
  result.second << xx, xy, xz, xy, yy, yz, xz, yz, zz;
}

}  // namespace dragcore::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace dragcore::kernels {

HWY_EXPORT(part_sums_on_target);
HWY_EXPORT(seen_on_target);
HWY_EXPORT(silhouette_on_target);

PartSums part_sums(const PartTask& task) {
  const PackedSurface::Part& part = task.surface->parts[task.part];
  const PackedSurface::Range range = task.varies ? part.groups : part.uniform;
  PartSums sums = in_chunks<PartSums>(
      range.first, range.last,
      [&](std::size_t first, std::size_t last, PartSums& sums) {
        HWY_DYNAMIC_DISPATCH(part_sums_on_target)
        (task, first, last, sums);
      },
      [](PartSums& all, const PartSums& more) {
        for (std::size_t term = 0; term < all.terms.size(); ++term)
          for (std::size_t k = 0; k < 6; ++k) all.terms[term][k] += more.terms[term][k];
        all.taken += more.taken, all.given += more.given;
      });
  if (task.law.friction && !task.varies) {
    const Eigen::Vector3d u = static_cast<double>(task.law.skin_friction) * task.direction.cast<double>();
    auto& friction = sums.terms[static_cast<std::size_t>(Term::friction)];
    Eigen::Map<Eigen::Vector3d>(friction.data()) = part.friction_force * u;
    Eigen::Map<Eigen::Vector3d>(friction.data() + 3) = part.friction_torque * u;
  }
  return sums;
}

Seen seen(const PackedSurface& surface, std::size_t part, const Eigen::Vector3f& direction, bool two_sided) {
  return in_chunks<Seen>(
      surface.parts[part].uniform.first, surface.parts[part].uniform.last,
      [&](std::size_t first, std::size_t last, Seen& sums) {
        HWY_DYNAMIC_DISPATCH(seen_on_target)(surface, {first, last}, direction, two_sided, sums);
      },
      [](Seen& all, const Seen& more) { all.frontal += more.frontal, all.sharp += more.sharp; });
}

SilhouetteSums silhouette(const PackedSurface& surface, std::size_t part, const Eigen::Vector3d& direction, bool two_sided,
                          const double* reached) {
  const PackedSurface::Part& packed = surface.parts[part];
  SilhouetteSums result;
  HWY_DYNAMIC_DISPATCH(silhouette_on_target)(surface, packed.facets, direction, two_sided, reached, result);
  result.whole *= packed.area, result.frontal *= packed.area, result.sharp *= packed.area;
  result.first *= packed.area * packed.size, result.second *= packed.area * packed.size * packed.size;
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
