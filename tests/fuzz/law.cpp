#include <dragcore/law_file.hpp>
#include <dragcore/shapes.hpp>

#include "fuzz.hpp"

/// Law files: no law that is accepted takes energy from the air.
int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace dragcore;
  static const Surface bodies[] = {Surface(triangulate(Box{2.0, 1.0, 0.6}, 1)), Surface(triangulate(Cone{}, 3)),
                                   Surface(triangulate(Plate{1.0, 1.0, 0.0}, 1), Surface::Sides::two)};
  LawFile file;
  try {
    file = parse_law({reinterpret_cast<const char*>(data), size}, "bytes");
  } catch (const std::runtime_error& fault) {
    fuzz::check(std::strlen(fault.what()) < 1000 + 2 * size, "a message is short");  // it may quote a key
    return 0;
  }
  validate(file.law);
  const Motion motion{
      .wind = {1.0, 2.0, 0.5}, .velocity = {-3.0, 0.5, 1.0}, .angular_velocity = {0.3, -1.0, 0.7}, .reference_point = {0.1, 0.0, 0.2}};
  const Eigen::Vector3d moves = motion.velocity - motion.wind;  // through the air
  for (const Surface& body : bodies)
    for (const double spin : {0.0, 1.0}) {
      Motion turning = motion;
      turning.angular_velocity *= spin;
      const Model model{.law = file.law, .pillow = {PillowForm::tilt, 0.78}};
      try {
        const Wrench total = wrench(body, turning, {}, model).total();
        fuzz::check(total.force.allFinite() && total.torque.allFinite(), "the wrench of a law from a file is finite");
        const TriangleForces parts = triangle_forces(body, turning, {}, model);
        const double size_of_sums =
            parts.force.colwise().norm().sum() * moves.norm() + parts.torque.colwise().norm().sum() * turning.angular_velocity.norm();
        // Rounding of some hundred terms, which may cancel.
        const double power = total.force.dot(moves) + total.torque.dot(turning.angular_velocity);
        fuzz::check(!(power > 1e-12 * size_of_sums),
                    "a law takes no energy from the air, but power = " + std::to_string(power) + " W of " + std::to_string(size_of_sums));
      } catch (const std::overflow_error&) {  // coefficients of 1e308
      }
    }
  return 0;
}
