#pragma once

#include "kernels/wrench_kernel.hpp"

namespace dragcore::kernels {

/// Sums over a part of what its secant matrix is made of, in units of density/2 speed area, lengths from its origin in units of its size.
/// Of pressures k (n.u) along n with moment m = r x n: k n n^T (6: xx, xy, xz, yy, yz, zz), k n m^T (9), k m m^T (6). Of friction k u at r:
/// k (1), k r (3), k r r^T (6), and what of it is along n as a negative pressure. Of what pushes: force (3), torque (3), power (1), in
/// units of a speed more, and of two.
struct SecantSums {
  static constexpr std::size_t normal = 0, mixed = 6, moment = 15, rubbed = 21, rubbed_first = 22, rubbed_second = 25, given = 31,
                               given_power = 37, rows = 38;
  /// Added to the diagonals of force and of torque, as a share of their traces: a sum of dyads is never negative along an axis, but in
  /// float it may come out negative by its rounding. Seven last bits of 6e-8: each entry is rounded two or three times, and so is its sum.
  /// Less than what single precision promises, so that it is not felt. test_secant_kernel.cpp tries it.
  static constexpr double rounding = 4e-7;
  std::array<double, rows> row{};
};

/// @param task  taken to vary, whatever its flow: all points of the rule count
SecantSums secant_sums(const PartTask& task);

}  // namespace dragcore::kernels
