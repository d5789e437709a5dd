#pragma once

#include <map>
#include <string>

#include "cfd_cases/mesh/mesh_recipe.hpp"
#include "cfd_cases/mesh/poly_mesh.hpp"

namespace cfd_cases {

/// A body given by its triangles is meshed by snappyHexMesh: cubes of the recipe's far size, halved as often as brings them nearest to the
/// recipe's sizes in its boxes and on the body (the levels of refinement_of() are then similar to each other), then drawn onto the
/// triangles and their sharp and open edges. An open shell has no thickness; both of its sides become wall, and cubes along its edges are
/// halved once more, since what is lost there is lost on both sides.
///
/// @return  files of a case folder by path, for surfaceFeatureExtract, blockMesh and snappyHexMesh, the triangles in their pose among them
std::map<std::string, std::string> snappy_files(const dragcore::MeshBody& body, const dragcore::Pose& pose, const MeshRecipe& recipe,
                                                Symmetry symmetry);

/// How many cells that gives. @accuracy 15 % (tests/cfd_cases/mesh/test_snappy.cpp)
double snappy_cells(const dragcore::MeshBody& body, const dragcore::Pose& pose, const MeshRecipe& recipe, Symmetry symmetry);

/// What shows that a mesh is not of this body: snappyHexMesh misses bodies, meshes their inside or loses their edges with exit code 0.
/// Asked for are the patches inlet, outlet, sides and body with faces; the body's area, twice that of a shell, and its volume, within
/// the larger of 1 % and what faces of this size cut off round walls; and that the body's faces close: their area vectors add up to 0, in a
/// half model but for the component across the plane.
/// @return  the first fault found, empty when there is none
std::string snappy_fault(const dragcore::MeshBody& body, const MeshRecipe& recipe, Symmetry symmetry, const PolyMesh& mesh);

}  // namespace cfd_cases
