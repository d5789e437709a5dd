#pragma once

#include <array>
#include <dragcore/drag.hpp>
#include <span>

namespace dragcore {

/// A point of a triangle rule: its place a + s ab + t ac, and its share of the area.
struct QuadraturePoint {
  double s, t, weight;
};

/// One, three and six interior points, exact to degree 1, 2 and 4 [dunavant1985].
inline std::span<const QuadraturePoint> quadrature_rule(Quadrature order) {
  static constexpr std::array<QuadraturePoint, 1> one{{{1.0 / 3.0, 1.0 / 3.0, 1.0}}};
  static constexpr std::array<QuadraturePoint, 3> three{
      {{1.0 / 6.0, 1.0 / 6.0, 1.0 / 3.0}, {2.0 / 3.0, 1.0 / 6.0, 1.0 / 3.0}, {1.0 / 6.0, 2.0 / 3.0, 1.0 / 3.0}}};
  constexpr double a = 0.445948490915964886318329253883, wa = 0.223381589678011465851945229553;
  constexpr double b = 0.091576213509770743459571463402, wb = 0.109951743655321867481388103780;
  static constexpr std::array<QuadraturePoint, 6> six{
      {{a, a, wa}, {a, 1.0 - 2.0 * a, wa}, {1.0 - 2.0 * a, a, wa}, {b, b, wb}, {b, 1.0 - 2.0 * b, wb}, {1.0 - 2.0 * b, b, wb}}};
  switch (order) {
    case Quadrature::one:
      return one;
    case Quadrature::three:
      return three;
    case Quadrature::six:
      return six;
    case Quadrature::adaptive:
      break;
  }
  return three;
}

/// Shares of the three rules in an adaptive one; their sum is 1.
struct QuadratureShares {
  double one, three, six;
};

/// @param variation  of the velocity between the centroid and the corners of a triangle, and `speed` at its centroid [m/s]
inline QuadratureShares adaptive_shares(double variation, double speed) {
  // Smooth step of `variation` from low * speed to high * speed: products, so that no speed divides by zero.
  const auto rise = [&](double low, double high) {
    const double x = variation - low * speed, range = (high - low) * speed;
    if (!(x > 0.0)) return 0.0;
    if (x >= range) return 1.0;
    const double y = x / range;
    return y * y * (3.0 - 2.0 * y);
  };
  const double three = rise(0.002, 0.004), six = rise(0.5, 1.0);
  return {1.0 - three, three * (1.0 - six), three * six};
}

}  // namespace dragcore
