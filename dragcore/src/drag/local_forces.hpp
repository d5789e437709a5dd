#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "drag/body_law.hpp"
#include "drag/pillow_shift.hpp"
#include "drag/quadrature.hpp"
#include "drag/viscous.hpp"

namespace dragcore {

/// One contribution to the force on a body: one term of the law at one point of the surface. What every sum over a surface is made of.
struct LocalForce {
  Eigen::Index triangle;
  Term term;
  Eigen::Vector3d place;   ///< where it acts, from the reference point [m]
  Eigen::Vector3d normal;  ///< out of the side that feels it
  Eigen::Vector3d u;       ///< velocity of the air relative to the place [m/s]
  double speed;            ///< |u| > 0
  double c;                ///< |u.n| / |u|, in (0, 1]
  double half_rho_area;    ///< rho dA / 2
  Curve coefficient;       ///< of c; negative where it pushes the body through the air
  double growth = 1.0;     ///< of friction: with which power of the speed it grows, beside the tangential velocity itself

  bool is_friction() const { return term == Term::friction; }
  /// Unit vector of a pressure with a positive coefficient: -normal on windward, +normal on leeward surface.
  Eigen::Vector3d downstream() const { return u.dot(normal) < 0.0 ? Eigen::Vector3d(-normal) : normal; }
  Eigen::Vector3d force() const {
    if (is_friction()) return half_rho_area * speed * coefficient.value * (u - normal * normal.dot(u));
    return half_rho_area * speed * speed * coefficient.value * downstream();
  }
};

/// The same as of the public header, seen from the side of the normal (1) or from the back of a sheet (-1), where what is convex is hollow.
double curvature_along(const Surface& surface, Eigen::Index triangle, const Eigen::Vector3d& tangential, double side);

/// Descriptors of all parts, each in its own flow.
std::vector<Descriptors> describe_parts(const Surface& surface, const std::vector<Eigen::Vector3d>& directions);

/// What one part of a surface feels by.
struct PartModel {
  BodyLaw law;
  PillowShift pillow;
  std::optional<Exposure::Sample> wind_from{};
  double directed = 1.0;

  /// Share of a triangle that the wind reaches.
  double reached(const Surface& surface, Eigen::Index triangle) const {
    return wind_from ? 1.0 - directed * (1.0 - surface.exposure->share(triangle, *wind_from)) : 1.0;
  }
};

inline std::vector<PartModel> part_models(const Surface& surface, const Motion& motion, const Medium& medium, const Model& model,
                                          const RelativeFlow& flow) {
  const std::size_t count = surface.parts.size();
  std::vector<ActiveEffects> active;
  std::vector<Eigen::Vector3d> directions;
  bool described = false;
  for (std::size_t p = 0; p < count; ++p) {
    const BodyClass body_class = surface.parts[p].body_class;
    active.emplace_back(motion, model, model.law_of(body_class), model.pillow_of(body_class), medium);
    directions.push_back(flow.at_centre(p));
    described = described || BodyLaw::needs_descriptors(model.law_of(body_class), active[p]);
  }
  const std::vector<Descriptors> bodies = described ? describe_parts(surface, directions) : std::vector<Descriptors>(count);
  std::vector<PartModel> parts;
  parts.reserve(count);
  for (std::size_t p = 0; p < count; ++p) {
    const BodyClass body_class = surface.parts[p].body_class;
    const Law& law = model.law_of(body_class);
    const Pillow pillow = pillow_at(model.pillow_of(body_class), surface.parts[p], directions[p].norm(), medium, active[p]);
    PartModel part{.law = BodyLaw(law, bodies[p], flow.directed(p), active[p], layer_scale(law, surface.parts[p], medium, active[p])),
                   .pillow = PillowShift(surface, p, flow, pillow, active[p].has<Effect::pillow>()),
                   .directed = flow.directed(p)};
    if (surface.exposure && flow.directed(p) > 0.0) part.wind_from = surface.exposure->towards(-directions[p]);
    parts.push_back(std::move(part));
  }
  return parts;
}

/// Friction of the boundary layer on all wetted sides of a triangle, eq. 16, as a function of c. Not for inlining into loops that may do
/// without it.
/// @param direction  of the flow, unit
[[gnu::noinline]] inline Curve layer_of_both_sides(const Surface& surface, Eigen::Index triangle, const BodyLaw& law,
                                                   const Eigen::Vector3d& direction, double speed) {
  instrument::count(Effect::viscous);
  const Eigen::Vector3d normal = surface.normal.row(triangle).matrix();
  const double back = surface.back[triangle], s = std::max(-1.0, std::min(1.0, -direction.dot(normal)));
  const auto chi = [&](double side) {
    return law.law().layer_curvature > 0.0 ? curvature_along(surface, triangle, direction + s * normal, side) : 0.0;
  };
  Curve both = law.layer(s, chi(1.0));
  if (back > 0.0) {
    const Curve behind = law.layer(-s, chi(-1.0));
    both = {both.value + back * behind.value, both.slope - back * behind.slope};
  }
  // c grows with s on the windward side and falls with it on the leeward one.
  return Curve{both.value, s > 0.0 ? both.slope : -both.slope} * (1.0 / std::sqrt(speed));
}

/// Calls visit(LocalForce) for every contribution, triangle by triangle: the one place where the model walks over a surface. Creeping
/// flow is not among them, which needs no walk: for_each_creeping_flow().
/// @param every_point  of the model's rule, also where the flow is the same all over a triangle: what a change of spin would do needs them
template <class Visit>
void for_each_local_force(const Surface& surface, const Motion& motion, const Medium& medium, const Model& model, Visit&& visit,
                          bool every_point = false) {
  using Eigen::Vector3d;
  const ActiveEffects moving(motion, model);  // spin and wind are of the motion alone
  const RelativeFlow flow(surface, motion, moving);
  const std::vector<PartModel> parts = part_models(surface, motion, medium, model, flow);

  for (Eigen::Index i = 0; i < surface.size(); ++i) {
    const PartModel& part = parts[RelativeFlow::part_of(surface, i)];
    const Vector3d normal = surface.normal.row(i).matrix(), centroid = surface.centroid.row(i).matrix();
    const Vector3d ab = surface.edge_ab.row(i).matrix(), ac = surface.edge_ac.row(i).matrix();
    const Vector3d a = centroid - (ab + ac) / 3.0, shift = part.pillow.of(i);
    const double back = surface.back[i], reached = part.reached(surface, i);
    const bool leeward = part.law.feels_leeward();

    const auto at_point = [&](double s, double t, double weight) {
      const Vector3d r = a + s * ab + t * ac;
      const double half_rho_area = 0.5 * medium.density * surface.area[i] * weight;

      const auto feel = [&](const Vector3d& place, bool is_leeward) {
        const Vector3d u = flow.at(place, i);
        const double speed = u.norm(), w = -u.dot(normal);
        if (speed == 0.0 || w == 0.0) return;  // what is no number goes on, into the result
        const bool front = (w < 0.0) == is_leeward;  // of the two sides of a sheet one is right for either
        const double side = front ? 1.0 : back;
        if (!(side > 0.0)) return;
        const Vector3d outward = front ? normal : Vector3d(-normal);
        const double c = std::min(1.0, std::abs(w) / speed);
        if (!(c > 0.0)) return;  // edge-on to the last bit
        const auto pass = [&](Term term, const Curve& coefficient) {
          visit(LocalForce{i, term, place - motion.reference_point, outward, u, speed, c, half_rho_area * side, coefficient});
        };
        if (is_leeward)
          part.law.leeward(c, pass);
        else
          part.law.windward(
              c, [&] { return curvature_along(surface, i, (u - normal * normal.dot(u)) / speed, w > 0.0 ? 1.0 : -1.0); },
              [&](Term term, const Curve& coefficient) { pass(term, coefficient * reached); });
      };
      feel(r + shift, false);
      if (leeward) feel(r, true);
      if (const double friction = part.law.friction(); friction > 0.0 || part.law.layer_scale() > 0.0) {
        const Vector3d u = flow.at(r, i);
        if (const double speed = u.norm(); speed != 0.0) {
          LocalForce rubbed{i,
                            Term::friction,
                            r - motion.reference_point,
                            normal,
                            u,
                            speed,
                            std::min(1.0, std::abs(u.dot(normal)) / speed),
                            half_rho_area * (1.0 + back),
                            {friction, 0.0}};
          if (friction > 0.0) {
            instrument::count(Effect::friction);
          } else {
            rubbed.half_rho_area = half_rho_area;
            rubbed.coefficient = layer_of_both_sides(surface, i, part.law, u / speed, speed), rubbed.growth = 0.5;
          }
          visit(rubbed);
        }
      }
    };
    const auto at_points = [&](Quadrature order, double share) {
      for (const QuadraturePoint& point : quadrature_rule(order)) at_point(point.s, point.t, share * point.weight);
    };

    if (!flow.varies_on_triangles() && !every_point) {
      at_points(Quadrature::one, 1.0);  // exact: the flow is the same all over the triangle
    } else if (model.quadrature != Quadrature::adaptive) {
      at_points(model.quadrature, 1.0);
    } else {
      const double radius =
          std::sqrt(std::max({(ab + ac).squaredNorm(), (2.0 * ab - ac).squaredNorm(), (2.0 * ac - ab).squaredNorm()})) / 3.0;
      const QuadratureShares shares = adaptive_shares(flow.variation_per_metre() * radius, flow.at(centroid, i).norm());
      if (shares.one > 0.0) at_points(Quadrature::one, shares.one);
      if (shares.three > 0.0) at_points(Quadrature::three, shares.three);
      if (shares.six > 0.0) at_points(Quadrature::six, shares.six);
    }
  }
}

}  // namespace dragcore
