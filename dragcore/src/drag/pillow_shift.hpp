#pragma once

#include <cmath>
#include <vector>

#include "drag/relative_flow.hpp"

namespace dragcore {

/// Where the pillow effect displaces windward pressure: along the flow that the part meets at its centre, not along the velocity of its own
/// spin. A face that only turns has no leading edge. Were the shift to follow the spin, it would feed it: a falling ball began to turn.
class PillowShift {
 public:
  PillowShift(const Surface& surface, std::size_t part, const RelativeFlow& flow, const Pillow& pillow, bool active)
      : surface_(surface),
        part_(surface.parts[part]),
        pillow_(pillow),
        u_(flow.at_centre(part)),
        directed_(active ? flow.directed(part) : 0.0),
        varies_(flow.varies()) {
    if (!active || pillow.form != PillowForm::patch) return;
    for (const Patch& patch : surface.patches)  // one for all of its triangles
      patches_.push_back(static_cast<std::size_t>(patch.part) == part ? of_patch(patch) : Eigen::Vector3d(Eigen::Vector3d::Zero()));
  }

  Eigen::Vector3d of(Eigen::Index triangle) const {
    using Eigen::Vector3d;
    if (!(directed_ > 0.0)) return Vector3d::Zero();
    const Vector3d normal = surface_.normal.row(triangle).matrix(), centroid = surface_.centroid.row(triangle).matrix();
    if (pillow_.form == PillowForm::patch) return directed_ * patches_[RelativeFlow::patch_of(surface_, triangle)];
    if (leeward(normal)) return Vector3d::Zero();
    instrument::count(Effect::pillow);
    if (pillow_.form == PillowForm::tilt)
      return directed_ * tilt_pillow_shift(normal, symmetric(surface_.second_moment.row(triangle)), u_, pillow_.factor);
    const Vector3d ab = surface_.edge_ab.row(triangle).matrix(), ac = surface_.edge_ac.row(triangle).matrix();
    const Vector3d a = centroid - (ab + ac) / 3.0;
    return directed_ * faded(normal, [&](double alpha) {
             return pillow_.form == PillowForm::eccentricity ? eccentricity_pillow_shift(a, a + ab, a + ac, u_, alpha)
                                                             : triangle_pillow_shift(a, a + ab, a + ac, u_, alpha, pillow_.falloff);
           });
  }

 private:
  /// As a whole: nothing to displace.
  bool leeward(const Eigen::Vector3d& normal) const { return !part_.two_sided && !varies_ && u_.dot(normal) >= 0.0; }

  Eigen::Vector3d of_patch(const Patch& patch) const {
    if (leeward(patch.normal)) return Eigen::Vector3d::Zero();
    instrument::count(Effect::pillow);
    return faded(patch.normal, [&](double alpha) { return patch_pillow_shift(patch, u_, alpha, pillow_.falloff); });
  }

  /// Under the note's factor, faded at normal incidence.
  template <class ShiftOf>
  Eigen::Vector3d faded(const Eigen::Vector3d& normal, ShiftOf shift_of) const {
    const double speed = u_.norm();
    if (!(speed > 0.0)) return Eigen::Vector3d::Zero();
    return shift_of(faded_pillow_factor(pillow_.factor, std::abs(u_.dot(normal)) / speed));
  }

  const Surface& surface_;
  const Part& part_;
  Pillow pillow_;
  Eigen::Vector3d u_;
  double directed_;
  bool varies_;
  std::vector<Eigen::Vector3d> patches_;
};

}  // namespace dragcore
