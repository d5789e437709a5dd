// cfd_mesh REQUEST.json OUTPUT.msh: the tetrahedral mesh of the air around one body, by the gmsh library, as an MSH 2.2 file.
// A program of its own, for gmsh keeps its state in globals and may end the process on a bad geometry. REQUEST.json is written by mesh.cpp.
// cfd_mesh --version prints the version of gmsh.

#include <gmsh.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <dragcore/pose.hpp>
#include <dragcore/shapes.hpp>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "cfd_cases/mesh/mesh_recipe.hpp"

namespace {

using Eigen::Vector3d;
using Entities = gmsh::vectorpair;
namespace occ = gmsh::model::occ;

/// The solid among what a surface sweeps.
int solid_of(const Entities& swept) {
  const auto solid = std::find_if(swept.begin(), swept.end(), [](const auto& entity) { return entity.first == 3; });
  if (solid == swept.end()) throw std::runtime_error("gmsh made no solid of the body's outline");
  return solid->second;
}

/// The exact shape as an OpenCASCADE solid, in the body frame.
struct Solid {
  double nose;

  int operator()(const dragcore::Plate& s) const {
    if (s.thickness <= 0.0)
      throw std::invalid_argument("a sheet cannot be meshed: thickness = 0, but it must be greater than 0; 0.05 chords meshes cleanly");
    return (*this)(dragcore::Box{s.chord, s.span, s.thickness});
  }
  int operator()(const dragcore::Box& s) const {
    return occ::addBox(-0.5 * s.length, -0.5 * s.width, -0.5 * s.height, s.length, s.width, s.height);
  }
  int operator()(const dragcore::Cone& s) const {
    const double r = 0.5 * s.diameter;
    return occ::addCone(nose, 0, 0, r / std::tan(0.5 * s.apex_angle), 0, 0, 0.0, r);
  }
  int operator()(const dragcore::Sphere& s) const { return occ::addSphere(0, 0, 0, 0.5 * s.diameter); }
  int operator()(const dragcore::Cylinder& s) const { return occ::addCylinder(nose, 0, 0, s.length, 0, 0, 0.5 * s.diameter); }
  int operator()(const dragcore::Ellipsoid& s) const {
    const int sphere = occ::addSphere(0, 0, 0, 1.0);
    occ::dilate({{3, sphere}}, 0, 0, 0, s.semi_x, s.semi_y, s.semi_z);
    return sphere;
  }
  /// The meridian (arc of the sphere, then its tangent to the tail) turned about the axis.
  int operator()(const dragcore::Teardrop& s) const {
    const double r = 0.5 * s.diameter, centre = nose + r, tail = s.length - r;
    const int front = occ::addPoint(nose, 0, 0), middle = occ::addPoint(centre, 0, 0), back = occ::addPoint(nose + s.length, 0, 0);
    const int joint = occ::addPoint(centre + r * r / tail, r * std::sqrt(1.0 - r * r / (tail * tail)), 0);
    const int meridian = occ::addCurveLoop({occ::addCircleArc(front, middle, joint), occ::addLine(joint, back), occ::addLine(back, front)});
    Entities turned;
    occ::revolve({{2, occ::addPlaneSurface({meridian})}}, 0, 0, 0, 1, 0, 0, 2.0 * std::numbers::pi, turned);
    return solid_of(turned);
  }
  int operator()(const dragcore::Prism& s) const {
    const double half = 0.5 * s.base, tail = nose + half / std::tan(0.5 * s.apex_angle), y = -0.5 * s.span;
    const int corners[] = {occ::addPoint(nose, y, 0), occ::addPoint(tail, y, half), occ::addPoint(tail, y, -half)};
    std::vector<int> sides;
    for (int i = 0; i < 3; ++i) sides.push_back(occ::addLine(corners[i], corners[(i + 1) % 3]));
    Entities drawn;
    occ::extrude({{2, occ::addPlaneSurface({occ::addCurveLoop(sides)})}}, 0, s.span, 0, drawn);
    return solid_of(drawn);
  }
  int operator()(const dragcore::MeshBody& s) const {
    throw std::invalid_argument("the body " + s.name + " is given by triangles: snappyHexMesh meshes it, not gmsh");
  }
};

void name_patches(const std::map<std::string, std::vector<int>>& patches, int air) {
  for (const auto& [name, tags] : patches) gmsh::model::setPhysicalName(2, gmsh::model::addPhysicalGroup(2, tags), name);
  gmsh::model::setPhysicalName(3, gmsh::model::addPhysicalGroup(3, {air}), "air");
}

/// The uniform grid of cubes of the far size from which an octree is refined: planes of the grid go through the body's centroid.
void make_base_grid(const nlohmann::json& request, const std::string& output) {
  const dragcore::Shape shape = cfd_cases::shape_from_json(request.at("shape"));
  const cfd_cases::MeshRecipe recipe = cfd_cases::recipe_from_json(request.at("recipe"));
  const auto symmetry = cfd_cases::symmetry_from(request.at("symmetry").get<std::string>());
  const cfd_cases::BaseGrid grid = cfd_cases::base_grid(shape, recipe, symmetry);
  const int halved = cfd_cases::halved_axis(symmetry);
  const double size = grid.size;
  const Vector3d corner = -size * grid.below.cast<double>(), extent = size * (grid.below + grid.above).cast<double>();
  occ::addBox(corner.x(), corner.y(), corner.z(), extent.x(), extent.y(), extent.z());
  occ::synchronize();
  Entities curves, faces, air;
  gmsh::model::getEntities(curves, 1);
  gmsh::model::getEntities(faces, 2);
  gmsh::model::getEntities(air, 3);
  Vector3d a, b;
  for (const auto& [dim, tag] : curves) {
    gmsh::model::getBoundingBox(dim, tag, a.x(), a.y(), a.z(), b.x(), b.y(), b.z());
    gmsh::model::mesh::setTransfiniteCurve(tag, static_cast<int>(std::lround((b - a).maxCoeff() / size)) + 1);
  }
  std::map<std::string, std::vector<int>> patches;
  for (const auto& [dim, tag] : faces) {
    gmsh::model::mesh::setTransfiniteSurface(tag);
    gmsh::model::mesh::setRecombine(dim, tag);
    gmsh::model::getBoundingBox(dim, tag, a.x(), a.y(), a.z(), b.x(), b.y(), b.z());
    const bool in_symmetry = halved >= 0 && std::abs(a[halved]) < 1e-3 * size && std::abs(b[halved]) < 1e-3 * size;
    patches[in_symmetry ? "symmetry" : "farfield"].push_back(tag);
  }
  gmsh::model::mesh::setTransfiniteVolume(air.at(0).second);
  name_patches(patches, air.at(0).second);
  gmsh::option::setNumber("Mesh.MshFileVersion", 2.2);
  gmsh::model::mesh::generate(3);
  gmsh::write(output);
}

void make_mesh(const nlohmann::json& request, const std::string& output) {
  const dragcore::Shape shape = cfd_cases::shape_from_json(request.at("shape"));
  const cfd_cases::MeshRecipe recipe = cfd_cases::recipe_from_json(request.at("recipe"));
  const auto angle = [&](const char* name) { return request.at("pose").at(name).get<double>() * std::numbers::pi / 180.0; };
  const dragcore::Pose pose{angle("incidence_deg"), angle("yaw_deg"), angle("roll_deg")};
  const auto symmetry = cfd_cases::symmetry_from(request.at("symmetry").get<std::string>());
  const double scale = cfd_cases::body_scale(shape);
  const auto properties = dragcore::properties(shape);

  // The body in its pose: rotations one by one are rigid for OpenCASCADE and keep planes and cylinders exact.
  const int body = std::visit(Solid{properties.nose_x}, shape);
  occ::rotate({{3, body}}, 0, 0, 0, 1, 0, 0, pose.roll);
  occ::rotate({{3, body}}, 0, 0, 0, 0, 1, 0, pose.incidence);
  occ::rotate({{3, body}}, 0, 0, 0, 0, 0, 1, pose.yaw);
  occ::synchronize();
  Vector3d lower, upper;
  gmsh::model::getBoundingBox(3, body, lower.x(), lower.y(), lower.z(), upper.x(), upper.y(), upper.z());

  const Eigen::AlignedBox3d bounds(lower, upper);
  const Eigen::AlignedBox3d around = cfd_cases::air_around(bounds, scale, recipe, symmetry);
  const Vector3d inlet = around.min(), outlet = around.max();
  const int halved = cfd_cases::halved_axis(symmetry);
  const Vector3d extent = outlet - inlet;
  const double radius = scale * recipe.far_radius;
  Entities air;
  std::vector<Entities> origins;
  int whole = 0;
  if (radius == 0.0) {
    whole = occ::addBox(inlet.x(), inlet.y(), inlet.z(), extent.x(), extent.y(), extent.z());
  } else {
    Vector3d corner = Vector3d::Constant(-2.0 * radius);
    if (halved >= 0) corner[halved] = 0.0;
    Entities half;
    const Vector3d edges = Vector3d::Constant(2.0 * radius) - corner;
    const int ball = occ::addSphere(0, 0, 0, radius),
              block = occ::addBox(corner.x(), corner.y(), corner.z(), edges.x(), edges.y(), edges.z());
    occ::intersect({{3, ball}}, {{3, block}}, half, origins);
    whole = half.at(0).second;
  }
  occ::cut({{3, whole}}, {{3, body}}, air, origins);
  occ::synchronize();
  if (air.size() != 1 || air[0].first != 3)
    throw std::runtime_error("cutting the body out of the air left " + std::to_string(air.size()) + " regions, needed 1");

  // Patches by place: a face that is flat in a side of the box belongs to it, the others are the body.
  std::map<std::string, std::vector<int>> patches;
  Entities faces;
  gmsh::model::getBoundary(air, faces, false, false);
  const double eps = 1e-4 * scale;
  for (const auto& [dim, tag] : faces) {
    Vector3d a, b;
    gmsh::model::getBoundingBox(dim, tag, a.x(), a.y(), a.z(), b.x(), b.y(), b.z());
    std::string patch = "body";
    if (radius > 0.0) {
      if (halved >= 0 && std::abs(a[halved]) < eps && std::abs(b[halved]) < eps)
        patch = "symmetry";
      else if (std::max(a.cwiseAbs().maxCoeff(), b.cwiseAbs().maxCoeff()) > 0.5 * radius)
        patch = "farfield";
      patches[patch].push_back(tag);
      continue;
    }
    for (int axis = 0; axis < 3; ++axis) {
      if (std::abs(a[axis] - inlet[axis]) < eps && std::abs(b[axis] - inlet[axis]) < eps)
        patch = axis == 0 ? "inlet" : axis == halved ? "symmetry" : "sides";
      if (std::abs(a[axis] - outlet[axis]) < eps && std::abs(b[axis] - outlet[axis]) < eps) patch = axis == 0 ? "outlet" : "sides";
    }
    patches[patch].push_back(tag);
  }
  name_patches(patches, air[0].second);

  const cfd_cases::SizeField size(shape, pose, recipe, bounds, symmetry);
  gmsh::model::mesh::setSizeCallback([&](int, int, double x, double y, double z) { return size(Vector3d(x, y, z)); });
  for (const char* source :
       {"Mesh.CharacteristicLengthExtendFromBoundary", "Mesh.CharacteristicLengthFromPoints", "Mesh.CharacteristicLengthFromCurvature"})
    gmsh::option::setNumber(source, 0);
  gmsh::option::setNumber("Mesh.MshFileVersion", 2.2);
  if (recipe.seed != 0.0) {
    // The generator shakes its points by 1e-9 to avoid degenerate ones; a thousand times as much makes another triangulation of the same
    // sizes, and more breaks it.
    gmsh::option::setNumber("Mesh.RandomSeed", recipe.seed);
    gmsh::option::setNumber("Mesh.RandomFactor", 1e-6);
    gmsh::option::setNumber("Mesh.RandomFactor3D", 1e-9);
  }
  gmsh::model::mesh::generate(3);
  gmsh::write(output);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 2 && std::string(argv[1]) == "--version") {
    gmsh::initialize(0, nullptr, false);
    std::string version;
    gmsh::option::getString("General.Version", version);
    std::printf("%s\n", version.c_str());
    gmsh::finalize();
    return 0;
  }
  if (argc != 3) {
    std::fprintf(stderr, "usage: cfd_mesh REQUEST.json OUTPUT.msh | --version\n");
    return 2;
  }
  try {
    std::ifstream file(argv[1]);
    if (!file) throw std::runtime_error(std::string("cannot read ") + argv[1]);
    const auto request = nlohmann::json::parse(file);
    gmsh::initialize(0, nullptr, false);  // no option files of the user: they would change the mesh
    gmsh::option::setNumber("General.Verbosity", 3);
    const bool octree = cfd_cases::recipe_from_json(request.at("recipe")).hexahedra != 0.0;
    (octree ? make_base_grid : make_mesh)(request, argv[2]);
    gmsh::finalize();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "cfd_mesh: %s\n", error.what());
    return 1;
  }
  return 0;
}
