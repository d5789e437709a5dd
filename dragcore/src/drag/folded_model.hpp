#pragma once

#include <dragcore/drag.hpp>

namespace dragcore {

/// What of a model does not change from call to call, worked out once. Every thread remembers the last few models it has seen, by their
/// numbers.
struct FoldedModel {
  bool valid = false;   ///< all numbers are in the ranges that wrench() states
  bool single = false;  ///< the kernels have its laws and pillows, and their numbers fit into single precision

  /// Valid until the next call in this thread.
  static const FoldedModel& of(const Model& model);
};

/// Whether a polynomial is never negative from 0 to 1, by its Bernstein coefficients: enough of a reason, though not the only one.
bool never_negative(const Law::Polynomial& p);

}  // namespace dragcore
