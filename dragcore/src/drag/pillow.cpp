#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <dragcore/pillow.hpp>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <utility>

#include "support/gauss_legendre.hpp"

namespace dragcore {

namespace {

using Eigen::Vector3d;

// The circular falloff sqrt(1 - s^2) has a root at the trailing edge, s = 1. With y = sqrt(1 - s) it is y sqrt(2 - y^2), analytic on the
// whole face, so that Gauss points in y converge geometrically: the nearest singularity is at y = sqrt(2). 16 points reach rounding.
const GaussLegendre<16>& gauss() {
  static const GaussLegendre<16> rule;
  return rule;
}

/// Integrals over a triangle of height 1 at s = beta, by thickness h(s): D = int g h ds, N = int s g h ds, P = int g h^2 ds, with g =
/// sqrt(1 - s^2).
struct FalloffIntegrals {
  double d = 0.0, n = 0.0, p = 0.0;
};

FalloffIntegrals integrate_falloff(double y_beta) {
  FalloffIntegrals sum;
  const auto add = [&sum](double y, double thickness, double ds) {
    const double g = y * std::sqrt(2.0 - y * y) * ds;
    sum.d += g * thickness;
    sum.n += g * thickness * (1.0 - y * y);
    sum.p += g * thickness * thickness;
  };
  for (int i = 0; i < 16; ++i) {
    const double x = gauss().point[i], weight = gauss().weight[i];
    const double before = y_beta + (1.0 - y_beta) * x;  // s from beta down to 0; ds = 2 y dy
    add(before, (1.0 - x) * (1.0 + before) / (1.0 + y_beta), weight * 2.0 * before * (1.0 - y_beta));
    const double behind = y_beta * x;  // s from 1 down to beta
    add(behind, x * x, weight * 2.0 * behind * y_beta);
  }
  return sum;
}

/// The three integrals as Chebyshev series in 2 sqrt(1 - beta) - 1, in which they are analytic: one table serves every triangle.
class FalloffTable {
 public:
  static constexpr int terms = 32;

  FalloffTable() {
    std::array<FalloffIntegrals, terms> value;
    for (int j = 0; j < terms; ++j) value[j] = integrate_falloff(0.5 * (1.0 + std::cos(std::numbers::pi * (j + 0.5) / terms)));
    for (int k = 0; k < terms; ++k)
      for (int j = 0; j < terms; ++j) {
        const double factor = (k == 0 ? 1.0 : 2.0) / terms * std::cos(std::numbers::pi * k * (j + 0.5) / terms);
        coefficient_[k] += factor * Vector3d(value[j].d, value[j].n, value[j].p);
      }
  }

  FalloffIntegrals at(double beta) const {
    const double z = 2.0 * std::sqrt(1.0 - beta) - 1.0;
    Vector3d b1 = Vector3d::Zero(), b2 = Vector3d::Zero();  // Clenshaw's recurrence
    for (int k = terms - 1; k > 0; --k) {
      const Vector3d b0 = coefficient_[k] + 2.0 * z * b1 - b2;
      b2 = b1;
      b1 = b0;
    }
    const Vector3d sum = coefficient_[0] + z * b1 - b2;
    return {sum[0], sum[1], sum[2]};
  }

 private:
  std::array<Vector3d, terms> coefficient_{};
  static_assert(sizeof(Vector3d) == 3 * sizeof(double));
};

/// Tangential direction of the flow over a face and the span of the outline along it; chord 0 where there is no direction.
struct ChordFrame {
  Vector3d along = Vector3d::Zero();
  double leading = 0.0, chord = 0.0;
};

ChordFrame chord_frame(const Patch& patch, const Vector3d& u) {
  ChordFrame frame;
  const Vector3d tangential = u - patch.normal * patch.normal.dot(u);
  const double size = tangential.norm();
  // Below this the direction is rounding error of the projection.
  if (!(size > 1e-14 * u.norm())) return frame;
  frame.along = tangential / size;
  double low = std::numeric_limits<double>::max(), high = std::numeric_limits<double>::lowest();
  for (const auto& [from, to] : patch.outline) {
    const double position = frame.along.dot(from - patch.centroid);
    low = std::min(low, position);
    high = std::max(high, position);
  }
  frame.leading = low;
  frame.chord = std::max(0.0, high - low);
  return frame;
}

}  // namespace

std::string to_string(PillowForm form) {
  switch (form) {
    case PillowForm::none:
      return "none";
    case PillowForm::triangle:
      return "triangle";
    case PillowForm::patch:
      return "patch";
    case PillowForm::tilt:
      return "tilt";
    case PillowForm::eccentricity:
      return "eccentricity";
  }
  throw std::invalid_argument("not a pillow form");
}

PillowForm pillow_form_from(const std::string& word) {
  for (const PillowForm form : {PillowForm::none, PillowForm::triangle, PillowForm::patch, PillowForm::tilt, PillowForm::eccentricity})
    if (to_string(form) == word) return form;
  throw std::invalid_argument("unknown pillow form '" + word + "'; known: none, triangle, patch, tilt, eccentricity");
}

std::string to_string(Falloff falloff) { return falloff == Falloff::linear ? "linear" : "circular"; }

Falloff falloff_from(const std::string& word) {
  for (const Falloff falloff : {Falloff::circular, Falloff::linear})
    if (to_string(falloff) == word) return falloff;
  throw std::invalid_argument("unknown falloff '" + word + "'; known: circular, linear");
}

Vector3d triangle_pillow_weights(double beta, double alpha, Falloff falloff) {
  if (falloff == Falloff::linear) {
    // Integral of 1 - alpha s times a barycentric coordinate: (1/3 - alpha (sum of s + its own s)/12) of the area.
    const Vector3d s(0.0, beta, 1.0);
    return (Vector3d::Constant(1.0 / 3.0) - alpha / 12.0 * (Vector3d::Constant(1.0 + beta) + s)) / (1.0 - alpha * (1.0 + beta) / 3.0);
  }
  static const FalloffTable table;
  const FalloffIntegrals circular = table.at(std::clamp(beta, 0.0, 1.0));
  const double area = alpha * circular.d + (1.0 - alpha) / 2.0;
  const double along = (alpha * circular.n + (1.0 - alpha) * (1.0 + beta) / 6.0) / area;
  const double middle = 0.5 * (alpha * circular.p + (1.0 - alpha) / 3.0) / area;
  return {1.0 - along - (1.0 - beta) * middle, middle, along - beta * middle};
}

double faded_pillow_factor(double alpha, double c) {
  const double x = std::clamp((1.0 - c) / 0.25, 0.0, 1.0);
  return alpha * x * x * (3.0 - 2.0 * x);
}

Vector3d triangle_pillow_shift(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& u, double alpha, Falloff falloff) {
  const Vector3d normal = (b - a).cross(c - a).normalized();
  const Vector3d tangential = u - normal * normal.dot(u);
  const double size = tangential.norm();
  if (alpha == 0.0 || !(size > 1e-14 * u.norm())) return Vector3d::Zero();
  const Vector3d along = tangential / size, centroid = (a + b + c) / 3.0;
  std::array<std::pair<double, Vector3d>, 3> vertex{
      {{along.dot(a - centroid), a}, {along.dot(b - centroid), b}, {along.dot(c - centroid), c}}};
  std::sort(vertex.begin(), vertex.end(), [](const auto& left, const auto& right) { return left.first < right.first; });
  const double length = vertex[2].first - vertex[0].first;
  if (!(length > 0.0)) return Vector3d::Zero();
  const Vector3d weights = triangle_pillow_weights((vertex[1].first - vertex[0].first) / length, alpha, falloff);
  return weights[0] * (vertex[0].second - centroid) + weights[1] * (vertex[1].second - centroid) +
         weights[2] * (vertex[2].second - centroid);
}

Vector3d eccentricity_pillow_shift(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& u, double alpha) {
  const Vector3d normal = (b - a).cross(c - a).normalized();
  const Vector3d tangential = u - normal * normal.dot(u);
  if (!(tangential.norm() > 1e-14 * u.norm())) return Vector3d::Zero();
  const Vector3d along = tangential.normalized(), across = normal.cross(along);
  const double ab = (b - a).norm(), bc = (c - b).norm(), ca = (a - c).norm();
  const Vector3d eccentricity = (bc * a + ca * b + ab * c) / (ab + bc + ca) - (a + b + c) / 3.0;
  return along * along.dot(triangle_pillow_shift(a, b, c, u, alpha)) + across * across.dot(eccentricity);
}

Vector3d patch_pillow_shift(const Patch& patch, const Vector3d& u, double alpha, Falloff falloff) {
  const ChordFrame frame = chord_frame(patch, u);
  if (alpha == 0.0 || !(frame.chord > 0.0)) return Vector3d::Zero();
  const Vector3d across = patch.normal.cross(frame.along);
  // Green's theorem: int F dA = -oint (int_0^h F dh) ds for an outline that runs counterclockwise in (s, h). h is measured in chords too.
  double area = 0.0, moment_s = 0.0, moment_h = 0.0;
  for (const auto& [from, to] : patch.outline) {
    const double s_from = std::clamp((frame.along.dot(from - patch.centroid) - frame.leading) / frame.chord, 0.0, 1.0);
    const double s_to = std::clamp((frame.along.dot(to - patch.centroid) - frame.leading) / frame.chord, 0.0, 1.0);
    const double h_from = across.dot(from - patch.centroid) / frame.chord, h_to = across.dot(to - patch.centroid) / frame.chord;
    const double y_from = std::sqrt(1.0 - s_from), y_to = std::sqrt(1.0 - s_to);
    if (y_from + y_to == 0.0) continue;  // along the trailing edge: ds = 0
    for (int i = 0; i < 16; ++i) {
      const double x = gauss().point[i];
      const double y = y_from + (y_to - y_from) * x, s = 1.0 - y * y;
      const double h = h_from + (h_to - h_from) * x * (y_from + y) / (y_from + y_to);  // linear in s, without dividing by ds
      const double f = alpha * (falloff == Falloff::linear ? y * y : y * std::sqrt(2.0 - y * y)) + 1.0 - alpha;
      const double minus_ds = gauss().weight[i] * 2.0 * y * (y_to - y_from);
      area += f * h * minus_ds;
      moment_s += f * s * h * minus_ds;
      moment_h += 0.5 * f * h * h * minus_ds;
    }
  }
  if (!(area > 0.0)) return Vector3d::Zero();  // an outline that rounding has emptied
  return frame.along * (moment_s / area * frame.chord + frame.leading) + across * (moment_h / area * frame.chord);
}

Vector3d tilt_pillow_shift(const Vector3d& normal, const Eigen::Matrix3d& second_moment, const Vector3d& u, double kappa) {
  const double speed = u.norm();
  const Vector3d tangential = u - normal * normal.dot(u);
  const double size = tangential.norm();
  // Below this the direction is rounding error of the projection.
  if (!(size > 1e-14 * speed)) return Vector3d::Zero();
  const Vector3d along = tangential / size, moment = second_moment * along;
  const double square = along.dot(moment);
  if (!(square > 0.0)) return Vector3d::Zero();
  return -kappa * size / speed / std::sqrt(3.0 * square) * (moment - normal * normal.dot(moment));
}

}  // namespace dragcore
