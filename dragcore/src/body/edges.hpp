#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <span>
#include <vector>

namespace dragcore {

/// A triangle's passage along an edge. The edge's ends are sorted; `forward` says whether the winding runs from the lower to the higher
/// one.
struct EdgeUse {
  int low = 0, high = 0;
  int triangle = 0;
  bool forward = true;
};

/// All edges of a list of triangles, each with those that use it, in the order of the triangles. Triangles with a repeated vertex have
/// none. One sort, no map: a million triangles take a third of a second.
class EdgeTable {
 public:
  explicit EdgeTable(const std::vector<Eigen::Vector3i>& triangles) {
    uses_.reserve(3 * triangles.size());
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      const Eigen::Vector3i& corner = triangles[t];
      if (corner[0] == corner[1] || corner[1] == corner[2] || corner[2] == corner[0]) continue;
      for (int k = 0; k < 3; ++k) {
        const int from = corner[k], to = corner[(k + 1) % 3];
        uses_.push_back({std::min(from, to), std::max(from, to), static_cast<int>(t), from < to});
      }
    }
    std::sort(uses_.begin(), uses_.end(), [](const EdgeUse& a, const EdgeUse& b) {
      if (a.low != b.low) return a.low < b.low;
      if (a.high != b.high) return a.high < b.high;
      return a.triangle < b.triangle;
    });
  }

  /// Calls visit(span of uses) once for every edge.
  template <class Visit>
  void for_each(Visit&& visit) const {
    for (std::size_t first = 0; first < uses_.size();) {
      std::size_t last = first;
      while (last < uses_.size() && uses_[last].low == uses_[first].low && uses_[last].high == uses_[first].high) ++last;
      visit(std::span<const EdgeUse>(uses_.data() + first, last - first));
      first = last;
    }
  }

 private:
  std::vector<EdgeUse> uses_;
};

/// Sets that grow together: which root an element belongs to, with paths halved on the way.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count) : parent_(count) {
    for (std::size_t i = 0; i < count; ++i) parent_[i] = static_cast<int>(i);
  }
  int root(int i) {
    while (parent_[static_cast<std::size_t>(i)] != i) {
      int& up = parent_[static_cast<std::size_t>(i)];
      up = parent_[static_cast<std::size_t>(up)];
      i = up;
    }
    return i;
  }
  /// The lower root stays, so that the order of joining does not matter.
  void join(int a, int b) {
    a = root(a), b = root(b);
    if (a != b) parent_[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
  }
  /// Numbers from 0 for every element's set, in the order in which sets first occur.
  std::vector<int> labels(int& count) {
    std::vector<int> label(parent_.size()), of_root(parent_.size(), -1);
    count = 0;
    for (std::size_t i = 0; i < parent_.size(); ++i) {
      int& number = of_root[static_cast<std::size_t>(root(static_cast<int>(i)))];
      if (number < 0) number = count++;
      label[i] = number;
    }
    return label;
  }

 private:
  std::vector<int> parent_;
};

}  // namespace dragcore
