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
    case Quadrature::one: return one;
    case Quadrature::three: return three;
    case Quadrature::six: return six;
  }
  return three;
}

/// @throws std::invalid_argument as wrench() says
void check_input(const Motion& motion, const Medium& medium, const Model& model);

}  // namespace dragcore
