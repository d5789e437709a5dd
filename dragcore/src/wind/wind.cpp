#include <algorithm>
#include <cmath>
#include <dragcore/turbulence.hpp>
#include <dragcore/wind.hpp>
#include <numbers>

#include "support/require.hpp"
#include "wind/grid_kernel.hpp"

namespace dragcore {

using Eigen::Array3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using std::numbers::pi;

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double jet_spreading =
    0.107;  // growth of the 1/e half-width of the velocity per length, mean over measured round jets: [fischer_1979]

struct Cell {
  Eigen::Index below, above;  // offsets of the two grid planes
  double fraction;
};

/// The cell of a coordinate that counts grid points from 0, clamped to the grid. Not a number: the first cell with a fraction that is not a
/// number.
Cell locate(double t, int points, Eigen::Index stride) {
  t = t < 0.0 ? 0.0 : t > points - 1 ? points - 1 : t;
  const int i = t > 0.0 ? std::min(static_cast<int>(t), std::max(points - 2, 0)) : 0;
  return {i * stride, std::min(i + 1, points - 1) * stride, t - i};
}

Array3d grid_coordinate(const Grid& grid, const Array3d& cells_per_metre, const Vector3d& point) {
  // Measured from the nearer end, so that both bounds map to the exact first and last point.
  Array3d t;
  for (int a = 0; a < 3; ++a) {
    const double from_lower = point[a] - grid.lower[a], from_upper = grid.upper[a] - point[a];
    t[a] = from_lower < from_upper ? from_lower * cells_per_metre[a] : (grid.points[a] - 1) - from_upper * cells_per_metre[a];
  }
  return t;
}

bool is_outside(const Grid& grid, const Vector3d& point) {
  return (point.array() < grid.lower.array()).any() || (point.array() > grid.upper.array()).any();
}

template <bool with_gradient>
WindSample interpolate(const Grid& grid, const Array3d& cells_per_metre, const Vector3d& point) {
  WindSample result;
  if (grid.outside == Outside::zero && is_outside(grid, point)) return result;
  const Array3d t = grid_coordinate(grid, cells_per_metre, point);
  const Eigen::Index nx = grid.points[0], nxy = nx * grid.points[1];
  const Cell x = locate(t[0], grid.points[0], 1), y = locate(t[1], grid.points[1], nx), z = locate(t[2], grid.points[2], nxy);
  const auto value = [&](Eigen::Index i, Eigen::Index j, Eigen::Index k) -> Vector3d { return grid.values.col(i + j + k); };
  const auto between = [](const Vector3d& a, const Vector3d& b, double f) -> Vector3d { return (1.0 - f) * a + f * b; };
  // V1..V8 of the note: four edges along x, two faces along y, one value.
  const Vector3d v1 = value(x.below, y.below, z.below), v2 = value(x.above, y.below, z.below), v3 = value(x.below, y.above, z.below),
                 v5 = value(x.above, y.above, z.below), v4 = value(x.below, y.below, z.above), v6 = value(x.above, y.below, z.above),
                 v7 = value(x.below, y.above, z.above), v8 = value(x.above, y.above, z.above);
  const Vector3d x12 = between(v1, v2, x.fraction), x35 = between(v3, v5, x.fraction), x46 = between(v4, v6, x.fraction),
                 x78 = between(v7, v8, x.fraction);
  const Vector3d lower = between(x12, x35, y.fraction), upper = between(x46, x78, y.fraction);
  result.velocity = between(lower, upper, z.fraction);
  if constexpr (with_gradient) {
    result.gradient.col(0) =
        cells_per_metre[0] * between(between(v2 - v1, v5 - v3, y.fraction), between(v6 - v4, v8 - v7, y.fraction), z.fraction);
    result.gradient.col(1) = cells_per_metre[1] * between(x35 - x12, x78 - x46, z.fraction);
    result.gradient.col(2) = cells_per_metre[2] * (upper - lower);
    for (int a = 0; a < 3; ++a)  // clamped: no change beyond the box
      if (point[a] < grid.lower[a] || point[a] > grid.upper[a]) result.gradient.col(a).setZero();
  }
  return result;
}

/// int_0^1 tau^m exp(-s tau) d tau for s >= 0: all that the vortex and the jet need, without their 0/0 on the axis. Accuracy 1e-14.
double exponential_moment(int m, double s) {
  if (s < 2.0) {  // recursion would cancel
    double sum = 0.0, power = 1.0;
    for (int n = 0; n < 28; ++n) {
      sum += power / (n + m + 1);
      power *= -s / (n + 1);
    }
    return sum;
  }
  const double decay = std::exp(-s);
  double moment = (1.0 - decay) / s;
  for (int k = 1; k <= m; ++k) moment = (k * moment - decay) / s;
  return moment;
}

double square(double x) { return x * x; }

double smoothstep(double x) { return x <= 0.0 ? 0.0 : x >= 1.0 ? 1.0 : x * x * (3.0 - 2.0 * x); }

WindSample sample(const VortexField& vortex, const Vector3d& p) {
  // u = W M0(s) (z x r), s = r^2/a^2, W the angular velocity on the axis.
  const double a2 = square(vortex.core_radius), angular = vortex.circulation / (2.0 * pi * a2), s = (p[0] * p[0] + p[1] * p[1]) / a2;
  const double m0 = exponential_moment(0, s), m1 = exponential_moment(1, s);
  const Vector3d swirl(-p[1], p[0], 0.0), radial(p[0], p[1], 0.0);
  WindSample result;
  result.velocity = angular * m0 * swirl;
  result.gradient(0, 1) = -angular * m0;
  result.gradient(1, 0) = angular * m0;
  result.gradient -= (angular * 2.0 * m1 / a2) * swirl * radial.transpose();
  return result;
}

WindSample sample(const JetField& jet, const Vector3d& p) {
  const double d = jet.diameter, b0 = d / std::numbers::sqrt2, s = jet_spreading;
  WindSample result;
  if (p[0] <= -d) return result;
  const double b = b0 + s * p[0], eta = (p[1] * p[1] + p[2] * p[2]) / (b * b), decay = std::exp(-eta);
  const double m0 = exponential_moment(0, eta), m1 = exponential_moment(1, eta);
  const double k = m0 - 2.0 * decay, dk = 2.0 * decay - m1;                      // shape of the inflow and its derivative by eta
  const double axial = jet.exit_speed * b0 / b, inflow = axial * s / (2.0 * b);  // u_perp = -inflow k(eta) r_perp
  const Vector3d radial(0.0, p[1], p[2]);
  result.velocity = -inflow * k * radial;
  result.velocity[0] = axial * decay;
  Matrix3d& gradient = result.gradient;
  gradient(0, 0) = axial * s / b * decay * (2.0 * eta - 1.0);
  gradient.row(0) -= (axial * decay * 2.0 / (b * b)) * radial.transpose();
  gradient.col(0) += (2.0 * inflow * s / b) * (k + eta * dk) * radial;
  gradient(1, 1) -= inflow * k;
  gradient(2, 2) -= inflow * k;
  gradient -= (inflow * dk * 2.0 / (b * b)) * radial * radial.transpose();
  if (p[0] < 0.0) {
    const double x = (p[0] + d) / d, fade = smoothstep(x);
    gradient *= fade;
    gradient.col(0) += (6.0 * x * (1.0 - x) / d) * result.velocity;
    result.velocity *= fade;
  }
  return result;
}

template <bool with_gradient>
WindSample sample_field(const Field& field, const Vector3d& p, double time) {
  return std::visit(
      [&](const auto& f) -> WindSample {
        using Kind = std::decay_t<decltype(f)>;
        if constexpr (std::is_same_v<Kind, UniformField>)
          return {f.velocity, Matrix3d::Zero()};
        else if constexpr (std::is_same_v<Kind, std::shared_ptr<const GridField>>)
          return with_gradient ? f->sample(p) : WindSample{f->velocity(p), Matrix3d::Zero()};
        else if constexpr (std::is_same_v<Kind, std::shared_ptr<const Turbulence>>)
          return with_gradient ? f->sample(p, time) : WindSample{f->velocity(p, time), Matrix3d::Zero()};
        else
          return sample(f, p);
      },
      field);
}

/// Bounds for a smooth field from those on its first and second derivatives in the ball.
FieldVariation smooth_variation(double slope, double curvature, double radius, double gradient_at_centre) {
  const double constant = radius * slope;
  return {constant, std::min(0.5 * curvature * radius * radius, constant + radius * gradient_at_centre), slope, 0.0};
}

FieldVariation variation_of(const VortexField& vortex, const Vector3d& centre, double radius) {
  const double a = vortex.core_radius, angular = std::abs(vortex.circulation) / (2.0 * pi * a * a),
               distance = std::hypot(centre[0], centre[1]);
  const double nearest = std::max(0.0, distance - radius) / a, farthest = (distance + radius) / a, s = nearest * nearest;
  // |gradient| = W M0(s), which falls outwards; |second derivative| <= W/a (6 M1 rho + 4 M2 rho^3), with M1, M2 falling and rho rising
  // outwards.
  const double slope = angular * exponential_moment(0, s);
  const double curvature =
      angular / a * (6.0 * exponential_moment(1, s) * farthest + 4.0 * exponential_moment(2, s) * farthest * farthest * farthest);
  return smooth_variation(slope, curvature, radius, angular * exponential_moment(0, square(distance / a)));
}

FieldVariation variation_of(const JetField& jet, const Vector3d& centre, double radius) {
  const double d = jet.diameter, b0 = d / std::numbers::sqrt2, speed = std::abs(jet.exit_speed);
  if (centre[0] + radius <= -d) return {};
  const auto half_width = [&](double x) { return b0 + jet_spreading * std::max(x, -d); };
  const double narrow = half_width(centre[0] - radius), wide = half_width(centre[0] + radius);
  const double rho = std::max(0.0, std::hypot(centre[1], centre[2]) - radius) / wide, decay = std::exp(-rho * rho);
  // Upper envelopes of |u|, |gradient|, |second derivative| of the self-similar profile at half-width 1, falling outwards: maxima on the
  // axis side by evaluation (1, 0.8581, 1.9986), outside the core Gaussian part plus inflow; tests compare them with the field itself.
  const double u = rho < 1.0 ? 1.0 : decay + 0.06 / rho;
  const double du = rho < 1.0 ? 0.87 : 2.0 * rho * decay + 0.06 / (rho * rho);
  const double ddu = rho < 1.0 ? 2.1 : 4.0 * rho * rho * decay + 0.12 / (rho * rho * rho);
  const double top = speed * b0 / narrow * u;
  double slope = speed * b0 / square(narrow) * du, curvature = speed * b0 / (square(narrow) * narrow) * ddu;
  if (centre[0] - radius < 0.0) {  // the upstream fade f: |f'| <= 1.5/d, |f''| <= 6/d^2
    curvature += 2.0 * slope * 1.5 / d + top * 6.0 / (d * d);
    slope += top * 1.5 / d;
  }
  return smooth_variation(slope, curvature, radius, sample(jet, centre).gradient.norm());
}

}  // namespace

GridField::GridField(Grid grid) : grid_(std::move(grid)) {
  require((grid_.points.array() >= 1).all(), "grid: points", grid_.points, "every axis needs at least 1");
  const double needed = grid_.points.cast<double>().prod();
  require(static_cast<double>(grid_.values.cols()) == needed, "grid: number of values", grid_.values.cols(),
          "the product of the points per axis is " + std::to_string(static_cast<long long>(needed)));
  require_finite("grid: lower", grid_.lower);
  require_finite("grid: upper", grid_.upper);
  const Array3d size = (grid_.upper - grid_.lower).array();
  require((size > 0.0).all() && size.allFinite(), "grid: upper - lower", Vector3d(size),
          "it must be greater than 0 m on every axis, and finite");
  for (Eigen::Index i = 0; i < grid_.values.cols(); ++i)
    require_finite([i] { return "grid: value " + std::to_string(i); }, Vector3d(grid_.values.col(i)));
  cells_per_metre_ = (grid_.points.array() - 1).cast<double>() / size;
  require(cells_per_metre_.allFinite(), "grid: upper - lower", Vector3d(size), "a cell is too small to divide by");
  packed_ = pack(grid_);
}

Vector3d GridField::velocity(const Vector3d& point) const { return interpolate<false>(grid_, cells_per_metre_, point).velocity; }

WindSample GridField::sample(const Vector3d& point) const { return interpolate<true>(grid_, cells_per_metre_, point); }

FieldVariation GridField::variation(const Vector3d& centre, double radius, const Array3d& inverse_scale) const {
  const Array3d extent = radius * inverse_scale;
  const Vector3d first = centre.array() - extent, last = centre.array() + extent;
  const bool beyond = is_outside(grid_, first) || is_outside(grid_, last);
  const bool zero_outside = grid_.outside == Outside::zero;
  if (zero_outside && ((last.array() < grid_.lower.array()).any() || (first.array() > grid_.upper.array()).any())) return {};

  // Inside the touched cells every value is a mean of their corners, and every partial derivative a mean of their edges' differences:
  // maxima over those bound both.
  const WindSample here = sample(centre);
  const Array3d t_first = grid_coordinate(grid_, cells_per_metre_, first), t_last = grid_coordinate(grid_, cells_per_metre_, last);
  const Eigen::Array3<Eigen::Index> stride(1, grid_.points[0], Eigen::Index{grid_.points[0]} * grid_.points[1]);
  Eigen::Array3<Eigen::Index> low, high;
  for (int a = 0; a < 3; ++a) {
    low[a] = locate(t_first[a], grid_.points[a], 1).below;
    high[a] = locate(t_last[a], grid_.points[a], 1).above;
  }
  double spread = 0.0, largest = 0.0;
  Array3d difference = Array3d::Zero(), deviation = Array3d::Zero();
  if (beyond)
    for (int a = 0; a < 3; ++a) deviation[a] = here.gradient.col(a).norm();  // clamped: no slope beyond
  for (Eigen::Index k = low[2]; k <= high[2]; ++k)
    for (Eigen::Index j = low[1]; j <= high[1]; ++j)
      for (Eigen::Index i = low[0]; i <= high[0]; ++i) {
        const Eigen::Array3<Eigen::Index> at(i, j, k);
        const Eigen::Index column = (at * stride).sum();
        const Vector3d value = grid_.values.col(column);
        spread = std::max(spread, (value - here.velocity).norm());
        largest = std::max(largest, value.norm());
        for (int a = 0; a < 3; ++a) {
          if (at[a] == high[a]) continue;
          const Vector3d slope = cells_per_metre_[a] * (grid_.values.col(column + stride[a]) - value);
          difference[a] = std::max(difference[a], slope.norm());
          deviation[a] = std::max(deviation[a], (slope - here.gradient.col(a)).norm());
        }
      }
  const auto over = [&](const Array3d& slopes) {
    return (slopes * extent).matrix().norm();
  };  // Cauchy-Schwarz on the ball, an ellipsoid in this frame
  FieldVariation result;
  result.slope = (difference * inverse_scale).matrix().norm();
  if (zero_outside && beyond) {
    result.jump = largest;
    result.constant = std::max(spread, here.velocity.norm());
    result.affine = result.constant + over(here.gradient.colwise().norm().transpose().array());
  } else {
    result.constant = std::min(spread, over(difference));
    result.affine = std::min(over(deviation), result.constant + over(here.gradient.colwise().norm().transpose().array()));
  }
  return result;
}

namespace {

std::array<double, 3> plain(const Vector3d& v) { return {v[0], v[1], v[2]}; }

std::array<std::array<double, 3>, 3> plain(const Matrix3d& m) {
  return {plain(Vector3d(m.row(0))), plain(Vector3d(m.row(1))), plain(Vector3d(m.row(2)))};
}

}  // namespace

WindSampling choose_sampling(const WindVariation& variation, double tolerance) {
  if (variation.constant <= tolerance) return WindSampling::constant;
  return variation.affine <= tolerance ? WindSampling::affine : WindSampling::per_triangle;
}

Wind::Wind(const std::vector<WindSource>& sources, double time) : time_(time) {
  require_finite("wind: time", time);
  std::vector<PlacedGrid> grids;
  sources_.reserve(sources.size());
  for (const WindSource& source : sources) {
    const auto name = [&source](const char* what) { return [&source, what] { return "wind source '" + source.name + "': " + what; }; };
    const auto& [position, rotation, scale] = source.placement;
    require_finite(name("position"), position);
    require(rotation.allFinite() && (rotation.transpose() * rotation - Matrix3d::Identity()).norm() < 1e-9 && rotation.determinant() > 0.0,
            name("determinant of the rotation"), rotation.determinant(),
            "its columns must be orthonormal and right-handed; put stretching and mirrors into the scale");
    const Array3d inverse_scale = scale.array().abs().inverse();
    require(scale.allFinite() && (inverse_scale > 0.0).all() && inverse_scale.allFinite(), name("scale"), scale,
            "it must be finite and not 0 on every axis");
    require_finite(name("intensity"), source.intensity);
    require(source.fade_radius > 0.0, name("fade_radius"), source.fade_radius, "it must be greater than 0 m");
    if (const auto* uniform = std::get_if<UniformField>(&source.field)) require_finite(name("velocity"), uniform->velocity);
    if (const auto* vortex = std::get_if<VortexField>(&source.field)) {
      require_finite(name("circulation"), vortex->circulation);
      require(vortex->core_radius > 0.0 && std::isfinite(vortex->core_radius), name("core_radius"), vortex->core_radius,
              "it must be greater than 0 m and finite");
    }
    if (const auto* jet = std::get_if<JetField>(&source.field)) {
      require_finite(name("exit_speed"), jet->exit_speed);
      require(jet->diameter > 0.0 && std::isfinite(jet->diameter), name("diameter"), jet->diameter,
              "it must be greater than 0 m and finite");
    }
    const auto* grid = std::get_if<std::shared_ptr<const GridField>>(&source.field);
    const auto* turbulence = std::get_if<std::shared_ptr<const Turbulence>>(&source.field);
    require(!(grid && !*grid) && !(turbulence && !*turbulence), name("field"), "null", "it must be set");

    Placed placed{source.field,
                  position,
                  (1.0 / scale.array()).matrix().asDiagonal() * rotation.transpose(),
                  source.intensity * rotation * scale.array().sign().matrix().asDiagonal(),
                  inverse_scale,
                  source.intensity,
                  source.fade_radius,
                  Eigen::AlignedBox3d(Vector3d::Constant(-infinity), Vector3d::Constant(infinity))};
    // World box of a box in the field's frame; a little larger, so that rounding never culls a point that the field itself would count as
    // inside.
    if (grid && (*grid)->grid().outside == Outside::zero) {
      const Grid& g = (*grid)->grid();
      const Vector3d middle = position + rotation * (scale.array() * 0.5 * (g.lower + g.upper).array()).matrix();
      const Vector3d half = (rotation * scale.asDiagonal()).cwiseAbs() * 0.5 * (g.upper - g.lower);
      const Vector3d margin = Vector3d::Constant(1e-14 * (position.norm() + (scale.array() * g.lower.array()).matrix().norm() +
                                                          (scale.array() * g.upper.array()).matrix().norm()));
      placed.box = Eigen::AlignedBox3d(middle - half - margin, middle + half + margin);
    }
    if (std::isfinite(source.fade_radius)) {
      const Vector3d half = (1.0 + 1e-14) * source.fade_radius * (rotation * scale.asDiagonal()).rowwise().norm() +
                            Vector3d::Constant(1e-14 * position.norm());
      placed.box = placed.box.intersection(Eigen::AlignedBox3d(position - half, position + half));
    }
    if (grid && (*grid)->packed()) {
      const GridField& field = **grid;
      const Matrix3d turn = field.packed()->largest * placed.turn;
      const Eigen::Vector3i points = field.grid().points;
      const std::int64_t line = 4 * std::max(points[0], 2);
      placed.packed = turn.allFinite() && std::isfinite(1.0 / source.fade_radius);  // else: numbers beyond what factors can be
      if (placed.packed)
        grids.push_back({.packed = field.packed(),
                         .strides = {4, line, line * points[1]},
                         .last_point = plain(Vector3d((points.array() - 1).cast<double>())),
                         .last_cell = plain(Vector3d((points.array() - 2).max(0).cast<double>())),
                         .lower = plain(field.grid().lower),
                         .upper = plain(field.grid().upper),
                         .cells_per_metre = plain(Vector3d(field.cells_per_metre())),
                         .position = plain(position),
                         .to_field = plain(placed.to_field),
                         .turn = plain(turn),
                         .zero_outside = field.grid().outside == Outside::zero,
                         .per_fade_radius = 1.0 / source.fade_radius,
                         .box_min = plain(placed.box.min()),
                         .box_max = plain(placed.box.max())});
    }
    sources_.push_back(std::move(placed));
  }
  if (!grids.empty()) grids_ = std::make_shared<const std::vector<PlacedGrid>>(std::move(grids));
}

namespace {

// Said the other way round, so that a point that is not a number is not culled but seen in the result.
bool misses(const Eigen::AlignedBox3d& box, const Vector3d& point) {
  return (point.array() < box.min().array()).any() || (point.array() > box.max().array()).any();
}

}  // namespace

template <bool with_gradient>
void Wind::add(const Placed& source, const Vector3d& point, WindSample& sum) const {
  if (misses(source.box, point)) return;
  const Vector3d local = source.to_field * (point - source.position);
  double fade = 1.0;
  Vector3d slope = Vector3d::Zero();
  if (std::isfinite(source.fade_radius)) {
    const double q = 1.0 - (local / source.fade_radius).squaredNorm();
    if (q <= 0.0) return;
    fade = q * q;
    slope = -4.0 * q / source.fade_radius * (local / source.fade_radius);
  }
  const WindSample field = sample_field<with_gradient>(source.field, local, time_);
  sum.velocity += source.turn * (fade * field.velocity);
  if constexpr (with_gradient) sum.gradient += source.turn * (fade * field.gradient + field.velocity * slope.transpose()) * source.to_field;
}

Vector3d Wind::velocity(const Vector3d& point) const {
  WindSample sum;
  for (const Placed& source : sources_) add<false>(source, point, sum);
  return sum.velocity;
}

WindSample Wind::sample(const Vector3d& point) const {
  WindSample sum;
  for (const Placed& source : sources_) add<true>(source, point, sum);
  return sum;
}

std::vector<std::size_t> Wind::sources_near(const Eigen::AlignedBox3d& box) const {
  std::vector<std::size_t> near;
  for (std::size_t i = 0; i < sources_.size(); ++i)
    if (!((sources_[i].box.max().array() < box.min().array()).any() || (sources_[i].box.min().array() > box.max().array()).any()))
      near.push_back(i);
  return near;
}

namespace {

/// A point that is not a number may lie anywhere: no source may be culled for its box.
Eigen::AlignedBox3d box_of(const Eigen::Ref<const Eigen::Matrix3Xd>& points) {
  if (points.hasNaN()) return {Vector3d::Constant(-infinity), Vector3d::Constant(infinity)};
  return {points.rowwise().minCoeff(), points.rowwise().maxCoeff()};
}

}  // namespace

/// Turbulence at many points at once, where the source reaches them.
void Wind::add_turbulence(const Placed& source, const Turbulence& turbulence, const Eigen::Ref<const Eigen::Matrix3Xd>& points,
                          Eigen::Matrix3Xd& sum) const {
  std::vector<Eigen::Index> inside;
  std::vector<double> fade;
  Eigen::Matrix3Xd places(3, points.cols());
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    if (misses(source.box, points.col(i))) continue;
    const Vector3d local = source.to_field * (points.col(i) - source.position);
    const double q = 1.0 - (local / source.fade_radius).squaredNorm();
    if (q <= 0.0) continue;
    places.col(static_cast<Eigen::Index>(inside.size())) = local;
    inside.push_back(i);
    fade.push_back(q * q);
  }
  const Eigen::Matrix3Xd velocities = turbulence.velocities(places.leftCols(static_cast<Eigen::Index>(inside.size())), time_);
  for (std::size_t i = 0; i < inside.size(); ++i)
    sum.col(inside[i]) += source.turn * (fade[i] * velocities.col(static_cast<Eigen::Index>(i)));
}

Eigen::Matrix3Xd Wind::velocities(const Eigen::Ref<const Eigen::Matrix3Xd>& points, Precision precision) const {
  if (sources_.empty() || points.cols() == 0) return Eigen::Matrix3Xd::Zero(3, points.cols());
  const bool single = precision == Precision::single, by_kernel = single && grids_;
  if (by_kernel && points.outerStride() != 3) return velocities(Eigen::Matrix3Xd(points), precision);
  Eigen::Matrix3Xd result(3, points.cols());
  bool finite = !single || grids_ || points.allFinite();
  if (by_kernel)
    finite = sum_of_grids(*grids_, points.data(), static_cast<std::size_t>(points.cols()), result.data());
  else
    result.setZero();
  if (by_kernel && finite && grids_->size() == sources_.size()) return result;

  std::vector<std::size_t> one_by_one;
  for (const std::size_t i : sources_near(box_of(points))) {
    const auto* turbulence = std::get_if<std::shared_ptr<const Turbulence>>(&sources_[i].field);
    if (by_kernel && sources_[i].packed) continue;
    if (single && turbulence)
      add_turbulence(sources_[i], **turbulence, points, result);
    else
      one_by_one.push_back(i);
  }
  if (!one_by_one.empty())
    for (Eigen::Index column = 0; column < points.cols(); ++column) {
      WindSample sum{.velocity = result.col(column)};
      for (const std::size_t i : one_by_one) add<false>(sources_[i], points.col(column), sum);
      result.col(column) = sum.velocity;
    }
  // The kernels know no more than numbers.
  if (!finite)
    for (Eigen::Index column = 0; column < points.cols(); ++column)
      if (!points.col(column).allFinite()) result.col(column) = velocity(points.col(column));
  return result;
}

std::vector<WindSample> Wind::samples(const Eigen::Ref<const Eigen::Matrix3Xd>& points, Precision precision) const {
  std::vector<WindSample> result(static_cast<std::size_t>(points.cols()));
  if (sources_.empty() || result.empty()) return result;
  const bool by_kernel = precision == Precision::single && grids_;
  if (by_kernel && points.outerStride() != 3) return samples(Eigen::Matrix3Xd(points), precision);
  const bool finite = !by_kernel || sum_of_grids(*grids_, points.data(), result.size(), result.data());
  if (by_kernel && finite && grids_->size() == sources_.size()) return result;
  const std::vector<std::size_t> near = sources_near(box_of(points));
  for (Eigen::Index column = 0; column < points.cols(); ++column)
    for (const std::size_t i : near)
      if (!by_kernel || !sources_[i].packed) add<true>(sources_[i], points.col(column), result[static_cast<std::size_t>(column)]);
  if (!finite)
    for (Eigen::Index column = 0; column < points.cols(); ++column)
      if (!points.col(column).allFinite()) result[static_cast<std::size_t>(column)] = sample(points.col(column));
  return result;
}

WindVariation Wind::variation(const Vector3d& centre, double radius, double triangle_radius) const {
  require_finite("wind variation: centre", centre);
  for (const auto& [name, value] : {std::pair{"radius", radius}, std::pair{"triangle_radius", triangle_radius}})
    require(value >= 0.0 && std::isfinite(value), std::string("wind variation: ") + name, value, "it must be finite and not negative");
  WindVariation sum;
  const Eigen::AlignedBox3d around(centre - Vector3d::Constant(radius), centre + Vector3d::Constant(radius));
  for (const std::size_t i : sources_near(around)) {
    const Placed& source = sources_[i];
    const Vector3d local = source.to_field * (centre - source.position);
    const double stretch = source.inverse_scale.maxCoeff(), local_radius = radius * stretch;
    FieldVariation v = std::visit(
        [&](const auto& field) -> FieldVariation {
          using Kind = std::decay_t<decltype(field)>;
          if constexpr (std::is_same_v<Kind, UniformField>) {
            return {};
          } else if constexpr (std::is_same_v<Kind, std::shared_ptr<const GridField>>) {
            return field->variation(local, radius, source.inverse_scale);
          } else {
            FieldVariation smooth;
            if constexpr (std::is_same_v<Kind, std::shared_ptr<const Turbulence>>)
              smooth = field->variation(local_radius);
            else
              smooth = variation_of(field, local, local_radius);
            smooth.slope *= stretch;
            return smooth;
          }
        },
        source.field);
    if (std::isfinite(source.fade_radius)) {
      // Product with f = q^2, q = 1 - (r/R)^2: |f'| <= 1.5397/R at r = R/sqrt(3), |f''| <= 8/R^2, at the edge; 0 <= f <= 1.
      const double speed = sample_field<false>(source.field, local, time_).velocity.norm();
      const double f_slope = 1.5397 / source.fade_radius, f_constant = std::min(1.0, f_slope * local_radius),
                   f_affine = 4.0 * square(local_radius / source.fade_radius);
      v = {v.constant + speed * f_constant, v.affine + speed * f_affine + f_constant * v.constant,
           v.slope + f_slope * stretch * (speed + v.constant), v.jump};
    }
    const double size = std::abs(source.intensity);
    sum.constant += size * v.constant;
    sum.affine += size * v.affine;
    sum.per_triangle += size * (std::min(v.slope * triangle_radius, 2.0 * v.constant) + v.jump);
  }
  return sum;
}

}  // namespace dragcore
