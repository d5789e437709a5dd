#include <dragcore/dragcore.h>

#include <algorithm>
#include <dragcore/drag.hpp>
#include <dragcore/stepping.hpp>
#include <exception>
#include <stdexcept>
#include <string>

struct dragcore_surface {
  dragcore::Surface surface;
};

namespace {

thread_local std::string last_error;

/// Runs `body` and turns what it throws into a status: no exception may pass into C.
template <class Body>
dragcore_status guarded(Body&& body) noexcept {
  try {
    last_error.clear();
    body();
    return DRAGCORE_OK;
  } catch (const std::invalid_argument& error) {
    last_error = error.what();
    return DRAGCORE_INVALID_ARGUMENT;
  } catch (const std::exception& error) {
    last_error = error.what();
    return DRAGCORE_FAILED;
  } catch (...) {
    last_error = "unknown failure";
    return DRAGCORE_FAILED;
  }
}

void require(const void* pointer, const char* name) {
  if (!pointer) throw std::invalid_argument(std::string(name) + " is NULL");
}

Eigen::Vector3d vector(const double (&v)[3]) { return {v[0], v[1], v[2]}; }

dragcore::Motion motion_of(const dragcore_motion& m) {
  return {vector(m.wind), vector(m.velocity), vector(m.angular_velocity), vector(m.reference_point)};
}

dragcore::Model model_of(const dragcore_model& m) {
  if (m.quadrature != 0 && m.quadrature != 1 && m.quadrature != 3 && m.quadrature != 6)
    throw std::invalid_argument("quadrature = " + std::to_string(m.quadrature) + ", but it must be 1, 3 or 6, or 0 for adaptive");
  if (m.pillow < DRAGCORE_PILLOW_NONE || m.pillow > DRAGCORE_PILLOW_TILT)
    throw std::invalid_argument("pillow = " + std::to_string(m.pillow) + ", but it must be one of enum dragcore_pillow, 0 to 3");
  dragcore::Model model;
  model.law.name = "given";
  std::copy(m.windward, m.windward + 5, model.law.windward.begin());
  std::copy(m.leeward, m.leeward + 5, model.law.leeward.begin());
  model.pillow = {static_cast<dragcore::PillowForm>(m.pillow), m.pillow_factor};
  model.quadrature = static_cast<dragcore::Quadrature>(m.quadrature);
  return model;
}

}  // namespace

extern "C" {

dragcore_model dragcore_note_model(void) {
  dragcore_model model{};
  const dragcore::Law law = dragcore::note_law();
  std::copy(law.windward.begin(), law.windward.end(), model.windward);
  model.quadrature = 3;
  return model;
}

dragcore_status dragcore_surface_create(const double* vertices, size_t vertex_count, const int* triangles, size_t triangle_count, int two_sided,
                                        dragcore_surface** surface) {
  if (surface) *surface = nullptr;
  return guarded([&] {
    require(surface, "surface");
    if (vertex_count > 0) require(vertices, "vertices");
    if (triangle_count > 0) require(triangles, "triangles");
    dragcore::TriangleMesh mesh;
    for (size_t i = 0; i < vertex_count; ++i) mesh.vertices.emplace_back(vertices[3 * i], vertices[3 * i + 1], vertices[3 * i + 2]);
    for (size_t i = 0; i < triangle_count; ++i) mesh.triangles.emplace_back(triangles[3 * i], triangles[3 * i + 1], triangles[3 * i + 2]);
    *surface = new dragcore_surface{dragcore::Surface(mesh, two_sided ? dragcore::Surface::Sides::two : dragcore::Surface::Sides::one)};
  });
}

void dragcore_surface_destroy(dragcore_surface* surface) { delete surface; }

dragcore_status dragcore_evaluate(const dragcore_surface* surface, const dragcore_motion* motion, double density, const dragcore_model* model,
                                  dragcore_wrench* result) {
  return guarded([&] {
    require(surface, "surface");
    require(motion, "motion");
    require(model, "model");
    require(result, "result");
    const dragcore::Wrench total = dragcore::wrench(surface->surface, motion_of(*motion), {.density = density}, model_of(*model)).total();
    std::copy(total.force.begin(), total.force.end(), result->force);
    std::copy(total.torque.begin(), total.torque.end(), result->torque);
  });
}

dragcore_status dragcore_resistance(const dragcore_surface* surface, const dragcore_motion* motion, double density, const dragcore_model* model,
                                    double matrix[36]) {
  return guarded([&] {
    require(surface, "surface");
    require(motion, "motion");
    require(model, "model");
    require(matrix, "matrix");
    const dragcore::Matrix6d s = dragcore::resistance(surface->surface, motion_of(*motion), {.density = density}, model_of(*model));
    std::copy(s.data(), s.data() + 36, matrix);  // symmetric: rows are columns
  });
}

const char* dragcore_last_error(void) { return last_error.c_str(); }

}  // extern "C"
