#include <algorithm>
#include <cmath>
#include <dragcore/drag.hpp>
#include <stdexcept>
#include <string>

#include "drag/check.hpp"
#include "drag/corrected_flow.hpp"
#include "drag/energy_balance.hpp"
#include "drag/fast_wrench.hpp"
#include "drag/folded_model.hpp"
#include "support/require.hpp"
#include "support/triangle_second_moment.hpp"

namespace dragcore {

using Eigen::Vector3d;

namespace {

/// Beyond 1e100 the square of a speed, times a density and an area of any size, leaves the range of numbers; sound is at 340 m/s.
template <class Numbers>
bool usable(const Numbers& numbers) {
  return (numbers.array().abs() <= 1e100).all();
}

void check(const Vector3d& v, const char* name) {
  require(
      usable(v), [name] { return std::string("wrench: motion.") + name; }, v, "it must be finite, and below 1e100");
}

}  // namespace

void check_model(const Model& model) {
  const auto check_pillow = [](const Pillow& pillow) {
    const double largest = pillow.form == PillowForm::tilt ? largest_tilt : 1.0;
    require(pillow.factor >= 0.0 && pillow.factor <= largest, "wrench: pillow factor", pillow.factor,
            [&] { return "the form '" + to_string(pillow.form) + "' takes 0 to " + std::to_string(largest); });
    require(pillow.viscous_gain >= 0.0 && pillow.viscous_gain < 1e6, "wrench: viscous gain of the pillow", pillow.viscous_gain,
            "it must be from 0 to 1e6");
  };
  check_pillow(model.pillow);
  const int points = static_cast<int>(model.quadrature);
  require(points == 0 || points == 1 || points == 3 || points == 6, "wrench: points of quadrature", points,
          "it must be 1, 3 or 6, or 0 for adaptive");
  validate(model.law);
  if (!model.sheets) return;
  check_pillow(model.sheets->pillow);
  validate(model.sheets->law);
}

void check_input(const Motion& motion, const Medium& medium, const Model& model) {
  if (!model.check) return;
  // At first all at once; one by one to say which is wrong.
  const double size = motion.wind.cwiseAbs().sum() + motion.velocity.cwiseAbs().sum() + motion.angular_velocity.cwiseAbs().sum() +
                      motion.reference_point.cwiseAbs().sum() + motion.wind_gradient.cwiseAbs().sum() + std::abs(medium.density) +
                      std::abs(medium.viscosity);
  if (!(size < 1e100 && medium.density >= 0.0 && medium.viscosity >= 0.0)) {
    check(motion.wind, "wind");
    check(motion.velocity, "velocity");
    check(motion.angular_velocity, "angular_velocity");
    check(motion.reference_point, "reference_point");
    if (!usable(motion.wind_gradient))
      for (Eigen::Index j = 0; j < 3; ++j) check(motion.wind_gradient.col(j), "wind_gradient column");
    require(medium.density >= 0.0 && medium.density < 1e100, "wrench: density", medium.density,
            "it must be finite and not negative [kg/m^3]");
    require(medium.viscosity >= 0.0 && medium.viscosity < 1e100, "wrench: viscosity", medium.viscosity,
            "it must be finite and not negative, or 0 where it is not known [Pa s]");
  }
  for (const Vector3d& wind : motion.triangle_wind) check(wind, "triangle_wind entry");
  if (!FoldedModel::of(model).valid) check_model(model);
}

void check_input(const Surface& surface, const Motion& motion, const Medium& medium, const Model& model) {
  const auto given = motion.triangle_wind.size();
  require(given == 0 || given == static_cast<std::size_t>(surface.size()), "wrench: entries of motion.triangle_wind", given,
          [&] { return "the surface has " + std::to_string(surface.size()) + " triangles (degenerate ones are dropped)"; });
  check_input(motion, medium, model);
  if (model.check && is_corrected(model)) check_correction(*model.correction, surface, medium);
}

void check_result(bool finite, const Model& model) {
  if (model.check && !finite)
    throw std::overflow_error(
        "wrench: the result is not finite, although every input is; velocity, density or size must be many orders of magnitude too large");
}

std::string to_string(Term term) {
  switch (term) {
    case Term::windward_pressure:
      return "windward pressure";
    case Term::leeward_suction:
      return "leeward suction";
    case Term::base_suction:
      return "base suction";
    case Term::rear_recovery:
      return "rear recovery";
    case Term::curvature:
      return "curvature";
    case Term::friction:
      return "friction";
    case Term::correction:
      return "correction";
    case Term::count:
      break;
  }
  throw std::invalid_argument("not a term of the wrench");
}

std::string to_string(Effect effect) {
  switch (effect) {
    case Effect::leeward_suction:
      return "leeward suction";
    case Effect::friction:
      return "friction";
    case Effect::base_suction:
      return "base suction";
    case Effect::recovery:
      return "rear recovery";
    case Effect::shelter:
      return "shelter";
    case Effect::curvature:
      return "curvature";
    case Effect::pillow:
      return "pillow";
    case Effect::spin:
      return "spin";
    case Effect::wind_variation:
      return "wind variation";
    case Effect::viscous:
      return "viscous terms";
    case Effect::correction:
      return "correction";
  }
  throw std::invalid_argument("not an effect");
}

Pillow class_pillow(BodyClass body_class) {
  return {.form = PillowForm::tilt, .factor = body_class == BodyClass::sheet ? 0.86 : 0.5, .viscous_gain = 5.9};
}

Model model_for(const Surface& surface) {
  const auto has = [&](bool sheet) {
    return std::any_of(surface.parts.begin(), surface.parts.end(),
                       [sheet](const Part& p) { return (p.body_class == BodyClass::sheet) == sheet; });
  };
  const BodyClass main = has(false) ? BodyClass::sharp : BodyClass::sheet;  // sharp and smooth bodies share a law
  Model model{.law = law_for(main), .pillow = class_pillow(main), .precision = Precision::single};
  if (has(false) && has(true)) model.sheets = SheetModel{law_for(BodyClass::sheet), class_pillow(BodyClass::sheet)};
  return model;
}

namespace {

/// In double precision, triangle by triangle.
WrenchByTerm full_wrench(const Surface& surface, const Motion& motion, const Medium& medium, const Model& model) {
  WrenchByTerm taken, given;
  EnergyBalance balance;
  for_each_local_force(surface, motion, medium, model, [&](const LocalForce& local) {
    balance.add(local);
    const Vector3d force = local.force();
    (local.coefficient.value < 0.0 ? given : taken)[local.term] += {force, local.place.cross(force)};
  });
  for_each_creeping_flow(surface, motion, medium, model, [&](const Part& part, const CreepingFlow& creeping) {
    balance.add(creeping.power(part), 0.0);
    taken[Term::friction] += creeping.wrench(part);
  });
  if (balance.has_gain()) {
    const double share = balance.gain_share();
    for (std::size_t k = 0; k < taken.terms.size(); ++k) taken.terms[k] += {share * given.terms[k].force, share * given.terms[k].torque};
  }
  return taken;
}

}  // namespace

WrenchByTerm wrench(const Surface& surface, const Motion& motion, const Medium& medium, const Model& model) {
  check_input(surface, motion, medium, model);
  WrenchByTerm taken;
  if (!fast_wrench(surface, motion, medium, model, taken)) taken = full_wrench(surface, motion, medium, model);
  if (is_corrected(model)) taken[Term::correction] = CorrectedFlow(surface, motion, medium, model).beside(taken.total());
  const Wrench total = taken.total();
  check_result(total.force.allFinite() && total.torque.allFinite(), model);
  return taken;
}

TriangleForces triangle_forces(const Surface& surface, const Motion& motion, const Medium& medium, const Model& model) {
  check_input(surface, motion, medium, model);
  // Force, and torque about the reference point, of every triangle: apart until it is known how much of the second may be given.
  Eigen::Matrix<double, 6, Eigen::Dynamic> taken = Eigen::Matrix<double, 6, Eigen::Dynamic>::Zero(6, surface.size()), given = taken;
  EnergyBalance balance;
  for_each_local_force(surface, motion, medium, model, [&](const LocalForce& local) {
    balance.add(local);
    const Vector3d force = local.force();
    auto column = (local.coefficient.value < 0.0 ? given : taken).col(local.triangle);
    column.head<3>() += force;
    column.tail<3>() += local.place.cross(force);
  });
  for_each_creeping_flow(surface, motion, medium, model, [&](const Part& part, const CreepingFlow& creeping) {
    balance.add(creeping.power(part), 0.0);
    for (Eigen::Index i = 0; i < surface.size(); ++i) {
      if (&surface.parts[RelativeFlow::part_of(surface, i)] != &part) continue;
      // The traction is linear in place: its moment about the triangle's centroid is that of the spread alone.
      const Vector3d r = surface.centroid.row(i).matrix().transpose() - part.creeping.centre;
      const Vector3d spin = -creeping.viscosity * part.creeping.spread * creeping.turning;
      const Eigen::Matrix3d second = triangle_second_moment(Vector3d(surface.edge_ab.row(i).matrix()), Vector3d(surface.edge_ac.row(i).matrix()));
      const double wetted = surface.area[i] * (1.0 + surface.back[i]);
      const Vector3d force = wetted * creeping.traction(part, r);
      taken.col(i).head<3>() += force;
      taken.col(i).tail<3>() += (creeping.arm + r).cross(force) + wetted * (second.trace() * spin - second * spin);
    }
  });
  if (balance.has_gain()) taken += balance.gain_share() * given;
  if (is_corrected(model)) add_spread_correction(surface, motion, medium, model, taken);
  check_result(taken.allFinite(), model);
  TriangleForces result;
  result.force = taken.topRows<3>();
  result.torque = taken.bottomRows<3>();
  return result;
}

std::optional<LineOfAction> line_of_action(const Wrench& wrench, const Vector3d& reference_point) {
  const double size = wrench.force.stableNorm();
  if (!(size > 0.0) || !std::isfinite(size)) return std::nullopt;
  const Vector3d direction = wrench.force / size;
  return LineOfAction{reference_point + direction.cross(wrench.torque) / size, direction, direction.dot(wrench.torque)};
}

std::optional<Vector3d> centre_of_pressure(const LineOfAction& line, const Vector3d& plane_point, const Vector3d& plane_normal) {
  const Vector3d normal = plane_normal.stableNormalized();
  const double slope = line.direction.dot(normal);
  if (!(std::abs(slope) > 0.05)) return std::nullopt;
  return line.point + line.direction * ((plane_point - line.point).dot(normal) / slope);
}

}  // namespace dragcore
