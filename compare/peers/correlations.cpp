#include "compare/peers/correlations.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <dragcore/mesh.hpp>
#include <numbers>

namespace peers {
namespace {

using std::pow;

double haider_levenspiel(double re, const Particle& p) {
  const double phi = p.sphericity;
  const double a = std::exp(2.3288 + phi * (-6.4581 + phi * 2.4486));
  const double b = 0.0964 + 0.5565 * phi;
  const double c = std::exp(4.905 + phi * (-13.8944 + phi * (18.4222 - phi * 10.2599)));
  const double d = std::exp(1.4681 + phi * (12.2584 + phi * (-20.7322 + phi * 15.8855)));
  return 24.0 / re * (1.0 + a * pow(re, b)) + c / (1.0 + d / re);
}

double ganser(double re, const Particle& p) {
  const double silhouette = 1.0 / std::sqrt(p.crosswise);  // its diameter / d_v
  const double stokes = 1.0 / (silhouette / 3.0 + 2.0 / (3.0 * std::sqrt(p.sphericity)));
  const double newton = pow(10.0, 1.8148 * pow(-std::log10(p.sphericity), 0.5743));
  const double x = re * stokes * newton;
  return newton * (24.0 / x * (1.0 + 0.1118 * pow(x, 0.6567)) + 0.4305 / (1.0 + 3305.0 / x));
}

double hoelzer_sommerfeld(double re, const Particle& p) {
  return 8.0 / (re * std::sqrt(p.lengthwise)) + 16.0 / (re * std::sqrt(p.sphericity)) + 3.0 / (std::sqrt(re) * pow(p.sphericity, 0.75)) +
         0.42 * pow(10.0, 0.4 * pow(-std::log10(p.sphericity), 0.2)) / p.crosswise;
}

double clift_gauvin(double re, const Particle&) {
  return 24.0 / re * (1.0 + 0.15 * pow(re, 0.687)) + 0.42 / (1.0 + 4.25e4 * pow(re, -1.16));
}

}  // namespace

std::optional<Particle> particle(const dragcore::Shape& shape, const Eigen::Vector3d& wind) {
  const dragcore::ShapeProperties body = dragcore::properties(shape);
  if (std::holds_alternative<dragcore::MeshBody>(shape) || !(body.volume > 0.0)) return std::nullopt;
  // A silhouette of a convex body is half of what its faces show along that direction; the mean over all directions square to the wind has
  // the mean |cos| = 2 / pi.
  const dragcore::TriangleMesh mesh = dragcore::triangulate(shape, 32);
  const Eigen::Vector3d along = wind.normalized();
  double area = 0.0, silhouette = 0.0, mean_across = 0.0;
  for (const auto& t : mesh.triangles) {
    const auto corner = [&](int k) -> const Eigen::Vector3d& { return mesh.vertices[static_cast<std::size_t>(t[k])]; };
    const Eigen::Vector3d face = 0.5 * (corner(1) - corner(0)).cross(corner(2) - corner(0));
    area += face.norm();
    silhouette += 0.5 * std::abs(face.dot(along));
    mean_across += face.cross(along).norm() / std::numbers::pi;
  }
  const double facets = body.area / area;  // a ball of facets is no ball: the correlations would feel a sphericity of 0.999
  Particle p;
  p.diameter = std::cbrt(6.0 * body.volume / std::numbers::pi);
  const double ball = std::numbers::pi * p.diameter * p.diameter;
  p.sphericity = std::min(1.0, ball / body.area);
  p.crosswise = ball / 4.0 / (facets * silhouette);
  p.lengthwise = ball / 4.0 / (body.area / 2.0 - facets * mean_across);
  return p;
}

const std::vector<Correlation>& correlations() {
  static const std::vector<Correlation> list = {{"Haider-Levenspiel", "haider_levenspiel_1989", false, haider_levenspiel},
                                                {"Ganser", "ganser_1993", false, ganser},
                                                {"H\u00f6lzer-Sommerfeld", "hoelzer_sommerfeld_2008", false, hoelzer_sommerfeld},
                                                {"Clift-Gauvin", "clift_gauvin_1970", true, clift_gauvin}};
  return list;
}

}  // namespace peers
