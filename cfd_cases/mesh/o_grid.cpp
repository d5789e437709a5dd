#include "cfd_cases/mesh/o_grid.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>
#include <tuple>
#include <utility>

namespace cfd_cases {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::Vector3i;

namespace {

constexpr double kPi = std::numbers::pi;
/// Distance at which a line of points has turned half-way from the wall's normal to its place in the fan, in body scales: far outside the
/// boundary layer, and near enough that the flat end of a cylinder does not send a bundle of parallel lines into the far field.
constexpr double kTurn = 0.4;

/// A point of the wall, body frame.
struct WallPoint {
  Vector3d place, normal;
};

/// The point of the wall that belongs to a point of the cube [-1, 1]^3 and to its direction on the cubed sphere.
struct OnWall {
  Vector3d cube, direction;
  double nose;

  Vector3d radial() const { return Vector3d(0.0, cube_y(), cube_z()).normalized(); }
  double cube_y() const { return std::tan(0.25 * kPi * cube.y()); }
  double cube_z() const { return std::tan(0.25 * kPi * cube.z()); }

  WallPoint operator()(const dragcore::Sphere& s) const { return {0.5 * s.diameter * direction, direction}; }
  WallPoint operator()(const dragcore::Ellipsoid& s) const {
    const Vector3d axes(s.semi_x, s.semi_y, s.semi_z);
    return {direction.cwiseProduct(axes), direction.cwiseQuotient(axes).normalized()};
  }
  WallPoint operator()(const dragcore::Cylinder& s) const {
    const double r = 0.5 * s.diameter, across = cube.tail<2>().cwiseAbs().maxCoeff();  // squares around the axis become circles
    const Vector3d out = across > 0.0 ? radial() : Vector3d::Zero();
    if (std::abs(cube.x()) < 1.0) return {0.5 * s.length * cube.x() * Vector3d::UnitX() + r * out, out};
    const Vector3d end = std::copysign(1.0, cube.x()) * Vector3d::UnitX();
    return {0.5 * s.length * end + r * across * out, across < 1.0 ? end : (end + out).normalized()};  // on the rim between the two
  }
  /// The angle from the nose becomes the length along the meridian: an arc of the sphere, then its tangent to the tail.
  WallPoint operator()(const dragcore::Teardrop& s) const {
    const double r = 0.5 * s.diameter, half_angle = std::asin(r / (s.length - r)), arc = r * (0.5 * kPi + half_angle);
    const double side = r / std::tan(half_angle), along = std::acos(std::clamp(-direction.x(), -1.0, 1.0)) / kPi * (arc + side);
    const bool pole = cube.tail<2>().isZero();
    const Vector3d out = pole ? Vector3d::Zero() : radial(), x = Vector3d::UnitX();
    if (along < arc) {
      const Vector3d normal = std::sin(along / r) * out - std::cos(along / r) * x;
      return {(nose + r) * x + r * normal, normal.normalized()};
    }
    const double left = arc + side - along;
    return {(nose + s.length - left * std::cos(half_angle)) * x + left * std::sin(half_angle) * out,
            pole ? x : Vector3d(std::sin(half_angle) * x + std::cos(half_angle) * out)};
  }
  template <class Other>
  WallPoint operator()(const Other& other) const {
    throw std::invalid_argument(
        fmt::format("an O-grid fits spheres, ellipsoids, cylinders and teardrops, not a {}", dragcore::kind(dragcore::Shape(other))));
  }
};

WallPoint on_wall(const dragcore::Shape& shape, const Vector3d& cube, const Vector3d& direction) {
  return std::visit(OnWall{cube, direction, dragcore::properties(shape).nose_x}, shape);
}

/// The direction of a point of the cube, at equal angles along the middle of each side.
Vector3d direction_of(const Vector3d& cube) { return (0.25 * kPi * cube).array().tan().matrix().normalized(); }

int even(double cells) { return std::max(4, 2 * static_cast<int>(std::lround(0.5 * cells))); }

/// Cells along and across the cube. Across: a quarter of the largest girth. Along: so that the cells of a long body are longer than wide
/// by the square root of what the body is, since flow changes less along it.
std::pair<int, int> divisions(const dragcore::Shape& shape, const MeshRecipe& recipe) {
  const double size = recipe.body_size * recipe.refinement * body_scale(shape);
  const auto place = [&](double x, double y) { return on_wall(shape, Vector3d(x, y, 0.0), direction_of(Vector3d(x, y, 0.0))).place; };
  double along = 0.0;
  constexpr int pieces = 100;
  for (int i = 0; i < pieces; ++i) along += (place(-1.0 + 2.0 * (i + 1) / pieces, 1.0) - place(-1.0 + 2.0 * i / pieces, 1.0)).norm();
  const double across = 0.25 * kPi * body_scale(shape);
  return {even(std::sqrt(along * across) / size), even(across / size)};
}

/// The cube's surface of unit squares, or the half of it beyond the middle of an axis: lattice points, and squares seen from outside
/// counter-clockwise.
struct CubeSurface {
  std::vector<Vector3i> points;
  std::vector<std::array<int, 4>> squares;

  CubeSurface(const Vector3i& lower, const Vector3i& upper, int halved) {
    std::map<std::tuple<int, int, int>, int> numbers;
    const auto number = [&](const Vector3i& p) {
      const auto [found, is_new] = numbers.emplace(std::tuple(p.x(), p.y(), p.z()), static_cast<int>(points.size()));
      if (is_new) points.push_back(p);
      return found->second;
    };
    for (int axis = 0; axis < 3; ++axis)
      for (const bool top : {false, true}) {
        if (axis == halved && !top) continue;
        const int a = (axis + 1) % 3, b = (axis + 2) % 3;
        Vector3i p;
        p[axis] = top ? upper[axis] : lower[axis];
        for (p[a] = lower[a]; p[a] < upper[a]; ++p[a])
          for (p[b] = lower[b]; p[b] < upper[b]; ++p[b]) {
            const Vector3i to_a = Vector3i::Unit(a), to_b = Vector3i::Unit(b);
            std::array<int, 4> square{number(p), number(p + to_a), number(p + to_a + to_b), number(p + to_b)};
            if (!top) std::swap(square[1], square[3]);
            squares.push_back(square);
          }
      }
  }
};

}  // namespace

std::vector<double> o_grid_layers(const MeshRecipe& recipe, double scale) {
  std::vector<double> bounds{0.0};
  while (bounds.back() < recipe.far_radius) {
    const double s = bounds.back();
    bounds.push_back(s + recipe.refinement * std::min(recipe.first_layer + recipe.growth * s,
                                                      recipe.wake_size + recipe.growth * std::max(0.0, s - recipe.wake_length)));
  }
  const double to_radius = scale * recipe.far_radius / bounds.back();
  for (double& s : bounds) s *= to_radius;
  return bounds;
}

double o_grid_cells(const dragcore::Shape& shape, const MeshRecipe& recipe, Symmetry symmetry) {
  const auto [along, across] = divisions(shape, recipe);
  const double squares = 2.0 * across * (across + 2.0 * along);
  return (symmetry == Symmetry::none ? 1.0 : 0.5) * squares * static_cast<double>(o_grid_layers(recipe, body_scale(shape)).size() - 1);
}

PolyMesh o_grid(const dragcore::Shape& shape, const dragcore::Pose& pose, const MeshRecipe& recipe, Symmetry symmetry) {
  const auto [along, across] = divisions(shape, recipe);
  const int halved = halved_axis(symmetry);
  const Matrix3d to_wind = pose.rotation();
  const Vector3i lower = -Vector3i(along, across, across) / 2, upper = -lower;
  Vector3i first = lower;
  if (halved >= 0) {
    if (!to_wind.col(halved).isApprox(Vector3d::Unit(halved), 1e-12))
      throw std::invalid_argument("an O-grid is halved by a plane of the body's own axes: leave out roll_deg, or set half_model = false");
    first[halved] = 0;
  }
  const CubeSurface wall(first, upper, halved);
  const double scale = body_scale(shape), drift = 1.0 - recipe.upstream / recipe.far_radius;
  const std::vector<double> layers = o_grid_layers(recipe, scale);
  const int columns = static_cast<int>(wall.points.size()), squares = static_cast<int>(wall.squares.size());
  const int depth = static_cast<int>(layers.size()) - 1;

  PolyMesh mesh;
  mesh.points.resize(static_cast<std::size_t>(columns) * layers.size());
  for (int column = 0; column < columns; ++column) {
    const Vector3d cube = wall.points[static_cast<std::size_t>(column)].cast<double>().cwiseQuotient(upper.cast<double>());
    const Vector3d direction = direction_of(cube);
    const WallPoint point = on_wall(shape, cube, direction);
    for (int layer = 0; layer <= depth; ++layer) {
      const double s = layers[static_cast<std::size_t>(layer)], turn = s * s / (s * s + scale * scale * kTurn * kTurn);
      const Vector3d outward = ((1.0 - turn) * point.normal + turn * direction).normalized();
      mesh.points[static_cast<std::size_t>(layer * columns + column)] =
          to_wind * (point.place + s * outward) + drift * s * s / (s + scale) * Vector3d::UnitX();
    }
  }

  // Cells are numbered layer by layer: cell = layer * squares + square. Every edge of the wall has one square on each side, or is in the
  // plane of symmetry.
  struct Edge {
    int from, to, left, right = -1;
  };
  std::map<std::pair<int, int>, Edge> edges;
  for (int square = 0; square < squares; ++square)
    for (std::size_t corner = 0; corner < 4; ++corner) {
      const auto& points = wall.squares[static_cast<std::size_t>(square)];
      const int from = points[corner], to = points[(corner + 1) % 4];
      const auto [edge, is_new] = edges.emplace(std::minmax(from, to), Edge{from, to, square});
      if (!is_new) edge->second.right = square;
    }
  struct Face {
    int owner, neighbour;
    std::vector<int> points;
  };
  std::vector<Face> inner, body, farfield, plane;
  const auto lid = [&](int square, int layer) {  // normal: away from the body
    const auto& points = wall.squares[static_cast<std::size_t>(square)];
    std::vector<int> face;
    for (const int point : points) face.push_back(layer * columns + point);
    return face;
  };
  for (int square = 0; square < squares; ++square) {
    body.push_back({square, -1, lid(square, 0)});
    std::reverse(body.back().points.begin(), body.back().points.end());
    farfield.push_back({(depth - 1) * squares + square, -1, lid(square, depth)});
    for (int layer = 1; layer < depth; ++layer)
      inner.push_back({(layer - 1) * squares + square, layer * squares + square, lid(square, layer)});
  }
  for (int layer = 0; layer < depth; ++layer)
    for (const auto& [ends, edge] : edges) {
      const int from = layer * columns + edge.from, to = layer * columns + edge.to;
      // The first square that had the edge has the lower number, and the normal points out of it.
      Face face{layer * squares + edge.left, edge.right < 0 ? -1 : layer * squares + edge.right, {from, to, to + columns, from + columns}};
      (edge.right < 0 ? plane : inner).push_back(std::move(face));
    }
  // OpenFOAM wants the faces in the order of their owners, then of their neighbours.
  std::sort(inner.begin(), inner.end(),
            [](const Face& a, const Face& b) { return std::pair(a.owner, a.neighbour) < std::pair(b.owner, b.neighbour); });
  const auto append = [&](std::vector<Face>& faces) {
    for (Face& face : faces) {
      mesh.owner.push_back(face.owner);
      if (face.neighbour >= 0) mesh.neighbour.push_back(face.neighbour);
      mesh.faces.push_back(std::move(face.points));
    }
  };
  append(inner);
  for (const auto& [name, faces] : {std::pair{"body", &body}, {"farfield", &farfield}, {"symmetry", &plane}}) {
    if (faces->empty()) continue;
    mesh.patches.push_back({name, static_cast<int>(mesh.faces.size()), static_cast<int>(faces->size())});
    append(*faces);
  }
  return mesh;
}

}  // namespace cfd_cases
