#ifndef DRAGCORE_DRAGCORE_H
#define DRAGCORE_DRAGCORE_H

/* dragcore for C and for everything that can call C. SI units; body frame; docs/conventions.md.
 *
 * Functions return DRAGCORE_OK or an error; dragcore_last_error() then says, for the calling thread, what was found and what is needed.
 * A surface may be used by any number of threads at once. The library is C++ inside: link with the C++ runtime too (-lstdc++, or let a C++ linker do it). */

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum dragcore_status {
  DRAGCORE_OK = 0,
  DRAGCORE_INVALID_ARGUMENT = 1, /* a value out of range, a null pointer, a mesh that is not usable */
  DRAGCORE_FAILED = 2            /* anything else: out of memory */
} dragcore_status;

typedef struct dragcore_surface dragcore_surface; /* a mesh prepared for drag */

typedef struct dragcore_motion {
  double wind[3];             /* velocity of the undisturbed air [m/s] */
  double velocity[3];         /* of the body at reference_point [m/s] */
  double angular_velocity[3]; /* [rad/s] */
  double reference_point[3];  /* torque is about it; usually the centre of mass [m] */
} dragcore_motion;

typedef enum dragcore_pillow { DRAGCORE_PILLOW_NONE = 0, DRAGCORE_PILLOW_TRIANGLE = 1, DRAGCORE_PILLOW_PATCH = 2, DRAGCORE_PILLOW_TILT = 3 } dragcore_pillow;

typedef struct dragcore_model {
  double windward[5]; /* pressure coefficient of windward surface: polynomial in c, constant term first */
  double leeward[5];  /* suction coefficient of leeward surface */
  dragcore_pillow pillow;
  double pillow_factor;
  int quadrature; /* points per triangle of a spinning body: 1, 3 or 6 */
} dragcore_model;

typedef struct dragcore_wrench {
  double force[3];  /* [N] */
  double torque[3]; /* about reference_point [N m] */
} dragcore_wrench;

/* The note's law, no pillow, three points. */
dragcore_model dragcore_note_model(void);

/* vertices: 3 * vertex_count coordinates; triangles: 3 * triangle_count indices, counterclockwise from outside; two_sided: not 0 for sheets.
 * Both arrays are copied. *surface is to be given to dragcore_surface_destroy(), and is NULL after an error. */
dragcore_status dragcore_surface_create(const double* vertices, size_t vertex_count, const int* triangles, size_t triangle_count, int two_sided,
                                        dragcore_surface** surface);
void dragcore_surface_destroy(dragcore_surface* surface); /* NULL is allowed */

/* Force and torque of the air; see wrench() in dragcore/drag.hpp. */
dragcore_status dragcore_evaluate(const dragcore_surface* surface, const dragcore_motion* motion, double density, const dragcore_model* model,
                                  dragcore_wrench* result);

/* 6 x 6 secant matrix, row by row: wrench = S (air velocity - body velocity); see dragcore/stepping.hpp. */
dragcore_status dragcore_resistance(const dragcore_surface* surface, const dragcore_motion* motion, double density, const dragcore_model* model,
                                    double matrix[36]);

/* Message of the last error on this thread; "" if there was none. Valid until the next call on this thread. */
const char* dragcore_last_error(void);

#ifdef __cplusplus
}
#endif

#endif
