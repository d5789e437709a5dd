#include <algorithm>
#include <cstring>
#include <dragcore/fluid_terms.hpp>
#include <iterator>

#include "c/handles.hpp"

namespace {

using namespace dragcore::c;

/// Every number of a law, either way between its two structs.
template <class From, class To>
void copy_numbers(const From& from, To& to) {
  std::copy(std::begin(from.windward), std::end(from.windward), std::begin(to.windward));
  std::copy(std::begin(from.leeward), std::end(from.leeward), std::begin(to.leeward));
  to.friction = from.friction;
  to.base_suction = from.base_suction, to.base_edge = from.base_edge;
  to.aspect_gain = from.aspect_gain, to.aspect_scale = from.aspect_scale;
  to.recovery = from.recovery, to.recovery_depth = from.recovery_depth, to.recovery_edge = from.recovery_edge;
  to.shelter = from.shelter;
  to.curvature = from.curvature;
  to.stokes = from.stokes;
  to.layer = from.layer, to.layer_curvature = from.layer_curvature;
}

dragcore_law law_from(const dragcore::Law& law) {
  dragcore_law numbers{};
  copy_numbers(law, numbers);
  return numbers;
}

dragcore::Pillow pillow_of(int form, double factor, int falloff, double viscous_gain) {
  if (form < DRAGCORE_PILLOW_NONE || form > DRAGCORE_PILLOW_ECCENTRICITY)
    throw std::invalid_argument("pillow = " + std::to_string(form) + ", but it must be one of enum dragcore_pillow, 0 to 4");
  if (falloff != DRAGCORE_FALLOFF_CIRCULAR && falloff != DRAGCORE_FALLOFF_LINEAR)
    throw std::invalid_argument("falloff = " + std::to_string(falloff) + ", but it must be one of enum dragcore_falloff, 0 or 1");
  return {static_cast<dragcore::PillowForm>(form), factor, static_cast<dragcore::Falloff>(falloff), viscous_gain};
}

dragcore::Wrench wrench_of(const dragcore_wrench& w) { return {vector(w.force), vector(w.torque)}; }

dragcore::Surface surface_of(const dragcore::TriangleMesh& mesh, int sides) {
  if (sides != DRAGCORE_SIDES_AUTOMATIC && sides != DRAGCORE_ONE_SIDED && sides != DRAGCORE_TWO_SIDED)
    throw std::invalid_argument("sides = " + std::to_string(sides) + ", but it must be one of enum dragcore_sides, 0 to 2");
  return dragcore::Surface(mesh, static_cast<dragcore::Surface::Sides>(sides));
}

using Step = dragcore::Vector6d (*)(const dragcore::Matrix6d&, const dragcore::MassProperties&, const dragcore::Motion&,
                                    const dragcore::Vector6d&, double);

dragcore_status step(Step step_function, const double* matrix, const dragcore_body* body, const dragcore_motion* motion,
                     const dragcore_wrench* external, double dt, double* velocity, double* angular_velocity) {
  return guarded([&] {
    require(matrix, "matrix");
    require(body, "body");
    require(motion, "motion");
    require(external, "external");
    require(velocity, "velocity");
    require(angular_velocity, "angular_velocity");
    dragcore::Vector6d wrench;
    wrench << vector(external->force), vector(external->torque);
    const dragcore::Vector6d moved = step_function(Eigen::Map<const RowMajor6d>(matrix), body_of(*body), motion_of(*motion), wrench, dt);
    copy(moved.head<3>(), velocity);
    copy(moved.tail<3>(), angular_velocity);
  });
}

}  // namespace

namespace dragcore::c {

thread_local char last_error[512];

void set_last_error(const char* message) noexcept {
  std::size_t length = std::min(std::strlen(message), sizeof last_error - 1);
  if (message[length] != '\0')  // cut: not within a character of UTF-8, whose further bytes are 10xxxxxx
    while (length > 0 && (static_cast<unsigned char>(message[length]) & 0xC0u) == 0x80u) --length;
  std::memcpy(last_error, message, length);
  last_error[length] = '\0';
}

Law law_of(const dragcore_law& given) {
  Law law{.name = "given"};
  copy_numbers(given, law);
  return law;
}

dragcore_model model_from(const dragcore::Model& model) {
  const dragcore::SheetModel sheets = model.sheets.value_or(dragcore::SheetModel{model.law, model.pillow});
  return {.law = law_from(model.law),
          .pillow = static_cast<int>(model.pillow.form),
          .pillow_factor = model.pillow.factor,
          .falloff = static_cast<int>(model.pillow.falloff),
          .quadrature = static_cast<int>(model.quadrature),
          .effects = model.effects.bits(),
          .precision = static_cast<int>(model.precision),
          .sheets = model.sheets.has_value(),
          .sheet_law = law_from(sheets.law),
          .sheet_pillow = static_cast<int>(sheets.pillow.form),
          .sheet_pillow_factor = sheets.pillow.factor,
          .sheet_falloff = static_cast<int>(sheets.pillow.falloff),
          .pillow_viscous_gain = model.pillow.viscous_gain,
          .sheet_pillow_viscous_gain = sheets.pillow.viscous_gain,
          .correction = nullptr};
}

Model model_of(const dragcore_model& m) {
  if (m.quadrature != 0 && m.quadrature != 1 && m.quadrature != 3 && m.quadrature != 6)
    throw std::invalid_argument("quadrature = " + std::to_string(m.quadrature) + ", but it must be 1, 3 or 6, or 0 for adaptive");
  if (m.precision != DRAGCORE_PRECISION_FULL && m.precision != DRAGCORE_PRECISION_SINGLE)
    throw std::invalid_argument("precision = " + std::to_string(m.precision) + ", but it must be one of enum dragcore_precision, 0 or 1");
  if (m.effects > DRAGCORE_ALL_EFFECTS)
    throw std::invalid_argument("effects = " + std::to_string(m.effects) + ", but it must be DRAGCORE_ALL_EFFECTS or some of its bits");
  dragcore::Model model{.law = law_of(m.law),
                        .pillow = pillow_of(m.pillow, m.pillow_factor, m.falloff, m.pillow_viscous_gain),
                        .quadrature = static_cast<dragcore::Quadrature>(m.quadrature),
                        .effects = {},
                        .precision = static_cast<dragcore::Precision>(m.precision)};
  if (m.sheets)
    model.sheets = dragcore::SheetModel{
        law_of(m.sheet_law), pillow_of(m.sheet_pillow, m.sheet_pillow_factor, m.sheet_falloff, m.sheet_pillow_viscous_gain)};
  for (unsigned bit = 1; bit < DRAGCORE_ALL_EFFECTS; bit <<= 1)
    if (m.effects & bit) model.effects = model.effects | static_cast<dragcore::Effect>(bit);
  if (m.correction) model.correction = m.correction->correction;
  return model;
}

}  // namespace dragcore::c

extern "C" {

static_assert(DRAGCORE_ALL_EFFECTS == dragcore::Effects::all().bits());

void dragcore_correction_destroy(dragcore_correction* correction) { delete correction; }

dragcore_model dragcore_note_model(void) { return model_from({}); }

dragcore_status dragcore_named_law(const char* name, dragcore_law* law) {
  return guarded([&] {
    require(name, "name");
    require(law, "law");
    *law = law_from(dragcore::named_law(name));
  });
}

dragcore_status dragcore_model_for(const dragcore_surface* surface, dragcore_model* model) {
  return guarded([&] {
    require(surface, "surface");
    require(model, "model");
    *model = model_from(dragcore::model_for(surface->surface));
  });
}

dragcore_status dragcore_surface_class(const dragcore_surface* surface, dragcore_body_class* body_class) {
  return guarded([&] {
    require(surface, "surface");
    require(body_class, "body_class");
    *body_class = static_cast<dragcore_body_class>(surface->surface.body_class);
  });
}

dragcore_status dragcore_surface_create(const double* vertices, size_t vertex_count, const int* triangles, size_t triangle_count, int sides,
                                        dragcore_surface** surface) {
  return made(surface, "surface",
              [&] { return new dragcore_surface{surface_of(mesh_of(vertices, vertex_count, triangles, triangle_count), sides)}; });
}

dragcore_status dragcore_surface_from_mesh(const dragcore_mesh* mesh, int sides, dragcore_surface** surface) {
  return made(surface, "surface", [&] {
    require(mesh, "mesh");
    return new dragcore_surface{surface_of(mesh->mesh, sides)};
  });
}

dragcore_status dragcore_surface_triangles(const dragcore_surface* surface, size_t* count) {
  return guarded([&] {
    require(surface, "surface");
    require(count, "count");
    *count = static_cast<size_t>(surface->surface.size());
  });
}

dragcore_status dragcore_surface_sides(const dragcore_surface* surface, dragcore_sides* sides) {
  return guarded([&] {
    require(surface, "surface");
    require(sides, "sides");
    *sides = static_cast<dragcore_sides>(surface->surface.sides);
  });
}

void dragcore_surface_destroy(dragcore_surface* surface) { delete surface; }

dragcore_status dragcore_evaluate(const dragcore_surface* surface, const dragcore_motion* motion, double density,
                                  const dragcore_model* model, dragcore_wrench* result) {
  return guarded([&] {
    require(surface, "surface");
    require(motion, "motion");
    require(model, "model");
    require(result, "result");
    const dragcore::Wrench total =
        dragcore::wrench(surface->surface, MotionOf(*motion, surface->surface).motion, medium_of(density, *motion), model_of(*model)).total();
    copy(total.force, result->force);
    copy(total.torque, result->torque);
  });
}

dragcore_status dragcore_resistance(const dragcore_surface* surface, const dragcore_motion* motion, double density,
                                    const dragcore_model* model, double matrix[36]) {
  return guarded([&] {
    require(surface, "surface");
    require(motion, "motion");
    require(model, "model");
    require(matrix, "matrix");
    const dragcore::Matrix6d s =
        dragcore::resistance(surface->surface, MotionOf(*motion, surface->surface).motion, medium_of(density, *motion), model_of(*model));
    std::copy(s.data(), s.data() + 36, matrix);  // symmetric: rows are columns
  });
}

dragcore_status dragcore_force_jacobian(const dragcore_surface* surface, const dragcore_motion* motion, double density,
                                        const dragcore_model* model, double matrix[36]) {
  return guarded([&] {
    require(surface, "surface");
    require(motion, "motion");
    require(model, "model");
    require(matrix, "matrix");
    Eigen::Map<RowMajor6d>{matrix} =
        dragcore::force_jacobian(surface->surface, MotionOf(*motion, surface->surface).motion, medium_of(density, *motion), model_of(*model));
  });
}

dragcore_status dragcore_step_secant_implicit(const double matrix[36], const dragcore_body* body, const dragcore_motion* motion,
                                              const dragcore_wrench* external, double dt, double velocity[3], double angular_velocity[3]) {
  return step(dragcore::step_secant_implicit, matrix, body, motion, external, dt, velocity, angular_velocity);
}

dragcore_status dragcore_step_scalar_implicit(const double matrix[36], const dragcore_body* body, const dragcore_motion* motion,
                                              const dragcore_wrench* external, double dt, double velocity[3], double angular_velocity[3]) {
  return step(dragcore::step_scalar_implicit, matrix, body, motion, external, dt, velocity, angular_velocity);
}

dragcore_status dragcore_ellipsoid_added_mass(const double semi_axes[3], double density, double matrix[36]) {
  return guarded([&] {
    require(semi_axes, "semi_axes");
    require(matrix, "matrix");
    Eigen::Map<RowMajor6d>{matrix} =
        dragcore::added_mass({.shape = {semi_axes[0], semi_axes[1], semi_axes[2]}}, Eigen::Vector3d::Zero(), {.density = density});
  });
}

dragcore_status dragcore_gyroscopic_spin(const dragcore_body* body, const double angular_velocity[3], double dt, double spin[3]) {
  return guarded([&] {
    require(body, "body");
    require(angular_velocity, "angular_velocity");
    require(spin, "spin");
    Eigen::Map<Eigen::Vector3d>{spin} = dragcore::gyroscopic_spin(body_of(*body), Eigen::Map<const Eigen::Vector3d>(angular_velocity), dt);
  });
}

dragcore_status dragcore_wind_excess(const dragcore_wrench* wrench, const double matrix[36], const dragcore_motion* motion,
                                     dragcore_wrench* excess) {
  return guarded([&] {
    require(wrench, "wrench");
    require(matrix, "matrix");
    require(motion, "motion");
    require(excess, "excess");
    const dragcore::Vector6d found = dragcore::wind_excess(wrench_of(*wrench), Eigen::Map<const RowMajor6d>(matrix), motion_of(*motion));
    copy(found.head<3>(), excess->force);
    copy(found.tail<3>(), excess->torque);
  });
}

dragcore_status dragcore_impulse_share(const dragcore_wrench* wrench, const dragcore_body* body, const dragcore_motion* motion, double dt,
                                       double* share) {
  return guarded([&] {
    require(wrench, "wrench");
    require(body, "body");
    require(motion, "motion");
    require(share, "share");
    *share = dragcore::impulse_share(wrench_of(*wrench), body_of(*body), motion_of(*motion), dt);
  });
}

const char* dragcore_last_error(void) { return last_error; }

}  // extern "C"
