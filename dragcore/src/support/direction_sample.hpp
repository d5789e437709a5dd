#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <dragcore/direction_map.hpp>

namespace dragcore {

/// 1, or -1 of what has a minus.
inline int sign_of(double x) { return 1 - 2 * static_cast<int>(std::bit_cast<std::uint64_t>(x) >> 63); }

/// @param direction  any length; the sum of the absolute components must be a normal number
[[gnu::always_inline]] inline DirectionMap::Sample direction_sample(const DirectionMap& map, const Eigen::Vector3d& direction) {
  // Without branches: directions are often random, and a branch guessed wrong costs more than all of this.
  const double scale = map.frequency / (std::abs(direction.x()) + std::abs(direction.y()) + std::abs(direction.z()));
  // The lower half is folded out over the diagonals of the square, on which z = 0: (x, y) -> (1 - y, 1 - x).
  const double fold = 0.5 * (std::abs(direction.z()) - direction.z());
  const double across = scale * (std::abs(direction.x()) + fold), up = scale * (std::abs(direction.y()) + fold);
  const int i = std::min(static_cast<int>(across), map.frequency - 1), j = std::min(static_cast<int>(up), map.frequency - 1);
  const float a = static_cast<float>(across - i), b = static_cast<float>(up - j);
  // Cells are cut along the same diagonals, so that no triangle lies on both sides of z = 0. Its third corner is the one to which `rest`
  // belongs: the cell's inner one, or, where `rest` is negative, the outer one.
  const float rest = 1.0f - a - b, beyond = std::min(rest, 0.0f);
  const int column = sign_of(direction.x()), row = map.side() * sign_of(direction.y());
  const int corner = map.frequency * (map.side() + 1) + i * column + j * row;
  return {{corner + (rest < 0.0f) * (column + row), corner + column, corner + row}, {std::abs(rest), a + beyond, b + beyond}};
}

}  // namespace dragcore
