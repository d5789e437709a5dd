#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <dragcore/diagnose.hpp>
#include <sstream>

namespace dragcore {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

template <class... Parts>
std::string sentence(const Parts&... parts) {
  std::ostringstream text;
  text.precision(4);
  (text << ... << parts);
  return text.str();
}

std::string in_words(const Vector3d& v) { return sentence("(", v.x(), ", ", v.y(), ", ", v.z(), ")"); }

Eigen::AlignedBox3d box_of(const Surface& surface) {
  Eigen::AlignedBox3d box;
  for (Eigen::Index i = 0; i < surface.size(); ++i) {
    const Vector3d ab = surface.edge_ab.row(i), ac = surface.edge_ac.row(i);
    const Vector3d a = surface.centroid.row(i).matrix().transpose() - (ab + ac) / 3.0;
    box.extend(a).extend(a + ab).extend(a + ac);
  }
  return box;
}

/// The largest speed of the air relative to a point of the surface, from above: spin adds its own by the longest arm.
double largest_speed(const Surface& surface, const Motion& motion) {
  double wind = (motion.wind - motion.velocity).norm();
  for (const Vector3d& here : motion.triangle_wind) wind = std::max(wind, (here - motion.velocity).norm());
  const double arm = (surface.centre - motion.reference_point).norm() + surface.radius;
  return wind + (motion.angular_velocity.norm() + motion.wind_gradient.norm()) * arm;
}

bool is_finite(const Motion& motion, const Medium& medium) {
  return motion.wind.allFinite() && motion.velocity.allFinite() && motion.angular_velocity.allFinite() &&
         motion.reference_point.allFinite() && motion.wind_gradient.allFinite() && std::isfinite(medium.density);
}

void look_at_length(const Eigen::AlignedBox3d& box, std::vector<Warning>& found) {
  const Vector3d size = box.sizes();
  const double largest = size.maxCoeff();
  const std::string extents = sentence("the surface measures ", size.x(), " x ", size.y(), " x ", size.z(), " m");
  if (largest > 50.0)
    found.push_back(
        {Mistake::unit_of_length,
         extents + ". If its file is in millimetres, multiply the coordinates by 0.001: read_mesh(file, 0.001); centimetres: 0.01"});
  if (largest < 1e-3)
    found.push_back({Mistake::unit_of_length, extents + ". Coordinates are in metres: was a factor such as 0.001 applied twice?"});
}

void look_at_reference_point(const Surface& surface, const Eigen::AlignedBox3d& box, const Motion& motion, std::vector<Warning>& found) {
  // A sheet's box is flat, and its centre of mass that of a body that is not all sheet: a tenth of the radius is no mistake.
  const double outside = box.exteriorDistance(motion.reference_point);
  if (!(outside > 0.1 * surface.radius)) return;
  found.push_back({Mistake::reference_point,
                   sentence("reference_point = ", in_words(motion.reference_point), " lies ", outside,
                            " m outside the surface, whose middle is ", in_words(surface.centre), " and whose radius is ", surface.radius,
                            " m. It is where velocity holds and about which torque is taken, in the body frame: give the centre of mass "
                            "(mass_properties()), or move the mesh with recentred()")});
}

void look_at_rotation(const Matrix3d& to_world, std::vector<Warning>& found) {
  const Matrix3d square = to_world.transpose() * to_world;
  const auto add = [&found](const std::string& text) { found.push_back({Mistake::rotation, text}); };
  if (square.isIdentity(1e-9)) {
    if (to_world.determinant() < 0.0)
      add("to_world mirrors (its determinant is -1), but it must be a rotation: a left-handed engine needs its axes changed first, "
          "docs/embedding.md");
  } else if (square.isIdentity(1e-5)) {
    add("to_world is a rotation to single precision only, but it must be one to 1e-9: normalise the quaternion in double precision and "
        "take its "
        "matrix");
  } else {
    const Vector3d lengths = square.diagonal().cwiseSqrt();
    add(sentence("to_world is not a rotation: its columns have the lengths ", in_words(lengths),
                 " and must be orthonormal. Take scale out of it and apply that to the mesh, transformed()"));
  }
}

void look_at_frame(const char* what, const Vector3d& in_body, const Vector3d& in_world, const Matrix3d& to_world,
                   std::vector<Warning>& found) {
  // Rounding of single precision, and more than that: 1e-4 of the velocity is no mistake of frames.
  const double tolerance = 1e-4 * in_world.norm();
  const Vector3d right = to_world.transpose() * in_world;
  if ((in_body - right).norm() <= tolerance) return;
  const std::string start = sentence("motion.", what, " = ", in_words(in_body), ", but to_world^T times the world's ", in_words(in_world),
                                     " is ", in_words(right));
  const bool transposed = (in_body - to_world * in_world).norm() <= tolerance;
  found.push_back({Mistake::frame, start + (transposed ? ": the matrix is transposed. Its columns must be the body's axes in the world"
                                                       : ": turn it into the body frame")});
}

}  // namespace

std::vector<Warning> diagnose(const Surface& surface, const Motion& motion, const Medium& medium) {
  std::vector<Warning> found;
  const bool finite = is_finite(motion, medium);
  if (surface.size() == 0) {
    found.push_back({Mistake::empty_surface, "the surface has no triangle with an area: it feels no air. Was the mesh read?"});
  } else {
    const Eigen::AlignedBox3d box = box_of(surface);
    look_at_length(box, found);
    if (finite) look_at_reference_point(surface, box, motion, found);
  }
  if (!finite) {
    found.push_back({Mistake::not_finite, "the motion or the density holds a value that is infinite or not a number: wrench() refuses it"});
    return found;
  }
  if (const double speed = largest_speed(surface, motion); speed > 100.0)
    found.push_back(
        {Mistake::speed, sentence("the air passes at up to ", speed, " m/s, Mach ", speed / 340.0,
                                  " in air at 15 C. The laws are for air that is not compressed, below Mach 0.3, about 100 m/s; above "
                                  "that drag is larger than they say. Are velocities in m/s and spin in rad/s?")});
  const double density = medium.density;
  if (const bool gas = density >= 0.005 && density <= 20.0, liquid = density >= 500.0 && density <= 2000.0; !gas && !liquid)
    found.push_back({Mistake::density, sentence("density = ", density,
                                                " kg/m^3, which is neither a gas nor a liquid: air at sea level has 1.225, "
                                                "water 1000. A body's own density does not belong here")});
  return found;
}

std::vector<Warning> diagnose(const Surface& surface, const Motion& motion, const Medium& medium, const WorldMotion& world) {
  std::vector<Warning> found = diagnose(surface, motion, medium);
  look_at_rotation(world.to_world, found);
  if (world.velocity) look_at_frame("velocity", motion.velocity, *world.velocity, world.to_world, found);
  if (world.wind) look_at_frame("wind", motion.wind, *world.wind, world.to_world, found);
  return found;
}

}  // namespace dragcore
