#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <dragcore/shapes.hpp>
#include <dragcore/unknown_word.hpp>
#include <numbers>
#include <numeric>
#include <set>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "support/ellipsoid_integrals.hpp"

namespace dragcore {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3i;
using std::numbers::pi;

template <class... Ts>
struct Overload : Ts... {
  using Ts::operator()...;
};
template <class... Ts>
Overload(Ts...) -> Overload<Ts...>;  // clang 14 cannot deduce an aggregate's arguments

void require(bool good, const char* shape, const char* parameter, double value, const char* needed) {
  if (good && std::isfinite(value)) return;
  std::ostringstream message;
  message << shape << ": " << parameter << " = " << value << ", but it must be " << needed;
  throw std::invalid_argument(message.str());
}
void require_positive(const char* shape, const char* parameter, double value) {
  require(value > 0.0, shape, parameter, value, "finite and greater than 0 (metres)");
}

void check(const Plate& s) {
  require_positive("plate", "chord", s.chord);
  require_positive("plate", "span", s.span);
  require(s.thickness >= 0.0, "plate", "thickness", s.thickness, "finite and at least 0 (metres; 0 makes a sheet)");
}
void check(const Box& s) {
  require_positive("box", "length", s.length);
  require_positive("box", "width", s.width);
  require_positive("box", "height", s.height);
}
void check(const Cone& s) {
  require_positive("cone", "diameter", s.diameter);
  require(s.apex_angle > 0.0 && s.apex_angle < pi, "cone", "apex_angle", s.apex_angle,
          "between 0 and pi, both excluded (radians, the full angle)");
}
void check(const Sphere& s) { require_positive("sphere", "diameter", s.diameter); }
void check(const Cylinder& s) {
  require_positive("cylinder", "diameter", s.diameter);
  require_positive("cylinder", "length", s.length);
}
void check(const Ellipsoid& s) {
  require_positive("ellipsoid", "semi_x", s.semi_x);
  require_positive("ellipsoid", "semi_y", s.semi_y);
  require_positive("ellipsoid", "semi_z", s.semi_z);
}
void check(const Teardrop& s) {
  require_positive("teardrop", "diameter", s.diameter);
  require(s.length > s.diameter, "teardrop", "length", s.length, "greater than its diameter");
}

void check(const Prism& s) {
  require_positive("prism", "base", s.base);
  require_positive("prism", "span", s.span);
  require(s.apex_angle > 0.0 && s.apex_angle < pi, "prism", "apex_angle", s.apex_angle,
          "between 0 and pi, both excluded (radians, the full angle)");
}

double height_of_point(double base, double apex_angle) { return 0.5 * base / std::tan(0.5 * apex_angle); }

/// The teardrop's parts, x measured from the nose: where sphere and cone touch, and the volumes and centroids of the two.
struct TeardropParts {
  double radius, centre_to_tail, x_joint, r_joint, volume_sphere, volume_cone, centroid;
};
TeardropParts parts(const Teardrop& s) {
  const double r = 0.5 * s.diameter, d = s.length - r;
  const double beyond = r * r / d;  // the tangent circle lies this far behind the sphere's centre
  const double cap = r + beyond;    // height of the part of the sphere that is kept
  const double cone = d - beyond;   // height of the cone
  TeardropParts p{};
  p.radius = r;
  p.centre_to_tail = d;
  p.x_joint = cap;
  p.r_joint = r * std::sqrt(1.0 - (r / d) * (r / d));
  p.volume_sphere = pi * cap * cap * (3.0 * r - cap) / 3.0;
  p.volume_cone = pi * p.r_joint * p.r_joint * cone / 3.0;
  const double centroid_sphere = r - 0.75 * (2.0 * r - cap) * (2.0 * r - cap) / (3.0 * r - cap);
  const double centroid_cone = cap + 0.25 * cone;
  p.centroid = (p.volume_sphere * centroid_sphere + p.volume_cone * centroid_cone) / (p.volume_sphere + p.volume_cone);
  return p;
}

/// pi (a b c)^2 times the integral of tau (s_x + s_y + s_z) sqrt(s_x s_y s_z), s_i = 1/(1 + tau a_i^2), over 0 < tau < infinity: Carlson's
/// R_G of the squared products of two semi-axes each. Not singular where semi-axes are equal, as Legendre's elliptic integrals are.
double ellipsoid_area(const Ellipsoid& s) {
  const Vector3d semi(s.semi_x, s.semi_y, s.semi_z), scaled = semi / semi.maxCoeff();
  double integral = 0.0;
  for_each_ellipsoid_node(scaled, [&integral](double tau, double d_tau, const Vector3d& shrink, double root) {
    integral += tau * shrink.sum() * root * d_tau;
  });
  return pi * std::pow(scaled.prod() * semi.maxCoeff(), 2) * integral;
}

void check_divisions(int divisions) {
  if (divisions < 1 || divisions > 4096)
    throw std::invalid_argument("triangulate: divisions = " + std::to_string(divisions) + ", but it must be from 1 to 4096");
}

/// The six faces of a box as lattices; vertices of neighbouring faces are equal to the bit, and joined at the end.
TriangleMesh box_mesh(const Vector3d& size, const Vector3i& divisions) {
  TriangleMesh mesh;
  const auto coordinate = [&](int axis, int i) { return size[axis] * (static_cast<double>(i) / divisions[axis] - 0.5); };
  for (int axis = 0; axis < 3; ++axis) {
    const int a = (axis + 1) % 3, b = (axis + 2) % 3;  // right-handed: a x b = axis
    for (const int end : {0, divisions[axis]}) {
      const int first = static_cast<int>(mesh.vertices.size());
      const auto index = [&](int i, int j) { return first + i * (divisions[b] + 1) + j; };
      for (int i = 0; i <= divisions[a]; ++i)
        for (int j = 0; j <= divisions[b]; ++j) {
          Vector3d v;
          v[axis] = coordinate(axis, end);
          v[a] = coordinate(a, i);
          v[b] = coordinate(b, j);
          mesh.vertices.push_back(v);
        }
      for (int i = 0; i < divisions[a]; ++i)
        for (int j = 0; j < divisions[b]; ++j) {
          Vector3i lower(index(i, j), index(i + 1, j), index(i + 1, j + 1)), upper(index(i, j), index(i + 1, j + 1), index(i, j + 1));
          if (end == 0) std::swap(lower[1], lower[2]), std::swap(upper[1], upper[2]);
          mesh.triangles.push_back(lower);
          mesh.triangles.push_back(upper);
        }
    }
  }
  return welded(mesh);
}

/// Two triangles at y = -+ span/2 and the three rectangles between them; edges that faces share are equal to the bit, and joined at the
/// end.
TriangleMesh prism_mesh(const std::array<Vector2d, 3>& corners, double span, int n) {
  TriangleMesh mesh;
  // Point (a, b, c)/n of the triangle (corners in x and z, integer weights), at step k along y.
  const auto point = [&](int a, int b, int c, int k) {
    const Vector2d p = (a * corners[0] + b * corners[1] + c * corners[2]) / n;
    return Vector3d(p.x(), span * (static_cast<double>(k) / n - 0.5), p.y());
  };
  const auto add = [&](const Vector3d& p, const Vector3d& q, const Vector3d& r) {
    const int first = static_cast<int>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), {p, q, r});
    mesh.triangles.emplace_back(first, first + 1, first + 2);
  };
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n - i; ++j) {
      const auto at = [&](int di, int dj, int k) { return point(n - i - j - di - dj, i + di, j + dj, k); };
      add(at(0, 0, 0), at(1, 0, 0), at(0, 1, 0));
      add(at(0, 0, n), at(0, 1, n), at(1, 0, n));
      if (j + 1 == n - i) continue;
      add(at(1, 0, 0), at(1, 1, 0), at(0, 1, 0));
      add(at(1, 0, n), at(0, 1, n), at(1, 1, n));
    }
  for (int side = 0; side < 3; ++side)
    for (int i = 0; i < n; ++i)
      for (int k = 0; k < n; ++k) {
        const auto at = [&](int di, int dk) {
          Vector3i weight = Vector3i::Zero();
          weight[side] = n - i - di;
          weight[(side + 1) % 3] = i + di;
          return point(weight[0], weight[1], weight[2], k + dk);
        };
        add(at(0, 0), at(0, 1), at(1, 1));
        add(at(0, 0), at(1, 1), at(1, 0));
      }
  return welded(mesh);
}

/// A rectangle in the plane z = 0, normal +z.
TriangleMesh sheet_mesh(double chord, double span, int n) {
  TriangleMesh mesh;
  const auto index = [n](int i, int j) { return i * (n + 1) + j; };
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j)
      mesh.vertices.emplace_back(chord * (static_cast<double>(i) / n - 0.5), span * (static_cast<double>(j) / n - 0.5), 0.0);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      mesh.triangles.emplace_back(index(i, j), index(i + 1, j), index(i + 1, j + 1));
      mesh.triangles.emplace_back(index(i, j), index(i + 1, j + 1), index(i, j + 1));
    }
  return mesh;
}

/// The eight faces of an octahedron, each split n x n, pushed out onto the unit sphere and stretched.
TriangleMesh ellipsoid_mesh(const Vector3d& semi_axes, int n) {
  TriangleMesh mesh;
  for (int octant = 0; octant < 8; ++octant) {
    const Vector3d sign(octant & 1 ? -1 : 1, octant & 2 ? -1 : 1, octant & 4 ? -1 : 1);
    const int first = static_cast<int>(mesh.vertices.size());
    // Row i has n - i + 1 points; integer coordinates (n-i-j, i, j) make the shared edges equal to the bit.
    const auto index = [&](int i, int j) { return first + i * (n + 1) - i * (i - 1) / 2 + j; };
    for (int i = 0; i <= n; ++i)
      for (int j = 0; j <= n - i; ++j)
        mesh.vertices.push_back(Vector3d(n - i - j, i, j).normalized().cwiseProduct(sign).cwiseProduct(semi_axes));
    const bool mirrored = sign.prod() < 0;
    const auto add = [&](int a, int b, int c) { mesh.triangles.push_back(mirrored ? Vector3i(a, c, b) : Vector3i(a, b, c)); };
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n - i; ++j) {
        add(index(i, j), index(i + 1, j), index(i, j + 1));
        if (j + 1 < n - i) add(index(i + 1, j), index(i + 1, j + 1), index(i, j + 1));
      }
  }
  // -0.0 and 0.0 are the same place: welded() compares values.
  return welded(mesh);
}

/// The surface swept by a profile (x, r) that starts and ends on the axis and runs from nose to tail.
TriangleMesh revolved_mesh(const std::vector<Vector2d>& profile, int segments) {
  TriangleMesh mesh;
  const int rings = static_cast<int>(profile.size()) - 2;
  mesh.vertices.emplace_back(profile.front().x(), 0.0, 0.0);
  for (int ring = 1; ring <= rings; ++ring)
    for (int k = 0; k < segments; ++k) {
      const double angle = 2.0 * pi * k / segments;
      mesh.vertices.emplace_back(profile[ring].x(), profile[ring].y() * std::cos(angle), profile[ring].y() * std::sin(angle));
    }
  mesh.vertices.emplace_back(profile.back().x(), 0.0, 0.0);
  const int tail = static_cast<int>(mesh.vertices.size()) - 1;
  const auto index = [segments](int ring, int k) { return 1 + (ring - 1) * segments + k % segments; };
  for (int k = 0; k < segments; ++k) {
    mesh.triangles.emplace_back(0, index(1, k + 1), index(1, k));
    for (int ring = 1; ring < rings; ++ring) {
      mesh.triangles.emplace_back(index(ring, k), index(ring, k + 1), index(ring + 1, k + 1));
      mesh.triangles.emplace_back(index(ring, k), index(ring + 1, k + 1), index(ring + 1, k));
    }
    mesh.triangles.emplace_back(tail, index(rings, k), index(rings, k + 1));
  }
  return mesh;
}

void append_segment(std::vector<Vector2d>& profile, const Vector2d& to, int divisions) {
  const Vector2d from = profile.back();
  for (int i = 1; i <= divisions; ++i)
    profile.push_back(i == divisions ? to : Vector2d(from + (to - from) * (static_cast<double>(i) / divisions)));
}

}  // namespace

ShapeProperties properties(const Shape& shape) {
  return std::visit(Overload{[](const Plate& s) {
                               check(s);
                               const bool sheet = s.thickness == 0.0;
                               ShapeProperties p;
                               p.area = sheet ? s.chord * s.span : 2.0 * (s.chord * s.span + s.thickness * (s.chord + s.span));
                               p.volume = s.chord * s.span * s.thickness;
                               p.reference_area = s.chord * s.span;
                               p.reference_length = p.length_x = s.chord;
                               p.nose_x = -0.5 * s.chord;
                               p.half_extent = 0.5 * Vector3d(s.chord, s.span, s.thickness);
                               return p;
                             },
                             [](const Box& s) {
                               check(s);
                               ShapeProperties p;
                               p.area = 2.0 * (s.length * s.width + s.width * s.height + s.height * s.length);
                               p.volume = s.length * s.width * s.height;
                               p.reference_area = s.width * s.height;
                               p.reference_length = p.length_x = s.length;
                               p.nose_x = -0.5 * s.length;
                               p.half_extent = 0.5 * Vector3d(s.length, s.width, s.height);
                               return p;
                             },
                             [](const Cone& s) {
                               check(s);
                               const double r = 0.5 * s.diameter, h = height_of_point(s.diameter, s.apex_angle);
                               ShapeProperties p;
                               p.area = pi * r * (r + std::hypot(r, h));
                               p.volume = pi * r * r * h / 3.0;
                               p.reference_area = pi * r * r;
                               p.reference_length = s.diameter;
                               p.length_x = h;
                               p.nose_x = -0.75 * h;
                               p.half_extent = Vector3d(0.5 * h, r, r);
                               return p;
                             },
                             [](const Sphere& s) {
                               check(s);
                               const double r = 0.5 * s.diameter;
                               ShapeProperties p;
                               p.area = 4.0 * pi * r * r;
                               p.volume = 4.0 / 3.0 * pi * r * r * r;
                               p.reference_area = pi * r * r;
                               p.reference_length = p.length_x = s.diameter;
                               p.nose_x = -r;
                               p.half_extent = Vector3d(r, r, r);
                               return p;
                             },
                             [](const Cylinder& s) {
                               check(s);
                               const double r = 0.5 * s.diameter;
                               ShapeProperties p;
                               p.area = 2.0 * pi * r * (r + s.length);
                               p.volume = pi * r * r * s.length;
                               p.reference_area = pi * r * r;
                               p.reference_length = s.diameter;
                               p.length_x = s.length;
                               p.nose_x = -0.5 * s.length;
                               p.half_extent = Vector3d(0.5 * s.length, r, r);
                               return p;
                             },
                             [](const Ellipsoid& s) {
                               check(s);
                               ShapeProperties p;
                               p.area = ellipsoid_area(s);
                               p.volume = 4.0 / 3.0 * pi * s.semi_x * s.semi_y * s.semi_z;
                               p.reference_length = 2.0 * std::cbrt(s.semi_x * s.semi_y * s.semi_z);
                               p.reference_area = 0.25 * pi * p.reference_length * p.reference_length;
                               p.length_x = 2.0 * s.semi_x;
                               p.nose_x = -s.semi_x;
                               p.half_extent = Vector3d(s.semi_x, s.semi_y, s.semi_z);
                               return p;
                             },
                             [](const Teardrop& s) {
                               check(s);
                               const TeardropParts t = parts(s);
                               const double slant = std::sqrt(t.centre_to_tail * t.centre_to_tail - t.radius * t.radius);
                               ShapeProperties p;
                               p.area = 2.0 * pi * t.radius * t.x_joint + pi * t.r_joint * slant;
                               p.volume = t.volume_sphere + t.volume_cone;
                               p.reference_area = pi * t.radius * t.radius;
                               p.reference_length = s.diameter;
                               p.length_x = s.length;
                               p.nose_x = -t.centroid;
                               p.half_extent = Vector3d(0.5 * s.length, t.radius, t.radius);
                               return p;
                             },
                             [](const Prism& s) {
                               check(s);
                               const double h = height_of_point(s.base, s.apex_angle);
                               ShapeProperties p;
                               p.area = s.base * h + s.span * (s.base + 2.0 * std::hypot(0.5 * s.base, h));
                               p.volume = 0.5 * s.base * h * s.span;
                               p.reference_area = s.base * s.span;
                               p.reference_length = s.base;
                               p.length_x = h;
                               p.nose_x = -2.0 * h / 3.0;
                               p.half_extent = 0.5 * Vector3d(h, s.span, s.base);
                               return p;
                             },
                             [](const MeshBody& s) { return s.measured; }},
                    shape);
}

TriangleMesh triangulate(const Shape& shape, int n) {
  check_divisions(n);
  const ShapeProperties exact = properties(shape);
  return std::visit(
      Overload{[&](const Plate& s) {
                 return s.thickness == 0.0 ? sheet_mesh(s.chord, s.span, n)
                                           : box_mesh(Vector3d(s.chord, s.span, s.thickness), Vector3i(n, n, 1));
               },
               [&](const Box& s) { return box_mesh(Vector3d(s.length, s.width, s.height), Vector3i(n, n, n)); },
               [&](const Cone& s) {
                 std::vector<Vector2d> profile{{exact.nose_x, 0.0}};
                 append_segment(profile, {exact.nose_x + exact.length_x, 0.5 * s.diameter}, n);
                 append_segment(profile, {exact.nose_x + exact.length_x, 0.0}, n);
                 return revolved_mesh(profile, 4 * n);
               },
               [&](const Sphere&) { return ellipsoid_mesh(exact.half_extent, n); },
               [&](const Cylinder& s) {
                 std::vector<Vector2d> profile{{exact.nose_x, 0.0}};
                 append_segment(profile, {exact.nose_x, 0.5 * s.diameter}, n);
                 append_segment(profile, {-exact.nose_x, 0.5 * s.diameter}, n);
                 append_segment(profile, {-exact.nose_x, 0.0}, n);
                 return revolved_mesh(profile, 4 * n);
               },
               [&](const Ellipsoid&) { return ellipsoid_mesh(exact.half_extent, n); },
               [&](const Teardrop& s) {
                 const TeardropParts t = parts(s);
                 const double end = pi - std::atan2(t.r_joint, t.x_joint - t.radius);  // polar angle of the joint, from the nose
                 const int arcs = 2 * n;
                 std::vector<Vector2d> profile{{exact.nose_x, 0.0}};
                 for (int i = 1; i <= arcs; ++i) {
                   const double angle = end * i / arcs;
                   profile.emplace_back(exact.nose_x + t.radius * (1.0 - std::cos(angle)), t.radius * std::sin(angle));
                 }
                 append_segment(profile, {exact.nose_x + s.length, 0.0}, n);
                 return revolved_mesh(profile, 4 * n);
               },
               [&](const Prism& s) {
                 const double tail = exact.nose_x + exact.length_x;
                 return prism_mesh({Vector2d(exact.nose_x, 0.0), Vector2d(tail, -0.5 * s.base), Vector2d(tail, 0.5 * s.base)}, s.span, n);
               },
               [&](const MeshBody& s) { return *s.mesh; }},
      shape);
}

namespace {

/// Whether every triangle falls, under the map, on one of the same mesh.
bool carried_onto_itself(const TriangleMesh& mesh, const Eigen::Matrix3d& map) {
  double size = 0.0;
  for (const Vector3d& vertex : mesh.vertices) size = std::max(size, vertex.norm());
  const double tolerance = 1e-6 * size;  // STL files have single precision
  std::vector<int> by_x(mesh.vertices.size());
  std::iota(by_x.begin(), by_x.end(), 0);
  const auto x_of = [&](int i) { return mesh.vertices[static_cast<std::size_t>(i)].x(); };
  std::sort(by_x.begin(), by_x.end(), [&](int a, int b) { return x_of(a) < x_of(b); });
  std::vector<int> image;
  for (const Vector3d& vertex : mesh.vertices) {
    const Vector3d wanted = map * vertex;
    auto near = std::lower_bound(by_x.begin(), by_x.end(), wanted.x() - tolerance, [&](int i, double x) { return x_of(i) < x; });
    while (near != by_x.end() && (mesh.vertices[static_cast<std::size_t>(*near)] - wanted).cwiseAbs().maxCoeff() > tolerance) {
      if (x_of(*near) > wanted.x() + tolerance) return false;
      ++near;
    }
    if (near == by_x.end()) return false;
    image.push_back(*near);
  }
  std::set<std::array<int, 3>> triangles;
  const auto corners = [](std::array<int, 3> of) {
    std::sort(of.begin(), of.end());
    return of;
  };
  for (const Vector3i& t : mesh.triangles) triangles.insert(corners({t[0], t[1], t[2]}));
  const auto image_of = [&](int vertex) { return image[static_cast<std::size_t>(vertex)]; };
  return std::all_of(mesh.triangles.begin(), mesh.triangles.end(), [&](const Vector3i& t) {
    return triangles.contains(corners({image_of(t[0]), image_of(t[1]), image_of(t[2])}));
  });
}

}  // namespace

bool mirror_symmetric(const Shape& shape, const Vector3d& normal_body) {
  const double length = normal_body.norm();
  if (!(length > 0.0) || !std::isfinite(length)) throw std::invalid_argument("mirror_symmetric: the normal must be finite and not zero");
  const Vector3d m = normal_body / length;
  constexpr double tolerance = 1e-9;  // angles come from degrees in files: a few ulps of 180 deg
  const Eigen::Matrix3d mirror = Eigen::Matrix3d::Identity() - 2.0 * m * m.transpose();
  // A box is carried onto itself when the mirror permutes its axes and the sides along them are equal; an ellipsoid when its quadric is
  // unchanged.
  const auto box_symmetric = [&](const Vector3d& size) {
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        const double entry = std::abs(mirror(i, j));
        if (std::min(entry, std::abs(1.0 - entry)) > tolerance) return false;
        if (entry > 0.5 && std::abs(size[i] - size[j]) > tolerance * size.maxCoeff()) return false;
      }
    return true;
  };
  const auto round_symmetric = [&](bool fore_and_aft) {
    return std::abs(m.x()) < tolerance || (fore_and_aft && std::abs(m.x()) > 1.0 - tolerance);
  };
  return std::visit(
      Overload{[&](const Plate& s) {
                 return box_symmetric({s.chord, s.span, s.thickness});
               },
               [&](const Box& s) {
                 return box_symmetric({s.length, s.width, s.height});
               },
               [&](const Cone&) { return round_symmetric(false); }, [&](const Sphere&) { return true; },
               [&](const Cylinder&) { return round_symmetric(true); },
               [&](const Ellipsoid& s) {
                 const Vector3d axes(s.semi_x, s.semi_y, s.semi_z);
                 const Eigen::Matrix3d quadric = (axes / axes.minCoeff()).cwiseProduct(axes / axes.minCoeff()).cwiseInverse().asDiagonal();
                 return (mirror * quadric * mirror - quadric).cwiseAbs().maxCoeff() < tolerance;
               },
               [&](const Teardrop&) { return round_symmetric(false); },
               [&](const Prism& s) {
                 const auto along = [&](const Vector3d& axis) { return m.cross(axis).norm() < tolerance; };
                 if (along(Vector3d::UnitY()) || along(Vector3d::UnitZ())) return true;
                 const Vector3d other(std::cos(pi / 6), 0.0, 0.5);  // square to the other two medians of an equilateral triangle
                 return std::abs(s.apex_angle - pi / 3) < tolerance && (along(other) || along(other.cwiseProduct(Vector3d(1, 1, -1))));
               },
               [&](const MeshBody& s) { return carried_onto_itself(*s.mesh, mirror); }},
      shape);
}

namespace {

bool is_cube(const Box& box) { return box.length == box.width && box.width == box.height; }

constexpr double degrees = 180.0 / pi;

using Parameters = std::map<std::string, double>;

constexpr std::array<std::string_view, 9> shape_kinds = {"plate",    "box",       "cube",     "cone", "sphere",
                                                         "cylinder", "ellipsoid", "teardrop", "prism"};

/// Takes the known parameters out of a map and complains about what is left.
class ParameterReader {
 public:
  ParameterReader(std::string_view kind, const Parameters& given) : kind_(kind), left_(given) {}
  double operator()(const std::string& name, double fallback) {
    known_ += (known_.empty() ? "" : ", ") + name;
    const auto found = left_.find(name);
    if (found == left_.end()) return fallback;
    const double value = found->second;
    left_.erase(found);
    return value;
  }
  void finish() const {
    if (!left_.empty()) throw std::invalid_argument(kind_ + ": unknown parameter '" + left_.begin()->first + "'; it takes: " + known_);
  }

 private:
  std::string kind_, known_;
  Parameters left_;
};

}  // namespace

std::string kind(const Shape& shape) {
  return std::visit(
      Overload{[](const Plate&) { return std::string("plate"); }, [](const Box& s) { return std::string(is_cube(s) ? "cube" : "box"); },
               [](const Cone&) { return std::string("cone"); }, [](const Sphere&) { return std::string("sphere"); },
               [](const Cylinder&) { return std::string("cylinder"); }, [](const Ellipsoid&) { return std::string("ellipsoid"); },
               [](const Teardrop&) { return std::string("teardrop"); }, [](const Prism&) { return std::string("prism"); },
               [](const MeshBody& s) { return s.name; }},
      shape);
}

std::map<std::string, double> parameters(const Shape& shape) {
  return std::visit(
      Overload{
          [](const Plate& s) {
            return Parameters{{"chord", s.chord}, {"span", s.span}, {"thickness", s.thickness}};
          },
          [](const Box& s) {
            return is_cube(s) ? Parameters{{"side", s.length}} : Parameters{{"length", s.length}, {"width", s.width}, {"height", s.height}};
          },
          [](const Cone& s) {
            return Parameters{{"diameter", s.diameter}, {"apex_angle_deg", s.apex_angle * degrees}};
          },
          [](const Sphere& s) {
            return Parameters{{"diameter", s.diameter}};
          },
          [](const Cylinder& s) {
            return Parameters{{"diameter", s.diameter}, {"length", s.length}};
          },
          [](const Ellipsoid& s) {
            return Parameters{{"semi_x", s.semi_x}, {"semi_y", s.semi_y}, {"semi_z", s.semi_z}};
          },
          [](const Teardrop& s) {
            return Parameters{{"diameter", s.diameter}, {"length", s.length}};
          },
          [](const Prism& s) {
            return Parameters{{"base", s.base}, {"span", s.span}, {"apex_angle_deg", s.apex_angle * degrees}};
          },
          [](const MeshBody& s) {
            const ShapeProperties& p = s.measured;
            return Parameters{
                {"area", p.area}, {"volume", p.volume}, {"reference_area", p.reference_area}, {"reference_length", p.reference_length}};
          }},
      shape);
}

Shape make_shape(std::string_view kind, const Parameters& given) {
  ParameterReader read(kind, given);
  Shape shape;
  if (kind == "plate") {
    const Plate d;
    shape = Plate{.chord = read("chord", d.chord), .span = read("span", d.span), .thickness = read("thickness", d.thickness)};
  } else if (kind == "box") {
    const Box d;
    shape = Box{.length = read("length", d.length), .width = read("width", d.width), .height = read("height", d.height)};
  } else if (kind == "cube") {
    const double side = read("side", 1.0);
    shape = Box{.length = side, .width = side, .height = side};
  } else if (kind == "cone") {
    const Cone d;
    shape = Cone{.diameter = read("diameter", d.diameter), .apex_angle = read("apex_angle_deg", d.apex_angle * degrees) / degrees};
  } else if (kind == "sphere") {
    shape = Sphere{.diameter = read("diameter", Sphere{}.diameter)};
  } else if (kind == "cylinder") {
    const Cylinder d;
    shape = Cylinder{.diameter = read("diameter", d.diameter), .length = read("length", d.length)};
  } else if (kind == "ellipsoid") {
    const Ellipsoid d;
    shape = Ellipsoid{.semi_x = read("semi_x", d.semi_x), .semi_y = read("semi_y", d.semi_y), .semi_z = read("semi_z", d.semi_z)};
  } else if (kind == "teardrop") {
    const Teardrop d;
    shape = Teardrop{.diameter = read("diameter", d.diameter), .length = read("length", d.length)};
  } else if (kind == "prism") {
    const Prism d;
    shape = Prism{
        .base = read("base", d.base), .span = read("span", d.span), .apex_angle = read("apex_angle_deg", d.apex_angle * degrees) / degrees};
  } else {
    throw std::invalid_argument(unknown_word("shape", kind, {shape_kinds.begin(), shape_kinds.end()}));
  }
  read.finish();
  properties(shape);  // checks the ranges
  return shape;
}

std::map<std::string, double> changed_parameters(const Shape& shape) {
  if (std::holds_alternative<MeshBody>(shape)) return {};
  Parameters changed = parameters(shape);
  for (const auto& [name, usual] : parameters(make_shape(kind(shape), {})))
    if (const auto found = changed.find(name); found != changed.end() && std::abs(found->second - usual) <= 1e-9 * std::abs(found->second))
      changed.erase(found);
  return changed;
}

MeshBody mesh_body(const std::string& name, const TriangleMesh& mesh, double reference_area, double reference_length) {
  const auto refuse = [&name](const std::string& fault) { throw std::invalid_argument("mesh body '" + name + "': " + fault); };
  if (name.empty() || name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_-.") != std::string::npos)
    refuse("a name needs lower-case letters, digits, '_', '-' or '.'");
  if (std::find(shape_kinds.begin(), shape_kinds.end(), name) != shape_kinds.end())
    refuse("this is the name of a shape with parameters; give the mesh another one");
  const std::string kind = "mesh body '" + name + "'";
  require_positive(kind.c_str(), "reference_area", reference_area);
  require_positive(kind.c_str(), "reference_length", reference_length);
  const TriangleMesh joined = welded(mesh);
  const MeshProperties found = inspect(joined);
  const auto count = [](int number, const char* what) { return std::to_string(number) + " " + what; };
  if (found.triangles == found.degenerate) refuse("it has no triangle with an area");
  if (found.non_manifold_edges > 0) refuse(count(found.non_manifold_edges, "edges have three or more triangles; needed are two at most"));
  if (!found.consistently_wound)
    refuse(count(found.inconsistent_edges, "edges lie between triangles of opposite winding; turn one of each pair"));
  if (found.inside_out) refuse("its triangles are wound inwards; turn them all");
  if (found.encloses && !found.closed)
    refuse(count(found.boundary_edges,
                 "edges are open, around holes that are small for a shell; close them, or the body would be meshed hollow"));

  // Moved only where it is not there yet, so that a body that is read again keeps its checksum.
  MeshBody body{.name = name, .mesh = {}, .measured = {}, .checksum = 0};
  Eigen::AlignedBox3d box;
  for (const Vector3d& vertex : joined.vertices) box.extend(vertex);
  const bool centred = found.centroid.norm() <= 1e-12 * box.diagonal().norm();
  const Vector3d to_centroid = centred ? Vector3d::Zero().eval() : (-found.centroid).eval();
  body.mesh = std::make_shared<const TriangleMesh>(transformed(joined, Eigen::Matrix3d::Identity(), to_centroid));
  box.translate(to_centroid);
  body.measured = {.area = found.area,
                   .volume = found.closed ? found.volume : 0.0,
                   .reference_area = reference_area,
                   .reference_length = reference_length,
                   .nose_x = box.min().x(),
                   .length_x = box.sizes().x(),
                   .half_extent = 0.5 * box.sizes()};
  body.checksum = surface_checksum(*body.mesh);
  return body;
}

}  // namespace dragcore
