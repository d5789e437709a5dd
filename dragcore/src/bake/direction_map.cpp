#include <cmath>
#include <dragcore/bake.hpp>

namespace dragcore {

Eigen::Vector3d DirectionMap::direction(int node) const {
  const int i = node % side() - frequency, j = node / side() - frequency, k = frequency - std::abs(i) - std::abs(j);
  // Integers, and no -0: nodes on the rim that are the same direction are the same numbers.
  if (k >= 0) return Eigen::Vector3d(i, j, k).normalized();
  return Eigen::Vector3d((i < 0 ? -1 : 1) * (frequency - std::abs(j)), (j < 0 ? -1 : 1) * (frequency - std::abs(i)), k).normalized();
}

}  // namespace dragcore
