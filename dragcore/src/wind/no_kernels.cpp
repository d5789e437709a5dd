// In place of the kernels where the library is built without them.
#include "wind/batch_kernels.hpp"
#include "wind/grid_kernel.hpp"

namespace dragcore {

std::shared_ptr<const PackedGrid> pack(const Grid&) { return nullptr; }

bool sum_of_grids(const std::vector<PlacedGrid>&, const double*, std::size_t, double*) { return true; }

bool sum_of_grids(const std::vector<PlacedGrid>&, const double*, std::size_t, WindSample*) { return true; }

bool gust_factors_by_kernel(const Gust&, std::span<const double>, std::span<double>) { return false; }

bool step_by_kernel(const Follower&, std::span<FollowerState>, std::span<const Eigen::Vector3d>, double) { return false; }

bool sum_of_waves(const Waves&, const double*, std::size_t, double*) { return false; }

std::size_t first_doubtful_follower(std::span<const FollowerState>, std::span<const Eigen::Vector3d>) { return 0; }

}  // namespace dragcore
