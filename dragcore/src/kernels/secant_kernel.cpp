#include "kernels/secant_kernel.hpp"

#include <algorithm>

#include "support/for_each_index.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/secant_kernel.cpp"
#include <hwy/foreach_target.h>

#include "kernels/blocks-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace dragcore::kernels::HWY_NAMESPACE {

namespace {

struct Rows8 {
  alignas(64) double row[SecantSums::rows][lanes / 2] = {};
};
using Kernel = void (*)(const Air& air, std::size_t first, std::size_t last, Rows8& sums);

void add(const SecantLanes& secant, Rows8& sums, std::size_t lane) {
  secant.for_each([&](std::size_t row, V sum) { add_to(sums.row[row], sum, lane); });
}

template <unsigned on>
void windward_secant(const Air& air, std::size_t first, std::size_t last, Rows8& sums) {
  const LawLanes law(air.task->law);
  const Everywhere everywhere(air.task->flow);
  const Flow flow = flow_of(*air.task, everywhere);
  for (std::size_t lane = 0; lane < lanes; lane += width) {
    SecantLanes secant;
    for (std::size_t g = first; g < last; ++g) {
      const Vec3 n = vector(air.groups[g].normal, Many{lane});
      const V share = air.area(g, lane);
      for (const QuadraturePoint& quadrature_point : air.points) {
        const PointLanes point(quadrature_point);
        Vec3 r = point.of(air.places[g], Many{lane});
        if constexpr (on & pillow) r = add(r, vector(air.shift[g - air.first_shift], Many{lane}));
        windward_at<on>(law, air.groups[g], Many{lane}, hn::Mul(share, point.weight), n, r, flow.at(g, lane, r),
                        [&](const Windward& here, const Vec3&, const Vec3& m, V w) { add_windward<on>(secant, here, n, m, w); });
      }
    }
    add(secant, sums, lane);
  }
}

template <unsigned on>
void straight_secant(const Air& air, std::size_t first, std::size_t last, Rows8& sums) {
  const LawLanes law(air.task->law);
  const Everywhere everywhere(air.task->flow);
  const Flow flow = flow_of(*air.task, everywhere);
  for (std::size_t lane = 0; lane < lanes; lane += width) {
    SecantLanes secant;
    for (std::size_t g = first; g < last; ++g) {
      const Vec3 n = vector(air.groups[g].normal, Many{lane});
      const V share = air.area(g, lane);
      for (const QuadraturePoint& quadrature_point : air.points) {
        const PointLanes point(quadrature_point);
        const Vec3 r = point.of(air.places[g], Many{lane});
        straight_at<on>(
            law, air.groups[g], Many{lane}, hn::Mul(share, point.weight), n, r, flow.at(g, lane, r),
            [&](V wetted, const Vec3& t) { secant.rub(wetted, n, t, r, t); },
            [&](V area, V pull, V push, const Vec3&, const Vec3& m, V w) { add_leeward<on>(secant, area, pull, push, n, m, w); });
      }
    }
    add(secant, sums, lane);
  }
}

template <unsigned on>
struct WindwardSecant {
  static constexpr Kernel kernel = windward_secant<on>;
};
template <unsigned on>
struct StraightSecant {
  static constexpr Kernel kernel = straight_secant<either_friction(on)>;
};

}  // namespace

void secant_sums_on_target(const PartTask& task, std::size_t first, std::size_t last, SecantSums& result) {
  static constexpr auto windwards = kernels_of<Kernel, WindwardSecant>(AllWindward());
  static constexpr auto straights = kernels_of<Kernel, StraightSecant>(AllStraight());
  const bool has_two_sides = task.surface->parts[task.part].two_sided;
  const bool has_straight = task.law.leeward || task.law.recovery || task.law.friction || task.law.viscous;
  const Kernel windward_kernel = windwards[windward_effects(task.law, has_two_sides)];
  const Kernel straight_kernel = straights[straight_effects(task.law, has_two_sides)];
  Rows8 sums;
  for_each_block(
      task, first, last,
      [&](const Air& air, std::size_t begin, std::size_t end) {
        if (has_straight) straight_kernel(air, begin, end, sums);
      },
      [&](const Air& air, std::size_t begin, std::size_t end) { windward_kernel(air, begin, end, sums); });
  for (std::size_t row = 0; row < SecantSums::rows; ++row) result.row[row] = total<lanes / 2>(sums.row[row]);
}

}  // namespace dragcore::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace dragcore::kernels {

HWY_EXPORT(secant_sums_on_target);

SecantSums secant_sums(const PartTask& task) {
  const PackedSurface::Range range = task.surface->parts[task.part].groups;
  return in_chunks<SecantSums>(
      range.first, range.last,
      [&](std::size_t first, std::size_t last, SecantSums& chunk) {
        const auto kernel = HWY_DYNAMIC_DISPATCH(secant_sums_on_target);
        kernel(task, first, last, chunk);
      },
      [](SecantSums& all, const SecantSums& more) {
        for (std::size_t row = 0; row < SecantSums::rows; ++row) all.row[row] += more.row[row];
      });
}

}  // namespace dragcore::kernels
#endif
