// A thousand boxes of cork thrown into a wind, a second of 60 steps, all at once: bodies that share a surface and a model go sixteen at a time.
#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>
#include <dragcore/batch.hpp>
#include <dragcore/mass_properties.hpp>
#include <dragcore/shapes.hpp>
#include <vector>

using Eigen::Vector3d;

int main() {
  const dragcore::TriangleMesh mesh = triangulate(dragcore::Box{0.3, 0.2, 0.1}, 1);  // its middle is the origin
  const dragcore::Surface surface(mesh);
  const dragcore::Model model = model_for(surface);
  const dragcore::MassProperties body = mass_properties(mesh, 120.0);
  const dragcore::Medium medium{.density = 1.2};
  const Vector3d wind(12, 0, 3), weight(0, 0, -9.81 * body.mass);
  const double dt = 1.0 / 60;

  struct State {
    Vector3d position = Vector3d::Zero(), velocity = Vector3d::Zero(), spin = Vector3d::Zero();
    Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();
  };
  std::vector<State> states(1000);
  for (std::size_t i = 0; i < states.size(); ++i) states[i].spin = Vector3d(0.01 * static_cast<double>(i), 1, 2);

  std::vector<dragcore::FreeBody> bodies(states.size(), {.surface = &surface, .model = &model, .mass = &body});
  std::vector<dragcore::Vector6d> velocities(bodies.size());
  for (int frame = 0; frame < 60; ++frame) {
    for (std::size_t i = 0; i < states.size(); ++i) {
      const Eigen::Matrix3d to_body = states[i].turn.toRotationMatrix().transpose();
      bodies[i].motion = {.wind = to_body * wind,
                          .velocity = to_body * states[i].velocity,
                          .angular_velocity = to_body * states[i].spin};
      bodies[i].external << to_body * weight, Vector3d::Zero();
    }
    dragcore::step_free_bodies(bodies, medium, dt, velocities);
    for (std::size_t i = 0; i < states.size(); ++i) {
      State& s = states[i];
      const Eigen::Matrix3d to_world = s.turn.toRotationMatrix();
      s.velocity = to_world * velocities[i].head<3>(), s.spin = to_world * velocities[i].tail<3>(), s.position += dt * s.velocity;
      s.turn = (Eigen::AngleAxisd(dt * s.spin.norm(), s.spin.stableNormalized()) * s.turn).normalized();
    }
  }
  Vector3d middle = Vector3d::Zero();
  for (const State& s : states) middle += s.position / static_cast<double>(states.size());
  std::printf("after a second the middle of all is %.1f m downwind, %.1f m down\n", middle.x(), -middle.z());
  return middle.x() > 0.5 && middle.x() < 12.0 ? 0 : 1;
}
