// The model, equation by equation, in double precision. Slow on purpose: every quantity is made where it is used.

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <dragcore/descriptors.hpp>
#include <dragcore/drag.hpp>
#include <limits>
#include <numbers>

#include "drag/check.hpp"
#include "drag/quadrature.hpp"

namespace dragcore::reference {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// A map at a direction: found among all its triangles, the one that holds the direction.
Eigen::Matrix<double, 6, 1> interpolated(const DirectionMap& map, const Vector3d& direction) {
  const Vector3d d = direction / direction.lpNorm<1>();
  const auto corner = [&](int node) {
    const Vector3d unit = map.direction(node);
    return Vector3d(unit / unit.lpNorm<1>());  // on the octahedron, where the map is linear
  };
  Eigen::Matrix<double, 6, 1> sum = Eigen::Matrix<double, 6, 1>::Zero();
  double nearest = -1.0;
  const int n = map.side();
  const auto try_triangle = [&](int a, int b, int c) {
    Matrix3d corners;
    corners << corner(a), corner(b), corner(c);
    const Vector3d weight = corners.fullPivLu().solve(d);
    // The triangle whose smallest weight is the largest: rounding may leave it below 0 on an edge.
    if (!(std::abs(corners.determinant()) > 0.0) || !(weight.minCoeff() > nearest)) return;
    nearest = weight.minCoeff();
    sum.setZero();
    int k = 0;
    for (const int node : {a, b, c}) {
      const float* row = map.row(node, 0);
      for (int channel = 0; channel < 3; ++channel)
        sum[channel] += weight[k] * double{row[channel]}, sum[3 + channel] += weight[k] * double{row[4 + channel]};
      ++k;
    }
  };
  // The square's cells are cut across along the diagonals around its middle: quadrants of one sign of i j one way, the others the other.
  for (int j = 0; j + 1 < n; ++j)
    for (int i = 0; i + 1 < n; ++i) {
      const int at = i + j * n, right = at + 1, up = at + n, across = up + 1;
      if ((i < map.frequency) == (j < map.frequency)) {
        try_triangle(at, right, up);
        try_triangle(across, right, up);
      } else {
        try_triangle(at, right, across);
        try_triangle(at, up, across);
      }
    }
  return sum;
}

}  // namespace

WrenchByTerm wrench(const TriangleMesh& mesh, Surface::Sides sides, const Motion& motion, const Medium& medium, const Model& model) {
  const Surface surface(mesh, sides);  // for its planar patches and its curvature
  check_input(surface, motion, medium, model);
  const bool spins = model.effects.has(Effect::spin), winds = model.effects.has(Effect::wind_variation);
  const Vector3d& r_0 = motion.reference_point;

  // Eq. 1: velocity of the air relative to the surface. `wind` is that at the triangle, where it is known.
  const auto u_in = [&](const Vector3d& wind, const Vector3d& r) -> Vector3d {
    Vector3d u = wind - motion.velocity;
    if (winds && motion.triangle_wind.empty()) u += motion.wind_gradient * (r - r_0);
    if (spins) u -= motion.angular_velocity.cross(r - r_0);
    return u;
  };
  const auto wind_at = [&](std::size_t triangle) {
    return winds && !motion.triangle_wind.empty() ? motion.triangle_wind[triangle] : motion.wind;
  };
  const auto mean_wind = [&](const std::vector<int>& label, int wanted) -> Vector3d {  // over one patch or part
    if (!winds || motion.triangle_wind.empty()) return motion.wind;
    Vector3d sum = Vector3d::Zero();
    double area = 0.0;
    for (std::size_t i = 0; i < label.size(); ++i)
      if (label[i] == wanted)
        sum += surface.area[static_cast<Eigen::Index>(i)] * wind_at(i), area += surface.area[static_cast<Eigen::Index>(i)];
    return area > 0.0 ? Vector3d(sum / area) : motion.wind;
  };
  // How much the relative flow varies per metre: rate of strain and turning of its gradient, G - [omega].
  Matrix3d gradient = Matrix3d::Zero();
  if (winds && motion.triangle_wind.empty()) gradient += motion.wind_gradient;
  if (spins)
    for (int axis = 0; axis < 3; ++axis) gradient.col(axis) -= motion.angular_velocity.cross(Vector3d::Unit(axis));
  const Vector3d curl(gradient(2, 1) - gradient(1, 2), gradient(0, 2) - gradient(2, 0), gradient(1, 0) - gradient(0, 1));
  const double variation = (gradient + gradient.transpose()).norm() / 2 + curl.norm() / 2;

  const auto saturating = [](double c, double e) { return c * (1.0 + e) / (c + e); };

  WrenchByTerm takes, gives;
  double taken = 0.0, given = 0.0;  // power
  const auto feel = [&](Term term, double coefficient, const Vector3d& dF, const Vector3d& r, const Vector3d& u) {
    (coefficient < 0.0 ? gives : takes)[term] += {dF, (r - r_0).cross(dF)};
    (coefficient < 0.0 ? given : taken) += std::abs(dF.dot(u));
  };

  for (std::size_t p = 0; p < surface.parts.size(); ++p) {
    const Part& part = surface.parts[p];
    const Law& law = model.law_of(part.body_class);
    const bool viscous = medium.viscosity > 0.0 && law.viscous() && model.effects.has(Effect::viscous);
    const double nu = medium.viscosity / medium.density, l = std::sqrt(part.creeping.wetted / std::numbers::pi);
    // Descriptors of the part in the flow at its centre, and the share of that flow in all of its motion.
    const Vector3d u_centre = u_in(mean_wind(surface.part, static_cast<int>(p)), part.centre);
    const Descriptors body = describe(surface, u_centre, p);
    const double travel = u_centre.squaredNorm(), turning = variation * variation * part.radius * part.radius;
    const double directed = travel > 0.0 ? travel / (travel + turning) : 0.0;
    const double aspect2 = body.aspect * body.aspect;
    const double h = 1.0 + directed * law.aspect_gain * aspect2 / (aspect2 + law.aspect_scale * law.aspect_scale);
    const double rear = directed * body.reached * law.recovery * body.depth / (body.depth + law.recovery_depth);
    const double k = body.sharpness;
    // Eq. 17: the pillow grows as the Reynolds number falls.
    Pillow pillow = model.pillow_of(part.body_class);
    if (viscous && pillow.form == PillowForm::tilt && pillow.viscous_gain > 0.0)
      pillow.factor = std::min(largest_tilt, pillow.factor + pillow.viscous_gain * std::sqrt(nu / (u_centre.norm() * l)));

    for (Eigen::Index index = 0; index < surface.size(); ++index) {
      if (surface.part[static_cast<std::size_t>(index)] != static_cast<int>(p)) continue;
      const Vector3d N = surface.normal.row(index).matrix(), G = surface.centroid.row(index).matrix();
      const Vector3d AB = surface.edge_ab.row(index).matrix(), AC = surface.edge_ac.row(index).matrix();
      const Vector3d A = G - (AB + AC) / 3.0, B = A + AB, C = A + AC;
      const double area = surface.area[index];
      const int patch_index = surface.patch[static_cast<std::size_t>(index)];
      const Patch& patch = surface.patches[static_cast<std::size_t>(patch_index)];
      const double share = surface.exposure ? surface.exposure->share(index, surface.exposure->towards(-u_centre)) : 1.0;
      const double reached = 1.0 - directed * (1.0 - share);
      const auto u = [&](const Vector3d& r) { return u_in(wind_at(static_cast<std::size_t>(index)), r); };

      // Displacement of the pressure by the pillow effect, eq. 4 to 6.
      Vector3d shift = Vector3d::Zero();
      const auto alpha = [&](const Vector3d& flow, const Vector3d& normal) {
        return flow.norm() > 0.0 ? faded_pillow_factor(pillow.factor, std::abs(flow.dot(normal)) / flow.norm()) : 0.0;
      };
      if (model.effects.has(Effect::pillow)) {
        switch (pillow.form) {
          case PillowForm::none:
            break;
          case PillowForm::triangle:
            shift = triangle_pillow_shift(A, B, C, u_centre, alpha(u_centre, N), pillow.falloff);
            break;
          case PillowForm::eccentricity:
            shift = eccentricity_pillow_shift(A, B, C, u_centre, alpha(u_centre, N));
            break;
          case PillowForm::patch:
            shift = patch_pillow_shift(patch, u_centre, alpha(u_centre, patch.normal), pillow.falloff);
            break;
          case PillowForm::tilt:
            shift = tilt_pillow_shift(N, symmetric(surface.second_moment.row(index)), u_centre, pillow.factor);
            break;
        }
        shift *= directed;
      }

      // Eq. 7: how much the side of the normal n curves along t. Hollow seen from the back of a sheet is convex seen from its front.
      const auto chi = [&](const Vector3d& n, const Vector3d& t) {
        if (!(t.squaredNorm() > 0.0)) return 0.0;
        const Matrix3d tensor = symmetric(surface.curvature.row(index));
        const double bend = n.dot(N) * t.dot(tensor * t) / t.squaredNorm() * std::sqrt(surface.total_area / std::numbers::pi);
        return bend > 0.0 ? bend * bend / (bend * bend + 0.45) : 0.0;
      };

      const auto at_point = [&](const QuadraturePoint& point, double share_of_rule) {
        const Vector3d r = A + point.s * (B - A) + point.t * (C - A), r_p = r + shift;
        const double piece = area * point.weight * share_of_rule;
        for (const double side : {1.0, -1.0}) {
          const double felt = side > 0.0 ? 1.0 : surface.back[index];
          if (felt == 0.0) continue;
          const Vector3d n = side * N;
          const double dA = piece * felt;

          // Eq. 2, 7, 9, 10: on the side that meets the flow, displaced.
          if (const double speed = u(r_p).norm(), w = -u(r_p).dot(n); w > 0.0) {
            const double c = w / speed, x = k > 0.0 ? 1.0 - c / k : 0.0, q_dA = 0.5 * medium.density * speed * speed * dA;
            const bool sheltered = model.effects.has(Effect::shelter) && x > 0.0;
            const double S = sheltered ? std::exp(-directed * law.shelter * k * k * k * k * x * x / (x + 0.1)) : 1.0;
            const auto push = [&](Term term, double coefficient) {
              feel(term, coefficient, -n * q_dA * reached * coefficient, r_p, u(r_p));
            };
            push(Term::windward_pressure, S * evaluate(law.windward, c));
            if (model.effects.has(Effect::base_suction))
              push(Term::base_suction, S * law.base_suction * h * saturating(c, law.base_edge) * (2.0 - c));
            if (model.effects.has(Effect::curvature)) {
              const Vector3d t = u(r_p) - n * n.dot(u(r_p));
              push(Term::curvature, -S * law.curvature * chi(n, t) * (1.0 - c * c) * saturating(c, 0.2));
            }
          }
          // Eq. 3, 8: on the side that turns away.
          if (const double speed = u(r).norm(), w = -u(r).dot(n); w < 0.0) {
            const double c = -w / speed, q_dA = 0.5 * medium.density * speed * speed * dA;
            const auto pull = [&](Term term, double coefficient) { feel(term, coefficient, n * q_dA * coefficient, r, u(r)); };
            if (model.effects.has(Effect::leeward_suction)) pull(Term::leeward_suction, evaluate(law.leeward, c));
            if (model.effects.has(Effect::recovery)) pull(Term::rear_recovery, -law.base_suction * rear * saturating(c, law.recovery_edge));
          }
          // Eq. 16: the boundary layer, on either. Without inertia there is none.
          if (viscous && medium.density > 0.0 && u(r).norm() > 0.0) {
            const double speed = u(r).norm(), s = -u(r).dot(n) / speed, head_on = 1.5 * s / std::sqrt(1.0 + 2.25 * s * s);
            const Vector3d t = u(r) - n * n.dot(u(r));
            const double coefficient = law.layer / std::sqrt(speed * l / nu) * (1.0 + head_on) * (1.0 + law.layer_curvature * chi(n, t));
            feel(Term::friction, coefficient, 0.5 * medium.density * coefficient * speed * t * dA, r, u(r));
          }
          // Eq. 12: along the surface, on either.
          if (model.effects.has(Effect::friction) && !viscous) {
            const Vector3d tangential = u(r) - n * n.dot(u(r));
            feel(Term::friction, law.friction, 0.5 * medium.density * law.friction * u(r).norm() * tangential * dA, r, u(r));
          }
        }
      };

      const double radius = std::max({(A - G).norm(), (B - G).norm(), (C - G).norm()});
      const auto with_rule = [&](Quadrature rule, double share_of_rule) {
        for (const QuadraturePoint& point : quadrature_rule(rule)) at_point(point, share_of_rule);
      };
      if (model.quadrature != Quadrature::adaptive) {
        with_rule(model.quadrature, 1.0);
      } else {
        const QuadratureShares shares = adaptive_shares(variation * radius, u(G).norm());
        with_rule(Quadrature::one, shares.one);
        with_rule(Quadrature::three, shares.three);
        with_rule(Quadrature::six, shares.six);
      }
    }
  }

  // Eq. 15: what air without inertia would do, on top.
  for (std::size_t p = 0; p < surface.parts.size(); ++p) {
    const Law& law = model.law_of(surface.parts[p].body_class);
    if (!(medium.viscosity > 0.0) || !law.viscous() || !model.effects.has(Effect::viscous)) continue;
    const CreepingResistance& body = surface.parts[p].creeping;
    Vector3d spin = Vector3d::Zero();  // of the part relative to the air
    if (spins) spin += motion.angular_velocity;
    if (winds && motion.triangle_wind.empty())
      for (int axis = 0; axis < 3; ++axis) spin -= 0.5 * Vector3d::Unit(axis).cross(Vector3d(motion.wind_gradient.col(axis)));
    const Vector3d u = u_in(mean_wind(surface.part, static_cast<int>(p)), body.centre);
    const Vector3d force = law.stokes * medium.viscosity * body.drag * u, couple = -law.stokes * medium.viscosity * body.turning * spin;
    takes[Term::friction] += {force, couple + (body.centre - r_0).cross(force)};
    taken += force.dot(u) - couple.dot(spin);
  }

  // Eq. 13: what pushes the body through the air never wins.
  if (given > 0.0) {
    const double x = largest_gain * taken / given;
    const double share = taken > 0.0 ? std::pow(1.0 + std::pow(1.0 / x, 8), -0.125) : 0.0;
    for (std::size_t term = 0; term < takes.terms.size(); ++term)
      takes.terms[term] += {share * gives.terms[term].force, share * gives.terms[term].torque};
  }

  // Eq. 18: what this body was found to feel besides, by the directions of the map around that of the flow.
  if (!model.correction || !model.effects.has(Effect::correction)) return takes;
  Vector3d u = Vector3d::Zero();
  for (Eigen::Index i = 0; i < surface.size(); ++i)
    u += surface.area[i] / surface.total_area * u_in(wind_at(static_cast<std::size_t>(i)), surface.centre);
  const double travel = u.squaredNorm(), turned = variation * surface.radius;
  if (!(travel > 0.0)) return takes;
  const Eigen::Matrix<double, 6, 1> found = interpolated(model.correction->map, u);
  const double scale = 0.5 * medium.density * travel * surface.total_area * travel / (travel + turned * turned);
  const Vector3d force = scale * found.head<3>(), couple = scale * surface.radius * found.tail<3>(), arm = surface.centre - r_0;
  const Wrench law = takes.total();
  const Vector3d turning = -0.5 * curl;  // of the body relative to the air
  const double braked = law.force.dot(u) - (law.torque - arm.cross(law.force)).dot(turning), pushed = couple.dot(turning) - force.dot(u);
  const double x = pushed > 0.0 ? largest_gain * std::max(0.0, braked) / pushed : std::numeric_limits<double>::infinity();
  const double share = x > 0.0 ? std::pow(1.0 + std::pow(1.0 / x, 8), -0.125) : 0.0;
  takes[Term::correction] = {share * force, share * (couple + arm.cross(force))};
  return takes;
}

}  // namespace dragcore::reference
