#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <dragcore/wind.hpp>
#include <memory>
#include <vector>

namespace dragcore {

/// Values of a grid in single precision, in units of `largest`. A point is a row of four floats, the last of them nothing, so that one load
/// brings it; x is fastest, and a grid of one point along x has it twice, so that a cell is always two neighbours in memory.
struct PackedGrid {
  std::vector<float> rows;
  double largest = 0.0;  ///< absolute value of a component [m/s]
};

/// Empty where the library is built without kernels, and for grids of 2^29 points and more.
std::shared_ptr<const PackedGrid> pack(const Grid& grid);

/// A grid in the world: (W1) of docs/wind.md in plain numbers.
struct PlacedGrid {
  std::shared_ptr<const PackedGrid> packed;
  std::array<std::int64_t, 3> strides{};            ///< from a point to the next along an axis, in floats
  std::array<double, 3> last_point{}, last_cell{};  ///< numbers, from 0
  std::array<double, 3> lower{}, upper{}, cells_per_metre{}, position{};
  std::array<std::array<double, 3>, 3> to_field{}, turn{};  ///< by rows; `turn` times the largest value
  bool zero_outside = true;
  double per_fade_radius = 0.0;  ///< 0: does not fade [1/m]
  std::array<double, 3> box_min{}, box_max{};
};

/// The sum of all grids at `count` points, x y z after each other: velocities likewise, or samples. A point's result does not depend on the
/// points beside it.
/// @return whether all points are finite; of one that is not the result is some number
/// @accuracy  where a point lies, and whether inside: as in double precision. Velocities: 1e-6 of the grid's largest value; gradients: of
///            that per cell
bool sum_of_grids(const std::vector<PlacedGrid>& grids, const double* points, std::size_t count, double* velocities);
bool sum_of_grids(const std::vector<PlacedGrid>& grids, const double* points, std::size_t count, WindSample* samples);

}  // namespace dragcore
