#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace cfd_cases {

/// The polyhedral mesh of an OpenFOAM case (constant/polyMesh, ascii).
struct PolyMesh {
  struct Patch {
    std::string name;
    int first_face = 0;
    int faces = 0;
  };
  std::vector<Eigen::Vector3d> points;
  std::vector<std::vector<int>> faces;  ///< right-handed about the normal, which points out of the owner
  std::vector<int> owner;               ///< cell of each face
  std::vector<int> neighbour;           ///< other cell of each internal face; internal faces come first
  std::vector<Patch> patches;

  int cells() const;
  /// @throws std::runtime_error naming the patches there are, when `name` is not one of them
  const Patch& patch(const std::string& name) const;
};

/// @throws std::runtime_error naming the file, when one is missing, binary, truncated or inconsistent with the others
PolyMesh read_poly_mesh(const std::filesystem::path& folder);
void write_points(const std::filesystem::path& folder, const std::vector<Eigen::Vector3d>& points);
/// All files of the folder, which is made; every patch is of the type "patch".
void write_poly_mesh(const std::filesystem::path& folder, const PolyMesh& mesh);

/// Centre and area vector of a face as OpenFOAM defines them: the triangles from the mean of the corners, weighted by area.
struct FaceGeometry {
  Eigen::Vector3d centre, area_vector;
};
FaceGeometry face_geometry(const PolyMesh& mesh, int face);

/// Area of the patch and the volume it encloses together with planes through the origin (of the half model, when the mesh is one).
struct PatchExtent {
  double area = 0.0, volume = 0.0;
};
PatchExtent patch_extent(const PolyMesh& mesh, const std::string& patch);

/// Makes the cells along the sharp edges of a body usable. There the dual cell wraps around the edge, and where its legs are uneven its
/// centroid lies behind one of its own wall faces (checkMesh: "incorrectly oriented"), so that the distance to the wall is negative. Moves
/// the inner points of such cells away from that wall face, by as little as lifts the centroid off it; points of any patch stay.
/// @return  cells that were moved
int lift_edge_cells(PolyMesh& mesh, const std::string& patch);

/// The bounding box of each cell.
struct CellExtent {
  Eigen::Vector3d lower, upper;
};
std::vector<CellExtent> cell_extents(const PolyMesh& mesh);

/// Writes a set of cells for OpenFOAM's tools: polyMesh/sets/<name>.
void write_cell_set(const std::filesystem::path& folder, const std::string& name, const std::vector<int>& cells);

/// The values of all cells of a scalar field in an ascii file of a time folder; "uniform" is spread out.
/// @throws std::runtime_error naming the file when there are not `cells` of them or one is not finite
Eigen::VectorXd read_cell_scalars(const std::filesystem::path& file, int cells);

/// The values of a vector field on the faces of one patch.
/// @throws std::runtime_error naming the file when the patch or its values are missing, or there are not `faces` of them, or one is not
/// finite
Eigen::Matrix3Xd read_patch_vectors(const std::filesystem::path& file, const std::string& patch, int faces);

}  // namespace cfd_cases
