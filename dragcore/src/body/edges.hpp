#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
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

/// Sorts by `key`, then by `less`, in a time that grows with the number of items alone where few share a key.
/// @param key  of an item, from 0 to below `keys`
template <class Item, class Key, class Less>
void sort_by_buckets(std::vector<Item>& items, std::size_t keys, Key&& key, Less&& less) {
  std::vector<std::size_t> first(keys + 1, 0);
  for (const Item& item : items) ++first[static_cast<std::size_t>(key(item)) + 1];
  for (std::size_t k = 0; k < keys; ++k) first[k + 1] += first[k];
  std::vector<Item> sorted(items.size());
  std::vector<std::size_t> next(first.begin(), first.end() - 1);
  for (const Item& item : items) sorted[next[static_cast<std::size_t>(key(item))]++] = item;
  for (std::size_t k = 0; k < keys; ++k)
    if (first[k + 1] - first[k] > 1)
      std::sort(sorted.begin() + static_cast<std::ptrdiff_t>(first[k]), sorted.begin() + static_cast<std::ptrdiff_t>(first[k + 1]), less);
  items = std::move(sorted);
}

/// One more than the largest index of a vertex.
inline std::size_t vertex_bound(const std::vector<Eigen::Vector3i>& triangles) {
  int largest = -1;
  for (const Eigen::Vector3i& t : triangles) largest = std::max(largest, t.maxCoeff());
  return static_cast<std::size_t>(largest + 1);
}

/// All edges of a list of triangles, each with those that use it, in the order of the triangles. Triangles with a repeated vertex have
/// none. Sorted by buckets, no map: a million triangles take a tenth of a second.
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
    sort_by_buckets(
        uses_, vertex_bound(triangles), [](const EdgeUse& use) { return use.low; },
        [](const EdgeUse& a, const EdgeUse& b) { return a.high != b.high ? a.high < b.high : a.triangle < b.triangle; });
    first_.reserve(uses_.size() / 2 + 1);
    edge_of_.assign(triangles.size(), {-1, -1, -1});
    for (std::size_t i = 0; i < uses_.size(); ++i) {
      const EdgeUse& use = uses_[i];
      if (i == 0 || use.low != uses_[i - 1].low || use.high != uses_[i - 1].high) first_.push_back(static_cast<int>(i));
      const Eigen::Vector3i& corner = triangles[static_cast<std::size_t>(use.triangle)];
      const int from = use.forward ? use.low : use.high;
      for (std::size_t k = 0; k < 3; ++k)
        if (corner[static_cast<Eigen::Index>(k)] == from)
          edge_of_[static_cast<std::size_t>(use.triangle)][k] = static_cast<int>(first_.size()) - 1;
    }
    first_.push_back(static_cast<int>(uses_.size()));
  }

  /// Calls visit(span of uses) once for every edge.
  template <class Visit>
  void for_each(Visit&& visit) const {
    for (std::size_t edge = 0; edge + 1 < first_.size(); ++edge) visit(uses(edge));
  }

  /// Those that use the edge from corner k of a triangle to the next, itself among them; none for a triangle with a repeated corner.
  std::span<const EdgeUse> at(std::size_t triangle, std::size_t k) const {
    const int edge = edge_of_[triangle][k];
    return edge < 0 ? std::span<const EdgeUse>() : uses(static_cast<std::size_t>(edge));
  }

 private:
  std::span<const EdgeUse> uses(std::size_t edge) const {
    return {uses_.data() + first_[edge], static_cast<std::size_t>(first_[edge + 1] - first_[edge])};
  }

  std::vector<EdgeUse> uses_;
  std::vector<int> first_;  // use of every edge, and one past the last
  std::vector<std::array<int, 3>> edge_of_;
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
    std::vector<int> label(parent_.size());
    count = 0;
    for (std::size_t i = 0; i < parent_.size(); ++i) {
      const int above = root(static_cast<int>(i));  // never a later one, so that its number is known
      label[i] = above == static_cast<int>(i) ? count++ : label[static_cast<std::size_t>(above)];
    }
    return label;
  }

 private:
  std::vector<int> parent_;
};

}  // namespace dragcore
