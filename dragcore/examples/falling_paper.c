/* The same sheet of paper in a gusty wind, from C. */
#include <dragcore/dragcore.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

static int failed(dragcore_status status) {
  if (status != DRAGCORE_OK) fprintf(stderr, "falling_paper_c: %s\n", dragcore_last_error());
  return status != DRAGCORE_OK;
}

/* Row by row, its columns the body's axes in the world; of a unit quaternion w x y z from body to world. */
static void matrix(const double q[4], double to_world[9]) {
  const double w = q[0], x = q[1], y = q[2], z = q[3];
  const double m[9] = {1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y), 2 * (x * y + w * z),    1 - 2 * (x * x + z * z),
                       2 * (y * z - w * x),     2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)};
  memcpy(to_world, m, sizeof m);
}

static void into_world(const double m[9], const double v[3], double out[3]) {
  int i;
  for (i = 0; i < 3; ++i) out[i] = m[3 * i] * v[0] + m[3 * i + 1] * v[1] + m[3 * i + 2] * v[2];
}
static void into_body(const double m[9], const double v[3], double out[3]) {
  int i;
  for (i = 0; i < 3; ++i) out[i] = m[i] * v[0] + m[3 + i] * v[1] + m[6 + i] * v[2];
}

/* Turned by a rotation vector of the world. */
static void turn(double q[4], const double w[3]) {
  const double angle = sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]), f = angle > 1e-12 ? sin(angle / 2) / angle : 0.5;
  const double a = cos(angle / 2), x = f * w[0], y = f * w[1], z = f * w[2];
  const double r[4] = {a * q[0] - x * q[1] - y * q[2] - z * q[3], a * q[1] + x * q[0] + y * q[3] - z * q[2],
                       a * q[2] - x * q[3] + y * q[0] + z * q[1], a * q[3] + x * q[2] - y * q[1] + z * q[0]};
  const double norm = sqrt(r[0] * r[0] + r[1] * r[1] + r[2] * r[2] + r[3] * r[3]);
  int i;
  for (i = 0; i < 4; ++i) q[i] = r[i] / norm;
}

int main(void) {
  const double a = 0.297, b = 0.210, density = 1.2, dt = 1.0 / 60, semi_axes[3] = {0.564 * a, 0.564 * b, 0.001};
  const double mean[3] = {3, 0, 0}, gust[3] = {5, 0, 0};
  const dragcore_dryden near_ground = {7, {0.5, 0.5, 0.3}, {3, 3, 1.5}, {3, 0, 0}, 0};
  double position[3] = {0, 0, 3}, velocity[3] = {0, 0, 0}, spin[3] = {0, 0, 0}, rotation[4] = {cos(0.15), 0, sin(0.15), 0}, to_world[9],
         S[36], V[3], W[3];
  double gust_now, per_triangle[3 * 2]; /* x y z for each of two triangles */
  dragcore_mesh* mesh = NULL;
  dragcore_surface* sheet = NULL;
  dragcore_wind* wind = NULL;
  dragcore_body body;
  dragcore_model model;
  int frame, i;

  if (failed(dragcore_mesh_plate(a, b, 0, 1, &mesh)) || failed(dragcore_sheet_mass_properties(mesh, 0.08, &body, NULL)) ||
      failed(dragcore_surface_from_mesh(mesh, DRAGCORE_SIDES_AUTOMATIC, &sheet)) || failed(dragcore_model_for(sheet, &model)) ||
      failed(dragcore_ellipsoid_added_mass(semi_axes, density, body.added_mass)) || failed(dragcore_wind_create(&wind)) ||
      failed(dragcore_wind_add_uniform(wind, mean, NULL)) || failed(dragcore_wind_add_uniform(wind, gust, NULL)) ||
      failed(dragcore_wind_add_turbulence(wind, &near_ground, NULL)))
    return 1;
  dragcore_mesh_destroy(mesh);
  for (frame = 0; frame < 600 && position[2] > 0; ++frame) {
    const double weight[3] = {0, 0, -9.81 * body.mass};
    dragcore_motion motion;
    dragcore_wrench external, air, excess;
    memset(&motion, 0, sizeof motion);
    matrix(rotation, to_world);
    into_body(to_world, velocity, motion.velocity);
    into_body(to_world, spin, W);
    if (failed(dragcore_gyroscopic_spin(&body, W, dt, motion.angular_velocity)) ||
        failed(dragcore_gust_factor(frame * dt, 0.5, 1.0, &gust_now)) || failed(dragcore_wind_set_time(wind, frame * dt)) ||
        failed(dragcore_wind_set_intensity(wind, 1, gust_now)) ||
        failed(dragcore_wind_over_body(wind, sheet, position, to_world, 0.1, per_triangle, &motion)))
      return 1;
    if (frame == 30) { /* once, when it moves: units, frames and reference points that are usually mistakes */
      char warnings[2000];
      size_t count;
      if (failed(dragcore_diagnose(sheet, &motion, density, to_world, velocity, &count, warnings, sizeof warnings))) return 1;
      if (count > 0) printf("%s", warnings);
    }
    if (failed(dragcore_resistance(sheet, &motion, density, &model, S)) ||
        failed(dragcore_evaluate(sheet, &motion, density, &model, &air)) || failed(dragcore_wind_excess(&air, S, &motion, &excess)))
      return 1;
    into_body(to_world, weight, external.force);
    for (i = 0; i < 3; ++i) external.force[i] += excess.force[i], external.torque[i] = excess.torque[i];
    if (failed(dragcore_step_secant_implicit(S, &body, &motion, &external, dt, V, W))) return 1;
    into_world(to_world, V, velocity);
    into_world(to_world, W, spin);
    for (i = 0; i < 3; ++i) position[i] += dt * velocity[i], W[i] = dt * spin[i];
    turn(rotation, W);
    if (frame % 10 == 9)
      printf("%5.2f s: x %6.2f m, z %5.2f m, %5.2f m/s\n", (frame + 1) * dt, position[0], position[2],
             sqrt(velocity[0] * velocity[0] + velocity[2] * velocity[2]));
  }
  dragcore_wind_destroy(wind);
  dragcore_surface_destroy(sheet);
  printf("on the ground after %.2f s\n", frame * dt);
  return frame > 60 && frame < 480 ? 0 : 1; /* a stone needs 0.78 s */
}
