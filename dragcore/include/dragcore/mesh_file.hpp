#pragma once

#include <dragcore/mesh.hpp>
#include <filesystem>
#include <string>
#include <vector>

/// Meshes in files. Part of dragcore::mesh_files, which needs nothing but dragcore.
namespace dragcore {

/// A mesh and what a reader must say about its file.
struct MeshFile {
  TriangleMesh mesh;
  std::vector<std::string> notes{};  ///< what the file holds and the mesh does not, a sentence each; empty where there is nothing
};

/// Reads the triangles of an STL or OBJ file. Equal vertices are joined. No other file that it may name is opened.
///
/// STL, ascii: double precision; capitals, byte-order mark, several solids and text outside of them are allowed. STL, binary: known by its
/// size, whatever its header says; bytes behind the last triangle are ignored. OBJ: polygons of any number of corners are split, convex
/// or not; weights w and colours of vertices are ignored. Text in UTF-16 is refused.
/// @param unit_m  size of the file's unit in metres: 0.001 for millimetres
/// @throws std::invalid_argument  when unit_m is not greater than 0
/// @throws std::runtime_error  missing, truncated or unreadable file, no triangle, a coordinate that is not finite, a face of vertices that
/// do not exist: the message names the file, the fault and, in text, the line
MeshFile read_mesh_file(const std::filesystem::path& file, double unit_m = 1.0);

/// The mesh of read_mesh_file() alone.
TriangleMesh read_mesh(const std::filesystem::path& file, double unit_m = 1.0);

/// Writes a binary STL file (single precision). @throws std::runtime_error when the file cannot be written
void write_stl(const std::filesystem::path& file, const TriangleMesh& mesh);

}  // namespace dragcore
