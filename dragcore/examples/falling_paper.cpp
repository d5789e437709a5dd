// A sheet of paper let go three metres above the ground in a gusty, turbulent wind, at 60 steps a second: the loop of an engine around dragcore.

#include <Eigen/Geometry>
#include <cstdio>
#include <dragcore/body_wind.hpp>
#include <dragcore/diagnose.hpp>
#include <dragcore/fluid_terms.hpp>
#include <dragcore/gust.hpp>
#include <dragcore/mass_properties.hpp>
#include <dragcore/required_effects.hpp>
#include <dragcore/stepping.hpp>
#include <dragcore/turbulence.hpp>
#include <memory>

using Eigen::Matrix3d;
using Eigen::Vector3d;

int main() {
  // The body, once. A4, 80 g/m^2; its frame has the centre of mass at the origin and z across the sheet. An open mesh is a sheet: both sides feel the air.
  const double length = 0.297, width = 0.210;
  const dragcore::TriangleMesh mesh{
      {{-length / 2, -width / 2, 0}, {length / 2, -width / 2, 0}, {length / 2, width / 2, 0}, {-length / 2, width / 2, 0}}, {{0, 1, 2}, {0, 2, 3}}};
  const dragcore::Surface surface(mesh);
  dragcore::Model model = model_for(surface);
  const dragcore::Medium medium{.density = 1.2};

  // It carries more than its own mass of air along: that of an ellipsoid of its area, nearly flat.
  dragcore::MassProperties body = sheet_mass_properties(mesh, 0.08);
  body.added = added_mass({.shape = {0.564 * length, 0.564 * width, 0.001}}, Vector3d::Zero(), medium);  // pi a b = the sheet's area

  // What this scene calls for, once: with the largest speed and spin to expect, whatever the motion is now.
  dragcore::Motion fastest{.velocity = {8, 0, 6}, .angular_velocity = {30, 30, 0}};
  model.effects = dragcore::required_effects({.surface = surface, .motion = fastest, .medium = medium, .model = model, .body = body}).effects;

  // The wind: 3 m/s on average, turbulence as near the ground, a gust of 5 m/s between t = 0.5 and 1.5 s, a whirl.
  dragcore::Dryden near_ground{.seed = 7, .intensity = {0.5, 0.5, 0.3}, .length = {3, 3, 1.5}, .mean_wind = {3, 0, 0}};
  const auto eddies = std::make_shared<const dragcore::Turbulence>(near_ground);
  const dragcore::Gust gust{.profile = dragcore::GustProfile::one_minus_cosine, .start = 0.5, .duration = 1.0, .rest = 0.0};

  Vector3d position(0, 0, 3), velocity(0, 0, 0), spin(0, 0, 0);         // world, z up
  Eigen::Quaterniond rotation(Eigen::AngleAxisd(0.3, Vector3d::UnitY()));  // body to world
  const double dt = 1.0 / 60;
  double time = 0.0;
  std::printf("   time       x       y       z   speed    spin\n");
  for (int frame = 0; frame < 600 && position.z() > 0.0; ++frame) {
    const std::vector<dragcore::WindSource> sources{{.name = "mean", .field = dragcore::UniformField{{3, 0, 0}}},
                                                    {.name = "gust", .field = dragcore::UniformField{{5, 0, 0}}, .intensity = gust_factor(gust, time)},
                                                    {.name = "eddies", .field = eddies},
                                                    {.name = "whirl", .field = dragcore::VortexField{.circulation = 4, .core_radius = 1}, .placement = {.position = {3, 1, 0}}}};
    const dragcore::Wind wind(sources, time);

    // Into the body frame, with the cheapest sampling of the wind within 0.1 m/s.
    const Matrix3d to_world = rotation.toRotationMatrix(), to_body = to_world.transpose();
    dragcore::Motion motion{.velocity = to_body * velocity, .angular_velocity = gyroscopic_spin(body, to_body * spin, dt)};
    const auto here = dragcore::BodyWind::within(wind, surface, {position, to_world}, motion.reference_point, 0.1);
    here.apply_to(motion);
    if (frame == 30)  // once, when it moves: units, frames and reference points that are usually mistakes
      for (const dragcore::Warning& warning : diagnose(surface, motion, medium, {.to_world = to_world, .velocity = velocity}))
        std::printf("warning: %s\n", warning.text.c_str());

    // What acts beside the drag: weight, and what the secant matrix misses where the wind varies over the body.
    const dragcore::Matrix6d S = resistance(surface, motion, medium, model);  // drag = S (V_air - V)
    dragcore::Vector6d external;
    external << to_body * Vector3d(0, 0, -9.81 * body.mass), Vector3d::Zero();
    if (here.sampling() != dragcore::WindSampling::constant) external += wind_excess(wrench(surface, motion, medium, model).total(), S, motion);

    const dragcore::Vector6d V = step_secant_implicit(S, body, motion, external, dt);  // new velocity and spin; the drag never adds energy
    velocity = to_world * V.head<3>();
    spin = to_world * V.tail<3>();
    position += dt * velocity;
    if (const double angle = spin.norm() * dt; angle > 0.0) rotation = (Eigen::AngleAxisd(angle, spin.normalized()) * rotation).normalized();
    time += dt;
    if (frame % 10 == 9) std::printf("%7.2f %7.2f %7.2f %7.2f %7.2f %7.1f\n", time, position.x(), position.y(), position.z(), velocity.norm(), spin.norm());
  }
  std::printf("on the ground after %.2f s\n", time);
  return time > 1.0 && time < 8.0 ? 0 : 1;  // a stone needs 0.78 s
}
