#pragma once

#include <dragcore/drag.hpp>
#include <optional>

namespace dragcore {

/// What the secant matrix of resistance() is made of, about the reference point. Force, then torque.
struct Secant {
  Eigen::Matrix<double, 6, 6> taken = Eigen::Matrix<double, 6, 6>::Zero();  ///< of the terms that hold back: their wrench over the velocity
  Eigen::Vector<double, 6> given = Eigen::Vector<double, 6>::Zero();        ///< wrench of the terms that push
  double given_power = 0.0;                                                 ///< of these, at least 0 [W]
};

/// By the kernels, as fast_wrench().
/// @accuracy  1e-6 of density/2 speed area, and times the radius for every moment; raised by as much, so that rounding leaves no negative
///            eigenvalue
std::optional<Secant> fast_secant(const Surface& surface, const Motion& motion, const Medium& medium, const Model& model);

}  // namespace dragcore
