#include "compare/calibration/symmetry.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>

namespace compare {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr std::size_t most_candidates = 600, most_points = 150;
// Of many-sided bodies a part of the symmetries does as well: the next image is nearer than anything changes.
constexpr std::size_t most_elements = 100;

double square_distance_to_segment(const Vector3d& p, const Vector3d& a, const Vector3d& b) {
  const Vector3d along = b - a;
  const double length2 = along.squaredNorm();
  const double t = length2 > 0.0 ? std::clamp((p - a).dot(along) / length2, 0.0, 1.0) : 0.0;
  return (p - a - t * along).squaredNorm();
}

double distance_to_triangle(const Vector3d& p, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const Vector3d normal = (b - a).cross(c - a);
  if (const double size = normal.norm(); size > 0.0) {
    const auto inside = [&](const Vector3d& from, const Vector3d& to) { return normal.dot((to - from).cross(p - from)) >= 0.0; };
    if (inside(a, b) && inside(b, c) && inside(c, a)) return std::abs(normal.dot(p - a)) / size;
  }
  return std::sqrt(
      std::min({square_distance_to_segment(p, a, b), square_distance_to_segment(p, b, c), square_distance_to_segment(p, c, a)}));
}

/// Vertices about the centroid of the area, in units of the distance of the farthest.
struct Shell {
  std::vector<Vector3d> vertices;
  std::vector<Eigen::Vector3i> triangles;
  Matrix3d second_moment = Matrix3d::Zero();       ///< of the area
  std::vector<Vector3d> points;                    ///< to be found on the surface again
  std::vector<std::pair<Vector3d, double>> balls;  ///< around every triangle

  explicit Shell(const dragcore::TriangleMesh& given) {
    const dragcore::TriangleMesh mesh = dragcore::welded(given);
    vertices = mesh.vertices, triangles = mesh.triangles;
    double area = 0.0;
    Vector3d centre = Vector3d::Zero();
    for (const auto& [a, b, c, size] : corners()) area += size, centre += size * (a + b + c) / 3.0;
    if (!(area > 0.0)) return;
    centre /= area;
    double radius = 0.0;
    for (Vector3d& vertex : vertices) vertex -= centre, radius = std::max(radius, vertex.norm());
    for (Vector3d& vertex : vertices) vertex /= radius;
    std::vector<Vector3d> all = vertices;
    for (const auto& [a, b, c, size] : corners()) {
      const Vector3d sum = a + b + c, middle = sum / 3.0;
      second_moment += size / 12.0 * (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
      all.push_back(middle);
      balls.emplace_back(middle, std::max({(a - middle).norm(), (b - middle).norm(), (c - middle).norm()}));
    }
    for (std::size_t k = 0; k < std::min(all.size(), most_points); ++k)
      points.push_back(all[k * all.size() / std::min(all.size(), most_points)]);
  }

  bool is_mapped_onto_itself_by(const Matrix3d& g) const {
    return std::all_of(points.begin(), points.end(), [&](const Vector3d& point) {
      const Vector3d p = g * point;
      for (std::size_t t = 0; t < triangles.size(); ++t) {
        if ((p - balls[t].first).norm() > balls[t].second + symmetry_tolerance) continue;
        const Eigen::Vector3i& k = triangles[t];
        if (distance_to_triangle(p, vertex(k[0]), vertex(k[1]), vertex(k[2])) <= symmetry_tolerance) return true;
      }
      return false;
    });
  }

 private:
  const Vector3d& vertex(int index) const { return vertices[static_cast<std::size_t>(index)]; }
  struct Corners {
    Vector3d a, b, c;
    double area;
  };
  std::vector<Corners> corners() const {
    std::vector<Corners> list;
    for (const Eigen::Vector3i& t : triangles) {
      const Vector3d a = vertex(t[0]), b = vertex(t[1]), c = vertex(t[2]);
      list.push_back({a, b, c, 0.5 * (b - a).cross(c - a).norm()});
    }
    return list;
  }
};

Matrix3d frame_of(const Vector3d& first, const Vector3d& second) {
  Matrix3d frame;
  frame.col(0) = first.normalized();
  frame.col(2) = first.cross(second).normalized();
  frame.col(1) = frame.col(2).cross(frame.col(0));
  return frame;
}

/// At most `count` of a list, spread over it.
template <class Item>
std::vector<Item> thinned(const std::vector<Item>& all, std::size_t count) {
  if (all.size() <= count) return all;
  std::vector<Item> some;
  for (std::size_t k = 0; k < count; ++k) some.push_back(all[k * all.size() / count]);
  return some;
}

/// All that might be symmetries: bodies whose principal moments differ allow eight; else corners must go to corners.
std::vector<Matrix3d> candidates(const Shell& shell) {
  const Eigen::SelfAdjointEigenSolver<Matrix3d> principal(shell.second_moment);
  const Vector3d moments = principal.eigenvalues();
  const Matrix3d axes = principal.eigenvectors();
  const double near = 0.01 * moments[2], same = 2.5 * symmetry_tolerance;
  const bool lower = moments[1] - moments[0] < near, upper = moments[2] - moments[1] < near;
  std::vector<Matrix3d> list;
  if (!lower && !upper) {
    for (int signs = 0; signs < 8; ++signs) {
      const Vector3d flip(signs & 1 ? -1.0 : 1.0, signs & 2 ? -1.0 : 1.0, signs & 4 ? -1.0 : 1.0);
      list.push_back(axes * flip.asDiagonal() * axes.transpose());
    }
    return list;
  }
  if (lower != upper) {  // an axis, about which any angle is possible
    const Vector3d axis = axes.col(lower ? 2 : 0);
    const auto across = [&](const Vector3d& r) { return Vector3d(r - axis * axis.dot(r)); };
    const Vector3d farthest = *std::max_element(shell.vertices.begin(), shell.vertices.end(), [&](const Vector3d& a, const Vector3d& b) {
      return across(a).squaredNorm() < across(b).squaredNorm();
    });
    const Matrix3d from = frame_of(across(farthest), axis.cross(across(farthest)));
    for (const Vector3d& corner : thinned(shell.vertices, 4 * most_candidates)) {
      if (std::abs(across(corner).norm() - across(farthest).norm()) > same) continue;
      const Matrix3d to = frame_of(across(corner), axis.cross(across(corner)));
      for (const double mirrored : {1.0, -1.0})
        for (const double turned : {1.0, -1.0})
          if (std::abs(axis.dot(corner) - turned * axis.dot(farthest)) <= same)
            list.push_back(to * Vector3d(1.0, mirrored, turned).asDiagonal() * from.transpose());
    }
    return thinned(list, most_candidates);
  }
  const Vector3d first = *std::max_element(shell.vertices.begin(), shell.vertices.end(),
                                           [](const Vector3d& a, const Vector3d& b) { return a.squaredNorm() < b.squaredNorm(); });
  const Vector3d second = *std::max_element(shell.vertices.begin(), shell.vertices.end(), [&](const Vector3d& a, const Vector3d& b) {
    return first.cross(a).squaredNorm() < first.cross(b).squaredNorm();
  });
  const Matrix3d from = frame_of(first, second);
  for (const Vector3d& a : thinned(shell.vertices, 200)) {
    if (std::abs(a.norm() - first.norm()) > same) continue;
    for (const Vector3d& b : thinned(shell.vertices, 200)) {
      if (std::abs(b.norm() - second.norm()) > same || std::abs(a.dot(b) - first.dot(second)) > same) continue;
      for (const double mirrored : {1.0, -1.0})
        list.push_back(frame_of(a, b) * Vector3d(1.0, 1.0, mirrored).asDiagonal() * from.transpose());
    }
  }
  return thinned(list, most_candidates);
}

bool is_among(const std::vector<Matrix3d>& group, const Matrix3d& g) {
  return std::any_of(group.begin(), group.end(), [&](const Matrix3d& known) { return (known - g).norm() < 5.0 * symmetry_tolerance; });
}

/// A group with one element more, and all products of it; given up beyond `most_elements`.
std::vector<Matrix3d> closed(std::vector<Matrix3d> group, const Matrix3d& more) {
  group.push_back(more);
  for (std::size_t i = 0; i < group.size() && group.size() <= most_elements; ++i)
    for (std::size_t j = 0; j <= i && group.size() <= most_elements; ++j)
      for (const Matrix3d& product : {Matrix3d(group[i] * group[j]), Matrix3d(group[j] * group[i])})
        if (!is_among(group, product)) group.push_back(product);
  return group;
}

/// The 48 of the cube.
std::vector<Matrix3d> of_cube() {
  std::vector<Matrix3d> list;
  std::array<int, 3> order{0, 1, 2};
  do {
    for (int signs = 0; signs < 8; ++signs) {
      Matrix3d g = Matrix3d::Zero();
      for (int k = 0; k < 3; ++k) g(k, order[static_cast<std::size_t>(k)]) = signs >> k & 1 ? -1.0 : 1.0;
      list.push_back(g);
    }
  } while (std::next_permutation(order.begin(), order.end()));
  return list;  // the identity is the first
}

}  // namespace

std::vector<Matrix3d> symmetry_group(const dragcore::TriangleMesh& mesh) {
  const Shell shell(mesh);
  std::vector<Matrix3d> group{Matrix3d::Identity()};
  if (shell.points.empty()) return group;
  const auto [nearest, farthest] = std::minmax_element(
      shell.vertices.begin(), shell.vertices.end(), [](const Vector3d& a, const Vector3d& b) { return a.squaredNorm() < b.squaredNorm(); });
  // Facets of a ball are nearer than its corners by the square of their size: a cube of eight corners is none.
  const bool ball = shell.vertices.size() > 60 && nearest->norm() > 0.99 * farthest->norm() &&
                    std::all_of(shell.balls.begin(), shell.balls.end(), [](const auto& face) { return face.first.norm() > 0.95; });
  if (ball) return of_cube();
  std::vector<Matrix3d> found;
  for (const Matrix3d& g : candidates(shell))
    if (!is_among(found, g) && shell.is_mapped_onto_itself_by(g)) found.push_back(g);
  // Mirrors and half turns first: with them directions in a plane stay in it.
  std::stable_partition(found.begin(), found.end(),
                        [](const Matrix3d& g) { return (g - g.transpose()).norm() < 5.0 * symmetry_tolerance; });
  for (const Matrix3d& g : found)
    if (!is_among(group, g))
      if (std::vector<Matrix3d> larger = closed(group, g); larger.size() <= most_elements) group = std::move(larger);
  return group;
}

std::vector<Vector3d> mirror_normals(const std::vector<Matrix3d>& group) {
  std::vector<Vector3d> normals;
  for (const Matrix3d& g : group) {
    // I - 2 n n^T: symmetric, of trace 1 and determinant -1.
    if (std::abs(g.trace() - 1.0) > 0.02 || g.determinant() > 0.0 || (g - g.transpose()).norm() > 0.05) continue;
    const Matrix3d dyad = 0.5 * (Matrix3d::Identity() - g);
    Eigen::Index largest = 0;
    dyad.diagonal().maxCoeff(&largest);
    normals.push_back(dyad.col(largest).normalized());
  }
  return normals;
}

}  // namespace compare
