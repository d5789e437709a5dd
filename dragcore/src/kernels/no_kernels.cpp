// In place of the kernels where the library is built without them.
#include "body/pack.hpp"
#include "drag/fast_deforming.hpp"
#include "drag/fast_wrench.hpp"
#include "drag/secant.hpp"
#include "kernels/instances.hpp"

namespace dragcore {

bool fast_wrench(const Surface&, const Motion&, const Medium&, const Model&, WrenchByTerm&) { return false; }

std::shared_ptr<const kernels::PackedSurface> kernels::pack(const Surface&) { return nullptr; }

bool kernels::instanced(const Surface&, const Model&) { return false; }
bool kernels::varies(const Motion&) { return false; }
unsigned kernels::wrenches_of(std::span<const BodyInFlow* const>, const Medium&, std::span<Wrench* const>) { return ~0u; }
unsigned kernels::steps_of(std::span<const FreeBody* const>, const Medium&, double, std::span<Vector6d* const>) { return ~0u; }

std::unique_ptr<FastDeforming> fast_deforming(std::span<const Eigen::Vector3i>, std::size_t) { return nullptr; }

std::optional<Secant> fast_secant(const Surface&, const Motion&, const Medium&, const Model&) { return std::nullopt; }

}  // namespace dragcore
