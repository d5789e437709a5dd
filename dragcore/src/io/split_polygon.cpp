#include <Eigen/Geometry>
#include <algorithm>
#include <utility>

#include "io/mesh_readers.hpp"

namespace dragcore {

namespace {

/// The polygon seen along the axis that is nearest to its normal, from the side where the corners run counterclockwise.
std::vector<Eigen::Vector2d> flattened(const std::vector<Eigen::Vector3d>& vertices, std::span<const int> corners) {
  const auto place = [&](std::size_t i) -> const Eigen::Vector3d& { return vertices[static_cast<std::size_t>(corners[i])]; };
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  for (std::size_t i = 1; i + 1 < corners.size(); ++i) normal += (place(i) - place(0)).cross(place(i + 1) - place(0));
  Eigen::Index axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  Eigen::Index x = (axis + 1) % 3, y = (axis + 2) % 3;
  if (normal[axis] < 0.0) std::swap(x, y);
  std::vector<Eigen::Vector2d> points;
  points.reserve(corners.size());
  for (std::size_t i = 0; i < corners.size(); ++i) points.emplace_back(place(i)[x], place(i)[y]);
  return points;
}

/// A ring of corners from which ears, convex corners whose triangle holds no other corner, are cut.
class Ring {
 public:
  explicit Ring(std::vector<Eigen::Vector2d> points) : points_(std::move(points)), links_(points_.size()), is_hollow_(points_.size()) {
    const std::size_t n = points_.size();
    for (std::size_t i = 0; i < n; ++i) links_[i] = {(i + n - 1) % n, (i + 1) % n};
    for (std::size_t i = 0; i < n; ++i) update(i);
  }

  std::size_t before(std::size_t i) const { return links_[i].before; }
  std::size_t after(std::size_t i) const { return links_[i].after; }

  /// True where a fan from the first corner covers the polygon once.
  bool is_fan() const {
    for (std::size_t i = 1; i + 1 < points_.size(); ++i)
      if (!(turn(0, i, i + 1) > 0.0) || !(turn(0, 1, i + 1) > 0.0)) return false;
    return true;
  }

  bool is_ear(std::size_t i) {
    if (is_hollow_[i]) return false;
    const std::size_t a = before(i), b = after(i);
    // Only corners that are not convex can lie in an ear. Those that have become so, or are cut off, are dropped here.
    for (std::size_t k = 0; k < hollow_.size();) {
      const std::size_t other = hollow_[k];
      if (!is_hollow_[other]) {
        hollow_[k] = hollow_.back();
        hollow_.pop_back();
        continue;
      }
      ++k;
      if (!(turn(a, i, other) >= 0.0 && turn(i, b, other) >= 0.0 && turn(b, a, other) >= 0.0)) continue;
      // A corner at the same place, where a slit leads to a hole, does not lie inside.
      if (points_[other] != points_[a] && points_[other] != points_[i] && points_[other] != points_[b]) return false;
    }
    return true;
  }

  void cut(std::size_t i) {
    const auto [a, b] = links_[i];
    is_hollow_[i] = false;
    links_[a].after = b;
    links_[b].before = a;
    update(a);
    update(b);
  }

 private:
  struct Links {
    std::size_t before, after;
  };

  /// Twice the area of the three, positive where they turn left.
  double turn(std::size_t from, std::size_t at, std::size_t to) const {
    const Eigen::Vector2d &a = points_[from], &b = points_[at], &c = points_[to];
    return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
  }

  void update(std::size_t i) {
    const bool hollow = !(turn(before(i), i, after(i)) > 0.0);
    if (hollow && !is_hollow_[i]) hollow_.push_back(i);
    is_hollow_[i] = hollow;
  }

  std::vector<Eigen::Vector2d> points_;
  std::vector<Links> links_;
  std::vector<bool> is_hollow_;
  std::vector<std::size_t> hollow_;
};

}  // namespace

void split_polygon(const std::vector<Eigen::Vector3d>& vertices, std::span<const int> corners, std::vector<Eigen::Vector3i>& triangles) {
  const auto add = [&](std::size_t a, std::size_t b, std::size_t c) { triangles.emplace_back(corners[a], corners[b], corners[c]); };
  std::size_t left = corners.size(), at = 0;
  if (left > 3) {
    Ring ring(flattened(vertices, corners));
    if (!ring.is_fan()) {
      // Cutting an ear makes at most its two neighbours into new ears. Going on with the one before, one round finds all; where edges
      // touch or cross it may take more, but not for ever.
      const std::size_t most_tests = 20 * left;
      at = 1;
      for (std::size_t tests = 0, failed = 0; left > 3 && failed < left && tests < most_tests; ++tests) {
        if (ring.is_ear(at)) {
          add(ring.before(at), at, ring.after(at));
          ring.cut(at);
          at = ring.before(at);
          --left;
          failed = 0;
        } else {
          at = ring.after(at);
          ++failed;
        }
      }
      for (std::size_t i = ring.after(at); left > 2; i = ring.after(i), --left) add(at, i, ring.after(i));
      return;
    }
  }
  for (std::size_t i = 1; i + 1 < corners.size(); ++i) add(0, i, i + 1);
}

}  // namespace dragcore
