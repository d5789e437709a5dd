#include <dragcore/drag.hpp>

#include <Eigen/Geometry>
#include <cmath>
#include <sstream>
#include <stdexcept>
#include <string>

#include "quadrature.hpp"

namespace dragcore {

using Eigen::Vector3d;

void check_input(const Motion& motion, const Medium& medium, const Model& model) {
  const auto finite = [](const Vector3d& v, const char* name) {
    if (v.allFinite()) return;
    std::ostringstream message;
    message << "wrench: motion." << name << " is (" << v.transpose() << "), but it must be finite";
    throw std::invalid_argument(message.str());
  };
  finite(motion.wind, "wind");
  finite(motion.velocity, "velocity");
  finite(motion.angular_velocity, "angular_velocity");
  finite(motion.reference_point, "reference_point");
  if (!(medium.density >= 0.0) || !std::isfinite(medium.density))
    throw std::invalid_argument("wrench: density = " + std::to_string(medium.density) + " kg/m^3, but it must be finite and not negative");
  const double largest = model.pillow.form == PillowForm::tilt ? 1.5 : 1.0;  // beyond, the tilt falloff would be negative on half the face
  if (!(model.pillow.factor >= 0.0 && model.pillow.factor <= largest))
    throw std::invalid_argument("wrench: pillow factor = " + std::to_string(model.pillow.factor) + ", but the form '" + to_string(model.pillow.form) +
                                "' takes 0 to " + std::to_string(largest));
  for (const Law::Polynomial& polynomial : {model.law.windward, model.law.leeward})
    for (const double coefficient : polynomial)
      if (!std::isfinite(coefficient)) throw std::invalid_argument("wrench: a coefficient of the law '" + model.law.name + "' is not finite");
}

namespace {

/// The pillow's displacement of a triangle or patch whose centroid and normal are given, from the flow at that centroid.
template <class ShiftOf>
Vector3d faded(const Vector3d& u, const Vector3d& normal, double factor, ShiftOf shift_of) {
  const double speed = u.norm();
  if (!(speed > 0.0)) return Vector3d::Zero();
  return shift_of(faded_pillow_factor(factor, std::abs(u.dot(normal)) / speed));
}

}  // namespace

WrenchByTerm wrench(const Surface& surface, const Motion& motion, const Medium& medium, const Model& model) {
  check_input(motion, medium, model);
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
        patch_shift.push_back(faded(u, patch.normal, pillow.factor, [&](double alpha) { return patch_pillow_shift(patch, u, alpha); }));
      else
        patch_shift.push_back(tilt_pillow_shift(patch, u, pillow.factor));
    }
  }

  bool has_suction = false;
  for (const double coefficient : model.law.leeward) has_suction |= coefficient != 0.0;

  WrenchByTerm result;
  Wrench& pressure = result[Term::windward_pressure];
  Wrench& suction = result[Term::leeward_suction];
  for (Eigen::Index i = 0; i < surface.size(); ++i) {
    const Vector3d normal = surface.normal.row(i).matrix(), centroid = surface.centroid.row(i).matrix();
    const Vector3d ab = surface.edge_ab.row(i).matrix(), ac = surface.edge_ac.row(i).matrix();
    const Vector3d a = centroid - (ab + ac) / 3.0;
    Vector3d shift = Vector3d::Zero();
    if (!patch_shift.empty()) {
      shift = patch_shift[surface.patch[i]];
    } else if (pillow.form == PillowForm::triangle) {
      const Vector3d u = u_at(centroid);
      shift = faded(u, normal, pillow.factor, [&](double alpha) { return triangle_pillow_shift(a, a + ab, a + ac, u, alpha); });
    }
    for (const QuadraturePoint& point : rule) {
      const Vector3d r = a + point.s * ab + point.t * ac;
      const double half_rho_area = 0.5 * medium.density * surface.area[i] * point.weight;
      // Adds -n q C(c) dA where `side` of the triangle meets the flow: +1 outside windward, -1 (sheets) inside windward.
      const auto add = [&](const Vector3d& place, const Law::Polynomial& law, bool leeward, Wrench& term) {
        const Vector3d u = u_at(place);
        const double speed = u.norm(), w = -u.dot(normal);
        if (!(speed > 0.0) || w == 0.0) return;
        if (!surface.two_sided() && (w < 0.0) != leeward) return;
        const double size = half_rho_area * speed * speed * evaluate(law, std::min(1.0, std::abs(w) / speed));
        const Vector3d force = (w > 0.0 ? -size : size) * normal;  // downstream, whichever side the air meets
        term.force += force;
        term.torque += (place - motion.reference_point).cross(force);
      };
      add(r + shift, model.law.windward, false, pressure);
      if (has_suction) add(r, model.law.leeward, true, suction);
    }
  }
  return result;
}

}  // namespace dragcore
