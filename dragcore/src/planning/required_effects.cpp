#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <dragcore/fluid_terms.hpp>
#include <dragcore/required_effects.hpp>
#include <numbers>
#include <sstream>

#include "drag/check.hpp"
#include "drag/corrected_flow.hpp"
#include "drag/local_forces.hpp"
#include "support/require.hpp"

namespace dragcore {

namespace {

using Eigen::Vector3d;

/// Upper bounds of a function of c on [0, 1] and of the slope sqrt(4 C^2 + C'^2 (1 - c^2)) of the force that it makes.
struct Bounds {
  double value = 0.0, slope = 0.0;
};

template <class Function>
Bounds bounds_of(Function function) {
  // Between samples a smooth function of order one changes by less than the 2 % that are added.
  constexpr int samples = 512;
  Bounds bounds;
  for (int i = 0; i <= samples; ++i) {
    const double c = static_cast<double>(i) / samples;
    const Curve curve = function(c);
    bounds.value = std::max(bounds.value, 1.02 * std::abs(curve.value));
    bounds.slope = std::max(bounds.slope, 1.02 * std::sqrt(4.0 * curve.value * curve.value + curve.slope * curve.slope * (1.0 - c * c)));
  }
  return bounds;
}

/// How far the pillow may displace a pressure on a patch or triangle with this largest second moment per area, and this radius.
double largest_shift(const Pillow& pillow, double moment, double radius) {
  switch (pillow.form) {
    case PillowForm::none:
      return 0.0;
    case PillowForm::eccentricity:
      return radius;
    // Covariance of falloff and place over the mean falloff: half the falloff's range times the radius of gyration, over at least 1 - 2/3
    // of it.
    case PillowForm::triangle:
    case PillowForm::patch:
      return std::min(radius, 1.5 * pillow.factor * std::sqrt(moment));
    case PillowForm::tilt:
      return std::min(radius, pillow.factor * std::sqrt(moment));
  }
  return radius;
}

std::string text(double value) {
  std::ostringstream out;
  out.precision(3);
  out << value;
  return out.str();
}

}  // namespace

RequiredEffects required_effects(const Scene& scene) {
  const Surface& surface = scene.surface;
  const Motion& motion = scene.motion;
  // Of a mesh with sheets and bodies: the larger of each number, and of each bound.
  const Law& second = scene.model.sheets ? scene.model.sheets->law : scene.model.law;
  Law law = scene.model.law;
  for (double Law::*number : {&Law::friction, &Law::base_suction, &Law::aspect_gain, &Law::recovery, &Law::shelter, &Law::curvature,
                              &Law::stokes, &Law::layer, &Law::layer_curvature})
    law.*number = std::max(law.*number, second.*number);
  check_input(surface, motion, scene.medium, scene.model);
  validate(law);
  require(scene.tolerance > 0.0 && scene.tolerance < 1e6, "required_effects: tolerance", scene.tolerance, "it must be greater than 0");
  require(scene.viscosity > 0.0 && std::isfinite(scene.viscosity), "required_effects: viscosity", scene.viscosity,
          "it must be greater than 0 [Pa s]");

  // Arms and speeds.
  const double arm = (surface.centre - motion.reference_point).norm() + surface.radius;
  double wind_speed = motion.wind.norm();
  for (const Vector3d& wind : motion.triangle_wind) wind_speed = std::max(wind_speed, wind.norm());
  WindVariation field;
  double jump_of_field = 0.0;
  if (scene.wind) {
    double largest_triangle = 0.0;
    for (Eigen::Index i = 0; i < surface.size(); ++i)
      largest_triangle = std::max({largest_triangle, surface.edge_ab.row(i).matrix().norm(), surface.edge_ac.row(i).matrix().norm()});
    field = scene.wind->variation(scene.place, surface.radius, largest_triangle);
    wind_speed += scene.wind->velocity(scene.place).norm() + field.constant;
    jump_of_field = field.constant;
  }
  const double travel =
      motion.triangle_wind.empty() && !scene.wind ? (motion.wind - motion.velocity).norm() : wind_speed + motion.velocity.norm();
  const double spin = motion.angular_velocity.norm() * arm;
  double uneven = motion.wind_gradient.norm() * arm + jump_of_field;
  for (const Vector3d& wind : motion.triangle_wind) uneven = std::max(uneven, (wind - motion.wind).norm());
  const double speed = travel + spin + uneven;
  require(speed > 0.0 || surface.size() == 0, "required_effects: speed of the motion", speed,
          "give the largest speed and spin to expect: at rest nothing is needed, and nothing follows from it");
  const double q = 0.5 * scene.medium.density * speed * speed;
  const double area = surface.total_area;

  RequiredEffects result;
  result.force_scale = q * area * (surface.volume > 0.0 ? 0.25 : 1.0);
  result.torque_scale = result.force_scale * surface.radius;

  // The law's terms, each at its largest.
  const auto of_polynomial = [&](Law::Polynomial Law::*polynomial) {
    const auto bounds = [](const Law::Polynomial& p) { return bounds_of([&](double c) { return Curve{evaluate(p, c), derivative(p, c)}; }); };
    const Bounds a = bounds(law.*polynomial), b = bounds(second.*polynomial);
    return Bounds{std::max(a.value, b.value), std::max(a.slope, b.slope)};
  };
  const Bounds windward = of_polynomial(&Law::windward), leeward = of_polynomial(&Law::leeward);
  const double h = 1.0 + law.aspect_gain;
  const Bounds base = bounds_of([&](double c) { return saturating(c, law.base_edge) * Curve{2.0 - c, -1.0} * (law.base_suction * h); });
  const Bounds recovery = bounds_of([&](double c) { return saturating(c, law.recovery_edge) * (law.base_suction * law.recovery); });
  double curved_area = 0.0;
  for (Eigen::Index i = 0; i < surface.size(); ++i)
    if ((surface.curvature.row(i) != 0.0).any()) curved_area += surface.area[i];
  const Bounds curvature = bounds_of([&](double c) { return saturating(c, 0.2) * Curve{1.0 - c * c, -2.0 * c} * law.curvature; });
  const double sides = 1.0 + (surface.size() > 0 ? surface.back.maxCoeff() : 0.0);
  // Smallest frontal area, from below: |n.d| >= (n.d)^2, and a body's rear half does not count.
  Eigen::Matrix3d facing = Eigen::Matrix3d::Zero();
  for (Eigen::Index i = 0; i < surface.size(); ++i) {
    const Vector3d n = surface.normal.row(i).matrix();
    facing += surface.area[i] * n * n.transpose();
  }
  const double smallest_front =
      0.5 * sides * std::max(0.0, Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(facing, Eigen::EigenvaluesOnly).eigenvalues()[0]);

  const ActiveEffects active(motion, scene.model, law, scene.model.pillow, scene.medium);
  const auto add = [&](const std::string& name, std::optional<Effect> effect, double force, double torque, const std::string& why) {
    EffectNeed need{name, effect, false, force, torque, why};
    need.needed = force > scene.tolerance * result.force_scale || torque > scene.tolerance * result.torque_scale;
    if (need.needed && effect) result.effects = result.effects | *effect;
    result.needs.push_back(std::move(need));
  };
  const auto keep = [&](Effect effect, const std::string& why) {  // the last judged, for reasons that its bound does not know
    EffectNeed& need = result.needs.back();
    need.needed = true;
    need.why += why;
    result.effects = result.effects | effect;
  };
  const auto add_pressure = [&](Effect effect, bool present, double coefficient, double wetted, const std::string& absent,
                                const std::string& there) {
    const double force = present ? q * wetted * coefficient : 0.0;
    add(to_string(effect), effect, force, force * arm, present ? there : absent);
  };

  add_pressure(Effect::leeward_suction, active.has<Effect::leeward_suction>(), leeward.value, area, "the law has no leeward polynomial",
               "leeward faces feel up to " + text(leeward.value) + " q");
  add_pressure(Effect::friction, active.has<Effect::friction>(), law.friction, sides * area,
               active.has<Effect::viscous>() ? "the viscous terms take its place" : "the law has no friction",
               "every wetted side feels up to " + text(law.friction) + " q");
  if (scene.free && active.has<Effect::friction>() && law.friction * sides * area > scene.tolerance * smallest_front)
    keep(Effect::friction, ", and little else brakes a free body whose frontal area may be as small as " + text(smallest_front) + " m^2");
  add_pressure(Effect::base_suction, active.has<Effect::base_suction>(), base.value, area, "the law has no base suction",
               "windward faces feel up to " + text(base.value) + " q of it");
  const bool recovers = active.has<Effect::recovery>() && surface.volume > 0.0;
  add_pressure(Effect::recovery, recovers, recovery.value, area,
               active.has<Effect::recovery>() ? "the body has no volume" : "the law has no rear recovery",
               "leeward faces get back up to " + text(recovery.value) + " q");
  add_pressure(Effect::shelter, active.has<Effect::shelter>(),
               (1.0 - std::exp(-law.shelter)) * (windward.value + base.value + curvature.value), area, "the law has no shelter",
               "a face behind a sharper one loses up to " + text(100.0 * (1.0 - std::exp(-law.shelter))) + " % of its pressure");
  const bool curves = active.has<Effect::curvature>() && curved_area > 0.0;
  add_pressure(Effect::curvature, curves, curvature.value, curved_area,
               active.has<Effect::curvature>() ? "no part of the surface is curved" : "the law has no term of curvature",
               text(100.0 * curved_area / std::max(area, 1e-300)) + " % of the surface is curved");

  // Pillow: moves pressure, and changes the force only where the velocity differs between the two places.
  double moved = 0.0;
  if (active.has<Effect::pillow>()) {
    if (scene.model.pillow.form == PillowForm::tilt) {
      double factor = std::max(scene.model.pillow.factor, scene.model.sheets ? scene.model.sheets->pillow.factor : 0.0);
      if (active.has<Effect::viscous>()) factor = largest_tilt;
      for (Eigen::Index i = 0; i < surface.size(); ++i)
        moved += surface.area[i] * largest_shift({PillowForm::tilt, factor}, symmetric(surface.second_moment.row(i)).trace(), 2.0 * surface.radius);
    } else if (scene.model.pillow.form == PillowForm::patch) {
      for (const Patch& patch : surface.patches) {
        double radius = 0.0;
        for (const auto& [from, to] : patch.outline) radius = std::max(radius, (from - patch.centroid).norm());
        moved += patch.area * largest_shift(scene.model.pillow, patch.second_moment.trace(), radius);
      }
    } else {
      for (Eigen::Index i = 0; i < surface.size(); ++i) {
        const double longest = std::max({surface.edge_ab.row(i).matrix().norm(), surface.edge_ac.row(i).matrix().norm(),
                                         (surface.edge_ab.row(i) - surface.edge_ac.row(i)).matrix().norm()});
        // Second moment of a triangle about its centroid: sum of its squared edges over 36.
        moved += surface.area[i] * largest_shift(scene.model.pillow, longest * longest / 12.0, longest);
      }
    }
  }
  // Of the boundary layer: 1 + h is below 2, and its slope at most 1.5.
  double friction_of_layer = 0.0;
  for (const Part& part : surface.parts)
    friction_of_layer = std::max(friction_of_layer, 1.5 * layer_scale(law, part, scene.medium, active) / std::sqrt(speed) * (1.0 + law.layer_curvature));
  const double pushing = windward.value + base.value + curvature.value;
  const double slope = windward.slope + leeward.slope + base.slope + recovery.slope + curvature.slope + 2.0 * sides * (law.friction + 2.0 * friction_of_layer);
  const double per_metre = motion.angular_velocity.norm() + motion.wind_gradient.norm();
  const double pillow_force = 0.5 * scene.medium.density * slope * speed * per_metre * moved;
  add(to_string(Effect::pillow), Effect::pillow, pillow_force, q * pushing * moved + pillow_force * arm,
      active.has<Effect::pillow>() ? "pressures move by " + text(moved / std::max(area, 1e-300)) + " m on average at most"
                                   : "the model has no pillow, or its factor is 0");

  // Spin and wind: largest change of velocity times largest slope, over the whole surface; and what depends on the one direction of flow.
  const double described = (1.0 - std::exp(-law.shelter)) * pushing + recovery.value + law.aspect_gain * law.base_suction;
  double creeping = 0.0;  // of Stokes' resistance, per speed
  if (active.has<Effect::viscous>())
    for (const Part& part : surface.parts)
      creeping += law.stokes * scene.medium.viscosity * (part.creeping.drag.norm() + part.creeping.turning.norm() / (part.radius * part.radius));
  const auto by_velocity = [&](double change) {
    const double turned = travel > 0.0 ? std::min(1.0, change / travel) : (change > 0.0 ? 1.0 : 0.0);
    return 0.5 * scene.medium.density * slope * speed * change * area + q * described * turned * area + creeping * change;
  };
  const double by_spin = active.has<Effect::spin>() ? by_velocity(spin) : 0.0;
  add(to_string(Effect::spin), Effect::spin, by_spin, by_spin * arm,
      active.has<Effect::spin>() ? "points move at up to " + text(spin) + " m/s by spin, " + text(travel) + " m/s by travel"
                                 : "the body does not spin");
  if (scene.free && scene.model.effects.has(Effect::spin))
    keep(Effect::spin, ", but a free body may come to, and nothing else would brake it");
  const bool varies = uneven > 0.0 && scene.model.effects.has(Effect::wind_variation);
  const double by_wind = varies ? by_velocity(uneven) : 0.0;
  add(to_string(Effect::wind_variation), Effect::wind_variation, by_wind, by_wind * arm,
      varies ? "the wind differs by up to " + text(uneven) + " m/s over the body" : "the wind is uniform over the body");
  if (scene.free && scene.wind && scene.model.effects.has(Effect::wind_variation) && !varies)
    keep(Effect::wind_variation, " here, but a free body moves on");
  if (scene.wind && varies && result.effects.has(Effect::wind_variation)) {
    const double allowed = scene.tolerance * result.force_scale / std::max(by_velocity(1.0), 1e-300);
    result.wind_sampling = choose_sampling(field, allowed);
    if (result.wind_sampling == WindSampling::constant) result.wind_sampling = WindSampling::affine;
  }

  // Eq. 15 and 16 at their largest; without them the constant friction is back.
  const bool viscous = active.has<Effect::viscous>();
  double by_viscosity = 0.0, by_viscous_turning = 0.0;
  const double layer = 2.0 * friction_of_layer;
  if (viscous) {
    for (const Part& part : surface.parts) {
      by_viscosity += law.stokes * scene.medium.viscosity * part.creeping.drag.norm() * speed;
      by_viscous_turning += law.stokes * scene.medium.viscosity * part.creeping.turning.norm() * per_metre;
    }
    by_viscosity += q * sides * area * (layer + law.friction);
  }
  add(to_string(Effect::viscous), Effect::viscous, by_viscosity, by_viscosity * arm + by_viscous_turning,
      viscous ? "Stokes' resistance, and every wetted side feels up to " + text(layer) + " q"
              : (scene.medium.viscosity > 0.0 ? "the law has no viscous terms" : "the viscosity of the medium is not known"));
  if (viscous && scene.free) keep(Effect::viscous, ", the more of q the slower the body, and a free one may slow down");

  // Eq. 18 in the worst direction.
  double most_force = 0.0, most_torque = 0.0;
  if (is_corrected(scene.model)) {
    const DirectionMap& map = scene.model.correction->map;
    for (int node = 0; node < map.nodes(); ++node) {
      most_force = std::max(most_force, double{Eigen::Map<const Eigen::Vector3f>(map.row(node, 0)).norm()});
      most_torque = std::max(most_torque, double{Eigen::Map<const Eigen::Vector3f>(map.row(node, 0) + 4).norm()});
    }
  }
  add(to_string(Effect::correction), Effect::correction, q * area * most_force,
      q * area * (most_torque * surface.radius + most_force * (surface.centre - motion.reference_point).norm()),
      is_corrected(scene.model) ? "calibration changes the force by up to " + text(most_force) + " q A" : "the model has no correction");

  // Beyond pressure: what fluid_terms.hpp has.
  const double ball = surface.radius;
  const bool smooth = surface.body_class == BodyClass::smooth && motion.angular_velocity.norm() > 0.0 && travel > 0.0;
  const double spin_parameter = smooth ? motion.angular_velocity.norm() * ball / travel : 0.0;
  const double lift = smooth ? 0.5 * scene.medium.density * travel * travel * std::numbers::pi * ball * ball *
                                   std::min(1.5 * spin_parameter, 0.09 + 0.6 * spin_parameter)
                             : 0.0;
  add("Magnus lift", std::nullopt, lift, 0.0,
      smooth ? "a smooth body with spin parameter " + text(spin_parameter) : "not a smooth body that spins and travels");
  double inertial = 0.0;
  if (scene.body) {
    const double carried =
        scene.medium.density * 8.0 / 3.0 * ball * ball * ball;  // broadside disc of that radius: the largest of all bodies inside the ball
    inertial = result.force_scale * carried / scene.body->mass;
    add("added mass", std::nullopt, inertial, inertial * ball,
        "air carried along: up to " + text(carried) + " kg with a body of " + text(scene.body->mass) + " kg");
  } else {
    add("added mass", std::nullopt, 0.0, 0.0, "not judged: the scene does not say the body's mass");
  }
  const double reynolds = scene.medium.density * speed * 2.0 * ball / (scene.medium.viscosity > 0.0 ? scene.medium.viscosity : scene.viscosity);
  const double lacking =
      !viscous && reynolds > 0.0 && reynolds < 1e4 ? std::max(0.0, sphere_drag_coefficient(reynolds) / sphere_drag_coefficient(1e4) - 1.0) : 0.0;
  add("low Reynolds number", std::nullopt, lacking * result.force_scale, lacking * result.torque_scale,
      "Re = " + text(reynolds) + " on the diameter of the body's ball; the laws " +
          (viscous ? "have viscous terms" : "are for Re >= 1e4, or for a medium whose viscosity is known"));
  return result;
}

}  // namespace dragcore
