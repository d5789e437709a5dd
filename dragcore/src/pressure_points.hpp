#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <dragcore/drag.hpp>
#include <vector>

#include "quadrature.hpp"

namespace dragcore {

/// One point of the surface that feels the air: what every sum over the surface is made of.
struct PressurePoint {
  Eigen::Index triangle;
  Term term;
  const Law::Polynomial* law;  ///< of the side that feels it
  Eigen::Vector3d place;       ///< where the pressure acts, from the reference point [m]
  Eigen::Vector3d normal;      ///< out of the side that meets the air: u.normal < 0 for windward pressure, > 0 for leeward suction
  Eigen::Vector3d u;           ///< velocity of the air relative to the point [m/s]
  double speed;                ///< |u| > 0
  double c;                    ///< |u.n| / |u|, in (0, 1]
  double half_rho_area;        ///< rho dA / 2

  /// Force along u.n: q C(c) dA, at least 0 for a passive law [N]. It acts along -normal on windward, +normal on leeward points: downstream both.
  double size() const { return half_rho_area * speed * speed * evaluate(*law, c); }
  Eigen::Vector3d downstream() const { return term == Term::windward_pressure ? Eigen::Vector3d(-normal) : normal; }
};

namespace detail {

/// The pillow's displacement under the note's factor, faded at normal incidence.
template <class ShiftOf>
Eigen::Vector3d faded_shift(const Eigen::Vector3d& u, const Eigen::Vector3d& normal, double factor, ShiftOf shift_of) {
  const double speed = u.norm();
  if (!(speed > 0.0)) return Eigen::Vector3d::Zero();
  return shift_of(faded_pillow_factor(factor, std::abs(u.dot(normal)) / speed));
}

}  // namespace detail

/// Calls visit(PressurePoint) for every point with pressure, triangle by triangle: the one place where the model walks over a surface.
template <class Visit>
void for_each_pressure_point(const Surface& surface, const Motion& motion, const Medium& medium, const Model& model, Visit&& visit) {
  using Eigen::Vector3d;
  const Vector3d u_reference = motion.wind - motion.velocity;
  const auto u_at = [&](const Vector3d& r) -> Vector3d { return u_reference - motion.angular_velocity.cross(r - motion.reference_point); };

  // Without spin the flow is the same everywhere, and the centroid alone is exact.
  const bool spinning = !motion.angular_velocity.isZero(0.0);
  const auto rule = quadrature_rule(spinning ? model.quadrature : Quadrature::one);

  const Pillow pillow = model.pillow.factor > 0.0 ? model.pillow : Pillow{};
  std::vector<Vector3d> patch_shift;
  if (pillow.form == PillowForm::patch || pillow.form == PillowForm::tilt) {
    patch_shift.reserve(surface.patches.size());
    for (const Patch& patch : surface.patches) {
      const Vector3d u = u_at(patch.centroid);
      if (!surface.two_sided() && !spinning && u.dot(patch.normal) >= 0.0)
        patch_shift.emplace_back(Vector3d::Zero());  // leeward as a whole: nothing to displace
      else if (pillow.form == PillowForm::patch)
        patch_shift.push_back(detail::faded_shift(u, patch.normal, pillow.factor, [&](double alpha) { return patch_pillow_shift(patch, u, alpha); }));
      else
        patch_shift.push_back(tilt_pillow_shift(patch, u, pillow.factor));
    }
  }

  bool has_suction = false;
  for (const double coefficient : model.law.leeward) has_suction |= coefficient != 0.0;

  for (Eigen::Index i = 0; i < surface.size(); ++i) {
    const Vector3d normal = surface.normal.row(i).matrix(), centroid = surface.centroid.row(i).matrix();
    const Vector3d ab = surface.edge_ab.row(i).matrix(), ac = surface.edge_ac.row(i).matrix();
    const Vector3d a = centroid - (ab + ac) / 3.0;
    Vector3d shift = Vector3d::Zero();
    if (!patch_shift.empty()) {
      shift = patch_shift[static_cast<std::size_t>(surface.patch[static_cast<std::size_t>(i)])];
    } else if (pillow.form == PillowForm::triangle) {
      const Vector3d u = u_at(centroid);
      shift = detail::faded_shift(u, normal, pillow.factor, [&](double alpha) { return triangle_pillow_shift(a, a + ab, a + ac, u, alpha); });
    }
    for (const QuadraturePoint& point : rule) {
      const Vector3d r = a + point.s * ab + point.t * ac;
      const auto visit_side = [&](const Vector3d& place, Term term) {
        const Vector3d u = u_at(place);
        const double speed = u.norm(), w = -u.dot(normal);
        const bool leeward = term == Term::leeward_suction;
        if (!(speed > 0.0) || w == 0.0) return;
        if (!surface.two_sided() && (w < 0.0) != leeward) return;
        // On a sheet one of the two sides is right for either term.
        const bool flipped = (w < 0.0) != leeward;
        visit(PressurePoint{i, term, leeward ? &model.law.leeward : &model.law.windward, place - motion.reference_point, flipped ? Vector3d(-normal) : normal, u, speed,
                            std::min(1.0, std::abs(w) / speed), 0.5 * medium.density * surface.area[i] * point.weight});
      };
      visit_side(r + shift, Term::windward_pressure);
      if (has_suction) visit_side(r, Term::leeward_suction);
    }
  }
}

}  // namespace dragcore
