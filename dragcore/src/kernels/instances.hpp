#pragma once

#include <dragcore/batch.hpp>
#include <span>

namespace dragcore::kernels {

/// Bodies that are one at once at most.
inline constexpr std::size_t instances = 16;

/// Whether bodies of this shape and model go sixteen at once, one a lane: small shapes in one part, without exposure.
bool instanced(const Surface& surface, const Model& model);

/// Whether the flow varies over a body that moves like this, winds by triangle aside.
bool varies(const Motion& motion);

/// Bodies of one shape and model, all or none of whose motions vary, for which instanced() holds. A set bit says that a body was not done:
/// what it is given is out of range, or beyond single precision.
/// @param bodies  not more than `instances`
unsigned wrenches_of(std::span<const BodyInFlow* const> bodies, const Medium& medium, std::span<Wrench* const> results);
unsigned steps_of(std::span<const FreeBody* const> bodies, const Medium& medium, double dt, std::span<Vector6d* const> velocities);

}  // namespace dragcore::kernels
