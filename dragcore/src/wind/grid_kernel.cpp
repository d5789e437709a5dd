#include "wind/grid_kernel.hpp"

#include <algorithm>
#include <cstdint>
#include <limits>

// This file is compiled once for every instruction set; the best one that the machine has is taken at run time.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "wind/grid_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace dragcore::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

constexpr std::size_t group = 16;  // points that are located together, then sampled
constexpr std::size_t block = 64;  // points that cull the grids together

using F = hn::CappedTag<float, group>;
constexpr F f;
using D = hn::CappedTag<double, group / 2>;
constexpr D d;
constexpr std::size_t wide = hn::MaxLanes(D());
using V = hn::Vec<D>;
const hn::Rebind<float, D> narrow;

/// a + s (b - a)
template <class Tag>
HWY_INLINE hn::Vec<Tag> between(Tag tag, hn::Vec<Tag> a, hn::Vec<Tag> b, float s) {
  return hn::MulAdd(hn::Set(tag, s), hn::Sub(b, a), a);
}

/// The row at the fractions (x, y, z) of a cell: its eight corners are four pairs of rows, neighbours along x. Along z and y whole pairs
/// are worked on where a vector holds one.
template <class Tag>
HWY_INLINE void interpolate(Tag pair, const float* cell, std::size_t to_y, std::size_t to_z, float x, float y, float z, float* row) {
  const auto along_yz = [&](auto tag, const float* at) {
    const auto near = between(tag, hn::LoadU(tag, at), hn::LoadU(tag, at + to_y), y);
    return between(tag, near, between(tag, hn::LoadU(tag, at + to_z), hn::LoadU(tag, at + to_y + to_z), y), z);
  };
  if constexpr (hn::MaxLanes(Tag()) == 8) {
    const hn::Half<Tag> one;
    const auto both = along_yz(pair, cell);
    // Without hn:: because vectors of one lane have no halves, and no such function.
    hn::Store(between(one, LowerHalf(one, both), UpperHalf(one, both), x), one, row);
  } else {
    for (std::size_t k = 0; k < 4; k += hn::MaxLanes(Tag()))
      hn::Store(between(pair, along_yz(pair, cell + k), along_yz(pair, cell + 4 + k), x), pair, row + k);
  }
}

class GridSum {
 public:
  bool run(const std::vector<PlacedGrid>& grids, const double* points, std::size_t count, double* velocities) {
    bool finite = true;
    for (std::size_t first = 0; first < count; first += block) {
      const std::size_t here = std::min(block, count - first);
      filled_ = (here + group - 1) / group * group;
      finite &= load(points + 3 * first, here);
      for (auto& axis : sum_) std::fill_n(axis, filled_, 0.0);
      for (const PlacedGrid& grid : grids)
        if (meets(grid)) add(grid);
      for (std::size_t k = 0; k < here; ++k)
        for (std::size_t axis = 0; axis < 3; ++axis) velocities[3 * (first + k) + axis] += sum_[axis][k];
    }
    return finite;
  }

 private:
  /// The block's points axis by axis, and their box. What fills the last group up is the last point again.
  bool load(const double* points, std::size_t count) {
    for (std::size_t k = 0; k < filled_; ++k)
      for (std::size_t axis = 0; axis < 3; ++axis) place_[axis][k] = points[3 * std::min(k, count - 1) + axis];
    constexpr double infinity = std::numeric_limits<double>::infinity();
    auto finite = hn::Eq(hn::Zero(d), hn::Zero(d));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      V low = hn::Set(d, infinity), high = hn::Set(d, -infinity);
      for (std::size_t k = 0; k < filled_; k += wide) {
        const V p = hn::Load(d, place_[axis] + k);
        const auto number = hn::Eq(hn::Sub(p, p), hn::Zero(d));
        finite = hn::And(finite, number);
        low = hn::IfThenElse(number, hn::Min(low, p), low);
        high = hn::IfThenElse(number, hn::Max(high, p), high);
      }
      min_[axis] = hn::GetLane(hn::MinOfLanes(d, low)), max_[axis] = hn::GetLane(hn::MaxOfLanes(d, high));
    }
    return hn::AllTrue(d, finite);
  }

  bool meets(const PlacedGrid& grid) const {
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (grid.box_max[axis] < min_[axis] || grid.box_min[axis] > max_[axis]) return false;
    return true;
  }

  void add(const PlacedGrid& grid) {
    const float* rows = grid.packed->rows.data();
    const auto to_y = static_cast<std::size_t>(grid.points[1] > 1 ? 4 * stride_y(grid) : 0),
               to_z = static_cast<std::size_t>(grid.points[2] > 1 ? 4 * stride_y(grid) * grid.points[1] : 0);
    for (std::size_t first = 0; first < filled_; first += group) {
      if (!locate(grid, first)) continue;
      for (std::size_t k = 0; k < group; ++k)
        interpolate(hn::CappedTag<float, 8>(), rows + 4 * static_cast<std::size_t>(cell_[k]), to_y, to_z, fraction_[0][k], fraction_[1][k],
                    fraction_[2][k], row_ + 4 * k);
      turn(grid, first);
    }
  }

  static std::int64_t stride_y(const PlacedGrid& grid) { return std::max(grid.points[0], 2); }

  /// Cells and fractions of the points of a group, and what the field counts there: nothing outside, less where it fades. Products and sums
  /// are those of double precision, one after the other, so that both find the same points inside.
  /// @return whether it counts anywhere
  bool locate(const PlacedGrid& grid, std::size_t first) {
    const V one = hn::Set(d, 1.0), zero = hn::Zero(d);
    const double stride[3] = {1.0, static_cast<double>(stride_y(grid)), static_cast<double>(stride_y(grid) * grid.points[1])};
    bool any = false;
    for (std::size_t k = 0; k < group; k += wide) {
      V from[3];
      for (std::size_t axis = 0; axis < 3; ++axis)
        from[axis] = hn::Sub(hn::Load(d, place_[axis] + first + k), hn::Set(d, grid.position[axis]));
      auto outside = hn::Gt(zero, zero);
      V cell = zero, distance2 = zero;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto& to_field = grid.to_field[axis];
        const V local = hn::Add(hn::Mul(hn::Set(d, to_field[0]), from[0]),
                                hn::Add(hn::Mul(hn::Set(d, to_field[1]), from[1]), hn::Mul(hn::Set(d, to_field[2]), from[2])));
        const V lower = hn::Set(d, grid.lower[axis]), upper = hn::Set(d, grid.upper[axis]),
                per_metre = hn::Set(d, grid.cells_per_metre[axis]);
        const V last = hn::Set(d, grid.points[axis] - 1);
        outside = hn::Or(outside, hn::Or(hn::Lt(local, lower), hn::Gt(local, upper)));
        const V from_lower = hn::Sub(local, lower), from_upper = hn::Sub(upper, local);
        V t = hn::IfThenElse(hn::Lt(from_lower, from_upper), hn::Mul(from_lower, per_metre), hn::Sub(last, hn::Mul(from_upper, per_metre)));
        t = hn::Min(hn::IfThenElseZero(hn::Gt(t, zero), t), last);  // what is not a number: the first cell
        const V below = hn::Min(hn::Floor(t), hn::Set(d, std::max(grid.points[axis] - 2, 0)));
        hn::Store(hn::DemoteTo(narrow, hn::Sub(t, below)), narrow, fraction_[axis] + k);
        cell = hn::Add(cell, hn::Mul(below, hn::Set(d, stride[axis])));
        const V q = hn::Mul(local, hn::Set(d, grid.per_fade_radius));
        distance2 = hn::Add(distance2, hn::Mul(q, q));
      }
      hn::Store(hn::DemoteTo(hn::Rebind<std::int32_t, D>(), cell), hn::Rebind<std::int32_t, D>(), cell_ + k);
      const V fade = hn::Sub(one, distance2);
      V share = hn::IfThenElseZero(hn::Gt(fade, zero), hn::Mul(fade, fade));
      if (grid.zero_outside) share = hn::IfThenZeroElse(outside, share);
      hn::Store(share, d, share_ + k);
      any |= !hn::AllFalse(d, hn::Gt(share, zero));
    }
    return any;
  }

  /// Into the world's axes, and onto the sum.
  void turn(const PlacedGrid& grid, std::size_t first) {
    HWY_ALIGN float velocity[3][group];
    for (std::size_t k = 0; k < group; k += hn::MaxLanes(F())) {
      hn::Vec<F> x, y, z, nothing;
      hn::LoadInterleaved4(f, row_ + 4 * k, x, y, z, nothing);
      hn::Store(x, f, velocity[0] + k), hn::Store(y, f, velocity[1] + k), hn::Store(z, f, velocity[2] + k);
    }
    for (std::size_t k = 0; k < group; k += wide) {
      const V share = hn::Load(d, share_ + k);
      V local[3];
      for (std::size_t axis = 0; axis < 3; ++axis) local[axis] = hn::Mul(share, hn::PromoteTo(d, hn::Load(narrow, velocity[axis] + k)));
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto& row = grid.turn[axis];
        double* sum = sum_[axis] + first + k;
        V s = hn::MulAdd(hn::Set(d, row[0]), local[0], hn::Load(d, sum));
        s = hn::MulAdd(hn::Set(d, row[1]), local[1], s);
        hn::Store(hn::MulAdd(hn::Set(d, row[2]), local[2], s), d, sum);
      }
    }
  }

  std::size_t filled_ = 0;
  double min_[3], max_[3];
  HWY_ALIGN double place_[3][block];
  HWY_ALIGN double sum_[3][block];
  // Of the group at hand.
  HWY_ALIGN double share_[group];
  HWY_ALIGN float fraction_[3][group];
  HWY_ALIGN float row_[4 * group];
  HWY_ALIGN std::int32_t cell_[group];
};

bool add_grids_on_target(const std::vector<PlacedGrid>& grids, const double* points, std::size_t count, double* velocities) {
  return GridSum().run(grids, points, count, velocities);
}

}  // namespace dragcore::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace dragcore {

HWY_EXPORT(add_grids_on_target);

bool add_grids(const std::vector<PlacedGrid>& grids, const double* points, std::size_t count, double* velocities) {
  return HWY_DYNAMIC_DISPATCH(add_grids_on_target)(grids, points, count, velocities);
}

std::shared_ptr<const PackedGrid> pack(const Grid& grid) {
  const Eigen::Index repeated = grid.points[0] == 1 ? 2 : 1;
  if (repeated * grid.values.cols() > std::numeric_limits<std::int32_t>::max()) return nullptr;
  PackedGrid packed{.rows = std::vector<float>(static_cast<std::size_t>(4 * repeated * grid.values.cols())),
                    .largest = grid.values.cwiseAbs().maxCoeff()};
  if (packed.largest > 0.0) {
    float* row = packed.rows.data();
    for (const auto& value : grid.values.colwise())
      for (Eigen::Index k = 0; k < repeated; ++k, row += 4)
        for (Eigen::Index axis = 0; axis < 3; ++axis) row[axis] = static_cast<float>(value[axis] / packed.largest);
  }
  return std::make_shared<const PackedGrid>(std::move(packed));
}

}  // namespace dragcore
#endif
