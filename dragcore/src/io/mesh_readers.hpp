#pragma once

#include <dragcore/mesh_file.hpp>
#include <span>
#include <string_view>
#include <vector>

/// What read_mesh_file() is made of. Coordinates are in the file's unit, vertices as often as the file says them.
/// Faults are std::runtime_error without the file's name.
namespace dragcore {

MeshFile read_stl(std::string_view bytes);
MeshFile read_obj(std::string_view bytes);

/// Splits a polygon into triangles over the same corners, added to `triangles`: a fan from its first corner where that covers it once,
/// else by cutting off ears. Where there is no ear, because edges cross or all lies on a line, what is left becomes a fan too. Time grows
/// with the corners times those of them that are not convex.
/// @param corners  indices into `vertices`, at least three
void split_polygon(const std::vector<Eigen::Vector3d>& vertices, std::span<const int> corners, std::vector<Eigen::Vector3i>& triangles);

}  // namespace dragcore
