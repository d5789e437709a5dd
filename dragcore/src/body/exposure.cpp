#include <Eigen/LU>
#include <dragcore/preparation.hpp>

namespace dragcore {

Exposure::Sample Exposure::towards(const Eigen::Vector3d& direction) const {
  Sample best;
  // Of cells that follow each other the one that holds the direction, or -1. On the far side of the sphere a cell has negative weights; on
  // an edge two cells agree, and rounding may leave either a hair outside.
  const auto holding = [&](int first, int count) {
    int found = -1;
    double largest = 0.0;
    for (int k = first; k < first + count; ++k) {
      const Eigen::Vector3i& cell = cells[static_cast<std::size_t>(k)].corner;
      Eigen::Matrix3d corners;
      for (int c = 0; c < 3; ++c) corners.col(c) = directions[static_cast<std::size_t>(cell[c])];
      const Eigen::Vector3d weight = corners.inverse() * direction;
      const double sum = weight.sum();
      if (!(sum > 0.0)) continue;
      if (const double own = weight.minCoeff() / sum; found < 0 || own > largest) {
        largest = own;
        found = k;
        best = {cell, weight.cwiseMax(0.0) / weight.cwiseMax(0.0).sum()};
      }
    }
    return found;
  };
  for (int at = holding(0, 20); at >= 0 && cells[static_cast<std::size_t>(at)].children > 0;) {
    const Cell& cut = cells[static_cast<std::size_t>(at)];
    at = holding(cut.child, cut.children);
  }
  return best;
}

}  // namespace dragcore
