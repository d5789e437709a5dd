#pragma once

#include <dragcore/drag.hpp>
#include <dragcore/pose.hpp>
#include <dragcore/shapes.hpp>
#include <numbers>
#include <random>
#include <vector>

/// Bodies and motions that many tests run through.
namespace zoo {

inline std::vector<dragcore::Shape> shapes() {
  return {dragcore::Plate{.chord = 1.3, .span = 0.7, .thickness = 0.05},
          dragcore::Plate{.chord = 1.0, .span = 1.0, .thickness = 0.0},
          dragcore::Box{.length = 1.0, .width = 1.0, .height = 1.0},
          dragcore::Box{.length = 2.0, .width = 1.0, .height = 0.6},
          dragcore::Cone{.diameter = 1.0, .apex_angle = std::numbers::pi / 3},
          dragcore::Cone{.diameter = 1.0, .apex_angle = std::numbers::pi / 6},
          dragcore::Sphere{.diameter = 1.0},
          dragcore::Cylinder{.diameter = 0.8, .length = 1.5},
          dragcore::Ellipsoid{.semi_x = 0.8, .semi_y = 0.5, .semi_z = 0.3},
          dragcore::Teardrop{.diameter = 1.0, .length = 3.0},
          dragcore::Prism{.base = 1.0, .span = 0.8, .apex_angle = 0.7}};
}

inline dragcore::Surface::Sides sides_of(const dragcore::Shape& shape) {
  const auto* plate = std::get_if<dragcore::Plate>(&shape);
  return plate && plate->thickness == 0.0 ? dragcore::Surface::Sides::two : dragcore::Surface::Sides::one;
}

inline dragcore::Surface surface(const dragcore::Shape& shape, int divisions) {
  return dragcore::Surface(triangulate(shape, divisions), sides_of(shape));
}

/// Seeded, so that a failure can be repeated.
class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine_); }
  Eigen::Vector3d vector(double size) { return {uniform(-size, size), uniform(-size, size), uniform(-size, size)}; }
  Eigen::Matrix3d rotation() {
    const dragcore::Pose pose{uniform(-1.5, 1.5), uniform(-3.1, 3.1), uniform(-3.1, 3.1)};
    return pose.rotation();
  }
  dragcore::Motion motion(double speed, double spin) {
    return {.wind = vector(speed), .velocity = vector(speed), .angular_velocity = vector(spin), .reference_point = vector(0.3)};
  }

 private:
  std::mt19937 engine_;
};

/// The same model in double precision: for tests of what the model says, where rounding would blur an identity.
inline dragcore::Model exactly(dragcore::Model model) {
  model.precision = dragcore::Precision::full;
  return model;
}

inline std::vector<dragcore::Model> models() {
  using namespace dragcore;
  std::vector<Model> list;
  for (const Law& law : {note_law(), consistent_law(), scaled_law(0.76, 0.4)})
    for (const Pillow& pillow :
         {Pillow{}, Pillow{PillowForm::triangle, 0.9}, Pillow{PillowForm::patch, 0.9}, Pillow{PillowForm::tilt, 0.8}})
      for (const Quadrature order : {Quadrature::one, Quadrature::three, Quadrature::six}) list.push_back({law, pillow, order});
  return list;
}

}  // namespace zoo
