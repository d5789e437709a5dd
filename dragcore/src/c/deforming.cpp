#include <dragcore/deforming.hpp>

#include "c/handles.hpp"

using namespace dragcore::c;

struct dragcore_deforming {
  dragcore::DeformingMesh mesh;
};

extern "C" {

dragcore_status dragcore_deforming_create(const int* triangles, size_t triangle_count, size_t vertex_count, int sides,
                                          dragcore_deforming** mesh) {
  return made(mesh, "mesh", [&] {
    if (triangle_count > 0) require(triangles, "triangles");
    std::vector<Eigen::Vector3i> corners;
    corners.reserve(triangle_count);
    for (size_t t = 0; t < triangle_count; ++t) corners.emplace_back(triangles[3 * t], triangles[3 * t + 1], triangles[3 * t + 2]);
    return new dragcore_deforming{dragcore::DeformingMesh(corners, vertex_count, static_cast<dragcore::Surface::Sides>(sides))};
  });
}

void dragcore_deforming_destroy(dragcore_deforming* mesh) { delete mesh; }

dragcore_status dragcore_deforming_forces(dragcore_deforming* mesh, const dragcore_deforming_motion* motion, double density,
                                          const dragcore_law* law, float* force, size_t force_stride) {
  return guarded([&] {
    require(mesh, "mesh");
    require(motion, "motion");
    require(law, "law");
    const std::size_t count = mesh->mesh.vertices();
    const auto vectors = [count](const dragcore_vertex_vectors& given) {
      return dragcore::VertexArray<const float>(given.first, count, given.stride);
    };
    const auto forces = [&](const auto& wind) {
      mesh->mesh.forces(vectors(motion->position), vectors(motion->velocity), wind, {.density = density}, law_of(*law),
                        {force, count, force_stride});
    };
    if (motion->vertex_wind.first)
      forces(vectors(motion->vertex_wind));
    else
      forces(vector(motion->wind));
  });
}

}  // extern "C"
