/* A C program: compiles the header as C99 and drives the library through it. */
#include <dragcore/dragcore.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

static int failures = 0;
static void check(int good, const char* what) {
  if (!good) {
    printf("FAILED: %s (last error: \"%s\")\n", what, dragcore_last_error());
    ++failures;
  }
}

int main(void) {
  /* A square sheet of 1 m^2 square to a wind of 10 m/s: C_N = 1. */
  const double vertices[] = {-0.5, -0.5, 0, 0.5, -0.5, 0, 0.5, 0.5, 0, -0.5, 0.5, 0};
  const int triangles[] = {0, 1, 2, 0, 2, 3};
  dragcore_surface* sheet = NULL;
  dragcore_model model = dragcore_note_model();
  dragcore_motion motion;
  dragcore_wrench wrench;
  double s[36];
  memset(&motion, 0, sizeof motion);
  motion.wind[2] = 10.0;

  check(dragcore_surface_create(vertices, 4, triangles, 2, DRAGCORE_SIDES_AUTOMATIC, &sheet) == DRAGCORE_OK, "a sheet can be made");
  {
    dragcore_sides sides = DRAGCORE_SIDES_AUTOMATIC;
    check(dragcore_surface_sides(sheet, &sides) == DRAGCORE_OK && sides == DRAGCORE_TWO_SIDED, "and is found to be one");
  }
  check(dragcore_evaluate(sheet, &motion, 1.2, &model, &wrench) == DRAGCORE_OK, "its wrench can be had");
  check(fabs(wrench.force[2] - 60.0) < 1e-12, "the force is rho U^2 A / 2");
  check(fabs(wrench.torque[0]) + fabs(wrench.torque[1]) < 1e-12, "and acts in the middle");
  check(dragcore_resistance(sheet, &motion, 1.2, &model, s) == DRAGCORE_OK && fabs(s[14] * 10.0 - 60.0) < 1e-12, "the secant matrix gives the same force");

  /* Tilted with the pillow, the force moves forward. */
  motion.wind[0] = 10.0;
  model.pillow = DRAGCORE_PILLOW_TILT;
  model.pillow_factor = 0.8;
  check(dragcore_evaluate(sheet, &motion, 1.2, &model, &wrench) == DRAGCORE_OK && wrench.torque[1] > 0.1, "the pillow lifts the leading edge");

  /* Laws by name, the class of a body and what suits it. */
  {
    dragcore_law law;
    dragcore_body_class body_class;
    dragcore_model best;
    check(dragcore_named_law("closed", &law) == DRAGCORE_OK && law.base_suction > 0.0, "the closed law has base suction");
    check(dragcore_surface_class(sheet, &body_class) == DRAGCORE_OK && body_class == DRAGCORE_SHEET, "an open sheet is a sheet");
    check(dragcore_model_for(sheet, &best) == DRAGCORE_OK && best.law.friction > 0.0 && best.pillow == DRAGCORE_PILLOW_TILT, "the sheet's model has friction");
    check(best.effects == DRAGCORE_ALL_EFFECTS, "and all effects");
    check(dragcore_evaluate(sheet, &motion, 1.2, &best, &wrench) == DRAGCORE_OK && wrench.force[0] > 0.0, "friction drags the sheet along");
    best.effects = 0;
    check(dragcore_evaluate(sheet, &motion, 1.2, &best, &wrench) == DRAGCORE_OK && fabs(wrench.force[0]) < 1e-12, "not with the effect off");
    best.effects = 1u << 20;
    check(dragcore_evaluate(sheet, &motion, 1.2, &best, &wrench) == DRAGCORE_INVALID_ARGUMENT, "unknown effects are refused");
  }

  /* A step: the sheet is taken along by the wind and never overtakes it. */
  {
    dragcore_body paper = {0.08, {0.0067, 0, 0, 0, 0.0067, 0, 0, 0, 0.0134}, {0}};
    const double ellipsoid[3] = {0.56, 0.56, 1e-3};
    const dragcore_wrench nothing = {{0, 0, 0}, {0, 0, 0}};
    double velocity[3], spin[3], share, jacobian[36];
    model.pillow = DRAGCORE_PILLOW_NONE;
    motion.wind[0] = 0.0;
    check(dragcore_resistance(sheet, &motion, 1.2, &model, s) == DRAGCORE_OK, "resistance for the step");
    check(dragcore_step_secant_implicit(s, &paper, &motion, &nothing, 10.0, velocity, spin) == DRAGCORE_OK && velocity[2] > 9.0 && velocity[2] < 10.0, "an implicit step");
    check(dragcore_step_scalar_implicit(s, &paper, &motion, &nothing, 10.0, velocity, spin) == DRAGCORE_OK && velocity[2] > 0.0 && velocity[2] < 10.0, "a scalar one");
    check(dragcore_evaluate(sheet, &motion, 1.2, &model, &wrench) == DRAGCORE_OK, "wrench for the impulse");
    check(dragcore_impulse_share(&wrench, &paper, &motion, 10.0, &share) == DRAGCORE_OK && share > 0.0 && share < 0.01, "an impulse is cut down");
    check(dragcore_force_jacobian(sheet, &motion, 1.2, &model, jacobian) == DRAGCORE_OK && fabs(jacobian[14] + 12.0) < 1e-9, "d force / d velocity = -2 F/U");
    check(dragcore_ellipsoid_added_mass(ellipsoid, 1.2, paper.added_mass) == DRAGCORE_OK && fabs(paper.added_mass[14] / (8.0 / 3 * 1.2 * 0.56 * 0.56 * 0.56) - 1) < 0.01,
          "a thin ellipsoid carries as much air as a disc");
    check(dragcore_step_secant_implicit(s, &paper, &motion, &nothing, 0.01, velocity, spin) == DRAGCORE_OK && velocity[2] > 0.0 && velocity[2] < 3.0, "and starts slowly with it");
    {
      const double turning[3] = {3, 4, 5};
      dragcore_wrench excess;
      check(dragcore_gyroscopic_spin(&paper, turning, 0.01, spin) == DRAGCORE_OK && fabs(spin[2] - 5) < 1e-6 && spin[0] > 3.05, "spin goes on by inertia");
      check(dragcore_evaluate(sheet, &motion, 1.2, &model, &wrench) == DRAGCORE_OK && dragcore_resistance(sheet, &motion, 1.2, &model, s) == DRAGCORE_OK &&
                dragcore_wind_excess(&wrench, s, &motion, &excess) == DRAGCORE_OK && fabs(excess.force[2]) < 1e-9, "nothing is missing in a uniform wind");
    }
    check(dragcore_step_secant_implicit(s, &paper, &motion, &nothing, -1.0, velocity, spin) == DRAGCORE_INVALID_ARGUMENT, "no step back in time");
  }

  check(dragcore_last_error()[0] != '\0', "the last error is kept");
  check(dragcore_evaluate(sheet, &motion, 1.2, &model, &wrench) == DRAGCORE_OK && dragcore_last_error()[0] == '\0', "until the next success");
  check(dragcore_evaluate(sheet, &motion, -1.0, &model, &wrench) == DRAGCORE_INVALID_ARGUMENT, "a negative density is refused");
  check(strstr(dragcore_last_error(), "density") != NULL, "by name");
  model.quadrature = 2;
  check(dragcore_evaluate(sheet, &motion, 1.2, &model, &wrench) == DRAGCORE_INVALID_ARGUMENT, "two points are refused");
  check(dragcore_evaluate(NULL, &motion, 1.2, &model, &wrench) == DRAGCORE_INVALID_ARGUMENT, "so is NULL");
  dragcore_surface_destroy(sheet);

  {
    const int wild[] = {0, 1, 7};
    check(dragcore_surface_create(vertices, 4, triangles, 2, 3, &sheet) == DRAGCORE_INVALID_ARGUMENT && strstr(dragcore_last_error(), "sides = 3") != NULL, "no third side");
    check(dragcore_surface_create(vertices, 4, wild, 1, DRAGCORE_TWO_SIDED, &sheet) == DRAGCORE_INVALID_ARGUMENT && sheet == NULL, "an index out of range is refused");
    check(strstr(dragcore_last_error(), "vertex 7") != NULL, "and named");
  }
  dragcore_surface_destroy(NULL);
  printf("%s\n", failures ? "the C interface is broken" : "the C interface holds");
  return failures != 0;
}
