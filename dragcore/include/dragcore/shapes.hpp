#pragma once

#include <cstdint>
#include <dragcore/mesh.hpp>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <variant>

namespace dragcore {

// Shapes as parameters, metres and radians. Frame: docs/conventions.md. The origin is the centroid of the volume; bodies of revolution have
// their axis along x with the nose at -x.

struct Plate {              ///< rectangular plate; thickness 0 makes an open, two-sided sheet
  double chord = 1.0;       ///< along x
  double span = 1.0;        ///< along y
  double thickness = 0.05;  ///< along z
};
struct Box {
  double length = 1.0;  ///< along x
  double width = 1.0;   ///< along y
  double height = 1.0;  ///< along z
};
struct Cone {                              ///< right circular cone with its base
  double diameter = 1.0;                   ///< of the base
  double apex_angle = 1.0471975511965976;  ///< full angle at the point [rad]; the default is 60 degrees
};
struct Sphere {
  double diameter = 1.0;
};
struct Cylinder {  ///< with both ends
  double diameter = 1.0;
  double length = 1.0;
};
struct Ellipsoid {  ///< semi-axes along x, y, z
  double semi_x = 0.5;
  double semi_y = 0.5;
  double semi_z = 0.5;
};
struct Teardrop {  ///< a sphere whose rear runs out, tangentially, into a cone; length must exceed diameter
  double diameter = 1.0;
  double length = 3.0;  ///< nose to tail
};

struct Prism {                             ///< an isosceles triangle in the x-z plane, its point at -x, drawn out along y
  double base = 1.0;                       ///< the side opposite to the point, along z
  double span = 1.0;                       ///< along y
  double apex_angle = 1.0471975511965976;  ///< full angle at the point [rad]; the default, 60 degrees, makes it equilateral
};

/// Closed-form properties of the exact shape (not of its triangles, unless it is given by them).
struct ShapeProperties {
  double area = 0.0;                                      ///< wetted [m^2]; a sheet counts one side
  double volume = 0.0;                                    ///< [m^3]
  double reference_area = 0.0;                            ///< A_ref of the coefficients [m^2], docs/conventions.md
  double reference_length = 0.0;                          ///< L_ref of the moment coefficients and of Re [m]
  double nose_x = 0.0;                                    ///< x of the foremost point; the centroid is the origin [m]
  double length_x = 0.0;                                  ///< extent along x [m]
  Eigen::Vector3d half_extent = Eigen::Vector3d::Zero();  ///< half the size of the bounding box [m] (not centred on the origin in x)
};

/// A body given by its triangles instead of parameters; mesh_body() makes it.
struct MeshBody {
  std::string name;                          ///< stands for the kind in tables and files
  std::shared_ptr<const TriangleMesh> mesh;  ///< never null, shared by copies; the origin is the centroid
  ShapeProperties measured;                  ///< of the triangles; volume 0: an open shell without thickness, two-sided
  std::uint64_t checksum = 0;                ///< surface_checksum(*mesh)
};

/// Joins equal vertices, moves the origin to the centroid and measures.
/// @param name  lower-case letters, digits, '_', '-', '.'; not the kind of another shape
/// @throws std::invalid_argument  a bad name; a reference area or length that is not above 0; a mesh that is not valid, of edges of three
/// triangles, not wound consistently, inside out, or neither closed nor a shell: with a hole of at most a twentieth of its area
MeshBody mesh_body(const std::string& name, const TriangleMesh& mesh, double reference_area, double reference_length);

using Shape = std::variant<Plate, Box, Cone, Sphere, Cylinder, Ellipsoid, Teardrop, Prism, MeshBody>;

/// @throws std::invalid_argument when a parameter is not finite or out of range: the message gives the parameter, its value and the range.
ShapeProperties properties(const Shape& shape);

/// Triangles with all vertices on the exact surface, wound outwards.
/// @param divisions  edge segments of a plate or box side; segments of a quarter turn of a round body. At least 1.
///                   Triangles: box 12 n^2; plate 4 n^2 + 8 n (sheet 2 n^2); prism 8 n^2; sphere and ellipsoid 8 n^2; round bodies of order
///                   16 n^2.
/// Area and volume of round bodies converge to properties() with second order. A body given by triangles keeps them, whatever `divisions`.
TriangleMesh triangulate(const Shape& shape, int divisions);

/// True when the shape equals its mirror image in the plane through its centroid with this normal (body frame, any length > 0). Of a body
/// given by triangles they must be mirror images of each other, to 1e-6 of its size.
bool mirror_symmetric(const Shape& shape, const Eigen::Vector3d& normal_body);

/// "plate", "box", "cone", ... and back, for files: lengths in metres, angles as `apex_angle_deg`. Parameters left out keep their default.
/// A box of equal sides goes by the name "cube" and the one parameter `side`. The kind of a MeshBody is its name; its parameters are
/// measured and do not make it again.
/// @throws std::invalid_argument naming an unknown kind or parameter and listing the known ones.
std::string kind(const Shape& shape);
std::map<std::string, double> parameters(const Shape& shape);
Shape make_shape(std::string_view kind, const std::map<std::string, double>& parameters);

/// Those parameters that are not at the default of their kind: what a name or a label must say. None of a MeshBody.
std::map<std::string, double> changed_parameters(const Shape& shape);

}  // namespace dragcore
