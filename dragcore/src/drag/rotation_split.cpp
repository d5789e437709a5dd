#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <dragcore/rotation_split.hpp>

#include "drag/check.hpp"
#include "support/gauss_legendre.hpp"

namespace dragcore {

namespace {

using Eigen::Vector3d;

/// Integrals of w^2 and of w^2 lambda_i for a linear w, as multiples of the area: complete homogeneous symmetric polynomials of its corner
/// values.
struct SquareMoments {
  double m = 0.0;
  Vector3d q = Vector3d::Zero();
};

double h2(const std::array<double, 4>& w, int n) {
  double sum = 0.0;
  for (int i = 0; i < n; ++i)
    for (int j = i; j < n; ++j) sum += w[static_cast<std::size_t>(i)] * w[static_cast<std::size_t>(j)];
  return sum;
}

SquareMoments whole_triangle(const Vector3d& w) {
  SquareMoments moments{.m = h2({w[0], w[1], w[2], 0.0}, 3) / 6.0};
  for (int i = 0; i < 3; ++i) moments.q[i] = h2({w[0], w[1], w[2], w[i]}, 4) / 30.0;
  return moments;
}

/// The same over the corner k that is cut off by w = 0.
SquareMoments lone_corner(const Vector3d& w, int k) {
  const int i = (k + 1) % 3, j = (k + 2) % 3;
  const double ti = w[k] / (w[k] - w[i]), tj = w[k] / (w[k] - w[j]);  // opposite signs: nothing cancels
  SquareMoments moments{.m = ti * tj * w[k] * w[k] / 6.0};
  const auto cut = [k](int corner, double t) { return Vector3d((1.0 - t) * Vector3d::Unit(k) + t * Vector3d::Unit(corner)); };
  moments.q = ti * tj * w[k] * w[k] / 30.0 * (3.0 * Vector3d::Unit(k) + cut(i, ti) + cut(j, tj));
  return moments;
}

/// The note's sections 2.2.2 to 2.2.5 to the letter. With x and h as printed; the sign of every part by its own rule.
Wrench printed_rotation(const std::array<Vector3d, 3>& corner, const Vector3d& omega, double density) {
  const Vector3d centroid = (corner[0] + corner[1] + corner[2]) / 3.0,
                 normal = (corner[1] - corner[0]).cross(corner[2] - corner[0]).normalized();
  const Vector3d axis = omega.cross(normal);  // E16
  if (!(axis.norm() > 1e-12 * omega.norm())) return {};
  const Vector3d x_axis = axis.normalized(), h_axis = x_axis.cross(normal);
  struct Point {
    double x, h;
  };
  std::array<Point, 3> p;
  for (std::size_t i = 0; i < 3; ++i) p[i] = {x_axis.dot(corner[i] - centroid), h_axis.dot(corner[i] - centroid)};
  std::sort(p.begin(), p.end(), [](const Point& left, const Point& right) { return left.x < right.x; });
  double flip = 1.0;
  if (p[1].x > 0.0) {  // E21: a = -c, b = -b, c = -a and a leading minus
    p = {Point{-p[2].x, p[2].h}, Point{-p[1].x, p[1].h}, Point{-p[0].x, p[0].h}};
    flip = -1.0;
  }
  const double a = p[0].x, b = p[1].x, c = p[2].x;
  const double chord_h = b > a ? p[0].h + (p[2].h - p[0].h) * (b - a) / (c - a) : p[1].h;
  const double H = std::abs(p[1].h - chord_h), side = p[1].h, d = p[2].h;               // "c" and "d" of the note are heights
  const double cosine = normal.dot(omega) / omega.norm();                               // E14
  const double factor = density * omega.squaredNorm() * cosine * (1.0 + cosine / 2.0);  // E15
  static const GaussLegendre<16> gauss;
  double torque = 0.0, tilt = 0.0;
  const auto integrate = [&](double from, double to, bool first, double sign) {
    if (!(to > from)) return;
    for (int i = 0; i < 16; ++i) {
      const double x = from + (to - from) * gauss.point[static_cast<std::size_t>(i)],
                   dx = (to - from) * gauss.weight[static_cast<std::size_t>(i)];
      const double h = first ? H * (x - a) / (b - a) : H * (1.0 - (x - b) / (c - b));
      const double middle = first ? (x - a) / (b - a) * (side - H / 2) : d + (x - b) / (c - b) * (d - side + H / 2);  // E6, E20
      torque += sign * factor * x * x * (h - middle) * x * dx;   // E17, E18: dF_1 = (1 - h_m/h) dF
      tilt += sign * factor * middle * middle * x * x * x * dx;  // E19
    }
  };
  integrate(a, b, true, -1.0);
  integrate(b, 0.0, false, -1.0);
  integrate(0.0, c, false, 1.0);
  return {Vector3d::Zero(), flip * (h_axis * torque + x_axis * tilt)};  // E22: no force
}

}  // namespace

Wrench rotating_triangle(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& omega, double density,
                         double leeward_share) {
  const double speed = omega.norm();
  if (!(speed > 0.0)) return {};
  const Vector3d cross = (b - a).cross(c - a), normal = cross.normalized(), centroid = (a + b + c) / 3.0;
  const double area = 0.5 * cross.norm();
  const Vector3d along = normal.cross(omega);  // v_surf . N = along . (P - G)
  const Vector3d w(along.dot(a - centroid), along.dot(b - centroid), along.dot(c - centroid));
  if (w.isZero(0.0)) return {};
  int k = 0;  // the corner whose sign no other has
  const int positive = static_cast<int>((w.array() > 0.0).count());
  if (positive == 1)
    w.maxCoeff(&k);
  else
    w.minCoeff(&k);
  const SquareMoments lone = lone_corner(w, k), all = whole_triangle(w);
  const SquareMoments rest{all.m - lone.m, all.q - lone.q};
  const bool lone_outwards = w[k] > 0.0;
  const SquareMoments &outwards = lone_outwards ? lone : rest, &inwards = lone_outwards ? rest : lone;
  const double sine = along.norm() / speed, factor = density * (1.0 - 0.5 * sine) * area;
  const Vector3d q = outwards.q - leeward_share * inwards.q;
  const Vector3d lever = q[0] * (a - centroid) + q[1] * (b - centroid) + q[2] * (c - centroid);
  return {-factor * (outwards.m - leeward_share * inwards.m) * normal, -factor * lever.cross(normal)};
}

WrenchByTerm rotation_split_wrench(const Surface& surface, const Motion& motion, const Medium& medium, const RotationSplit& split) {
  check_input(motion, medium, {});
  WrenchByTerm result;
  Wrench& sum = result[Term::windward_pressure];
  const Law::Polynomial windward = note_law().windward;
  for (Eigen::Index i = 0; i < surface.size(); ++i) {
    const Vector3d centroid = surface.centroid.row(i).matrix(), ab = surface.edge_ab.row(i).matrix(), ac = surface.edge_ac.row(i).matrix();
    const Vector3d normal = surface.normal.row(i).matrix(), a = centroid - (ab + ac) / 3.0, lever = centroid - motion.reference_point;
    const Vector3d u = motion.wind - motion.velocity - motion.angular_velocity.cross(lever);
    if (const double speed = u.norm(), w = -u.dot(normal); speed > 0.0 && (w > 0.0 || surface.back[i] > 0.0)) {
      const Vector3d force =
          -std::copysign(0.5 * medium.density * surface.area[i] * speed * speed * evaluate(windward, std::min(1.0, std::abs(w) / speed)),
                         w) *
          normal;
      sum += {force, lever.cross(force)};
    }
    const Wrench rotation = split.formulas == RotationSplit::Formulas::printed
                                ? printed_rotation({a, Vector3d(a + ab), Vector3d(a + ac)}, motion.angular_velocity, medium.density)
                                // The other side of a sheet pushes the parts that move the other way.
                                : rotating_triangle(a, a + ab, a + ac, motion.angular_velocity, medium.density,
                                                    surface.back[i] > 0.0 ? 1.0 : split.leeward_share);
    sum += {rotation.force, rotation.torque + lever.cross(rotation.force)};
  }
  return result;
}

}  // namespace dragcore
