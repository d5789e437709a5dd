#pragma once

#include <cmath>
#include <vector>

#include "drag/relative_flow.hpp"

namespace dragcore {

/// Where the pillow effect displaces windward pressure.
class PillowShift {
 public:
  PillowShift(const Surface& surface, const RelativeFlow& flow, const Pillow& pillow, const ActiveEffects& active)
      : surface_(surface), flow_(flow), pillow_(pillow), active_(active.has<Effect::pillow>()) {
    if (!active_ || (pillow.form != PillowForm::patch && pillow.form != PillowForm::tilt)) return;
    patches_.reserve(surface.patches.size());
    for (std::size_t p = 0; p < surface.patches.size(); ++p) {
      const Patch& patch = surface.patches[p];
      const Eigen::Vector3d u = flow.at_patch(patch, p);
      if (!surface.two_sided() && !flow.varies() && u.dot(patch.normal) >= 0.0) {
        patches_.emplace_back(Eigen::Vector3d::Zero());  // leeward as a whole: nothing to displace
        continue;
      }
      instrument::count(Effect::pillow);
      const auto falls_off = [&](double alpha) { return patch_pillow_shift(patch, u, alpha, pillow.falloff); };
      const Eigen::Vector3d shift =
          pillow.form == PillowForm::tilt ? tilt_pillow_shift(patch, u, pillow.factor) : faded(u, patch.normal, falls_off);
      patches_.emplace_back(directed(u, patch.second_moment.trace()) * shift);
    }
  }

  Eigen::Vector3d of(Eigen::Index triangle) const {
    if (!active_) return Eigen::Vector3d::Zero();
    if (!patches_.empty()) return patches_[RelativeFlow::patch_of(surface_, triangle)];
    instrument::count(Effect::pillow);
    const Eigen::Vector3d normal = surface_.normal.row(triangle).matrix(), centroid = surface_.centroid.row(triangle).matrix();
    const Eigen::Vector3d ab = surface_.edge_ab.row(triangle).matrix(), ac = surface_.edge_ac.row(triangle).matrix();
    const Eigen::Vector3d u = flow_.at(centroid, triangle), a = centroid - (ab + ac) / 3.0;
    const double square_radius = (ab.squaredNorm() + ac.squaredNorm() - ab.dot(ac)) / 18.0;
    return directed(u, square_radius) * faded(u, normal, [&](double alpha) {
             return pillow_.form == PillowForm::eccentricity ? eccentricity_pillow_shift(a, a + ab, a + ac, u, alpha)
                                                             : triangle_pillow_shift(a, a + ab, a + ac, u, alpha, pillow_.falloff);
           });
  }

 private:
  /// Where the air turns about a face more than it passes it there is no leading edge: as BodyLaw does with what depends on one direction
  /// of flow.
  double directed(const Eigen::Vector3d& u, double square_radius) const {
    const double travel = u.squaredNorm(), variation = flow_.variation_per_metre();
    return travel > 0.0 ? travel / (travel + variation * variation * square_radius) : 0.0;
  }

  /// Under the note's factor, faded at normal incidence.
  template <class ShiftOf>
  Eigen::Vector3d faded(const Eigen::Vector3d& u, const Eigen::Vector3d& normal, ShiftOf shift_of) const {
    const double speed = u.norm();
    if (!(speed > 0.0)) return Eigen::Vector3d::Zero();
    return shift_of(faded_pillow_factor(pillow_.factor, std::abs(u.dot(normal)) / speed));
  }

  const Surface& surface_;
  const RelativeFlow& flow_;
  const Pillow& pillow_;
  bool active_;
  std::vector<Eigen::Vector3d> patches_;
};

}  // namespace dragcore
