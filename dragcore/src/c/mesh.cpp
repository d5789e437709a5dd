#include <algorithm>
#include <dragcore/mass_properties.hpp>
#include <dragcore/shapes.hpp>

#include "c/handles.hpp"

using namespace dragcore::c;

namespace dragcore::c {

TriangleMesh mesh_of(const double* vertices, size_t vertex_count, const int* triangles, size_t triangle_count) {
  if (vertex_count > 0) require(vertices, "vertices");
  if (triangle_count > 0) require(triangles, "triangles");
  TriangleMesh mesh;
  mesh.vertices.reserve(vertex_count);
  mesh.triangles.reserve(triangle_count);
  for (size_t i = 0; i < vertex_count; ++i) mesh.vertices.push_back(vector(vertices + 3 * i));
  for (size_t i = 0; i < triangle_count; ++i) mesh.triangles.emplace_back(triangles[3 * i], triangles[3 * i + 1], triangles[3 * i + 2]);
  return mesh;
}

}  // namespace dragcore::c

namespace {

dragcore_status shape(const dragcore::Shape& parameters, int divisions, dragcore_mesh** mesh) {
  return made(mesh, "mesh", [&] { return new dragcore_mesh{triangulate(parameters, divisions)}; });
}

using MassFunction = dragcore::MeshMass (*)(const dragcore::TriangleMesh&, double);

dragcore_status mass(MassFunction function, const dragcore_mesh* mesh, double density, dragcore_body* body, double centre_of_mass[3]) {
  return guarded([&] {
    require(mesh, "mesh");
    require(body, "body");
    const dragcore::MeshMass found = function(mesh->mesh, density);
    *body = body_from(found);
    if (centre_of_mass) copy(found.centre_of_mass, centre_of_mass);
  });
}

}  // namespace

extern "C" {

dragcore_status dragcore_mesh_create(const double* vertices, size_t vertex_count, const int* triangles, size_t triangle_count,
                                     dragcore_mesh** mesh) {
  return made(mesh, "mesh", [&] {
    dragcore::TriangleMesh given = mesh_of(vertices, vertex_count, triangles, triangle_count);
    validate(given);
    return new dragcore_mesh{std::move(given)};
  });
}

void dragcore_mesh_destroy(dragcore_mesh* mesh) { delete mesh; }

dragcore_status dragcore_mesh_plate(double chord, double span, double thickness, int divisions, dragcore_mesh** mesh) {
  return shape(dragcore::Plate{chord, span, thickness}, divisions, mesh);
}
dragcore_status dragcore_mesh_box(double length, double width, double height, int divisions, dragcore_mesh** mesh) {
  return shape(dragcore::Box{length, width, height}, divisions, mesh);
}
dragcore_status dragcore_mesh_cone(double diameter, double apex_angle, int divisions, dragcore_mesh** mesh) {
  return shape(dragcore::Cone{diameter, apex_angle}, divisions, mesh);
}
dragcore_status dragcore_mesh_sphere(double diameter, int divisions, dragcore_mesh** mesh) {
  return shape(dragcore::Sphere{diameter}, divisions, mesh);
}
dragcore_status dragcore_mesh_cylinder(double diameter, double length, int divisions, dragcore_mesh** mesh) {
  return shape(dragcore::Cylinder{diameter, length}, divisions, mesh);
}
dragcore_status dragcore_mesh_ellipsoid(double semi_x, double semi_y, double semi_z, int divisions, dragcore_mesh** mesh) {
  return shape(dragcore::Ellipsoid{semi_x, semi_y, semi_z}, divisions, mesh);
}
dragcore_status dragcore_mesh_teardrop(double diameter, double length, int divisions, dragcore_mesh** mesh) {
  return shape(dragcore::Teardrop{diameter, length}, divisions, mesh);
}
dragcore_status dragcore_mesh_prism(double base, double span, double apex_angle, int divisions, dragcore_mesh** mesh) {
  return shape(dragcore::Prism{base, span, apex_angle}, divisions, mesh);
}

dragcore_status dragcore_mesh_size(const dragcore_mesh* mesh, size_t* vertex_count, size_t* triangle_count) {
  return guarded([&] {
    require(mesh, "mesh");
    if (vertex_count) *vertex_count = mesh->mesh.vertices.size();
    if (triangle_count) *triangle_count = mesh->mesh.triangles.size();
  });
}

dragcore_status dragcore_mesh_copy(const dragcore_mesh* mesh, double* vertices, int* triangles) {
  return guarded([&] {
    require(mesh, "mesh");
    for (const Eigen::Vector3d& v : mesh->mesh.vertices)
      if (vertices) vertices = std::copy(v.begin(), v.end(), vertices);
    for (const Eigen::Vector3i& t : mesh->mesh.triangles)
      if (triangles) triangles = std::copy(t.begin(), t.end(), triangles);
  });
}

dragcore_status dragcore_mesh_recentre(dragcore_mesh* mesh, const double origin[3]) {
  return guarded([&] {
    require(mesh, "mesh");
    mesh->mesh = origin ? dragcore::recentred(mesh->mesh, vector(origin)) : dragcore::recentred(mesh->mesh);
  });
}

dragcore_status dragcore_mass_properties(const dragcore_mesh* mesh, double density, dragcore_body* body, double centre_of_mass[3]) {
  return mass(dragcore::mass_properties, mesh, density, body, centre_of_mass);
}

dragcore_status dragcore_sheet_mass_properties(const dragcore_mesh* mesh, double area_density, dragcore_body* body,
                                               double centre_of_mass[3]) {
  return mass(dragcore::sheet_mass_properties, mesh, area_density, body, centre_of_mass);
}

}  // extern "C"
