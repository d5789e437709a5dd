// The model, equation by equation, in double precision. Slow on purpose: every quantity is made where it is used.

#include <dragcore/drag.hpp>

#include <Eigen/Geometry>
#include <cmath>

#include "quadrature.hpp"

namespace dragcore::reference {

using Eigen::Vector3d;

WrenchByTerm wrench(const TriangleMesh& mesh, Surface::Sides sides, const Motion& motion, const Medium& medium, const Model& model) {
  check_input(motion, medium, model);
  const Surface surface(mesh, sides);  // for its planar patches
  WrenchByTerm result;

  // Eq. 1: velocity of the air relative to the surface.
  const auto u = [&](const Vector3d& r) -> Vector3d {
    return motion.wind - motion.velocity - motion.angular_velocity.cross(r - motion.reference_point);
  };

  Eigen::Index kept = 0;
  for (const Eigen::Vector3i& triangle : mesh.triangles) {
    const Vector3d A = mesh.vertices[triangle[0]], B = mesh.vertices[triangle[1]], C = mesh.vertices[triangle[2]];
    if (is_degenerate(A, B, C)) continue;
    const Patch& patch = surface.patches[surface.patch[kept++]];
    const Vector3d N = (B - A).cross(C - A).normalized(), G = (A + B + C) / 3.0;
    const double area = 0.5 * (B - A).cross(C - A).norm();

    // Displacement of the pressure by the pillow effect.
    Vector3d shift = Vector3d::Zero();
    const auto alpha = [&](const Vector3d& at, const Vector3d& normal) {
      return u(at).norm() > 0.0 ? faded_pillow_factor(model.pillow.factor, std::abs(u(at).dot(normal)) / u(at).norm()) : 0.0;
    };
    if (model.pillow.form == PillowForm::triangle) shift = triangle_pillow_shift(A, B, C, u(G), alpha(G, N));
    if (model.pillow.form == PillowForm::patch) shift = patch_pillow_shift(patch, u(patch.centroid), alpha(patch.centroid, patch.normal));
    if (model.pillow.form == PillowForm::tilt) shift = tilt_pillow_shift(patch, u(patch.centroid), model.pillow.factor);

    for (const QuadraturePoint& point : quadrature_rule(model.quadrature)) {
      const Vector3d r = A + point.s * (B - A) + point.t * (C - A);
      const double dA = area * point.weight;
      for (const double side : {1.0, -1.0}) {
        if (side < 0.0 && sides == Surface::Sides::one) continue;
        const Vector3d n = side * N;

        // Eq. 2: pressure on the side that meets the flow, displaced.
        const Vector3d r_p = r + shift;
        if (const double speed = u(r_p).norm(), w = -u(r_p).dot(n); w > 0.0) {
          const Vector3d dF = -n * 0.5 * medium.density * speed * speed * evaluate(model.law.windward, w / speed) * dA;
          result[Term::windward_pressure] += {dF, (r_p - motion.reference_point).cross(dF)};
        }
        // Eq. 3: suction on the side that turns away.
        if (const double speed = u(r).norm(), w = -u(r).dot(n); w < 0.0) {
          const Vector3d dF = n * 0.5 * medium.density * speed * speed * evaluate(model.law.leeward, -w / speed) * dA;
          result[Term::leeward_suction] += {dF, (r - motion.reference_point).cross(dF)};
        }
      }
    }
  }
  return result;
}

}  // namespace dragcore::reference
