#pragma once

#include <dragcore/dragcore.h>

#include <dragcore/bake.hpp>
#include <dragcore/drag.hpp>
#include <dragcore/stepping.hpp>
#include <dragcore/wind.hpp>
#include <exception>
#include <memory>
#include <stdexcept>
#include <string>

// What C holds pointers to, and what every function of the C interface does: no exception may pass into C.

struct dragcore_mesh {
  dragcore::TriangleMesh mesh;
};

struct dragcore_surface {
  dragcore::Surface surface;
};

struct dragcore_correction {
  std::shared_ptr<const dragcore::Correction> correction;
};

struct dragcore_baked {
  dragcore::BakedBody body;
};

struct dragcore_wind {
  std::vector<dragcore::WindSource> sources;
  double time = 0.0;
  dragcore::Wind wind;  ///< of the two above
};

namespace dragcore::c {

/// Keeps the beginning of a message for dragcore_last_error(), as much as has room, without allocating.
void set_last_error(const char* message) noexcept;

/// Runs `body` and turns what it throws into a status.
template <class Body>
dragcore_status guarded(Body&& body) noexcept {
  try {
    set_last_error("");
    body();
    return DRAGCORE_OK;
  } catch (const std::invalid_argument& error) {
    set_last_error(error.what());
    return DRAGCORE_INVALID_ARGUMENT;
  } catch (const std::exception& error) {
    set_last_error(error.what());
    return DRAGCORE_FAILED;
  } catch (...) {
    set_last_error("unknown failure");
    return DRAGCORE_FAILED;
  }
}

inline void require(const void* pointer, const char* name) {
  if (!pointer) throw std::invalid_argument(std::string(name) + " is NULL");
}

/// The same for a function that makes a new object: `*handle` is NULL after an error.
template <class Handle, class Make>
dragcore_status made(Handle** handle, const char* name, Make&& make) noexcept {
  if (handle) *handle = nullptr;
  return guarded([&] {
    require(handle, name);
    *handle = make();
  });
}

using RowMajor3d = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
using RowMajor6d = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;

inline Eigen::Vector3d vector(const double v[3]) { return {v[0], v[1], v[2]}; }

inline void copy(const Eigen::Vector3d& from, double to[3]) { Eigen::Map<Eigen::Vector3d>{to} = from; }

inline dragcore_body body_from(const MassProperties& properties) {
  dragcore_body body{};
  body.mass = properties.mass;
  Eigen::Map<RowMajor3d>{body.inertia} = properties.inertia;
  Eigen::Map<RowMajor6d>{body.added_mass} = properties.added;
  return body;
}

inline MassProperties body_of(const dragcore_body& b) {
  return {b.mass, Eigen::Map<const RowMajor3d>(b.inertia), Eigen::Map<const RowMajor6d>(b.added_mass)};
}

/// Without the wind per triangle, which belongs to a surface.
inline Motion motion_of(const dragcore_motion& m) {
  return {vector(m.wind),
          vector(m.velocity),
          vector(m.angular_velocity),
          vector(m.reference_point),
          Eigen::Map<const RowMajor3d>(m.wind_gradient),
          {}};
}

inline Medium medium_of(double density, const dragcore_motion& m) { return {.density = density, .viscosity = m.viscosity}; }

/// A motion with the wind per triangle, which it owns.
struct MotionOf {
  MotionOf(const dragcore_motion& m, const Surface& surface) : motion(motion_of(m)) {
    if (!m.triangle_wind) return;
    for (Eigen::Index i = 0; i < surface.size(); ++i) triangle_wind.push_back(vector(m.triangle_wind + 3 * i));
    motion.triangle_wind = triangle_wind;
  }
  MotionOf(const MotionOf&) = delete;

  std::vector<Eigen::Vector3d> triangle_wind;
  Motion motion;
};

Law law_of(const dragcore_law& law);

/// @throws std::invalid_argument  for numbers that are in no enumeration
Model model_of(const dragcore_model& model);
dragcore_model model_from(const Model& model);  ///< without a correction, which C must keep

/// @throws std::invalid_argument  for NULL; indices are checked by whoever takes the mesh
TriangleMesh mesh_of(const double* vertices, size_t vertex_count, const int* triangles, size_t triangle_count);

/// Sentences for `text` of `size` bytes, one a line, cut at the end of a line where there is no room; NULL: not wanted.
void copy_lines(const std::vector<std::string>& lines, char* text, size_t size);

}  // namespace dragcore::c
