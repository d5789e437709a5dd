/* The same sheet of paper in still air, from C: no wind fields here, a uniform wind and its gradient are members of dragcore_motion. */
#include <dragcore/dragcore.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

static int failed(dragcore_status status) {
  if (status != DRAGCORE_OK) fprintf(stderr, "falling_paper_c: %s\n", dragcore_last_error());
  return status != DRAGCORE_OK;
}

/* out = R v or R^T v, with the rotation of a unit quaternion w x y z from body to world. */
static void rotate(const double q[4], const double v[3], int to_body, double out[3]) {
  const double s = to_body ? -1 : 1, t[3] = {2 * s * (q[2] * v[2] - q[3] * v[1]), 2 * s * (q[3] * v[0] - q[1] * v[2]), 2 * s * (q[1] * v[1] - q[2] * v[0])};
  out[0] = v[0] + q[0] * t[0] + s * (q[2] * t[2] - q[3] * t[1]);
  out[1] = v[1] + q[0] * t[1] + s * (q[3] * t[0] - q[1] * t[2]);
  out[2] = v[2] + q[0] * t[2] + s * (q[1] * t[1] - q[2] * t[0]);
}

/* Turned by a rotation vector of the world. */
static void turn(double q[4], const double w[3]) {
  const double angle = sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]), f = angle > 1e-12 ? sin(angle / 2) / angle : 0.5;
  const double a = cos(angle / 2), x = f * w[0], y = f * w[1], z = f * w[2];
  const double r[4] = {a * q[0] - x * q[1] - y * q[2] - z * q[3], a * q[1] + x * q[0] + y * q[3] - z * q[2], a * q[2] - x * q[3] + y * q[0] + z * q[1],
                       a * q[3] + x * q[2] - y * q[1] + z * q[0]};
  const double norm = sqrt(r[0] * r[0] + r[1] * r[1] + r[2] * r[2] + r[3] * r[3]);
  int i;
  for (i = 0; i < 4; ++i) q[i] = r[i] / norm;
}

int main(void) {
  const double a = 0.297, b = 0.210, mass = 0.08 * a * b, density = 1.2, dt = 1.0 / 60, semi_axes[3] = {0.564 * a, 0.564 * b, 0.001};
  const double vertices[] = {-a / 2, -b / 2, 0, a / 2, -b / 2, 0, a / 2, b / 2, 0, -a / 2, b / 2, 0};
  const int triangles[] = {0, 1, 2, 0, 2, 3};
  dragcore_body body = {mass, {mass * b * b / 12, 0, 0, 0, mass * a * a / 12, 0, 0, 0, mass * (a * a + b * b) / 12}, {0}};
  double position[3] = {0, 0, 3}, velocity[3] = {0, 0, 0}, spin[3] = {0, 0, 0}, rotation[4] = {0.9888, 0, 0.1494, 0}, S[36], V[3], W[3];
  dragcore_surface* sheet = NULL;
  dragcore_model model;
  int frame, i;

  if (failed(dragcore_surface_create(vertices, 4, triangles, 2, DRAGCORE_SIDES_AUTOMATIC, &sheet)) || failed(dragcore_model_for(sheet, &model)) ||
      failed(dragcore_ellipsoid_added_mass(semi_axes, density, body.added_mass)))
    return 1;
  for (frame = 0; frame < 600 && position[2] > 0; ++frame) {
    const double weight[3] = {0, 0, -9.81 * mass};
    dragcore_motion motion;
    dragcore_wrench external;
    memset(&motion, 0, sizeof motion);
    rotate(rotation, velocity, 1, motion.velocity);
    rotate(rotation, spin, 1, W);
    rotate(rotation, weight, 1, external.force);
    external.torque[0] = external.torque[1] = external.torque[2] = 0;
    if (failed(dragcore_gyroscopic_spin(&body, W, dt, motion.angular_velocity)) || failed(dragcore_resistance(sheet, &motion, density, &model, S)) || failed(dragcore_step_secant_implicit(S, &body, &motion, &external, dt, V, W))) return 1;
    rotate(rotation, V, 0, velocity);
    rotate(rotation, W, 0, spin);
    for (i = 0; i < 3; ++i) position[i] += dt * velocity[i], W[i] = dt * spin[i];
    turn(rotation, W);
    if (frame % 10 == 9) printf("%5.2f s: x %6.2f m, z %5.2f m, %5.2f m/s\n", (frame + 1) * dt, position[0], position[2], sqrt(velocity[0] * velocity[0] + velocity[2] * velocity[2]));
  }
  dragcore_surface_destroy(sheet);
  printf("on the ground after %.2f s\n", frame * dt);
  return frame > 60 && frame < 480 ? 0 : 1; /* a stone needs 0.78 s */
}
