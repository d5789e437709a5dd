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

  check(dragcore_surface_create(vertices, 4, triangles, 2, 1, &sheet) == DRAGCORE_OK, "a sheet can be made");
  check(dragcore_evaluate(sheet, &motion, 1.2, &model, &wrench) == DRAGCORE_OK, "its wrench can be had");
  check(fabs(wrench.force[2] - 60.0) < 1e-12, "the force is rho U^2 A / 2");
  check(fabs(wrench.torque[0]) + fabs(wrench.torque[1]) < 1e-12, "and acts in the middle");
  check(dragcore_resistance(sheet, &motion, 1.2, &model, s) == DRAGCORE_OK && fabs(s[14] * 10.0 - 60.0) < 1e-12, "the secant matrix gives the same force");

  /* Tilted with the pillow, the force moves forward. */
  motion.wind[0] = 10.0;
  model.pillow = DRAGCORE_PILLOW_TILT;
  model.pillow_factor = 0.8;
  check(dragcore_evaluate(sheet, &motion, 1.2, &model, &wrench) == DRAGCORE_OK && wrench.torque[1] > 0.1, "the pillow lifts the leading edge");

  check(dragcore_last_error()[0] == '\0', "no error so far");
  check(dragcore_evaluate(sheet, &motion, -1.0, &model, &wrench) == DRAGCORE_INVALID_ARGUMENT, "a negative density is refused");
  check(strstr(dragcore_last_error(), "density") != NULL, "by name");
  model.quadrature = 2;
  check(dragcore_evaluate(sheet, &motion, 1.2, &model, &wrench) == DRAGCORE_INVALID_ARGUMENT, "two points are refused");
  check(dragcore_evaluate(NULL, &motion, 1.2, &model, &wrench) == DRAGCORE_INVALID_ARGUMENT, "so is NULL");
  dragcore_surface_destroy(sheet);

  {
    const int wild[] = {0, 1, 7};
    check(dragcore_surface_create(vertices, 4, wild, 1, 1, &sheet) == DRAGCORE_INVALID_ARGUMENT && sheet == NULL, "an index out of range is refused");
    check(strstr(dragcore_last_error(), "vertex 7") != NULL, "and named");
  }
  dragcore_surface_destroy(NULL);
  printf("%s\n", failures ? "the C interface is broken" : "the C interface holds");
  return failures != 0;
}
