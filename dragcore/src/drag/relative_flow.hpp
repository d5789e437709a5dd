#pragma once

#include <Eigen/Geometry>
#include <dragcore/drag.hpp>
#include <vector>

#include "drag/active_effects.hpp"
#include "support/cross_matrix.hpp"

namespace dragcore {

/// Velocity of the air relative to the points of a surface: eq. 1.
class RelativeFlow {
 public:
  RelativeFlow(const Surface& surface, const Motion& motion, const ActiveEffects& active)
      : motion_(motion),
        spin_(active.has<Effect::spin>()),
        per_triangle_(false),
        gradient_(false),
        surface_(surface),
        uniform_(motion.wind - motion.velocity) {
    if (active.has<Effect::wind_variation>()) {
      per_triangle_ = !motion.triangle_wind.empty();
      gradient_ = !per_triangle_ && !motion.wind_gradient.isZero(0.0);
    }
    if (per_triangle_) {
      mean_.assign(surface.parts.size(), Eigen::Vector3d::Zero());
      for (Eigen::Index i = 0; i < surface.size(); ++i) {
        instrument::count(Effect::wind_variation);
        mean_[part_of(surface, i)] += surface.area[i] * motion.triangle_wind[static_cast<std::size_t>(i)];
      }
      for (std::size_t p = 0; p < mean_.size(); ++p)
        mean_[p] = surface.parts[p].area > 0.0 ? Eigen::Vector3d(mean_[p] / surface.parts[p].area - motion.velocity) : uniform_;
    }
    // Of the relative flow: its rate of strain, and its turning. Air that turns with the body does not vary.
    if (spin_) turning_ = motion.angular_velocity;
    if (gradient_) {
      const Eigen::Matrix3d& G = motion.wind_gradient;
      turning_ -= 0.5 * Eigen::Vector3d(G(2, 1) - G(1, 2), G(0, 2) - G(2, 0), G(1, 0) - G(0, 1));
      variation_ = 0.5 * (G + G.transpose()).norm();
    }
    variation_ += turning_.norm();
  }

  static std::size_t part_of(const Surface& surface, Eigen::Index triangle) {
    return static_cast<std::size_t>(surface.part[static_cast<std::size_t>(triangle)]);
  }

  static std::size_t patch_of(const Surface& surface, Eigen::Index triangle) {
    return static_cast<std::size_t>(surface.patch[static_cast<std::size_t>(triangle)]);
  }

  /// At a point of a triangle, and at the centre of a part.
  Eigen::Vector3d at(const Eigen::Vector3d& r, Eigen::Index triangle) const {
    return moved(per_triangle_ ? Eigen::Vector3d(motion_.triangle_wind[static_cast<std::size_t>(triangle)] - motion_.velocity) : uniform_,
                 r);
  }
  Eigen::Vector3d at_centre(std::size_t part) const { return at_place(part, surface_.parts[part].centre); }
  /// Anywhere in a part, in the mean of its winds.
  Eigen::Vector3d at_place(std::size_t part, const Eigen::Vector3d& r) const { return moved(per_triangle_ ? mean_[part] : uniform_, r); }
  /// Of the body relative to the air [rad/s].
  const Eigen::Vector3d& turning() const { return turning_; }
  /// A spinning body has no one direction of flow: what depends on it (descriptors, pillow, exposure) fades by this share as the spin takes
  /// over, and a tumbling body is left with the local terms. 1 without spin.
  double directed(std::size_t part) const {
    const double travel = at_centre(part).squaredNorm(), turned = variation_ * surface_.parts[part].radius;
    return travel > 0.0 ? travel / (travel + turned * turned) : 0.0;
  }

  /// Of the relative flow by place: (i, j) = d u_i / d x_j [1/s].
  Eigen::Matrix3d gradient() const {
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    if (gradient_) sum = motion_.wind_gradient;
    if (spin_) sum -= cross_matrix(motion_.angular_velocity);
    return sum;
  }

  /// Whether the velocity differs between the points of one triangle, and a bound of how much per metre.
  bool varies_on_triangles() const { return spin_ || gradient_; }
  bool varies_by_triangle() const { return per_triangle_; }
  bool varies() const { return varies_on_triangles() || per_triangle_; }
  double variation_per_metre() const { return variation_; }

 private:
  Eigen::Vector3d moved(Eigen::Vector3d u, const Eigen::Vector3d& r) const {
    const Eigen::Vector3d arm = r - motion_.reference_point;
    if (gradient_) {
      instrument::count(Effect::wind_variation);
      u += motion_.wind_gradient * arm;
    }
    if (spin_) {
      instrument::count(Effect::spin);
      u -= motion_.angular_velocity.cross(arm);
    }
    return u;
  }

  const Motion& motion_;
  bool spin_, per_triangle_, gradient_;
  const Surface& surface_;
  Eigen::Vector3d uniform_;
  std::vector<Eigen::Vector3d> mean_;  // over every part, of winds by triangle
  Eigen::Vector3d turning_ = Eigen::Vector3d::Zero();
  double variation_ = 0.0;
};

}  // namespace dragcore
