#pragma once

#include <cstddef>
#include <cstdint>

#include "kernels/wrench_kernel.hpp"

namespace dragcore::kernels {

/// Where the corners of sixteen triangles have their rows: in numbers from the first row.
struct CornerRows {
  std::uint32_t of[3][lanes];
};

/// Numbers of a row: of a vertex, its place, 0, velocity of the air relative to it, 0; of a triangle, what each corner gets of its force,
/// 0.
inline constexpr std::size_t vertex_row = 8, force_row = 4;

/// Row of a triangle's force: within each group as the kernels transpose them, four lanes that are four apart together.
constexpr std::size_t force_place(std::size_t triangle) {
  const std::size_t lane = triangle % lanes;
  return triangle - lane + lane % 4 * (lanes / 4) + lane / 4;
}

/// Vectors of vertices where the engine has them.
struct Strided {
  const float* first = nullptr;
  std::size_t stride = 0;
};

/// One call for a deforming mesh.
struct DeformingTask {
  std::size_t vertices = 0;
  const CornerRows* corners = nullptr;  ///< of every group
  /// Rows of forces that each vertex takes: incident[first[v]] to incident[first[v + 1]], in numbers from the first row.
  const std::uint32_t* first = nullptr;
  const std::uint32_t* incident = nullptr;
  float* vertex_rows = nullptr;
  float* force_rows = nullptr;

  Strided position{}, velocity{}, wind{};
  float* force = nullptr;
  std::size_t force_stride = 0;
  ResolvedLaw law{};
  bool two_sided = false;
  /// density/108 [kg/m^3]: of density/2 a half, since a cross product is twice the area; a third, since a triangle has three corners; and a
  /// ninth, since the kernel squares the sum of three velocities.
  float scale = 0.0f;
};

// Three steps, each over a range whose items do not depend on each other.

/// Rows of vertices.
void fill_vertex_rows(const DeformingTask& task, std::size_t first, std::size_t last);
/// Rows of forces of groups of triangles. Those whose numbers do not fit are left to one_by_one(triangle).
void fill_force_rows(const DeformingTask& task, std::size_t first, std::size_t last,
                     void (*one_by_one)(void* context, std::size_t triangle), void* context);
/// Sums the forces of vertices in the order of `incident`.
void sum_forces(const DeformingTask& task, std::size_t first, std::size_t last);

}  // namespace dragcore::kernels
