#include <algorithm>
#include <dragcore/bake.hpp>

#include "c/handles.hpp"

namespace {

using namespace dragcore::c;

/// A baked body knows no triangles: a wind by triangle is refused before its length, which nobody knows, is needed.
dragcore::Motion motion_for_map(const dragcore_motion& motion) {
  if (motion.triangle_wind)
    throw std::invalid_argument(
        "baked wrench: triangle_wind is given, but a map knows no triangles: set it to NULL, or use dragcore_evaluate()");
  return motion_of(motion);
}

dragcore_bake_error error_from(const dragcore::BakeError& error) {
  return {error.rms_force, error.worst_force, error.rms_torque, error.worst_torque};
}

}  // namespace

extern "C" {

dragcore_status dragcore_bake(const dragcore_surface* surface, const dragcore_model* model, double rms_error, size_t most_bytes,
                              dragcore_baked** baked) {
  return made(baked, "baked", [&] {
    require(surface, "surface");
    require(model, "model");
    return new dragcore_baked{dragcore::bake(surface->surface, model_of(*model), {.rms_error = rms_error, .most_bytes = most_bytes})};
  });
}

void dragcore_baked_destroy(dragcore_baked* baked) { delete baked; }

dragcore_status dragcore_baked_matches(const dragcore_baked* baked, const dragcore_surface* surface, const dragcore_model* model,
                                       int* matches) {
  return guarded([&] {
    require(baked, "baked");
    require(surface, "surface");
    require(model, "model");
    require(matches, "matches");
    *matches = baked->body.matches(surface->surface, model_of(*model));
  });
}

dragcore_status dragcore_baked_errors(const dragcore_baked* baked, size_t* bytes, dragcore_bake_error* straight,
                                      dragcore_bake_error spinning[3]) {
  return guarded([&] {
    require(baked, "baked");
    if (bytes) *bytes = baked->body.bytes();
    if (straight) *straight = error_from(baked->body.error);
    if (spinning) std::transform(baked->body.spin_error.begin(), baked->body.spin_error.end(), spinning, error_from);
  });
}

dragcore_status dragcore_baked_wrench(const dragcore_baked* baked, const dragcore_motion* motion, double density, dragcore_wrench* result) {
  return guarded([&] {
    require(baked, "baked");
    require(motion, "motion");
    require(result, "result");
    const dragcore::Wrench total = dragcore::wrench(baked->body, motion_for_map(*motion), medium_of(density, *motion));
    copy(total.force, result->force);
    copy(total.torque, result->torque);
  });
}

dragcore_status dragcore_baked_resistance(const dragcore_baked* baked, const dragcore_motion* motion, double density, double matrix[36]) {
  return guarded([&] {
    require(baked, "baked");
    require(motion, "motion");
    require(matrix, "matrix");
    const dragcore::Matrix6d s = dragcore::resistance(baked->body, motion_for_map(*motion), medium_of(density, *motion));
    std::copy(s.data(), s.data() + 36, matrix);  // symmetric: rows are columns
  });
}

}  // extern "C"
