#include <dragcore/drag.hpp>

#include <cmath>
#include <sstream>
#include <stdexcept>
#include <string>

#include "pressure_points.hpp"

namespace dragcore {

using Eigen::Vector3d;

void check_input(const Motion& motion, const Medium& medium, const Model& model) {
  const auto finite = [](const Vector3d& v, const char* name) {
    if (v.allFinite()) return;
    std::ostringstream message;
    message << "wrench: motion." << name << " is (" << v.transpose() << "), but it must be finite";
    throw std::invalid_argument(message.str());
  };
  finite(motion.wind, "wind");
  finite(motion.velocity, "velocity");
  finite(motion.angular_velocity, "angular_velocity");
  finite(motion.reference_point, "reference_point");
  if (!(medium.density >= 0.0) || !std::isfinite(medium.density))
    throw std::invalid_argument("wrench: density = " + std::to_string(medium.density) + " kg/m^3, but it must be finite and not negative");
  const double largest = model.pillow.form == PillowForm::tilt ? 1.5 : 1.0;  // beyond, the tilt falloff would be negative on half the face
  if (!(model.pillow.factor >= 0.0 && model.pillow.factor <= largest))
    throw std::invalid_argument("wrench: pillow factor = " + std::to_string(model.pillow.factor) + ", but the form '" + to_string(model.pillow.form) +
                                "' takes 0 to " + std::to_string(largest));
  if (const int points = static_cast<int>(model.quadrature); points != 1 && points != 3 && points != 6)
    throw std::invalid_argument("wrench: quadrature of " + std::to_string(points) + " points, but it must be 1, 3 or 6");
  // Beyond this the square of the speed, times a density and an area of any size, leaves the range of numbers; sound is at 340 m/s.
  constexpr double largest_speed = 1e100;
  for (const Vector3d& v : {motion.wind, motion.velocity, motion.angular_velocity})
    if (v.cwiseAbs().maxCoeff() > largest_speed)
      throw std::invalid_argument("wrench: a velocity of " + std::to_string(v.cwiseAbs().maxCoeff()) + " is beyond 1e100 in SI units; was it ever set?");
  for (const Law::Polynomial& polynomial : {model.law.windward, model.law.leeward})
    for (const double coefficient : polynomial)
      if (!std::isfinite(coefficient)) throw std::invalid_argument("wrench: a coefficient of the law '" + model.law.name + "' is not finite");
}

WrenchByTerm wrench(const Surface& surface, const Motion& motion, const Medium& medium, const Model& model) {
  check_input(motion, medium, model);
  WrenchByTerm result;
  for_each_pressure_point(surface, motion, medium, model, [&result](const PressurePoint& point) {
    const Vector3d force = point.size() * point.downstream();
    result[point.term] += {force, point.place.cross(force)};
  });
  return result;
}

}  // namespace dragcore
