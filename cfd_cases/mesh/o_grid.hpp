#pragma once

#include <dragcore/pose.hpp>
#include <dragcore/shapes.hpp>
#include <vector>

#include "cfd_cases/mesh/mesh_recipe.hpp"
#include "cfd_cases/mesh/poly_mesh.hpp"

namespace cfd_cases {

/// An O-grid: layers of hexahedra around a smooth convex body, thin enough at the wall for a boundary layer without wall functions. The
/// wall is a cubed sphere drawn onto the body: the six sides of a cube, of which the two along the axis become the ends of a cylinder. From
/// a point W of the wall with the outward normal n goes one line of points at the distances s of the layers,
///
///   P(s) = W + s (m(s) + kappa(s) x),   m = unit vector of (1 - b) n + b d,   b = s^2 / (s^2 + a^2)
///
/// with the direction d of that point on the cubed sphere: close to the body the lines are square to it, far off they fan out evenly, from
/// the rim of a cylinder and the point of a teardrop too. The drift kappa along the wind x, which grows to 1 - upstream / far_radius, gives
/// the wake more cells than the front and the far field its usual place: recipe.upstream before the body. Patches: body, farfield and, in a
/// half model, symmetry. Frame of the mesh: that of the wind.
///
/// Of the recipe it reads body_size (faces on the wall), first_layer, growth, wake_size and wake_length (layers no thicker than wake_size
/// within that distance of the wall), upstream, far_radius and refinement.
///
/// @throws std::invalid_argument  the shape is no sphere, ellipsoid, cylinder or teardrop, or the plane of symmetry cuts no cube's middle
///                                (the body is rolled, or turned about two axes)
/// @accuracy  volume of a sphere -0.7 % on a coarse mesh (tests/cfd_cases/mesh/test_o_grid.cpp)
PolyMesh o_grid(const dragcore::Shape& shape, const dragcore::Pose& pose, const MeshRecipe& recipe, Symmetry symmetry);

/// Distances of the layers' bounds from the wall, 0 first, far_radius last [m].
std::vector<double> o_grid_layers(const MeshRecipe& recipe, double scale);

/// How many cells that gives, exactly. @throws std::invalid_argument as o_grid() does for the shape
double o_grid_cells(const dragcore::Shape& shape, const MeshRecipe& recipe, Symmetry symmetry);

}  // namespace cfd_cases
