// How kernels walk over the triangles of one part, block by block: one source for all of what they sum.
#if defined(DRAGCORE_BLOCKS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef DRAGCORE_BLOCKS_INL
#undef DRAGCORE_BLOCKS_INL
#else
#define DRAGCORE_BLOCKS_INL
#endif

#include <span>
#include <utility>

#include "kernels/law-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace dragcore::kernels::HWY_NAMESPACE {

constexpr std::size_t block = 32;  // groups that are summed in float

/// Groups in one flow.
struct Air {
  const PartTask* task;
  const Group* groups;
  const GroupPlace* places;
  Rows share{};  ///< area that feels the pressure of windward surface, or the rest
  const Row (*shift)[3] = nullptr;
  std::size_t first_shift = 0;  ///< group of the first of them
  std::span<const QuadraturePoint> points{};
  HWY_INLINE V area(std::size_t g, std::size_t lane) const { return load(share.first + g * share.stride + lane); }
};

/// The relative flow by place.
struct Flow {
  Vec3 x, y, z;  ///< change along the axes
  const Row (*origin)[3];
  std::size_t stride;
  HWY_INLINE Vec3 at(std::size_t g, std::size_t lane, const Vec3& r) const {
    return along(along(along(vector(origin[g * stride], Many{lane}), r.x, x), r.y, y), r.z, z);
  }
};
/// The flow at the origin as a row of equal numbers.
struct Everywhere {
  alignas(64) Row row[1][3];
  explicit HWY_INLINE Everywhere(const Eigen::Vector3f& u) {
    for (std::size_t lane = 0; lane < lanes; lane += width) store(set(u), row[0], lane);
  }
};
HWY_INLINE Flow flow_of(const PartTask& task, const Everywhere& everywhere) {
  const auto& g = task.gradient;
  return {set(g.col(0)), set(g.col(1)), set(g.col(2)), task.wind ? task.wind : everywhere.row, task.wind ? 1u : 0u};
}

/// A table of kernels, one for each set of effects.
template <class Kernel, template <unsigned> class Make, unsigned... on>
constexpr std::array<Kernel, sizeof...(on)> kernels_of(std::integer_sequence<unsigned, on...>) {
  return {Make<on>::kernel...};
}
using AllWindward = std::make_integer_sequence<unsigned, windward_kernels>;
using AllStraight = std::make_integer_sequence<unsigned, straight_kernels>;

inline void shifts(const PartTask& task, std::size_t first, std::size_t last, Row (*shift)[3]) {
  const Vec3 u = set(task.direction);
  const V kappa = set(task.law.pillow_factor);
  for (std::size_t g = first; g < last; ++g)
    for (std::size_t lane = 0; lane < lanes; lane += width)
      store(pillow_shift(kappa, task.surface->groups[g], Many{lane}, u), shift[g - first], lane);
}

/// Shares of the rules on every triangle, times its area; says which rules are needed at all.
inline std::array<bool, 3> adapt(const PartTask& task, std::size_t first, std::size_t last, Row (*shares)[block]) {
  V most[3] = {hn::Zero(f), hn::Zero(f), hn::Zero(f)};
  const Everywhere everywhere(task.flow);
  const Flow flow = flow_of(task, everywhere);
  const V per_length = set(task.variation);
  for (std::size_t g = first; g < last; ++g)
    for (std::size_t lane = 0; lane < lanes; lane += width) {
      const GroupPlace& place = task.surface->places[g];
      const Many at{lane};
      const Vec3 ab = vector(place.edge_ab, at), ac = vector(place.edge_ac, at), u = flow.at(g, lane, vector(place.place, at));
      const Vec3 a = add(ab, ac), b = along(ac, set(-2.0f), ab), c = along(ab, set(-2.0f), ac);
      const V radius = hn::Mul(hn::Sqrt(hn::Max(dot(a, a), hn::Max(dot(b, b), dot(c, c)))), set(1.0f / 3.0f));
      const V variation = hn::Mul(radius, per_length), speed = hn::Sqrt(dot(u, u)), own = at(task.surface->groups[g].share);
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
inline void reach(const PartTask& task, std::size_t first, std::size_t last, Rows share, Row* reached) {
  for (std::size_t g = first; g < last; ++g)
    for (std::size_t lane = 0; lane < lanes; lane += width)
      hn::Store(hn::Mul(load(share.first + g * share.stride + lane), hn::LoadU(f, task.reached + g * lanes + lane)), f,
                reached[g - first] + lane);
}

/// Rows that stand for the groups from `first` on.
inline Rows rows_from(const Row* row, std::size_t first) { return {row[0] - first * lanes, lanes}; }

/// Calls straight(air, first, last) and windward(air, first, last) for every block, and every rule of quadrature that it needs.
template <class Straight, class Windward>
HWY_INLINE void for_each_block(const PartTask& task, std::size_t first, std::size_t last, const Straight& straight,
                               const Windward& windward) {
  const PackedSurface& surface = *task.surface;
  Air air{.task = &task, .groups = task.varies ? surface.groups.data() : surface.uniform_groups(), .places = surface.places.data()};
  const Rows whole{air.groups[0].share, sizeof(Group) / sizeof(float)};
  alignas(64) Row shift[block][3], shares[3][block], reached[block];
  for (std::size_t begin = first; begin < last; begin += block) {
    const std::size_t end = std::min(begin + block, last);
    const auto with = [&](Rows share) {
      air.share = share;
      straight(air, begin, end);
      if (task.reached) reach(task, begin, end, share, reached), air.share = rows_from(reached, begin);
      windward(air, begin, end);
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
}

}  // namespace dragcore::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
