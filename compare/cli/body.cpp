#include "compare/cli/body.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <Eigen/Geometry>
#include <charconv>
#include <cmath>
#include <dragcore/expose.hpp>
#include <dragcore/mesh_file.hpp>
#include <dragcore/validity.hpp>
#include <map>

#include "compare/cli/commands.hpp"

namespace cli {
namespace {

Eigen::Vector3d extents_of(const dragcore::TriangleMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& vertex : mesh.vertices) box.extend(vertex);
  return box.isEmpty() ? Eigen::Vector3d::Zero() : Eigen::Vector3d(box.sizes());
}

}  // namespace

Eigen::Vector3d Body::extents() const { return extents_of(mesh); }

std::string text(double value, double scale) { return std::abs(value) <= 1e-12 * scale ? "0" : fmt::format("{:.4g}", value); }

double BodyOptions::unit_m() const {
  static const std::map<std::string, double> units = {{"mm", 1e-3}, {"cm", 1e-2}, {"m", 1.0}, {"in", 0.0254}, {"ft", 0.3048}};
  if (unit.empty()) return 1.0;
  if (const auto found = units.find(unit); found != units.end()) return found->second;
  double factor = 0.0;
  const auto [end, error] = std::from_chars(unit.data(), unit.data() + unit.size(), factor);
  if (error != std::errc{} || end != unit.data() + unit.size() || !(factor > 0.0) || !std::isfinite(factor))
    throw UsageError(fmt::format("--unit {} is not known; give mm, cm, m, in, ft or the size of the unit in metres, such as 0.001", unit));
  return factor;
}

void add_body_options(CLI::App& command, BodyOptions& options) {
  command.add_option("file", options.file, "STL (ascii or binary) or OBJ")->required();
  command.add_option("--unit", options.unit, "Unit of the file: mm, cm, m, in, ft, or its size in metres (default: m)");
  command.add_flag("--sheet", options.sheet, "Both sides of every triangle feel the air, as they do anyway where the mesh is open");
}

Body load_body(const BodyOptions& options) {
  dragcore::MeshFile file = dragcore::read_mesh_file(options.file, options.unit_m());
  const dragcore::TriangleMesh& mesh = file.mesh;
  const dragcore::MeshProperties as_read = dragcore::inspect(mesh);
  try {
    if (as_read.degenerate == as_read.triangles)
      throw std::invalid_argument("no triangle has an area, so nothing feels the air; check the file and its unit");
    if (options.sheet) {
      dragcore::Surface surface(mesh, dragcore::Surface::Sides::two);
      return {.mesh = mesh,
              .surface = std::move(surface),
              .properties = as_read,
              .triangles_of_file = as_read.triangles,
              .notes = std::move(file.notes)};
    }
    const dragcore::Preparation as_closed = dragcore::prepare(mesh);
    const dragcore::Preparation prepared = dragcore::expose(as_closed);
    Body body{.mesh = prepared.mesh,
              .surface = dragcore::Surface(prepared),
              .properties = inspect(as_closed.mesh),
              .triangles_of_file = as_read.triangles,
              .notes = std::move(file.notes)};
    for (const dragcore::Finding& finding : prepared.report) body.findings.push_back(to_string(finding.kind) + ": " + finding.text);
    for (const dragcore::WindwardRatio& view : dragcore::windward_over_silhouette(as_closed)) {
      if (view.silhouette > 0.0) body.windward_ratio = std::max(body.windward_ratio, view.summed / view.silhouette);
      for (int axis = 0; axis < 3; ++axis)
        if (view.direction[axis] > 0.5) body.silhouette[static_cast<std::size_t>(axis)] = view.silhouette;
    }
    return body;
  } catch (const std::invalid_argument& fault) {
    const Eigen::Vector3d size = extents_of(mesh);
    throw EnvironmentError(fmt::format("{}: {}\nThe file holds {}; its extents are {:.4g} x {:.4g} x {:.4g} m.", options.file, fault.what(),
                                       describe(as_read), size.x(), size.y(), size.z()));
  }
}

std::string unit_question(const BodyOptions& options, const Body& body) {
  // Most files are made for printers and drawing boards, in millimetres; few bodies are longer than 20 m.
  constexpr double least = 20.0, most = 1e5;
  const double largest = body.extents().maxCoeff();
  if (!options.unit.empty() || largest < least || largest > most) return "";
  return fmt::format("The largest extent is {:.4g} m. Is the file in millimetres? If so, add --unit mm; if not, --unit m.", largest);
}

std::vector<std::string> validity(const Body& body, const dragcore::Motion& motion, const dragcore::Medium& medium,
                                  const dragcore::Model& model) {
  return dragcore::validity(body.surface, motion, medium, model).reasons;
}

}  // namespace cli
