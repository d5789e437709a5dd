#include "body/convexity.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "body/edges.hpp"

namespace dragcore {

namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

class Convexity {
 public:
  Convexity(const std::vector<Vector3i>& triangles, const std::vector<Vector3d>& vertices) : triangles_(triangles), vertices_(vertices) {
    Vector3d low = at(triangles[0][0]), high = low;
    for (const Vector3i& t : triangles)
      for (const int corner : t) low = low.cwiseMin(at(corner)), high = high.cwiseMax(at(corner));
    tolerance_ = 1e-3 * (high - low).norm();
  }

  bool is_flat() const {
    const Vector3d normal = normal_of(triangles_[0]), origin = at(triangles_[0][0]);
    for (const Vector3i& t : triangles_)
      for (const int corner : t)
        if (std::abs(normal.dot(at(corner) - origin)) > tolerance_) return false;
    return true;
  }

  /// Of fine meshes every so many triangles: a dent has many of them.
  bool nothing_rises_from_afar() const {
    const std::size_t stride = 1 + triangles_.size() / 20000;
    const auto count = static_cast<Eigen::Index>(1 + (triangles_.size() - 1) / stride);
    const Vector3d origin = at(triangles_[0][0]);
    Eigen::MatrixX3d normals(count, 3);
    Eigen::VectorXd height(count);  // of each plane over `origin`
    std::vector<int> corners;
    for (Eigen::Index n = 0; n < count; ++n) {
      const Vector3i& t = triangles_[static_cast<std::size_t>(n) * stride];
      normals.row(n) = normal_of(t).transpose();
      height[n] = normals.row(n).dot((at(t[0]) - origin).transpose());
      corners.insert(corners.end(), t.begin(), t.end());
    }
    std::sort(corners.begin(), corners.end());
    corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
    Eigen::MatrixX3d places(static_cast<Eigen::Index>(corners.size()), 3);  // from `origin`
    for (std::size_t i = 0; i < corners.size(); ++i) places.row(static_cast<Eigen::Index>(i)) = (at(corners[i]) - origin).transpose();
    constexpr int directions = 200;
    for (int k = 0; k < directions; ++k) {  // a spiral from pole to pole
      const double z = (2.0 * k + 1.0) / directions - 1.0, r = std::sqrt(1.0 - z * z), turn = 2.399963229728653 * k;
      Eigen::Index outermost = 0;
      (places * Vector3d(r * std::cos(turn), r * std::sin(turn), z)).maxCoeff(&outermost);
      if ((normals * places.row(outermost).transpose() - height).maxCoeff() > tolerance_) return false;
    }
    return true;
  }

  /// And every edge has two triangles.
  bool no_neighbour_rises(const EdgeTable& edges) const {
    for (std::size_t i = 0; i < triangles_.size(); ++i) {
      const Vector3i& t = triangles_[i];
      const Vector3d normal = normal_of(t);
      for (int e = 0; e < 3; ++e) {
        const auto uses = edges.at(i, static_cast<std::size_t>(e));
        if (uses.size() != 2) return false;
        const Vector3i& next =
            triangles_[static_cast<std::size_t>(uses[0].triangle == static_cast<int>(i) ? uses[1].triangle : uses[0].triangle)];
        const int from = t[e], tip = next.sum() - from - t[(e + 1) % 3];
        if (normal.dot(at(tip) - at(from)) > tolerance_) return false;
      }
    }
    return true;
  }

 private:
  const Vector3d& at(int vertex) const { return vertices_[static_cast<std::size_t>(vertex)]; }
  Vector3d normal_of(const Vector3i& t) const { return (at(t[1]) - at(t[0])).cross(at(t[2]) - at(t[0])).stableNormalized(); }

  const std::vector<Vector3i>& triangles_;
  const std::vector<Vector3d>& vertices_;
  double tolerance_ = 0.0;
};

}  // namespace

bool is_convex(const std::vector<Vector3i>& triangles, const std::vector<Vector3d>& vertices, bool sheet, const EdgeTable* edges) {
  if (triangles.empty()) return false;
  const Convexity convexity(triangles, vertices);
  if (sheet) return convexity.is_flat();
  // The edges, which cost most to find, come last.
  return convexity.nothing_rises_from_afar() && convexity.no_neighbour_rises(edges ? *edges : EdgeTable(triangles));
}

bool is_convex(const Preparation& preparation) {
  if (preparation.parts() != 1) return false;
  const std::vector<Vector3d>& vertices = preparation.mesh.vertices;
  std::vector<Vector3i> triangles;
  triangles.reserve(preparation.mesh.triangles.size());
  for (const Vector3i& t : preparation.mesh.triangles)
    if (!is_degenerate(vertices[static_cast<std::size_t>(t[0])], vertices[static_cast<std::size_t>(t[1])],
                       vertices[static_cast<std::size_t>(t[2])]))
      triangles.push_back(t);
  return is_convex(triangles, vertices, preparation.sheet[0]);
}

}  // namespace dragcore
