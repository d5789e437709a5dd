#pragma once

#include <Eigen/Core>
#include <dragcore/preparation.hpp>
#include <set>
#include <utility>
#include <vector>

namespace dragcore {

/// The sphere of directions while it is being refined: an icosahedron whose cells are cut where somebody asks for it.
class DirectionSphere {
 public:
  /// Two directions, the lower number first.
  using Edge = std::pair<int, int>;

  /// An icosahedron with its edges halved this many times: 12, 42, 162, 642 directions. Midpoints of the first are the six along the axes.
  explicit DirectionSphere(int halvings);

  /// Halves these edges of whole cells, and as many others as it takes to keep every corner off its neighbours' edges: a cell is halved
  /// along its longest edge before any other, so that none becomes a needle.
  void halve(std::set<Edge> edges);

  const std::vector<Eigen::Vector3d>& directions() const { return directions_; }
  const std::vector<Exposure::Cell>& cells() const { return cells_; }
  /// Of every direction but the first 12 the two that it was put in the middle of.
  const std::vector<Edge>& parents() const { return parents_; }

  Eigen::Vector3d middle(const Edge& edge) const;
  /// Distance between two directions, 0 to 2.
  double length(const Edge& edge) const;
  /// The edge from corner k of a cell to the next.
  static Edge edge(const Exposure::Cell& cell, int k);
  /// Which edge of a cell is the longest; the same for both cells at that edge.
  int longest(const Exposure::Cell& cell) const;

 private:
  const Eigen::Vector3d& at(int k) const { return directions_[static_cast<std::size_t>(k)]; }

  std::vector<Eigen::Vector3d> directions_;
  std::vector<Edge> parents_;
  std::vector<Exposure::Cell> cells_;
};

}  // namespace dragcore
