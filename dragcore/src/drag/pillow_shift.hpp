#pragma once

#include <cmath>
#include <vector>

#include "drag/relative_flow.hpp"

namespace dragcore {

/// Where the pillow effect displaces windward pressure: along the flow that the part meets at its centre, not along the velocity of its own
/// spin. A face that only turns has no leading edge. Were the shift to follow the spin, it would feed it: a falling ball began to turn.
class PillowShift {
 public:
  PillowShift(const Surface& surface, const RelativeFlow& flow, const Pillow& pillow, bool active)
      : surface_(surface), flow_(flow), pillow_(pillow), active_(active) {
    if (!active || pillow.form != PillowForm::patch) return;
    for (std::size_t p = 0; p < surface.patches.size(); ++p) patches_.push_back(of_patch(p));  // one for all of its triangles
  }

  Eigen::Vector3d of(Eigen::Index triangle) const {
    using Eigen::Vector3d;
    const std::size_t part = RelativeFlow::part_of(surface_, triangle);
    const double directed = active_ ? flow_.directed(part) : 0.0;
    if (!(directed > 0.0)) return Vector3d::Zero();
    const Vector3d normal = surface_.normal.row(triangle).matrix(), centroid = surface_.centroid.row(triangle).matrix();
    if (pillow_.form == PillowForm::patch) return directed * patches_[RelativeFlow::patch_of(surface_, triangle)];
    const Vector3d& u = flow_.at_centre(part);
    if (!surface_.parts[part].two_sided && !flow_.varies() && u.dot(normal) >= 0.0) return Vector3d::Zero();
    instrument::count(Effect::pillow);
    if (pillow_.form == PillowForm::tilt)
      return directed * tilt_pillow_shift(normal, symmetric(surface_.second_moment.row(triangle)), u, pillow_.factor);
    const Vector3d ab = surface_.edge_ab.row(triangle).matrix(), ac = surface_.edge_ac.row(triangle).matrix();
    const Vector3d a = centroid - (ab + ac) / 3.0;
    return directed * faded(u, normal, [&](double alpha) {
             return pillow_.form == PillowForm::eccentricity ? eccentricity_pillow_shift(a, a + ab, a + ac, u, alpha)
                                                             : triangle_pillow_shift(a, a + ab, a + ac, u, alpha, pillow_.falloff);
           });
  }

 private:
  Eigen::Vector3d of_patch(std::size_t index) const {
    const Patch& patch = surface_.patches[index];
    const Part& part = surface_.parts[static_cast<std::size_t>(patch.part)];
    const Eigen::Vector3d& u = flow_.at_centre(static_cast<std::size_t>(patch.part));
    const bool leeward = !part.two_sided && !flow_.varies() && u.dot(patch.normal) >= 0.0;
    if (leeward) return Eigen::Vector3d::Zero();  // as a whole: nothing to displace
    instrument::count(Effect::pillow);
    return faded(u, patch.normal, [&](double alpha) { return patch_pillow_shift(patch, u, alpha, pillow_.falloff); });
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
