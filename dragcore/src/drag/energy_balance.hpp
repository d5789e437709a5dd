#pragma once

#include <cmath>

#include "drag/local_forces.hpp"

namespace dragcore {

/// A vector quantity summed over a surface, apart for what takes energy from the body's motion through the air and for what gives it.
/// The second is held below `largest_gain` of the first: eq. 13.
class EnergyBalance {
 public:
  void add(const LocalForce& local) {
    const double power = local.force().dot(local.u);
    (local.coefficient.value < 0.0 ? given_ : taken_) += std::abs(power);
  }
  void add(double taken, double given) { taken_ += taken, given_ += given; }
  bool has_gain() const { return given_ > 0.0; }
  /// Factor in [0, 1] on everything that gives: 1 - x^8/8 for little of it, never more than largest_gain * taken / given. Smooth.
  double gain_share() const {
    const double bound = largest_gain * taken_;
    if (!(given_ > 0.0078125 * bound)) return 1.0;  // to the last bit
    // (1 + x^8)^(-1/8)
    const auto held = [](double x) {
      const double square = x * x, fourth = square * square;
      return 1.0 / std::sqrt(std::sqrt(std::sqrt(1.0 + fourth * fourth)));
    };
    return given_ <= bound ? held(given_ / bound) : bound / given_ * held(bound / given_);
  }

 private:
  double taken_ = 0.0, given_ = 0.0;
};

}  // namespace dragcore
