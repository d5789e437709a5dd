// In place of the kernels where the library is built without them.
#include "body/pack.hpp"
#include "drag/fast_wrench.hpp"

namespace dragcore {

std::optional<WrenchByTerm> fast_wrench(const Surface&, const Motion&, const Medium&, const Model&) { return std::nullopt; }

std::shared_ptr<const kernels::PackedSurface> kernels::pack(const Surface&) { return nullptr; }

}  // namespace dragcore
