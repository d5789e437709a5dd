#pragma once

// What the benchmarks evaluate, and the loop that textbooks have. Compiles against the library of commit 3f4dda5, too: recorded_build.cpp.

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <dragcore/drag.hpp>
#include <dragcore/shapes.hpp>
#include <dragcore/stepping.hpp>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace dragcore::bench {

struct Body {
  TriangleMesh mesh;
  Surface surface;
};

/// A body of the benchmarks by its name, made when it is first asked for. Not for two threads at once.
/// @param name  "cube-12", "sheet-3200", or "ball-N" with N = 8 n^2 triangles
inline const Body& body(const std::string& name) {
  static std::map<std::string, Body> made;
  const auto found = made.find(name);
  if (found != made.end()) return found->second;
  const double triangles = std::stod(name.substr(name.find('-') + 1));
  const auto mesh_of = [triangles](const Shape& shape, double per_square) {
    return triangulate(shape, static_cast<int>(std::lround(std::sqrt(triangles / per_square))));
  };
  const TriangleMesh mesh = name.starts_with("cube")    ? mesh_of(Box{}, 12)
                            : name.starts_with("sheet") ? mesh_of(Plate{.chord = 1.0, .span = 1.0, .thickness = 0.0}, 2)
                                                        : mesh_of(Sphere{}, 8);
  return made.emplace(name, Body{mesh, Surface(mesh)}).first->second;
}

/// "straight", or "spinning" by a third of a radian per metre of travel: three points a triangle.
inline Motion motion(const std::string& name) {
  Motion result{.velocity = {-10, -1, -2}};
  if (name == "spinning") result.angular_velocity = {3, 2, 1};
  return result;
}

/// "note"; "class": the law by class; "class+pillow": model_for().
inline Model model(const std::string& name, const Surface& surface) {
  if (name == "note") return {};
  Model result = model_for(surface);
  if (name == "class") result.pillow = {};
  return result;
}

struct IndexedMesh {
  explicit IndexedMesh(const TriangleMesh& mesh) : triangles(mesh.triangles) {
    for (const Eigen::Vector3d& vertex : mesh.vertices) vertices.push_back(vertex.cast<float>());
  }
  std::vector<Eigen::Vector3f> vertices;
  std::vector<Eigen::Vector3i> triangles;
};

/// Force and torque of the note's law, as one writes it down first: single precision, vertices by index, one point a triangle, no checks.
inline Wrench textbook(const IndexedMesh& mesh, const Motion& motion, const Medium& medium) {
  using Eigen::Vector3f;
  const Vector3f velocity = motion.velocity.cast<float>(), spin = motion.angular_velocity.cast<float>();
  const float density = static_cast<float>(medium.density);
  Vector3f force = Vector3f::Zero(), torque = Vector3f::Zero();
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const Vector3f &a = mesh.vertices[static_cast<std::size_t>(t[0])], &b = mesh.vertices[static_cast<std::size_t>(t[1])],
                   &c = mesh.vertices[static_cast<std::size_t>(t[2])];
    const Vector3f cross = (b - a).cross(c - a), place = (a + b + c) / 3.0f, u = -velocity - spin.cross(place);
    const float twice_area = cross.norm(), speed = u.norm(), w = -u.dot(cross) / twice_area;
    if (!(w > 0.0f)) continue;
    const float cosine = w / speed;
    const Vector3f push = -0.25f * density * speed * speed * cosine * cosine * (2.0f - cosine) * cross;
    force += push;
    torque += place.cross(push);
  }
  return {force.cast<double>(), torque.cast<double>()};
}

/// A free box of cork as in the README's loop, 12 triangles.
struct FreeBox {
  FreeBox() : surface(triangulate(Box{0.3, 0.2, 0.1}, 1)), model(model_for(surface)) {
    mass.mass = 120.0 * 0.3 * 0.2 * 0.1;
    mass.inertia = mass.mass / 12.0 * Eigen::Vector3d(0.05, 0.10, 0.13).asDiagonal();
  }
  Surface surface;
  Model model;
  MassProperties mass{};
};

/// One step of the README's loop.
struct FreeFlight {
  Eigen::Vector3d position{0, 0, 50}, velocity{0, 0, 0}, spin{0, 0, 1};
  Eigen::Quaterniond turn{Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY())};  ///< body to world

  void step(const FreeBox& box) {
    const double dt = 1.0 / 60;
    const Eigen::Matrix3d to_world = turn.toRotationMatrix(), to_body = to_world.transpose();
    Motion here{.wind = to_body * Eigen::Vector3d(12, 0, 3), .velocity = to_body * velocity};
    here.angular_velocity = gyroscopic_spin(box.mass, to_body * spin, dt);
    const Matrix6d S = resistance(box.surface, here, {.density = 1.2}, box.model);
    Vector6d external;
    external << to_body * Eigen::Vector3d(0, 0, -9.81 * box.mass.mass), Eigen::Vector3d::Zero();
    const Vector6d V = step_secant_implicit(S, box.mass, here, external, dt);
    velocity = to_world * V.head<3>(), spin = to_world * V.tail<3>(), position += dt * velocity;
    turn = (Eigen::AngleAxisd(dt * spin.norm(), spin.stableNormalized()) * turn).normalized();
  }
};

/// FNV-1a of the bits of results, as sixteen hexadecimal digits.
class Hash {
 public:
  template <class Derived>
  Hash& add(const Eigen::DenseBase<Derived>& values) {
    for (Eigen::Index column = 0; column < values.cols(); ++column)
      for (Eigen::Index row = 0; row < values.rows(); ++row) {
        const double value = values(row, column);
        unsigned char bytes[sizeof value];
        std::memcpy(bytes, &value, sizeof value);
        for (const unsigned char byte : bytes) value_ = (value_ ^ byte) * 1099511628211ull;
      }
    return *this;
  }
  Hash& add(const Wrench& wrench) { return add(wrench.force).add(wrench.torque); }
  std::string text() const {
    std::string digits;
    for (int shift = 60; shift >= 0; shift -= 4) digits += "0123456789abcdef"[value_ >> shift & 15];
    return digits;
  }

 private:
  std::uint64_t value_ = 14695981039346656037ull;
};

/// Largest error of a wrench: of force by density/2 speed^2 times the area of both sides, of torque by that times the radius.
inline double error(const Wrench& found, const Wrench& exact, const Surface& surface, const Motion& motion, const Medium& medium) {
  const double speed = (motion.wind - motion.velocity).norm() + motion.angular_velocity.norm() * surface.radius;
  const double scale = medium.density * speed * speed * surface.total_area;
  return std::max((found.force - exact.force).norm(), (found.torque - exact.torque).norm() / surface.radius) / scale;
}

}  // namespace dragcore::bench
