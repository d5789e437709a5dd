#pragma once

#include <dragcore/drag.hpp>
#include <optional>

namespace dragcore {

/// wrench() by the kernels, checked input taken for granted. Empty where the model asks for full precision, or for what the kernels do not
/// know.
/// @accuracy  1e-6 of density/2 speed^2 area (tests/dragcore/kernels/test_wrench_kernel.cpp)
std::optional<WrenchByTerm> fast_wrench(const Surface& surface, const Motion& motion, const Medium& medium, const Model& model);

}  // namespace dragcore
