#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <dragcore/ellipsoid.hpp>
#include <numbers>

#include "drag/check.hpp"
#include "support/ellipsoid_integrals.hpp"
#include "support/require.hpp"

namespace dragcore {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using std::numbers::pi;

Vector3d semi_axes(const Ellipsoid& shape) { return {shape.semi_x, shape.semi_y, shape.semi_z}; }

std::vector<EllipsoidSurface::FlowNode> flow_nodes(const Vector3d& semi) {
  const double size = semi.maxCoeff();
  const Vector3d scaled = semi / size;
  const double det_squared = scaled.prod() * scaled.prod();
  std::vector<EllipsoidSurface::FlowNode> nodes;
  for_each_ellipsoid_node(scaled, [&](double tau, double d_tau, const Vector3d& shrink, double root) {
    const double weight = det_squared * root * d_tau;
    nodes.push_back({shrink, size * size * weight * tau, size * size * size * weight * std::sqrt(tau)});
  });
  return nodes;
}

/// Angles on a quarter turn that crowd towards 0 with the scale `ratio`, and their weights: theta = pi/2 ratio sinh(y asinh(1/ratio)), y in
/// [0, 1].
std::vector<std::pair<double, double>> graded_quarter(double ratio, int panels_per_quarter) {
  static const GaussLegendre<4> gauss;
  // The range of scales between ratio and 1 is logarithmic, and so is what it costs: 0.3 panels more per e-fold, from measured errors.
  const int panels = static_cast<int>(std::lround(panels_per_quarter * (1.0 - 0.3 * std::log(ratio))));
  const double stretch = std::asinh(1.0 / ratio);
  std::vector<std::pair<double, double>> angles;
  for (int panel = 0; panel < panels; ++panel)
    for (int i = 0; i < 4; ++i) {
      const double y = (panel + gauss.point[i]) / panels;
      angles.emplace_back(0.5 * pi * ratio * std::sinh(stretch * y),
                          0.5 * pi * ratio * stretch * std::cosh(stretch * y) * gauss.weight[i] / panels);
    }
  return angles;
}

std::vector<EllipsoidSurface::SurfacePoint> surface_points(const Vector3d& semi, int panels_per_quarter) {
  // Curvature is strongest about the ends of the longest axis and the rim across the shortest: latitude is measured from that rim,
  // longitude from that end.
  std::array<int, 3> order{0, 1, 2};
  std::sort(order.begin(), order.end(), [&semi](int i, int j) { return semi[i] > semi[j]; });
  const auto [longest, middle, shortest] = order;
  const auto latitudes = graded_quarter(semi[shortest] / semi[longest], panels_per_quarter);
  const auto longitudes = graded_quarter(semi[middle] / semi[longest], panels_per_quarter);
  const Vector3d scaled = semi / semi[longest];
  std::vector<EllipsoidSurface::SurfacePoint> points;
  points.reserve(8 * latitudes.size() * longitudes.size());
  for (const auto& [latitude, d_latitude] : latitudes)
    for (const auto& [longitude, d_longitude] : longitudes)
      for (int octant = 0; octant < 8; ++octant) {
        Vector3d unit;  // on the unit sphere, which the semi-axes stretch into the ellipsoid
        unit[longest] = std::cos(latitude) * std::cos(longitude) * (octant & 1 ? -1 : 1);
        unit[middle] = std::cos(latitude) * std::sin(longitude) * (octant & 2 ? -1 : 1);
        unit[shortest] = std::sin(latitude) * (octant & 4 ? -1 : 1);
        // n dA = det(A) A^-1 unit dsigma
        const Vector3d normal = scaled.prod() * unit.cwiseQuotient(scaled);
        const double stretch = normal.norm();
        points.push_back({semi.cwiseProduct(unit), normal / stretch,
                          stretch * semi[longest] * semi[longest] * std::cos(latitude) * d_latitude * d_longitude});
      }
  return points;
}

bool is_zero(const Law::Polynomial& polynomial) {
  return std::all_of(polynomial.begin(), polynomial.end(), [](double coefficient) { return coefficient == 0.0; });
}

/// One side in uniform flow along the unit vector d, for q = 1 (docs/ellipsoids.md, eq. 3, 4). The torque is that of windward pressure.
Wrench side_in_uniform_flow(const EllipsoidSurface& ellipsoid, const Law::Polynomial& law, const Vector3d& d) {
  Wrench sum;
  if (is_zero(law)) return sum;
  // pi k/2, and 4 sqrt(pi)/3 (k/2) Gamma((k+1)/2) / Gamma(k/2), for the powers k = 1..4 of c
  const std::array<double, 4> force{0.5 * pi * law[1], pi * law[2], 1.5 * pi * law[3], 2.0 * pi * law[4]};
  const std::array<double, 4> torque{2.0 / 3.0 * law[1], 2.0 / 3.0 * pi * law[2], 4.0 * law[3], 2.0 * pi * law[4]};
  const auto horner = [](const std::array<double, 4>& p, double s) { return p[0] + s * (p[1] + s * (p[2] + s * p[3])); };
  Vector3d arm = Vector3d::Zero();
  for (const auto& node : ellipsoid.flow_nodes) {
    const Vector3d shrunk = node.shrink.cwiseProduct(d);
    const double s = std::sqrt(d.dot(shrunk));
    sum.force += node.force * horner(force, s) * shrunk;
    arm += node.torque / s * horner(torque, s) * shrunk;
  }
  sum.torque = arm.cross(d);
  // A constant pressure acts on the windward half as on the plane section through its edge: no torque.
  const Vector3d semi = semi_axes(ellipsoid.body.shape), section = d.cwiseQuotient(semi);
  sum.force += law[0] * pi * semi.prod() * section.cwiseQuotient(semi) / section.norm();
  return sum;
}

WrenchByTerm in_uniform_flow(const EllipsoidSurface& ellipsoid, const Vector3d& u, double density, const Law& law) {
  WrenchByTerm result;
  const double speed = u.stableNorm();
  if (!(speed > 0.0)) return result;
  const Vector3d d = u.stableNormalized();
  const double q = 0.5 * density * speed * speed;
  // Opposite points have opposite normals: suction on one pulls as pressure on the other pushes, on the opposite arm.
  const Wrench pressure = side_in_uniform_flow(ellipsoid, law.windward, d), suction = side_in_uniform_flow(ellipsoid, law.leeward, d);
  result[Term::windward_pressure] = {q * pressure.force, q * pressure.torque};
  result[Term::leeward_suction] = {q * suction.force, -q * suction.torque};
  return result;
}

WrenchByTerm with_spin(const EllipsoidSurface& ellipsoid, const Vector3d& u_centre, const Vector3d& spin, double density, const Law& law) {
  WrenchByTerm result;
  const bool felt[2] = {!is_zero(law.leeward), !is_zero(law.windward)};
  for (const auto& point : ellipsoid.surface_points) {
    const Vector3d u = u_centre - spin.cross(point.place);
    const double un = u.dot(point.normal);
    const bool windward = un < 0.0;
    if (un == 0.0 || !felt[windward]) continue;
    const double speed = u.norm();
    if (!(speed > 0.0)) continue;  // its square underflows, and so would the force
    const double c = std::min(1.0, std::abs(un) / speed);
    const double size = 0.5 * density * speed * speed * point.area * evaluate(windward ? law.windward : law.leeward, c);
    const Vector3d force = (windward ? -size : size) * point.normal;
    result[windward ? Term::windward_pressure : Term::leeward_suction] += {force, point.place.cross(force)};
  }
  return result;
}

}  // namespace

void validate(const PlacedEllipsoid& body) {
  properties(body.shape);  // throws for semi-axes out of range
  require_finite("ellipsoid: centre", body.centre);
  // 1e-9 leaves room for rotations that were composed many times, and changes the wrench by no more than that.
  const bool rotation = body.axes.allFinite() && (body.axes.transpose() * body.axes).isIdentity(1e-9) && body.axes.determinant() > 0.0;
  require(rotation, "ellipsoid: axes", Eigen::Matrix<double, 9, 1>(body.axes.reshaped()),
          "it must be a rotation: orthonormal columns, determinant +1");
}

EllipsoidSurface::EllipsoidSurface(const PlacedEllipsoid& placed, int panels_per_quarter) : body(placed) {
  validate(body);
  require(panels_per_quarter >= 1, "ellipsoid: panels_per_quarter", panels_per_quarter, "it must be at least 1");
  flow_nodes = dragcore::flow_nodes(semi_axes(body.shape));
  surface_points = dragcore::surface_points(semi_axes(body.shape), panels_per_quarter);
}

WrenchByTerm wrench(const EllipsoidSurface& ellipsoid, const Motion& motion, const Medium& medium, const Law& law) {
  check_input(motion, medium, Model{.law = law});
  require(law.friction == 0.0 && law.base_suction == 0.0 && law.curvature == 0.0 && law.shelter == 0.0, "ellipsoid: law", law.name,
          "only the polynomials have an exact integral here: give a law without friction, base suction, shelter and curvature, or a mesh "
          "to wrench()");
  const Matrix3d& axes = ellipsoid.body.axes;
  const Vector3d arm = ellipsoid.body.centre - motion.reference_point;
  const Vector3d u = axes.transpose() * (motion.wind - motion.velocity - motion.angular_velocity.cross(arm));
  const Vector3d spin = axes.transpose() * motion.angular_velocity;
  WrenchByTerm result =
      spin.isZero(0.0) ? in_uniform_flow(ellipsoid, u, medium.density, law) : with_spin(ellipsoid, u, spin, medium.density, law);
  for (Wrench& term : result.terms) {
    const Vector3d force = axes * term.force;
    term = {force, axes * term.torque + arm.cross(force)};
  }
  return result;
}

}  // namespace dragcore
