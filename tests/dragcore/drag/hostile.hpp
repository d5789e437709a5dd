#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <dragcore/drag.hpp>
#include <vector>

#include "tests/support/zoo.hpp"

/// Bodies, motions and models that nobody would choose, each from a seed of its own: a failure names the seed and is repeated by it alone.
namespace hostile {

using Eigen::Matrix3d;
using Eigen::Vector3d;

struct Body {
  dragcore::TriangleMesh mesh;
  dragcore::Surface::Sides sides = dragcore::Surface::Sides::one;

  dragcore::Surface surface() const { return dragcore::Surface(mesh, sides); }
};

/// 1 to 8 triangles over few vertices, so that they share corners and edges. No winding, no plane, no order.
inline Body soup(zoo::Random& random, bool degenerate) {
  Body body{.sides = dragcore::Surface::Sides::two};
  const int count = 1 + static_cast<int>(random.uniform(0.0, 7.999)), corners = 3 + static_cast<int>(random.uniform(0.0, 5.999));
  for (int i = 0; i < corners; ++i) body.mesh.vertices.push_back(random.vector(1.0));
  for (int i = 0; i < count; ++i) {
    const int a = static_cast<int>(random.uniform(0.0, corners - 1e-9)),
              step = 1 + static_cast<int>(random.uniform(0.0, corners - 2 - 1e-9));
    const int b = (a + step) % corners, c = (b + 1) % corners;
    body.mesh.triangles.emplace_back(a, b, c);
  }
  if (!degenerate) return body;
  // A sliver of 1e-12 to 1, a triangle without area, one that repeats a corner and one that repeats another triangle.
  const Vector3d a = body.mesh.vertices[0], b = body.mesh.vertices[1];
  const int next = static_cast<int>(body.mesh.vertices.size());
  body.mesh.vertices.push_back(0.3 * a + 0.7 * b + std::pow(10.0, random.uniform(-12.0, -1.0)) * random.vector(1.0));
  body.mesh.vertices.push_back(0.5 * (a + b));
  body.mesh.triangles.emplace_back(0, 1, next);
  body.mesh.triangles.emplace_back(0, next + 1, 1);
  body.mesh.triangles.emplace_back(1, 1, 2);
  body.mesh.triangles.push_back(body.mesh.triangles.front());
  return body;
}

/// Tetrahedron, box or cone, stretched, turned and mirrored: closed, wound outwards.
inline Body closed(zoo::Random& random) {
  Body body;
  const double kind = random.uniform(0.0, 1.0);
  if (kind < 0.5) {
    Vector3d v[4];
    do {
      for (Vector3d& corner : v) corner = random.vector(1.0);
    } while (std::abs((v[1] - v[0]).cross(v[2] - v[0]).dot(v[3] - v[0])) < 1e-3);
    const bool outward = (v[1] - v[0]).cross(v[2] - v[0]).dot(v[3] - v[0]) < 0.0;
    body.mesh.vertices = {v[0], v[1], v[2], v[3]};
    body.mesh.triangles = {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}};
    if (!outward) body.mesh = dragcore::TriangleMesh{{v[0], v[2], v[1], v[3]}, body.mesh.triangles};
    return body;
  }
  const dragcore::Shape shape = kind < 0.9 ? dragcore::Shape(dragcore::Box{}) : dragcore::Shape(dragcore::Cone{});
  Vector3d stretch{std::exp(random.uniform(-1.5, 0.5)), std::exp(random.uniform(-1.5, 0.5)), std::exp(random.uniform(-1.5, 0.5))};
  if (kind < 0.7) stretch.z() *= -1.0;
  body.mesh = dragcore::transformed(dragcore::triangulate(shape, 1), random.rotation() * stretch.asDiagonal() * random.rotation(),
                                    random.vector(1.0));
  return body;
}

inline Body body(zoo::Random& random, bool degenerate) {
  return random.uniform(0.0, 1.0) < 0.5 ? soup(random, degenerate) : closed(random);
}

/// Anything validate() lets through, with pushing terms of any strength. `edges`: with forces that jump where a face turns edge-on, W(0) or
/// L(0) not 0.
inline dragcore::Law wild_law(zoo::Random& random, bool edges) {
  dragcore::Law law{.name = "wild"};
  for (std::size_t k = edges ? 0 : 1; k < 5; ++k) {
    law.windward[k] = random.uniform(-3.0, 3.0);
    law.leeward[k] = random.uniform(-3.0, 3.0);
  }
  const auto maybe = [&](double largest) { return random.uniform(0.0, 1.0) < 0.5 ? random.uniform(0.0, largest) : 0.0; };
  law.friction = maybe(0.1);
  law.base_suction = maybe(2.0);
  law.base_edge = std::exp(random.uniform(-4.0, 1.0));
  law.aspect_gain = maybe(3.0);
  law.aspect_scale = std::exp(random.uniform(-1.0, 4.0));
  law.recovery = maybe(1.0);
  law.recovery_depth = std::exp(random.uniform(-3.0, 2.0));
  law.recovery_edge = std::exp(random.uniform(-4.0, 1.0));
  law.shelter = maybe(5.0);
  law.curvature = maybe(5.0);
  return law;
}

inline std::vector<dragcore::Law> laws() {
  using namespace dragcore;
  return {note_law(), consistent_law(), sheet_law(), closed_law(), scaled_law(0.89, 0.25)};
}

inline std::vector<dragcore::Pillow> pillows() {
  using namespace dragcore;
  return {{},
          {PillowForm::triangle, 0.9},
          {PillowForm::triangle, 0.9, Falloff::linear},
          {PillowForm::patch, 0.9},
          {PillowForm::patch, 1.0, Falloff::linear},
          {PillowForm::tilt, 1.4},
          {PillowForm::eccentricity, 0.7}};
}

/// `masked`: now and then with some effects left out.
inline dragcore::Model model(zoo::Random& random, bool wild, bool masked) {
  using namespace dragcore;
  Model model;
  const auto pick = [&](const auto& list) {
    return list[static_cast<std::size_t>(random.uniform(0.0, static_cast<double>(list.size()) - 1e-9))];
  };
  static const std::vector<Law> known = laws();
  static const std::vector<Pillow> cushions = pillows();
  model.law = wild ? wild_law(random, true) : pick(known);
  model.pillow = pick(cushions);
  model.quadrature = pick(std::vector{Quadrature::adaptive, Quadrature::one, Quadrature::three, Quadrature::six});
  if (masked && random.uniform(0.0, 1.0) < 0.2)
    for (unsigned i = 0; i < effect_count; ++i)
      if (random.uniform(0.0, 1.0) < 0.3) model.effects = model.effects.without(static_cast<Effect>(1u << i));
  return model;
}

/// Both: the core in double, and the kernels. Where the library has none, the second is the first.
inline constexpr dragcore::Precision precisions[] = {dragcore::Precision::full, dragcore::Precision::single};

inline bool known_to_kernels(const dragcore::Pillow& pillow) {
  return pillow.form == dragcore::PillowForm::none || pillow.form == dragcore::PillowForm::tilt;
}

/// The same model in a precision; in single the nearest one that the kernels know, so that it is they who are tried: the tilt form for
/// other pillows, and no polynomial of a wild law changes sign.
inline dragcore::Model in(dragcore::Precision precision, dragcore::Model model) {
  using namespace dragcore;
  model.precision = precision;
  if (precision == Precision::full) return model;
  if (!known_to_kernels(model.pillow)) model.pillow = {PillowForm::tilt, model.pillow.factor};
  if (model.law.name == "wild")
    for (Law::Polynomial* p : {&model.law.windward, &model.law.leeward})
      for (double& k : *p) k = std::abs(k);
  return model;
}

/// Rounding of a result of its precision, of what its largest speed and all its area could make: given for double; and what docs/speed.md
/// promises of single, 1e-6, for a body that is not made of slivers.
inline double rounding(dragcore::Precision precision, double of_double) {
  return precision == dragcore::Precision::single ? std::max(1e-6, of_double) : of_double;
}

/// Wind, travel and spin of any ratio: none of the three, one or all.
inline dragcore::Motion motion(zoo::Random& random) {
  dragcore::Motion motion{.velocity = random.vector(10.0), .reference_point = random.vector(1.0)};
  const double kind = random.uniform(0.0, 1.0);
  if (kind > 0.2) motion.wind = random.vector(10.0);
  if (kind > 0.4) motion.angular_velocity = std::pow(10.0, random.uniform(-4.0, 3.0)) * random.vector(1.0);
  if (kind > 0.95) motion.velocity = motion.wind;  // spin alone
  return motion;
}

/// Half density times the square of the largest speed of any point, times all area: no force of a coefficient of 1 is larger.
inline double force_scale(const dragcore::Surface& surface, const dragcore::Motion& motion, double density) {
  const double arm =
      (surface.centre - motion.reference_point).norm() + 2.0 * surface.radius;  // a pillow moves a point by less than a radius
  double wind = motion.wind.norm() + motion.wind_gradient.norm() * arm;
  for (const Vector3d& w : motion.triangle_wind) wind = std::max(wind, w.norm());
  const double speed = wind + motion.velocity.norm() + motion.angular_velocity.norm() * arm;
  return 0.5 * density * speed * speed * surface.total_area * (surface.two_sided() ? 2.0 : 1.0);
}

inline double arm_scale(const dragcore::Surface& surface, const dragcore::Motion& motion) {
  return (surface.centre - motion.reference_point).norm() + 2.0 * surface.radius;
}

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr int sanitizer_divisor = 10;  // a sanitizer costs a factor of 10 to 30; what it looks for needs no 100,000 cases
#else
inline constexpr int sanitizer_divisor = 1;
#endif

}  // namespace hostile
