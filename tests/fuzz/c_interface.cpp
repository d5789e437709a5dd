#include <dragcore/dragcore.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "fuzz.hpp"

namespace {

/// Values made of the bytes, zeros behind their end.
class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}

  template <class Value>
  Value take() {
    Value value{};
    const std::size_t count = std::min(sizeof value, size_);
    if (count > 0) std::memcpy(&value, data_, count);
    data_ += count;
    size_ -= count;
    return value;
  }
  /// Any double at all, or one of a size that bodies and winds have: else nearly all would be refused.
  double number() { return take<std::uint8_t>() % 8 == 0 ? take<double>() : take<std::int8_t>() / 16.0; }
  int index(int count) { return take<std::uint8_t>() % 32 == 0 ? take<int>() : take<std::uint8_t>() % std::max(1, count); }
  template <std::size_t count>
  void fill(double (&numbers)[count]) {
    for (double& x : numbers) x = number();
  }

 private:
  const std::uint8_t* data_;
  std::size_t size_;
};

void check_status(dragcore_status status) {
  fuzz::check(status == DRAGCORE_OK || status == DRAGCORE_INVALID_ARGUMENT || status == DRAGCORE_FAILED, "a function returns a status");
  fuzz::check((status == DRAGCORE_OK) == (dragcore_last_error()[0] == '\0'), "an error has a message, and success has none");
  fuzz::check(std::strlen(dragcore_last_error()) < 1000, "a message is short");
}

void check_finite(dragcore_status status, const double* numbers, int count, const char* what) {
  if (status != DRAGCORE_OK) return;
  for (int i = 0; i < count; ++i) fuzz::check(std::isfinite(numbers[i]), std::string("what is returned without error is finite: ") + what);
}

}  // namespace

/// The C interface: any numbers, any indices, NULL anywhere.
int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes bytes(data, size);
  const auto nulls = bytes.take<std::uint8_t>() % 4 == 0 ? bytes.take<std::uint32_t>() : 0u;  // one bit for each pointer
  const auto pointer = [&](int bit, auto* p) { return nulls >> bit & 1 ? nullptr : p; };

  const int vertex_count = bytes.take<std::uint8_t>() % 12, triangle_count = bytes.take<std::uint8_t>() % 20;
  std::vector<double> vertices(3 * vertex_count);
  for (double& x : vertices) x = bytes.number();
  std::vector<int> triangles(3 * triangle_count);
  for (int& i : triangles) i = bytes.index(vertex_count);
  const int two_sided = bytes.take<std::uint8_t>() % 3;

  dragcore_surface* surface = nullptr;
  dragcore_status status = dragcore_surface_create(pointer(0, vertices.data()), vertex_count, pointer(1, triangles.data()), triangle_count,
                                                   two_sided, pointer(2, &surface));
  check_status(status);
  fuzz::check((status == DRAGCORE_OK) == (surface != nullptr), "there is a surface where there is no error");

  dragcore_body_class body_class;
  check_status(dragcore_surface_class(pointer(3, surface), pointer(4, &body_class)));
  dragcore_model model = dragcore_note_model();
  check_status(dragcore_model_for(pointer(5, surface), pointer(6, &model)));
  const char name[] = {bytes.take<char>(), bytes.take<char>(), '\0'};
  const char* known[] = {"note", "consistent", "sheet", "closed", name, nullptr};
  check_status(dragcore_named_law(known[bytes.take<std::uint8_t>() % 6], pointer(7, &model.law)));

  dragcore_motion motion{};
  for (auto* v : {&motion.wind, &motion.velocity, &motion.angular_velocity, &motion.reference_point}) bytes.fill(*v);
  bytes.fill(motion.wind_gradient);
  const double density = bytes.number();
  if (bytes.take<std::uint8_t>() % 2) {
    bytes.fill(model.law.windward);
    bytes.fill(model.law.leeward);
    for (double* x : {&model.law.friction, &model.law.base_suction, &model.law.base_edge, &model.law.aspect_gain, &model.law.aspect_scale,
                      &model.law.recovery, &model.law.recovery_depth, &model.law.recovery_edge, &model.law.shelter, &model.law.curvature})
      *x = bytes.number();
  }
  // C lets any number into an enum.
  const int pillow = bytes.index(5), falloff = bytes.index(2);
  std::memcpy(&model.pillow, &pillow, sizeof pillow);
  std::memcpy(&model.falloff, &falloff, sizeof falloff);
  model.pillow_factor = bytes.number();
  model.quadrature = bytes.index(7);
  model.effects = static_cast<unsigned>(bytes.index(512));
  model.precision = bytes.index(3);

  dragcore_wrench wrench{};
  status = dragcore_evaluate(pointer(8, surface), pointer(9, &motion), density, pointer(10, &model), pointer(11, &wrench));
  check_status(status);
  check_finite(status, wrench.force, 3, "force");
  check_finite(status, wrench.torque, 3, "torque");

  double matrix[36] = {}, jacobian[36];
  status = dragcore_force_jacobian(pointer(12, surface), pointer(13, &motion), density, pointer(14, &model), pointer(15, jacobian));
  check_status(status);
  check_finite(status, jacobian, 36, "Jacobian");
  status = dragcore_resistance(pointer(16, surface), pointer(17, &motion), density, pointer(18, &model), pointer(19, matrix));
  check_status(status);
  check_finite(status, matrix, 36, "resistance");

  dragcore_body body{};
  body.mass = bytes.number();
  bytes.fill(body.inertia);
  const double dt = bytes.number();
  bytes.fill(wrench.force);
  bytes.fill(wrench.torque);
  if (bytes.take<std::uint8_t>() % 2) bytes.fill(matrix);
  for (const auto step : {&dragcore_step_secant_implicit, &dragcore_step_scalar_implicit}) {
    double velocity[3], angular_velocity[3];
    status = step(pointer(20, matrix), pointer(21, &body), pointer(22, &motion), pointer(23, &wrench), dt, pointer(24, velocity),
                  pointer(25, angular_velocity));
    check_status(status);
    check_finite(status, velocity, 3, "velocity after a step");
    check_finite(status, angular_velocity, 3, "angular velocity after a step");
  }
  double share;
  status = dragcore_impulse_share(pointer(26, &wrench), pointer(27, &body), pointer(28, &motion), dt, pointer(29, &share));
  check_status(status);
  fuzz::check(status != DRAGCORE_OK || (share >= 0.0 && share <= 1.0), "the share of an impulse is from 0 to 1");

  // What came later has a second word of NULLs, so that older inputs of the corpus mean what they meant.
  const auto more_nulls = bytes.take<std::uint8_t>() % 4 == 0 ? bytes.take<std::uint32_t>() : 0u;
  const auto other = [&](int bit, auto* p) { return more_nulls >> bit & 1 ? nullptr : p; };

  dragcore_mesh* mesh = nullptr;
  status = dragcore_mesh_create(other(0, vertices.data()), vertex_count, other(1, triangles.data()), triangle_count, other(2, &mesh));
  check_status(status);
  fuzz::check((status == DRAGCORE_OK) == (mesh != nullptr), "there is a mesh where there is no error");
  double centre[3] = {};
  for (const auto mass : {&dragcore_mass_properties, &dragcore_sheet_mass_properties}) {
    dragcore_body found{};
    status = mass(mesh, bytes.number(), other(3, &found), other(4, centre));
    check_status(status);
    check_finite(status, &found.mass, 1, "mass");
    check_finite(status, found.inertia, 9, "inertia");
    check_finite(status, centre, 3, "centre of mass");
    fuzz::check(status != DRAGCORE_OK || found.mass > 0.0, "mass is positive");
  }
  bytes.fill(centre);
  check_status(dragcore_mesh_recentre(mesh, other(5, centre)));
  dragcore_mesh_destroy(mesh);

  double placed[9], where[3];
  bytes.fill(where);
  bytes.fill(placed);
  if (bytes.take<std::uint8_t>() % 4) std::copy_n(dragcore_no_placement().to_world, 9, placed);
  std::size_t count = 0;
  char text[64];
  check_status(dragcore_diagnose(other(6, surface), other(7, &motion), density, other(8, placed), other(9, where), other(10, &count),
                                 other(11, text), bytes.take<std::uint8_t>() % sizeof text));

  dragcore_wind* wind = nullptr;
  check_status(dragcore_wind_create(other(12, &wind)));
  dragcore_placement placement = dragcore_no_placement();
  if (bytes.take<std::uint8_t>() % 2) {
    bytes.fill(placement.position);
    bytes.fill(placement.scale);
    placement.intensity = bytes.number();
    placement.fade_radius = bytes.number();
  }
  check_status(dragcore_wind_add_uniform(wind, other(13, where), other(14, &placement)));
  check_status(dragcore_wind_add_vortex(wind, bytes.number(), bytes.number(), &placement));
  check_status(dragcore_wind_add_jet(wind, bytes.number(), bytes.number(), nullptr));
  dragcore_grid grid{};
  const double values[24] = {1, 2, 3};
  for (int& points : grid.points) points = bytes.take<std::uint8_t>() % 3;  // at most the 8 points that there are
  bytes.fill(grid.lower);
  bytes.fill(grid.upper);
  grid.values = other(15, values);
  check_status(dragcore_wind_add_grid(wind, other(16, &grid), nullptr));
  dragcore_dryden dryden{};
  bytes.fill(dryden.intensity);
  bytes.fill(dryden.length);
  bytes.fill(dryden.mean_wind);
  dryden.waves = bytes.take<std::int8_t>();
  check_status(dragcore_wind_add_turbulence(wind, other(17, &dryden), nullptr));
  check_status(dragcore_wind_set_time(wind, bytes.number()));
  check_status(dragcore_wind_set_intensity(wind, bytes.take<std::uint8_t>() % 6, bytes.number()));
  double gradient[9];
  check_status(dragcore_wind_sample(wind, other(18, where), other(19, centre), other(20, gradient)));

  std::size_t felt = 0;
  if (surface) check_status(dragcore_surface_triangles(surface, &felt));
  std::vector<double> per_triangle(3 * felt);
  check_status(dragcore_wind_over_body(wind, surface, other(21, where), other(22, placed), bytes.number(), other(23, per_triangle.data()),
                                       other(24, &motion)));
  status = dragcore_evaluate(surface, &motion, density, &model, &wrench);
  check_status(status);
  check_finite(status, wrench.force, 3, "force in a wind field");

  dragcore_scene scene{};
  scene.surface = surface;
  scene.motion = other(25, &motion);
  scene.model = other(26, &model);
  scene.density = density;
  scene.held = bytes.take<std::uint8_t>() % 2;
  scene.wind = bytes.take<std::uint8_t>() % 2 ? wind : nullptr;
  scene.body = bytes.take<std::uint8_t>() % 2 ? &body : nullptr;
  scene.tolerance = bytes.number();
  dragcore_needs needs;
  check_status(dragcore_required_effects(other(27, &scene), other(28, &needs), text, sizeof text));

  // The same triangles as a cloth whose vertices move each by itself.
  const std::vector<float> position(vertices.begin(), vertices.end());
  std::vector<float> moving(position.size()), force(position.size());
  for (float& x : moving) x = static_cast<float>(bytes.number());
  const std::size_t stride = bytes.take<std::uint8_t>() % 32 == 0 ? 2 : 3;
  dragcore_deforming_motion deforming{.position = {position.data(), stride}, .velocity = {other(29, moving.data()), 3}};
  bytes.fill(deforming.wind);
  if (bytes.take<std::uint8_t>() % 4 == 0) deforming.vertex_wind = {position.data(), 3};
  dragcore_law local = model.law;
  if (bytes.take<std::uint8_t>() % 8) local.aspect_gain = local.recovery = local.shelter = local.curvature = 0.0;
  dragcore_deforming* cloth = nullptr;
  check_status(dragcore_deforming_create(triangles.data(), static_cast<std::size_t>(triangle_count), static_cast<std::size_t>(vertex_count),
                                         bytes.take<std::uint8_t>() % 4, other(30, &cloth)));
  status = dragcore_deforming_forces(cloth, other(31, &deforming), density, &local, force.data(), 3);
  check_status(status);
  for (const float f : force) check_finite(status, std::array{static_cast<double>(f)}.data(), 1, "force on a vertex");
  dragcore_deforming_destroy(cloth);

  dragcore_wind_destroy(wind);
  dragcore_surface_destroy(surface);
  return 0;
}
