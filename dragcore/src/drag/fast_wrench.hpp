#pragma once

#include <dragcore/drag.hpp>

namespace dragcore {

/// wrench() by the kernels, checked input taken for granted.
/// @param result  zero at first
/// @return        false where the model asks for full precision, or for what the kernels do not know: `result` means nothing then
/// @accuracy      1e-6 of density/2 speed^2 area (tests/dragcore/kernels/test_wrench_kernel.cpp)
bool fast_wrench(const Surface& surface, const Motion& motion, const Medium& medium, const Model& model, WrenchByTerm& result);

}  // namespace dragcore
