#include "exposure/direction_sphere.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <numbers>

namespace dragcore {

using Eigen::Vector3d;
using Eigen::Vector3i;

DirectionSphere::DirectionSphere(int halvings) {
  const double g = std::numbers::phi;
  directions_ = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                 {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  for (Vector3d& corner : directions_) corner.normalize();
  parents_.assign(directions_.size(), {-1, -1});
  // Its faces are the triples of corners that are all neighbours of each other.
  const auto adjacent = [&](int a, int b) { return at(a).dot(at(b)) > 0.4; };
  for (int a = 0; a < 12; ++a)
    for (int b = a + 1; b < 12; ++b)
      for (int c = b + 1; c < 12; ++c)
        if (adjacent(a, b) && adjacent(b, c) && adjacent(c, a)) cells_.push_back({.corner = {a, b, c}});
  for (; halvings > 0; --halvings) {
    std::set<Edge> all;
    for (const Exposure::Cell& cell : cells_)
      if (cell.children == 0)
        for (int k = 0; k < 3; ++k) all.insert(edge(cell, k));
    halve(std::move(all));
  }
}

Vector3d DirectionSphere::middle(const Edge& edge) const { return (at(edge.first) + at(edge.second)).normalized(); }

double DirectionSphere::length(const Edge& edge) const { return (at(edge.first) - at(edge.second)).norm(); }

DirectionSphere::Edge DirectionSphere::edge(const Exposure::Cell& cell, int k) {
  return std::minmax({cell.corner[k], cell.corner[(k + 1) % 3]});
}

int DirectionSphere::longest(const Exposure::Cell& cell) const {
  // Lengths that are equal but for rounding must rank alike in both cells: then the edge's own numbers decide.
  const auto longer = [&](int a, int b) {
    const Edge first = edge(cell, a), second = edge(cell, b);
    const double difference = length(first) - length(second);
    return std::abs(difference) > 1e-9 ? difference > 0.0 : first > second;
  };
  int most = 0;
  for (int k = 1; k < 3; ++k)
    if (longer(k, most)) most = k;
  return most;
}

void DirectionSphere::halve(std::set<Edge> edges) {
  for (bool grown = true; grown;) {
    grown = false;
    for (const Exposure::Cell& cell : cells_) {
      if (cell.children > 0) continue;
      bool any = false;
      for (int k = 0; k < 3; ++k) any = any || edges.contains(edge(cell, k));
      if (any && edges.insert(edge(cell, longest(cell))).second) grown = true;
    }
  }
  std::map<Edge, int> middles;
  const auto middle_of = [&](const Edge& halved) {
    const auto [place, made] = middles.try_emplace(halved, static_cast<int>(directions_.size()));
    if (made) {
      directions_.push_back(middle(halved));
      parents_.push_back(halved);
    }
    return place->second;
  };
  const std::size_t before = cells_.size();
  for (std::size_t i = 0; i < before; ++i) {
    if (cells_[i].children > 0) continue;
    const Exposure::Cell cell = cells_[i];
    std::array<bool, 3> cut{};
    for (int k = 0; k < 3; ++k) cut[static_cast<std::size_t>(k)] = edges.contains(edge(cell, k));
    const auto cuts = std::count(cut.begin(), cut.end(), true);
    if (cuts == 0) continue;
    std::vector<Vector3i> parts;
    const int first = cuts == 3 ? 0 : longest(cell);
    const auto corner = [&](int k) { return cell.corner[(first + k) % 3]; };
    const auto cut_at = [&](int k) { return cut[static_cast<std::size_t>((first + k) % 3)]; };
    const auto middle_at = [&](int k) { return middle_of(edge(cell, (first + k) % 3)); };
    const int a = corner(0), b = corner(1), c = corner(2), ab = middle_at(0);
    if (cuts == 3) {
      const int bc = middle_at(1), ca = middle_at(2);
      parts = {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}};
    } else if (cut_at(1)) {
      const int bc = middle_at(1);
      parts = {{a, ab, c}, {ab, b, bc}, {ab, bc, c}};
    } else if (cut_at(2)) {
      const int ca = middle_at(2);
      parts = {{a, ab, ca}, {ca, ab, c}, {ab, b, c}};
    } else {
      parts = {{a, ab, c}, {ab, b, c}};
    }
    cells_[i].child = static_cast<int>(cells_.size());
    cells_[i].children = static_cast<int>(parts.size());
    for (const Vector3i& part : parts) cells_.push_back({.corner = part});
  }
}

}  // namespace dragcore
