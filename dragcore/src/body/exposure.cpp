#include <Eigen/LU>
#include <dragcore/preparation.hpp>

namespace dragcore {

Exposure::Sample Exposure::towards(const Eigen::Vector3d& direction) const {
  Sample best;
  double largest = -1.0;
  const auto try_cell = [&](const Eigen::Vector3i& cell) {
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
  };
  // Nearly always one of the cells at the nearest corner: a product per corner costs a fiftieth of an inverse per cell.
  std::size_t nearest = 0;
  double cosine = -2.0;
  for (std::size_t k = 0; k < directions.size(); ++k)
    if (const double own = directions[k].dot(direction); own > cosine) cosine = own, nearest = k;
  for (const Eigen::Vector3i& cell : cells)
    if ((cell.array() == static_cast<int>(nearest)).any()) try_cell(cell);
  for (std::size_t k = 0; k < cells.size() && largest < 0.0; ++k) try_cell(cells[k]);
  return best;
}

}  // namespace dragcore
