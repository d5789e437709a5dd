#pragma once

#include <Eigen/Core>
#include <dragcore/preparation.hpp>
#include <vector>

namespace dragcore {

class EdgeTable;

/// Whether triangles with area are one closed convex body, neither a neighbour nor the outermost corners in any direction rising above a
/// triangle's plane by more than a thousandth of the size; or one flat sheet. Neighbours alone would call every fine mesh convex: over a
/// short edge nothing rises far.
/// @param edges  of the triangles, where they are known
bool is_convex(const std::vector<Eigen::Vector3i>& triangles, const std::vector<Eigen::Vector3d>& vertices, bool sheet,
               const EdgeTable* edges = nullptr);

/// The same of what was prepared; false of several parts.
bool is_convex(const Preparation& preparation);

}  // namespace dragcore
