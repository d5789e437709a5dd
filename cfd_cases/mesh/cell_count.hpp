#pragma once

#include "cfd_cases/mesh/mesh_recipe.hpp"

namespace cfd_cases {

/// How many edges of the size field fill the meshed air and its boundary: what the number of cells is made of.
///
///   volume = int_air h^-3 dV,   surface = int_boundary h^-2 dA
///
/// `surface` counts the body, the sides of the air and the plane of symmetry: the polyhedral dual has one cell per point of the
/// tetrahedral mesh, and a point of the boundary fills half of the air that one inside does.
struct SizeIntegrals {
  double volume = 0.0;
  double surface = 0.0;
};

/// By bisection of the air until the size hardly varies over a piece, then one point each. The pieces are the same for all levels, so that
/// `volume` grows with refinement^-3 and `surface` with refinement^-2 to rounding.
///
/// @accuracy  2 % (tests/cfd_cases/mesh/test_cell_count.cpp); in and on the body the size is taken as that of the wall, which leaves out
/// the
///            point of a cone (below 1 %)
/// @cost      15,000 to 40,000 sizes: 1 to 5 ms
SizeIntegrals integrate_size(const dragcore::Shape& shape, const dragcore::Pose& pose, const MeshRecipe& recipe, Symmetry symmetry);

/// Cubes of an octree around a body with flat sides, but for those that keep neighbours within one halving: a few per cent more.
/// @throws std::invalid_argument  as OctreeSizes does
double octree_cells(const dragcore::Shape& shape, const MeshRecipe& recipe, Symmetry symmetry);

}  // namespace cfd_cases
