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
const hn::Rebind<std::int32_t, D> whole;

/// a + s (b - a)
template <class Tag>
HWY_INLINE hn::Vec<Tag> between(Tag tag, hn::Vec<Tag> a, hn::Vec<Tag> b, float s) {
  return hn::MulAdd(hn::Set(tag, s), hn::Sub(b, a), a);
}

/// Where the rows of a cell begin that are nearest and next along y, z and both.
struct Corners {
  const float *here, *along_y, *along_z, *along_yz;
};

/// On the line along x through a point of a cell: the value, and its change from one point to the next along y and z.
template <class Vector>
struct OnLine {
  Vector value, slope_y, slope_z;
};

template <class Tag>
HWY_INLINE OnLine<hn::Vec<Tag>> on_line(Tag tag, const Corners& corners, std::size_t at, float y, float z) {
  const auto here = hn::LoadU(tag, corners.here + at), along_z = hn::LoadU(tag, corners.along_z + at);
  const auto near_slope = hn::Sub(hn::LoadU(tag, corners.along_y + at), here);
  const auto far_slope = hn::Sub(hn::LoadU(tag, corners.along_yz + at), along_z);
  const auto near = hn::MulAdd(hn::Set(tag, y), near_slope, here);
  const auto slope_z = hn::Sub(hn::MulAdd(hn::Set(tag, y), far_slope, along_z), near);
  return {hn::MulAdd(hn::Set(tag, z), slope_z, near), between(tag, near_slope, far_slope, z), slope_z};
}

/// The row at the fractions (x, y, z) of a cell, and those of its changes per cell along x, y and z, `next` floats after each other. The
/// eight corners are four pairs of rows, neighbours along x: whole pairs are worked on where a vector holds one.
template <bool with_gradient, class Tag>
HWY_INLINE void interpolate(Tag pair, const Corners& corners, std::size_t cell, float x, float y, float z, float* row, std::size_t next) {
  const auto finish = [&](auto tag, const auto& left, const auto& right, std::size_t k) {
    const auto slope_x = hn::Sub(right.value, left.value);
    hn::Store(hn::MulAdd(hn::Set(tag, x), slope_x, left.value), tag, row + k);
    if constexpr (with_gradient) {
      hn::Store(slope_x, tag, row + next + k);
      hn::Store(between(tag, left.slope_y, right.slope_y, x), tag, row + 2 * next + k);
      hn::Store(between(tag, left.slope_z, right.slope_z, x), tag, row + 3 * next + k);
    }
  };
  if constexpr (hn::MaxLanes(Tag()) == 8) {
    const hn::Half<Tag> one;
    const auto both = on_line(pair, corners, cell, y, z);
    // Without hn:: because vectors of one lane have no halves, and no such functions.
    const OnLine<hn::Vec<hn::Half<Tag>>> left{LowerHalf(one, both.value), LowerHalf(one, both.slope_y), LowerHalf(one, both.slope_z)};
    const OnLine<hn::Vec<hn::Half<Tag>>> right{UpperHalf(one, both.value), UpperHalf(one, both.slope_y), UpperHalf(one, both.slope_z)};
    finish(one, left, right, 0);
  } else {
    for (std::size_t k = 0; k < 4; k += hn::MaxLanes(Tag()))
      finish(pair, on_line(pair, corners, cell + k, y, z), on_line(pair, corners, cell + 4 + k, y, z), k);
  }
}

/// @tparam with_gradient  each point has twelve numbers, as a WindSample, not the three of its velocity
template <bool with_gradient>
class GridSum {
 public:
  static constexpr std::size_t numbers = with_gradient ? 12 : 3;

  bool run(const std::vector<PlacedGrid>& grids, const double* points, std::size_t count, double* sums) {
    bool finite = true;
    HWY_ALIGN double part[3 * block];  // of a block that is not full
    for (std::size_t first = 0; first < count; first += block) {
      const std::size_t here = std::min(block, count - first);
      const double* from = points + 3 * first;
      filled_ = (here + group - 1) / group * group;
      if (here < filled_) {  // the last point again and again
        for (std::size_t k = 0; k < filled_; ++k) std::copy_n(from + 3 * std::min(k, here - 1), 3, part + 3 * k);
        from = part;
      }
      finite &= load(from);
      for (auto& number : sum_) std::fill_n(number, filled_, 0.0);
      for (const PlacedGrid& grid : grids)
        if (meets(grid)) grid.per_fade_radius > 0.0 ? add<true>(grid) : add<false>(grid);
      save(here, sums + numbers * first);
    }
    return finite;
  }

 private:
  /// The block's points axis by axis, and their box.   @return whether all are finite
  bool load(const double* points) {
    const V infinity = hn::Set(d, std::numeric_limits<double>::infinity());
    V low[3] = {infinity, infinity, infinity}, high[3] = {hn::Neg(infinity), hn::Neg(infinity), hn::Neg(infinity)};
    auto finite = hn::Eq(hn::Zero(d), hn::Zero(d));
    for (std::size_t k = 0; k < filled_; k += wide) {
      V p[3];
      hn::LoadInterleaved3(d, points + 3 * k, p[0], p[1], p[2]);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        hn::Store(p[axis], d, place_[axis] + k);
        const auto number = hn::Lt(hn::Abs(p[axis]), infinity);
        finite = hn::And(finite, number);
        low[axis] = hn::Min(low[axis], hn::IfThenElse(number, p[axis], infinity));
        high[axis] = hn::Max(high[axis], hn::IfThenElse(number, p[axis], hn::Neg(infinity)));
      }
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      min_[axis] = hn::GetLane(hn::MinOfLanes(d, low[axis])), max_[axis] = hn::GetLane(hn::MaxOfLanes(d, high[axis]));
    }
    return hn::AllTrue(d, finite);
  }

  void save(std::size_t count, double* sums) const {
    std::size_t k = 0;
    if constexpr (!with_gradient)
      for (; k + wide <= count; k += wide)
        hn::StoreInterleaved3(hn::Load(d, sum_[0] + k), hn::Load(d, sum_[1] + k), hn::Load(d, sum_[2] + k), d, sums + 3 * k);
    for (; k < count; ++k)
      for (std::size_t i = 0; i < numbers; ++i) sums[numbers * k + i] = sum_[i][k];
  }

  bool meets(const PlacedGrid& grid) const {
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (grid.box_max[axis] < min_[axis] || grid.box_min[axis] > max_[axis]) return false;
    return true;
  }

  template <bool fades>
  void add(const PlacedGrid& grid) {
    const float* rows = grid.packed->rows.data();
    const auto [row, line, layer] = grid.strides;
    const std::int64_t to_y = grid.last_cell[1] < grid.last_point[1] ? line : 0, to_z = grid.last_cell[2] < grid.last_point[2] ? layer : 0;
    const Corners corners{rows, rows + to_y, rows + to_z, rows + to_y + to_z};
    // Turned only when the whole block is interpolated: rows that have just been stored one by one cannot yet be loaded as one vector.
    std::size_t hit[block / group], hits = 0;
    for (std::size_t first = 0; first < filled_; first += group) {
      if (!locate<fades>(grid, first)) continue;
      hit[hits++] = first;
      for (std::size_t k = 0; k < group; ++k)
        interpolate<with_gradient>(hn::CappedTag<float, 8>(), corners, static_cast<std::size_t>(cell_[k]), fraction_[0][k], fraction_[1][k],
                                   fraction_[2][k], row_[0] + 4 * (first + k), 4 * block);
    }
    for (std::size_t i = 0; i < hits; ++i) turn<fades>(grid, hit[i]);
  }

  /// Cells and fractions of the points of a group, and the share of the field there: nothing outside, less where it fades. Products and
  /// sums are those of double precision, one after the other, so that both find the same points inside.
  /// @return whether there is any
  template <bool fades>
  HWY_INLINE bool locate(const PlacedGrid& grid, std::size_t first) {
    constexpr std::size_t vectors = group / wide;
    const V one = hn::Set(d, 1.0), zero = hn::Zero(d);
    HWY_ALIGN double from[3][group];
    V depth[vectors], cell[vectors], distance2[vectors];
    for (std::size_t i = 0; i < vectors; ++i) depth[i] = one, cell[i] = distance2[i] = zero;
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (std::size_t k = 0; k < group; k += wide)
        hn::Store(hn::Sub(hn::Load(d, place_[axis] + first + k), hn::Set(d, grid.position[axis])), d, from[axis] + k);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const V to_x = hn::Set(d, grid.to_field[axis][0]), to_y = hn::Set(d, grid.to_field[axis][1]),
              to_z = hn::Set(d, grid.to_field[axis][2]);
      const V lower = hn::Set(d, grid.lower[axis]), upper = hn::Set(d, grid.upper[axis]),
              per_metre = hn::Set(d, grid.cells_per_metre[axis]);
      const V last_point = hn::Set(d, grid.last_point[axis]), last_cell = hn::Set(d, grid.last_cell[axis]);
      const V stride = hn::Set(d, static_cast<double>(grid.strides[axis])), per_fade_radius = hn::Set(d, grid.per_fade_radius);
      for (std::size_t i = 0, k = 0; i < vectors; ++i, k += wide) {
        const V local = hn::Add(hn::Mul(to_x, hn::Load(d, from[0] + k)),
                                hn::Add(hn::Mul(to_y, hn::Load(d, from[1] + k)), hn::Mul(to_z, hn::Load(d, from[2] + k))));
        const V from_lower = hn::Sub(local, lower), from_upper = hn::Sub(upper, local);
        const V inside = hn::Min(from_lower, from_upper);
        depth[i] = hn::Min(depth[i], inside);
        V t = hn::IfThenElse(hn::Lt(from_lower, from_upper), hn::Mul(from_lower, per_metre),
                             hn::Sub(last_point, hn::Mul(from_upper, per_metre)));
        t = hn::Min(hn::IfThenElseZero(hn::Gt(t, zero), t), last_point);  // what is not a number: the first cell
        const V below = hn::Min(hn::Floor(t), last_cell);
        hn::Store(hn::DemoteTo(narrow, hn::Sub(t, below)), narrow, fraction_[axis] + k);
        cell[i] = hn::Add(cell[i], hn::Mul(below, stride));
        if constexpr (fades) {
          const V q = hn::Mul(local, per_fade_radius);
          distance2[i] = hn::Add(distance2[i], hn::Mul(q, q));
          if constexpr (with_gradient) hn::Store(q, d, slope_[axis] + first + k);
        }
        // Clamped: no change beyond the box.
        if constexpr (with_gradient) hn::Store(hn::IfThenZeroElse(hn::Lt(inside, zero), per_metre), d, per_metre_[axis] + first + k);
      }
    }
    auto some = hn::Gt(zero, zero);
    for (std::size_t i = 0, k = 0; i < vectors; ++i, k += wide) {
      hn::Store(hn::DemoteTo(whole, cell[i]), whole, cell_ + k);
      const auto outside = hn::Lt(depth[i], zero);
      V share = one;
      if constexpr (fades) {
        V q = hn::Sub(one, distance2[i]);
        q = hn::IfThenElseZero(hn::Gt(q, zero), q);
        share = hn::Mul(q, q);
        if constexpr (with_gradient) {
          V factor = hn::Mul(hn::Set(d, -4.0 * grid.per_fade_radius), q);
          if (grid.zero_outside) factor = hn::IfThenZeroElse(outside, factor);
          for (auto& slope : slope_) hn::Store(hn::Mul(factor, hn::Load(d, slope + first + k)), d, slope + first + k);
        }
      }
      if (grid.zero_outside) share = hn::IfThenZeroElse(outside, share);
      hn::Store(share, d, share_ + first + k);
      some = hn::Or(some, hn::Gt(share, zero));
    }
    return !hn::AllFalse(d, some);
  }

  /// Into the world's axes, and onto the sum.
  template <bool fades>
  void turn(const PlacedGrid& grid, std::size_t first) {
    HWY_ALIGN float axes[with_gradient ? 12 : 3][group];  // of the value, then of its slopes
    for (std::size_t row = 0; row < numbers / 3; ++row)
      for (std::size_t k = 0; k < group; k += hn::MaxLanes(F())) {
        hn::Vec<F> x, y, z, nothing;
        hn::LoadInterleaved4(f, row_[row] + 4 * (first + k), x, y, z, nothing);
        hn::Store(x, f, axes[3 * row] + k), hn::Store(y, f, axes[3 * row + 1] + k), hn::Store(z, f, axes[3 * row + 2] + k);
      }
    for (std::size_t k = 0; k < group; k += wide) {
      const V share = hn::Load(d, share_ + first + k);
      const auto at = [&](std::size_t i) { return hn::PromoteTo(d, hn::Load(narrow, axes[i] + k)); };
      const auto add_turned = [&](const V(&local)[3], std::size_t axis, V sum) {
        for (std::size_t i = 0; i < 3; ++i) sum = hn::MulAdd(hn::Set(d, grid.turn[axis][i]), local[i], sum);
        return sum;
      };
      const V velocity[3] = {at(0), at(1), at(2)};
      const V local[3] = {hn::Mul(share, velocity[0]), hn::Mul(share, velocity[1]), hn::Mul(share, velocity[2])};
      for (std::size_t axis = 0; axis < 3; ++axis)
        hn::Store(add_turned(local, axis, hn::Load(d, sum_[axis] + first + k)), d, sum_[axis] + first + k);
      if constexpr (with_gradient)
        for (std::size_t along = 0; along < 3; ++along) {  // an axis of the field
          const V per_metre = hn::Mul(share, hn::Load(d, per_metre_[along] + first + k));
          V change[3];
          for (std::size_t i = 0; i < 3; ++i) {
            change[i] = hn::Mul(per_metre, at(3 * along + 3 + i));
            if constexpr (fades) change[i] = hn::MulAdd(velocity[i], hn::Load(d, slope_[along] + first + k), change[i]);
          }
          for (std::size_t axis = 0; axis < 3; ++axis) {
            const V turned = add_turned(change, axis, hn::Zero(d));
            for (std::size_t by = 0; by < 3; ++by) {
              double* sum = sum_[3 + 3 * by + axis] + first + k;
              hn::Store(hn::MulAdd(turned, hn::Set(d, grid.to_field[along][by]), hn::Load(d, sum)), d, sum);
            }
          }
        }
    }
  }

  std::size_t filled_ = 0;
  double min_[3], max_[3];
  HWY_ALIGN double place_[3][block];
  HWY_ALIGN double sum_[with_gradient ? 12 : 3][block];
  // Of the grid at hand.
  HWY_ALIGN double share_[block];
  HWY_ALIGN float row_[with_gradient ? 4 : 1][4 * block];
  HWY_ALIGN double per_metre_[3][with_gradient ? block : 1], slope_[3][with_gradient ? block : 1];
  // Of the group at hand.
  HWY_ALIGN float fraction_[3][group];
  HWY_ALIGN std::int32_t cell_[group];
};

template <bool with_gradient>
bool sum_of_grids_with(const std::vector<PlacedGrid>& grids, const double* points, std::size_t count, double* sums) {
  GridSum<with_gradient> sum;
  return sum.run(grids, points, count, sums);
}

bool sum_of_grids_on_target(const std::vector<PlacedGrid>& grids, const double* points, std::size_t count, double* sums,
                            bool with_gradient) {
  return with_gradient ? sum_of_grids_with<true>(grids, points, count, sums) : sum_of_grids_with<false>(grids, points, count, sums);
}

}  // namespace dragcore::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace dragcore {

HWY_EXPORT(sum_of_grids_on_target);

bool sum_of_grids(const std::vector<PlacedGrid>& grids, const double* points, std::size_t count, double* velocities) {
  return HWY_DYNAMIC_DISPATCH(sum_of_grids_on_target)(grids, points, count, velocities, false);
}

bool sum_of_grids(const std::vector<PlacedGrid>& grids, const double* points, std::size_t count, WindSample* samples) {
  static_assert(sizeof(WindSample) == 12 * sizeof(double));  // velocity, then the gradient by columns
  return HWY_DYNAMIC_DISPATCH(sum_of_grids_on_target)(grids, points, count, samples->velocity.data(), true);
}

std::shared_ptr<const PackedGrid> pack(const Grid& grid) {
  const Eigen::Index repeated = grid.points[0] == 1 ? 2 : 1;
  if (4 * repeated * grid.values.cols() > std::numeric_limits<std::int32_t>::max()) return nullptr;
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
