#pragma once

#include <Eigen/Geometry>
#include <dragcore/deforming.hpp>
#include <memory>

#include "drag/body_law.hpp"

namespace dragcore {

/// A law as a triangle that deforms feels it: its local terms.
struct DeformingLaw {
  BodyLaw local;
  bool two_sided;
  double density;  ///< [kg/m^3]

  /// What the air does to each corner of a triangle, a third of its force [N]. Zero without area and without flow; not a number where
  /// an input is none.
  /// @param ab, ac  edges [m]
  /// @param u       velocity of the air relative to the triangle [m/s]
  Eigen::Vector3d corner_force(const Eigen::Vector3d& ab, const Eigen::Vector3d& ac, const Eigen::Vector3d& u) const {
    const Eigen::Vector3d cross = ab.cross(ac);
    const double twice_area = cross.stableNorm(), speed = u.stableNorm();
    if (twice_area == 0.0 || speed == 0.0) return Eigen::Vector3d::Zero();
    const Eigen::Vector3d normal = cross / twice_area;
    const double w = -u.dot(normal), c = std::min(1.0, std::abs(w) / speed);
    const double sixth = density * twice_area / 12.0;  // of density/2 area: there are three corners
    Eigen::Vector3d force = local.friction() * (two_sided ? 2.0 : 1.0) * sixth * speed * (u + w * normal);
    const auto press = [&](Term, const Curve& coefficient) {
      force -= std::copysign(sixth * speed * speed * coefficient.value, w) * normal;  // either side is pressed or pulled downstream
    };
    if (c > 0.0 && (two_sided || w > 0.0))
      local.windward(
          c, [] { return 0.0; }, press);
    if (c > 0.0 && (two_sided || w < 0.0)) local.leeward(c, press);
    return force;
  }
};

/// A force that the kernels and their sums of many can still hold in single precision [N].
inline constexpr double largest_deforming_force = 1e30;

/// A DeformingMesh as the kernels want it, and what they work with.
class FastDeforming {
 public:
  virtual ~FastDeforming() = default;

  /// Checked numbers of vertices and a checked law taken for granted.
  /// @return  false, and nothing written, where a force is beyond `largest_deforming_force` or none, or the law is beyond single precision
  virtual bool forces(VertexArray<const float> position, VertexArray<const float> velocity, VertexArray<const float> wind,
                      const DeformingLaw& law, VertexArray<float> force) = 0;
};

/// Null where the library was built without kernels.
std::unique_ptr<FastDeforming> fast_deforming(std::span<const Eigen::Vector3i> triangles, std::size_t vertices);

}  // namespace dragcore
