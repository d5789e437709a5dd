#include <Eigen/LU>
#include <dragcore/preparation.hpp>

namespace dragcore {

Exposure::Sample Exposure::towards(const Eigen::Vector3d& direction) const {
  Sample best;
  double largest = -1.0;
  for (const Eigen::Vector3i& cell : cells) {
    Eigen::Matrix3d corners;
    for (int k = 0; k < 3; ++k) corners.col(k) = directions[static_cast<std::size_t>(cell[k])];
    const Eigen::Vector3d weight = corners.inverse() * direction;
    const double sum = weight.sum();
    // On the far side of the sphere the cell has negative weights; on an edge two cells agree, and rounding may leave either a hair
    // outside.
    if (sum > 0.0 && weight.minCoeff() / sum > largest) {
      largest = weight.minCoeff() / sum;
      best = {cell, weight.cwiseMax(0.0) / weight.cwiseMax(0.0).sum()};
    }
    if (largest >= 0.0) break;
  }
  return best;
}

}  // namespace dragcore
