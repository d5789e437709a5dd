#include "kernels/wrench_kernel.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "support/for_each_index.hpp"

// This file is compiled once for every instruction set; the best one that the machine has is taken at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/wrench_kernel.cpp"
#include <hwy/foreach_target.h>

#include "kernels/blocks-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace dragcore::kernels::HWY_NAMESPACE {

namespace {

/// Rows of sums in double: six for each of three terms, and two of power.
struct Sums {
  static constexpr std::size_t powers = 18, rows = 20;
  alignas(64) double row[rows][lanes / 2];
  void clear(std::size_t first, std::size_t count) { std::fill_n(row[first], count * (lanes / 2), 0.0); }
  HWY_INLINE void add(std::size_t first, const Sum& sum, std::size_t lane) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      add_to(row[first + axis], sum.force[axis], lane);
      add_to(row[first + 3 + axis], sum.torque[axis], lane);
    }
  }
};
using Kernel = void (*)(const Air& air, std::size_t first, std::size_t last, Sums& sums);

// ---- a flow that is the same everywhere: in units of its own dynamic pressure

template <unsigned on>
void uniform_windward(const Air& air, std::size_t first, std::size_t last, Sums& sums) {
  const LawLanes law(air.task->law);
  const Vec3 u = set(air.task->direction);
  for (std::size_t lane = 0; lane < lanes; lane += width) {
    Sum pressure, suction, curved;
    for (std::size_t g = first; g < last; ++g)
      uniform_windward_at<on>(law, air.groups[g], Many{lane}, air.area(g, lane), u,
                              [&](const Windward& here, const Vec3& n, const Vec3& moment, V) {
                                pressure.press(hn::Mul(here.sheltered, here.pressure), n, moment);
                                if constexpr (on & base) suction.press(hn::Mul(here.sheltered, here.base_suction), n, moment);
                                if constexpr (on & curvature) curved.press(hn::Mul(here.sheltered, here.curvature), n, moment);
                              });
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
    for (std::size_t g = first; g < last; ++g)
      uniform_leeward_at<on>(law, air.groups[g], Many{lane}, air.area(g, lane), u,
                             [&](V area, V pull, V push, const Vec3& n, const Vec3& moment, V) {
                               if constexpr (on & leeward) pulled.press(hn::Mul(area, pull), n, moment);
                               if constexpr (on & recovery) pushed.press(hn::Mul(area, push), n, moment);
                             });
    if constexpr (on & leeward) sums.add(0, pulled, lane);
    if constexpr (on & recovery) sums.add(6, pushed, lane);
  }
}

// ---- a flow that varies: in units of the dynamic pressure of one speed

template <unsigned on>
void varying_windward(const Air& air, std::size_t first, std::size_t last, Sums& sums) {
  const LawLanes law(air.task->law);
  const Everywhere everywhere(air.task->flow);
  const Flow flow = flow_of(*air.task, everywhere);
  for (std::size_t lane = 0; lane < lanes; lane += width) {
    Sum pressure, suction, curved;
    V taken = hn::Zero(f), given = hn::Zero(f);
    for (std::size_t g = first; g < last; ++g) {
      const Group& group = air.groups[g];
      const Vec3 n = vector(group.normal, Many{lane});
      const V share = air.area(g, lane);
      for (const QuadraturePoint& quadrature_point : air.points) {
        const PointLanes point(quadrature_point);
        Vec3 r = point.of(air.places[g], Many{lane});
        if constexpr (on & pillow) r = add(r, vector(air.shift[g - air.first_shift], Many{lane}));
        windward_at<on>(law, group, Many{lane}, hn::Mul(share, point.weight), n, r, flow.at(g, lane, r),
                        [&](const Windward& here, const Vec3&, const Vec3& moment, V w) {
                          const V work = hn::Mul(here.sheltered, w);
                          pressure.press(hn::Mul(here.sheltered, here.pressure), n, moment);
                          taken = hn::MulAdd(work, here.pressure, taken);
                          if constexpr (on & base) {
                            suction.press(hn::Mul(here.sheltered, here.base_suction), n, moment);
                            taken = hn::MulAdd(work, here.base_suction, taken);
                          }
                          if constexpr (on & curvature) {
                            curved.press(hn::Mul(here.sheltered, here.curvature), n, moment);
                            given = hn::NegMulAdd(work, here.curvature, given);
                          }
                        });
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
  const LawLanes law(air.task->law);
  const Everywhere everywhere(air.task->flow);
  const Flow flow = flow_of(*air.task, everywhere);
  for (std::size_t lane = 0; lane < lanes; lane += width) {
    Sum pulled, pushed, rubbed;
    V taken = hn::Zero(f), given = hn::Zero(f);
    for (std::size_t g = first; g < last; ++g) {
      const Vec3 n = vector(air.groups[g].normal, Many{lane});
      const V share = air.area(g, lane);
      for (const QuadraturePoint& quadrature_point : air.points) {
        const PointLanes point(quadrature_point);
        const Vec3 r = point.of(air.places[g], Many{lane}), u = flow.at(g, lane, r);
        straight_at<on>(
            law, air.groups[g], Many{lane}, hn::Mul(share, point.weight), n, r, u,
            [&](V wetted, const Vec3& t) {
              rubbed.rub(wetted, t, r);
              taken = hn::MulAdd(wetted, dot(t, u), taken);
            },
            [&](V area, V pull, V push, const Vec3&, const Vec3& moment, V w) {
              const V work = hn::Mul(area, w);
              if constexpr (on & leeward) {
                pulled.press(hn::Mul(area, pull), n, moment);
                taken = hn::MulAdd(work, pull, taken);
              }
              if constexpr (on & recovery) {
                pushed.press(hn::Mul(area, push), n, moment);
                given = hn::NegMulAdd(work, push, given);
              }
            });
      }
    }
    if constexpr (on & leeward) sums.add(0, pulled, lane);
    if constexpr (on & recovery) sums.add(6, pushed, lane);
    if constexpr (on & (friction | viscous)) sums.add(12, rubbed, lane);
    add_to(sums.row[Sums::powers], taken, lane);
    if constexpr (on & recovery) add_to(sums.row[Sums::powers + 1], given, lane);
  }
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
  static constexpr Kernel kernel = uniform_straight<(on & ~(friction | viscous))>;  // the sum of the first is known beforehand; the other takes the flow to vary
};
template <unsigned on>
struct VaryingStraight {
  static constexpr Kernel kernel = varying_straight<either_friction(on)>;
};

}  // namespace

void part_sums_on_target(const PartTask& task, std::size_t first, std::size_t last, PartSums& result) {
  static constexpr auto uniform_windwards = kernels_of<Kernel, UniformWindward>(AllWindward());
  static constexpr auto varying_windwards = kernels_of<Kernel, VaryingWindward>(AllWindward());
  static constexpr auto uniform_straights = kernels_of<Kernel, UniformStraight>(AllStraight());
  static constexpr auto varying_straights = kernels_of<Kernel, VaryingStraight>(AllStraight());
  const bool has_two_sides = task.surface->parts[task.part].two_sided;
  const Kernel windward_kernel = (task.varies ? varying_windwards : uniform_windwards)[windward_effects(task.law, has_two_sides)];
  const Kernel straight_kernel = (task.varies ? varying_straights : uniform_straights)[straight_effects(task.law, has_two_sides)];
  // Which terms each kernel sums: three times six rows.
  const ResolvedLaw& law = task.law;
  const bool rubs = task.varies && (law.friction || law.viscous);
  const std::array<std::pair<Term, bool>, 3> windward_terms{
      {{Term::windward_pressure, true}, {Term::base_suction, law.base}, {Term::curvature, law.curvature}}};
  const std::array<std::pair<Term, bool>, 3> straight_terms{
      {{Term::leeward_suction, law.leeward}, {Term::rear_recovery, law.recovery}, {Term::friction, rubs}}};
  const auto clear = [&](Sums& sums, const auto& terms) {
    for (std::size_t k = 0; k < 3; ++k)
      if (terms[k].second) sums.clear(6 * k, 6);
    if (task.varies) sums.clear(Sums::powers, 2);
  };
  Sums windward_sums, straight_sums;
  clear(windward_sums, windward_terms), clear(straight_sums, straight_terms);
  for_each_block(
      task, first, last,
      [&](const Air& air, std::size_t begin, std::size_t end) {
        if (law.leeward || law.recovery || rubs) straight_kernel(air, begin, end, straight_sums);
      },
      [&](const Air& air, std::size_t begin, std::size_t end) { windward_kernel(air, begin, end, windward_sums); });
  const auto take = [&](Sums& sums, const auto& terms) {
    for (std::size_t k = 0; k < 3; ++k)
      if (terms[k].second)
        for (std::size_t i = 0; i < 6; ++i)
          result.terms[static_cast<std::size_t>(terms[k].first)][i] = total<lanes / 2>(sums.row[6 * k + i]);
  };
  take(windward_sums, windward_terms), take(straight_sums, straight_terms);
  if (!task.varies) return;
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
        V c = hn::Neg(dot(u, vector(groups[g].normal, Many{lane})));
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
      [&](std::size_t first, std::size_t last, PartSums& chunk) {
        HWY_DYNAMIC_DISPATCH(part_sums_on_target)
        (task, first, last, chunk);
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
