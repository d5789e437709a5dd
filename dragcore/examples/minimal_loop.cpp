// A box of cork dropped into a wind, 60 steps a second: all that a program needs around dragcore.
#include <Eigen/Geometry>
#include <cstdio>
#include <dragcore/diagnose.hpp>
#include <dragcore/mass_properties.hpp>
#include <dragcore/shapes.hpp>

using Eigen::Vector3d;

int main() {
  // Or of read_mesh("body.stl", 0.001): made sound, and moved so that its centre of mass is the origin.
  const dragcore::TriangleMesh mesh = recentred(prepare(triangulate(dragcore::Box{0.3, 0.2, 0.1}, 1)).mesh);
  const dragcore::Surface surface(mesh);
  const dragcore::Model model = model_for(surface);
  const dragcore::Medium medium{.density = 1.2};                       // air [kg/m^3]
  const dragcore::MassProperties body = mass_properties(mesh, 120.0);  // cork [kg/m^3]
  const Vector3d wind(12, 0, 3), weight(0, 0, -9.81 * body.mass);      // world, z up
  Vector3d position(0, 0, 50), velocity(0, 0, 0), spin(0, 0, 1);
  Eigen::Quaterniond turn(Eigen::AngleAxisd(0.3, Vector3d::UnitY()));  // body to world
  const double dt = 1.0 / 60;
  for (int frame = 0; position.z() > 0.0; ++frame) {
    const Eigen::Matrix3d to_world = turn.toRotationMatrix(), to_body = to_world.transpose();
    dragcore::Motion motion{.wind = to_body * wind, .velocity = to_body * velocity};
    motion.angular_velocity = gyroscopic_spin(body, to_body * spin, dt);
    if (frame == 30)  // once, when it moves: wrong units, frames, reference points
      for (auto& w : diagnose(surface, motion, medium, {to_world, velocity})) std::puts(w.text.c_str());
    const dragcore::Matrix6d S = resistance(surface, motion, medium, model);  // drag = S (V_air - V)
    dragcore::Vector6d external;                                             // force, then torque, body frame
    external << to_body * weight, Vector3d::Zero();
    const dragcore::Vector6d V = step_secant_implicit(S, body, motion, external, dt);  // velocity, then spin
    velocity = to_world * V.head<3>(), spin = to_world * V.tail<3>(), position += dt * velocity;
    turn = (Eigen::AngleAxisd(dt * spin.norm(), spin.stableNormalized()) * turn).normalized();
  }
  std::printf("%.1f m downwind\n", position.x());
  return position.x() > 10.0 && position.x() < 60.0 ? 0 : 1;
}
