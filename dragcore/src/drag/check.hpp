#pragma once

#include <dragcore/drag.hpp>

namespace dragcore {

/// @throws std::invalid_argument as wrench() says; where the model does without checks, only the length of `triangle_wind` is looked at
void check_input(const Surface& surface, const Motion& motion, const Medium& medium, const Model& model);
void check_input(const Motion& motion, const Medium& medium, const Model& model);
void check_model(const Model& model);
/// @throws std::overflow_error  when a checked result is not finite
void check_result(bool finite, const Model& model);

}  // namespace dragcore
