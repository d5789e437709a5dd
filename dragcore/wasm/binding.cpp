// What dragcore.js calls. Numbers pass in arrays of double, in the order that is written here and there; words as zero-terminated UTF-8.
// The C interface has no forces by term or triangle and no validity, so this goes to the C++ one.

#include <emscripten/emscripten.h>

#include <Eigen/Geometry>
#include <cstddef>
#include <cstring>
#include <dragcore/bake.hpp>
#include <dragcore/descriptors.hpp>
#include <dragcore/drag.hpp>
#include <dragcore/mesh_file.hpp>
#include <dragcore/shapes.hpp>
#include <dragcore/validity.hpp>
#include <map>
#include <memory>
#include <numeric>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/mesh_readers.hpp"

namespace {

using Eigen::Vector3d;
using RowMajor3d = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

struct Body {
  dragcore::Surface surface;
  std::vector<std::string> notes;
  double reference_area = 0.0, reference_length = 0.0;  ///< of a shape; of any other mesh nobody said [m^2], [m]
};

std::string said;  // by the call before this one: why it failed, or the words that were asked for

/// Runs `body`; where it throws, `said` has the message and the result is `failed`.
template <class Result, class Code>
Result guarded(Result failed, Code&& body) {
  try {
    said.clear();
    return body();
  } catch (const std::exception& fault) {
    said = fault.what();
    return failed;
  }
}

std::string lines(const std::vector<std::string>& list) {
  return std::accumulate(list.begin(), list.end(), std::string(),
                         [](const std::string& all, const std::string& line) { return all + line + "\n"; });
}

/// Bodies of files: metres, equal corners joined, made sound.
Body* prepared(dragcore::TriangleMesh mesh, std::vector<std::string> notes, double unit_m) {
  if (!(unit_m > 0.0)) throw std::invalid_argument("unit = " + std::to_string(unit_m) + ", but it must be greater than 0");
  for (Vector3d& vertex : mesh.vertices) vertex *= unit_m;
  dragcore::validate(mesh);  // welded() believes its indices
  auto body = std::make_unique<Body>(Body{dragcore::Surface(dragcore::welded(mesh)), std::move(notes)});
  if (body->surface.size() == 0) throw std::invalid_argument("no triangle has an area, so nothing feels the air");
  for (const dragcore::Finding& finding : body->surface.report) body->notes.push_back(to_string(finding.kind) + ": " + finding.text);
  return body.release();
}

/// A body in moving air. As numbers: wind, velocity, angular velocity, reference point, gradient of the wind row by row, density,
/// viscosity.
struct Flow {
  dragcore::Motion motion;
  dragcore::Medium medium;

  explicit Flow(const double* numbers) {
    motion.wind = Eigen::Map<const Vector3d>(numbers);
    motion.velocity = Eigen::Map<const Vector3d>(numbers + 3);
    motion.angular_velocity = Eigen::Map<const Vector3d>(numbers + 6);
    motion.reference_point = Eigen::Map<const Vector3d>(numbers + 9);
    motion.wind_gradient = Eigen::Map<const RowMajor3d>(numbers + 12);
    medium = {.density = numbers[21], .viscosity = numbers[22]};
  }
};

/// As dragcore.js writes it into memory.
struct ModelChoice {
  const char* law;       ///< "class" or one of law_names()
  const char* pillow;    ///< "class" or a PillowForm
  double pillow_factor;  ///< of the latter
  unsigned effects;      ///< bits of Effect
  int quadrature;        ///< points per triangle: 1, 3 or 6, or 0 for adaptive
};
static_assert(offsetof(ModelChoice, pillow_factor) == 8 && offsetof(ModelChoice, effects) == 16 && sizeof(ModelChoice) == 24);

dragcore::Model model_of(const Body& body, const ModelChoice& choice) {
  const std::string law = choice.law, pillow = choice.pillow, by_class = "class";
  const dragcore::Model of_class = dragcore::model_for(body.surface);
  dragcore::Model model;
  if (law == by_class)
    model.law = of_class.law, model.sheets = of_class.sheets;
  else
    model.law = dragcore::named_law(law);
  model.pillow = pillow == by_class ? of_class.pillow : dragcore::Pillow{dragcore::pillow_form_from(pillow), choice.pillow_factor};
  if (model.sheets && pillow != by_class) model.sheets->pillow = model.pillow;
  model.effects = {};
  for (unsigned bit = 1; bit < 1u << dragcore::effect_count; bit <<= 1)
    if (choice.effects & bit) model.effects = model.effects | static_cast<dragcore::Effect>(bit);
  const int points = choice.quadrature;
  if (points != 0 && points != 1 && points != 3 && points != 6)
    throw std::invalid_argument("quadrature = " + std::to_string(points) + ", but it must be 1, 3 or 6, or 0 for adaptive");
  model.quadrature = static_cast<dragcore::Quadrature>(points);
  return model;
}

/// Force, then torque.
void write(const dragcore::Wrench& wrench, double* out) {
  Eigen::Map<Vector3d>{out} = wrench.force;
  Eigen::Map<Vector3d>{out + 3} = wrench.torque;
}

}  // namespace

extern "C" {

EMSCRIPTEN_KEEPALIVE const char* web_said() { return said.c_str(); }

/// The words that numbers stand for, a line each: names of laws, of terms and of effects, the lowest bit first; an empty line between.
EMSCRIPTEN_KEEPALIVE void web_words() {
  std::vector<std::string> list = dragcore::law_names();
  list.push_back("");
  for (unsigned i = 0; i < static_cast<unsigned>(dragcore::Term::count); ++i) list.push_back(to_string(static_cast<dragcore::Term>(i)));
  list.push_back("");
  for (unsigned i = 0; i < dragcore::effect_count; ++i) list.push_back(to_string(static_cast<dragcore::Effect>(1u << i)));
  said = lines(list);
}

/// @param names  of the parameters, a line each: make_shape() has them [m], [deg]
EMSCRIPTEN_KEEPALIVE Body* web_body_of_shape(const char* kind, const char* names, const double* values, int divisions) {
  return guarded<Body*>(nullptr, [&] {
    std::map<std::string, double> parameters;
    for (std::string_view rest = names; !rest.empty(); ++values) {
      const auto end = rest.find('\n');
      parameters[std::string(rest.substr(0, end))] = *values;
      rest.remove_prefix(end + 1);
    }
    const dragcore::Shape shape = dragcore::make_shape(kind, parameters);
    const dragcore::ShapeProperties properties = dragcore::properties(shape);
    return new Body{dragcore::Surface(dragcore::triangulate(shape, divisions)), {}, properties.reference_area, properties.reference_length};
  });
}

EMSCRIPTEN_KEEPALIVE Body* web_body_of_triangles(const double* vertices, int vertex_count, const int* triangles, int triangle_count) {
  return guarded<Body*>(nullptr, [&] {
    dragcore::TriangleMesh mesh;
    for (int i = 0; i < vertex_count; ++i) mesh.vertices.emplace_back(Eigen::Map<const Vector3d>(vertices + 3 * i));
    for (int i = 0; i < triangle_count; ++i) mesh.triangles.emplace_back(Eigen::Map<const Eigen::Vector3i>(triangles + 3 * i));
    return prepared(std::move(mesh), {}, 1.0);
  });
}

/// @param is_obj  1: OBJ, 0: STL, ascii or binary
EMSCRIPTEN_KEEPALIVE Body* web_body_of_file(const char* bytes, int size, int is_obj, double unit_m) {
  return guarded<Body*>(nullptr, [&] {
    const std::string_view content(bytes, static_cast<std::size_t>(size));
    if (content.empty()) throw std::runtime_error("the file is empty");
    dragcore::MeshFile file = is_obj ? dragcore::read_obj(content) : dragcore::read_stl(content);
    if (file.mesh.triangles.empty()) throw std::runtime_error("the file holds no triangle");
    return prepared(std::move(file.mesh), std::move(file.notes), unit_m);
  });
}

EMSCRIPTEN_KEEPALIVE void web_body_destroy(Body* body) { delete body; }

/// What the reader and the preparation found, a line each.
EMSCRIPTEN_KEEPALIVE void web_body_notes(const Body* body) { said = lines(body->notes); }

/// Its class.
EMSCRIPTEN_KEEPALIVE void web_body_class(const Body* body) { said = to_string(body->surface.body_class); }

/// Triangles; area of one side, volume, centre of the area x y z, radius, convex (0 or 1), reference area and length.
EMSCRIPTEN_KEEPALIVE void web_body_numbers(const Body* body, double* out) {
  const dragcore::Surface& surface = body->surface;
  const double numbers[] = {static_cast<double>(surface.size()),
                            surface.total_area,
                            surface.volume,
                            surface.centre.x(),
                            surface.centre.y(),
                            surface.centre.z(),
                            surface.radius,
                            surface.convex ? 1.0 : 0.0,
                            body->reference_area,
                            body->reference_length};
  std::memcpy(out, numbers, sizeof numbers);
}

/// Corners of every triangle of the surface, nine numbers each, in the order of web_forces_by_triangle().
EMSCRIPTEN_KEEPALIVE void web_body_corners(const Body* body, double* out) {
  const dragcore::Surface& surface = body->surface;
  for (Eigen::Index i = 0; i < surface.size(); ++i, out += 9) {
    const Vector3d ab = surface.edge_ab.row(i), ac = surface.edge_ac.row(i);
    const Vector3d a = Vector3d(surface.centroid.row(i)) - (ab + ac) / 3.0;
    Eigen::Map<Eigen::Matrix3d>(out) << a, a + ab, a + ac;
  }
}

/// Area that the wind meets: summed over the windward sides, so that what stands behind something counts too.
EMSCRIPTEN_KEEPALIVE double web_windward_area(const Body* body, const double* direction) {
  double area = 0.0;
  for (std::size_t part = 0; part < body->surface.parts.size(); ++part)
    area += dragcore::describe(body->surface, Eigen::Map<const Vector3d>(direction), part).frontal_area;
  return area;
}

/// Six numbers for each term. @return 1, or 0 after a fault
EMSCRIPTEN_KEEPALIVE int web_wrench_by_term(const Body* body, const double* flow, const ModelChoice* model, double* out) {
  return guarded(0, [&] {
    const Flow in(flow);
    const auto result = dragcore::wrench(body->surface, in.motion, in.medium, model_of(*body, *model));
    for (const dragcore::Wrench& term : result.terms) write(term, out), out += 6;
    return 1;
  });
}

/// Force of every triangle, three numbers each, then torque of every triangle. @return 1, or 0 after a fault
EMSCRIPTEN_KEEPALIVE int web_forces_by_triangle(const Body* body, const double* flow, const ModelChoice* model, double* out) {
  return guarded(0, [&] {
    const Flow in(flow);
    const auto forces = dragcore::triangle_forces(body->surface, in.motion, in.medium, model_of(*body, *model));
    Eigen::Map<Eigen::Matrix3Xd>(out, 3, forces.force.cols()) = forces.force;
    Eigen::Map<Eigen::Matrix3Xd>(out + forces.force.size(), 3, forces.force.cols()) = forces.torque;
    return 1;
  });
}

/// What makes the result doubtful: names of the doubts, a line each, an empty line, and a sentence for each. @return 1, or 0 after a fault
EMSCRIPTEN_KEEPALIVE int web_doubts(const Body* body, const double* flow, const ModelChoice* model) {
  return guarded(0, [&] {
    const Flow in(flow);
    const dragcore::Validity found = dragcore::validity(body->surface, in.motion, in.medium, model_of(*body, *model));
    std::vector<std::string> list;
    for (unsigned bit = 1; bit != 0; bit <<= 1)
      if (found.doubts & bit) list.push_back(to_string(static_cast<dragcore::Doubt>(bit)));
    list.push_back("");
    list.insert(list.end(), found.reasons.begin(), found.reasons.end());
    said = lines(list);
    return 1;
  });
}

EMSCRIPTEN_KEEPALIVE dragcore::BakedBody* web_bake(const Body* body, const ModelChoice* model, double rms_error, int most_bytes) {
  return guarded<dragcore::BakedBody*>(nullptr, [&] {
    const dragcore::BakeOptions options{.rms_error = rms_error, .most_bytes = static_cast<std::size_t>(most_bytes)};
    return new dragcore::BakedBody(dragcore::bake(body->surface, model_of(*body, *model), options));
  });
}

EMSCRIPTEN_KEEPALIVE void web_baked_destroy(dragcore::BakedBody* baked) { delete baked; }

/// Bytes of the maps; rms errors of force and torque without spin.
EMSCRIPTEN_KEEPALIVE void web_baked_numbers(const dragcore::BakedBody* baked, double* out) {
  out[0] = static_cast<double>(baked->bytes()), out[1] = baked->error.rms_force, out[2] = baked->error.rms_torque;
}

/// @return 1, or 0 after a fault
EMSCRIPTEN_KEEPALIVE int web_baked_wrench(const dragcore::BakedBody* baked, const double* flow, double* out) {
  return guarded(0, [&] {
    const Flow in(flow);
    write(dragcore::wrench(*baked, in.motion, in.medium), out);
    return 1;
  });
}

}  // extern "C"
