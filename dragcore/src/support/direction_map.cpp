#include <cmath>
#include <dragcore/direction_map.hpp>

namespace dragcore {

Eigen::Vector3d DirectionMap::direction(int node) const {
  const int i = node % side() - frequency, j = node / side() - frequency, k = frequency - std::abs(i) - std::abs(j);
  // Integers, and no -0: nodes on the rim that are the same direction are the same numbers.
  if (k >= 0) return Eigen::Vector3d(i, j, k).normalized();
  return Eigen::Vector3d((i < 0 ? -1 : 1) * (frequency - std::abs(j)), (j < 0 ? -1 : 1) * (frequency - std::abs(i)), k).normalized();
}

DirectionMap DirectionMap::zero(int frequency, int columns) {
  DirectionMap map{frequency, columns, {}};
  map.values.assign(8u * static_cast<std::size_t>(map.nodes()) * static_cast<std::size_t>(columns), 0.0f);
  return map;
}

void DirectionMap::set(int node, int column, const Eigen::Vector3d& force, const Eigen::Vector3d& torque) {
  float* to = values.data() + 8 * (static_cast<std::size_t>(node) * columns + column);
  Eigen::Map<Eigen::Vector3f>{to} = force.cast<float>();
  Eigen::Map<Eigen::Vector3f>{to + 4} = torque.cast<float>();
}

}  // namespace dragcore
