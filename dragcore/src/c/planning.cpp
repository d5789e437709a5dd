#include <cstring>
#include <dragcore/diagnose.hpp>
#include <dragcore/required_effects.hpp>

#include "c/handles.hpp"

using namespace dragcore::c;

namespace dragcore::c {

void copy_lines(const std::vector<std::string>& lines, char* text, size_t size) {
  if (!text || size == 0) return;
  size_t used = 0;
  for (const std::string& line : lines) {
    if (used + line.size() + 2 > size) break;  // a newline and the end
    std::memcpy(text + used, line.data(), line.size());
    used += line.size();
    text[used++] = '\n';
  }
  text[used] = '\0';
}

}  // namespace dragcore::c

extern "C" {

dragcore_status dragcore_required_effects(const dragcore_scene* scene, dragcore_needs* needs, char* text, size_t size) {
  if (text && size > 0) text[0] = '\0';
  return guarded([&] {
    require(scene, "scene");
    require(scene->surface, "scene->surface");
    require(scene->motion, "scene->motion");
    require(scene->model, "scene->model");
    require(needs, "needs");
    const dragcore::Surface& surface = scene->surface->surface;
    const MotionOf given(*scene->motion, surface);
    dragcore::Scene asked{.surface = surface,
                          .motion = given.motion,
                          .free = !scene->held,
                          .medium = medium_of(scene->density, *scene->motion),
                          .model = model_of(*scene->model),
                          .wind = scene->wind ? &scene->wind->wind : nullptr,
                          .place = vector(scene->place)};
    if (scene->body) asked.body = body_of(*scene->body);
    if (scene->viscosity != 0.0) asked.viscosity = scene->viscosity;
    if (scene->tolerance != 0.0) asked.tolerance = scene->tolerance;
    const dragcore::RequiredEffects found = dragcore::required_effects(asked);
    *needs = {found.effects.bits(), static_cast<int>(found.wind_sampling), found.force_scale, found.torque_scale};
    std::vector<std::string> lines;
    for (const dragcore::EffectNeed& need : found.needs)
      lines.push_back(need.name + (need.needed ? ": needed; " : ": not needed; ") + need.why);
    copy_lines(lines, text, size);
  });
}

dragcore_status dragcore_diagnose(const dragcore_surface* surface, const dragcore_motion* motion, double density, const double to_world[9],
                                  const double world_velocity[3], size_t* count, char* text, size_t size) {
  if (text && size > 0) text[0] = '\0';
  return guarded([&] {
    require(surface, "surface");
    require(motion, "motion");
    require(count, "count");
    const MotionOf given(*motion, surface->surface);
    std::vector<dragcore::Warning> found;
    if (to_world) {
      dragcore::WorldMotion world{.to_world = Eigen::Map<const RowMajor3d>(to_world)};
      if (world_velocity) world.velocity = vector(world_velocity);
      found = dragcore::diagnose(surface->surface, given.motion, medium_of(density, *motion), world);
    } else {
      found = dragcore::diagnose(surface->surface, given.motion, medium_of(density, *motion));
    }
    *count = found.size();
    std::vector<std::string> lines;
    for (const dragcore::Warning& warning : found) lines.push_back(warning.text);
    copy_lines(lines, text, size);
  });
}

}  // extern "C"
