#pragma once

#include <dragcore/stepping.hpp>
#include <span>

namespace dragcore {

// Many bodies at once. Sixteen of one small shape cost little more than one, so bodies had better share their Surface and Model. Built with
// oneTBB (DRAGCORE_THREADS), the work goes to the threads of the caller's arena: tbb::task_arena or tbb::global_control limit them. The
// number of threads does not change a bit.

/// A body in the air: what wrench() takes. Pointers are not owned, and not null.
struct BodyInFlow {
  const Surface* surface = nullptr;
  const Model* model = nullptr;
  Motion motion{};
};

/// The total wrench of every body: force [N], torque about its `reference_point` [N m], in its body frame.
/// @throws std::invalid_argument  as wrench() does, for the first body that has something wrong, by its number: all others have their
///                                results then; and unless there is room for every body's
/// @accuracy  that of the model's Precision
void wrenches(std::span<const BodyInFlow> bodies, const Medium& medium, std::span<Wrench> results);

/// A rigid body that moves freely. Its centre of mass is `motion.reference_point`.
struct FreeBody {
  const Surface* surface = nullptr;
  const Model* model = nullptr;
  const MassProperties* mass = nullptr;
  Motion motion{};
  Vector6d external = Vector6d::Zero();  ///< what else acts: force [N], torque about the centre of mass [N m], body frame
};

/// Velocity and spin of every body after `dt`, in the frame of its body as it is now: gyroscopic_spin(), resistance() and
/// step_secant_implicit() of each, with what wind_excess() says where the wind varies over a body.
/// @throws std::invalid_argument  as these do, for the first body that has something wrong
/// @accuracy  that of the model's Precision
void step_free_bodies(std::span<const FreeBody> bodies, const Medium& medium, double dt, std::span<Vector6d> velocities);

}  // namespace dragcore
