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
    if (!(given_ > 0.0)) return 1.0;
    const double bound = largest_gain * taken_;
    const auto eighth = [](double x) { return x * x * x * x * x * x * x * x; };
    if (given_ <= bound) return std::pow(1.0 + eighth(given_ / bound), -0.125);
    return bound / given_ * std::pow(1.0 + eighth(bound / given_), -0.125);
  }

 private:
  double taken_ = 0.0, given_ = 0.0;
};

}  // namespace dragcore
