#pragma once

#include <dragcore/mesh.hpp>
#include <filesystem>

namespace dragcore {

/// Reads the triangles of an STL (ascii or binary) or OBJ file; polygons of OBJ, up to 2,000 corners, are split. Equal vertices are joined.
/// No other file that it may name is opened. Part of dragcore::io.
/// @param unit_m  size of the file's unit in metres: 0.001 for millimetres
/// @throws std::invalid_argument  when unit_m is not greater than 0
/// @throws std::runtime_error  missing, truncated or unreadable file, no triangle, a coordinate that is not finite, a face of vertices that
/// do not
///                             exist: the message names the file and the fault, in OBJ files the line
TriangleMesh read_mesh(const std::filesystem::path& file, double unit_m = 1.0);

/// Writes a binary STL file (single precision). @throws std::runtime_error when the file cannot be written
void write_stl(const std::filesystem::path& file, const TriangleMesh& mesh);

}  // namespace dragcore
