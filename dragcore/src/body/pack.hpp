#pragma once

#include <dragcore/surface.hpp>
#include <memory>

namespace dragcore::kernels {

/// A surface as the kernels want it; null where the library was built without them.
std::shared_ptr<const PackedSurface> pack(const Surface& surface);

}  // namespace dragcore::kernels
