#ifndef DRAGCORE_DRAGCORE_H
#define DRAGCORE_DRAGCORE_H

/* dragcore for C and for everything that can call C. SI units; body frame; docs/conventions.md.
 *
 * Functions return DRAGCORE_OK or an error; dragcore_last_error() then says, for the calling thread, what was found and what is needed.
 * A surface may be used by any number of threads at once. The library is C++ inside: gcc program.c -ldragcore -lstdc++ -lm, in this order.
 * Matrices are row by row; a symmetric one reads the same either way. */

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum dragcore_status {
  DRAGCORE_OK = 0,
  DRAGCORE_INVALID_ARGUMENT = 1, /* a value out of range, a null pointer, a mesh that is not usable */
  DRAGCORE_FAILED = 2            /* anything else: out of memory, a result beyond the range of numbers */
} dragcore_status;

typedef struct dragcore_surface dragcore_surface; /* a mesh prepared for drag */

/* Faces of a triangle that feel the air: the outer one of a body, both of a sheet. Automatic: two where the mesh is open,
 * but for a body with small holes: class Surface in dragcore/surface.hpp. */
typedef enum dragcore_sides { DRAGCORE_SIDES_AUTOMATIC = 0, DRAGCORE_ONE_SIDED = 1, DRAGCORE_TWO_SIDED = 2 } dragcore_sides;

typedef enum dragcore_body_class { DRAGCORE_SHEET = 0, DRAGCORE_SHARP = 1, DRAGCORE_SMOOTH = 2 } dragcore_body_class;

typedef struct dragcore_motion {
  double wind[3];             /* velocity of the undisturbed air at reference_point [m/s] */
  double velocity[3];         /* of the body at reference_point [m/s] */
  double angular_velocity[3]; /* [rad/s] */
  double reference_point[3];  /* torque is about it; usually the centre of mass [m] */
  double wind_gradient[9];    /* entry 3 i + j: change of wind component i along axis j [1/s] */
} dragcore_motion;

/* What a piece of surface feels: struct Law in dragcore/law.hpp has the meaning of every number. Start from dragcore_named_law(). */
typedef struct dragcore_law {
  double windward[5]; /* pressure coefficient of windward surface: polynomial in c, constant term first */
  double leeward[5];  /* suction coefficient of leeward surface */
  double friction;
  double base_suction, base_edge;
  double aspect_gain, aspect_scale;
  double recovery, recovery_depth, recovery_edge;
  double shelter;
  double curvature;
} dragcore_law;

typedef enum dragcore_pillow {
  DRAGCORE_PILLOW_NONE = 0,
  DRAGCORE_PILLOW_TRIANGLE = 1,
  DRAGCORE_PILLOW_PATCH = 2,
  DRAGCORE_PILLOW_TILT = 3,
  DRAGCORE_PILLOW_ECCENTRICITY = 4
} dragcore_pillow;

typedef enum dragcore_falloff { DRAGCORE_FALLOFF_CIRCULAR = 0, DRAGCORE_FALLOFF_LINEAR = 1 } dragcore_falloff;

#define DRAGCORE_ALL_EFFECTS 511u /* bits of enum Effect in dragcore/effects.hpp */

typedef struct dragcore_model {
  dragcore_law law;
  int pillow; /* one of enum dragcore_pillow; int, since C lets any number into an enum and C++ none */
  double pillow_factor;
  int falloff; /* one of enum dragcore_falloff */
  int quadrature;   /* points per triangle where the velocity varies over it: 1, 3 or 6, or 0 for adaptive */
  unsigned effects; /* DRAGCORE_ALL_EFFECTS, or the bits of those to evaluate */
} dragcore_model;

typedef struct dragcore_wrench {
  double force[3];  /* [N] */
  double torque[3]; /* about reference_point [N m] */
} dragcore_wrench;

typedef struct dragcore_body {
  double mass;       /* [kg] */
  double inertia[9]; /* about reference_point, which must be the centre of mass; body axes [kg m^2] */
  double added_mass[36]; /* of the air carried along, for light bodies; zeros: none [kg, kg m, kg m^2] */
} dragcore_body;

/* The note's law, no pillow, three points. */
dragcore_model dragcore_note_model(void);

/* "note", "consistent", "sheet" or "closed". */
dragcore_status dragcore_named_law(const char* name, dragcore_law* law);

/* What validation found best for the class of a surface: law, pillow, three points. */
dragcore_status dragcore_model_for(const dragcore_surface* surface, dragcore_model* model);

/* vertices: 3 * vertex_count coordinates; triangles: 3 * triangle_count indices, counterclockwise from outside; sides: one of enum dragcore_sides.
 * Both arrays are copied. *surface is to be given to dragcore_surface_destroy(), and is NULL after an error. */
dragcore_status dragcore_surface_create(const double* vertices, size_t vertex_count, const int* triangles, size_t triangle_count, int sides,
                                        dragcore_surface** surface);
void dragcore_surface_destroy(dragcore_surface* surface); /* NULL is allowed */

/* What was found or asked for: one-sided or two-sided. */
dragcore_status dragcore_surface_sides(const dragcore_surface* surface, dragcore_sides* sides);
dragcore_status dragcore_surface_class(const dragcore_surface* surface, dragcore_body_class* body_class);

/* Force and torque of the air; see wrench() in dragcore/drag.hpp. */
dragcore_status dragcore_evaluate(const dragcore_surface* surface, const dragcore_motion* motion, double density, const dragcore_model* model,
                                  dragcore_wrench* result);

/* 6 x 6 secant matrix: wrench = S (air velocity - body velocity) in a uniform wind; see dragcore/stepping.hpp. */
dragcore_status dragcore_resistance(const dragcore_surface* surface, const dragcore_motion* motion, double density, const dragcore_model* model,
                                    double matrix[36]);

/* 6 x 6 derivative of (force, torque) by (velocity, angular velocity), row by row: for engines that step implicitly themselves. */
dragcore_status dragcore_force_jacobian(const dragcore_surface* surface, const dragcore_motion* motion, double density, const dragcore_model* model,
                                        double matrix[36]);

/* New velocity and angular velocity after dt [s] under drag and a constant external wrench (gravity, say): step_secant_implicit(), and the cheaper
 * step_scalar_implicit(). Never gains energy from the air, at any dt. */
dragcore_status dragcore_step_secant_implicit(const double matrix[36], const dragcore_body* body, const dragcore_motion* motion, const dragcore_wrench* external,
                                              double dt, double velocity[3], double angular_velocity[3]);
dragcore_status dragcore_step_scalar_implicit(const double matrix[36], const dragcore_body* body, const dragcore_motion* motion, const dragcore_wrench* external,
                                              double dt, double velocity[3], double angular_velocity[3]);

/* Added mass about the centre of an ellipsoid with semi-axes along the body's, for dragcore_body: added_mass() in dragcore/fluid_terms.hpp.
 * A sheet is about an ellipsoid of its area with one short semi-axis. */
dragcore_status dragcore_ellipsoid_added_mass(const double semi_axes[3], double density, double matrix[36]);

/* Spin after dt by inertia alone: gyroscopic_spin() in dragcore/stepping.hpp. Replace motion.angular_velocity with it before dragcore_resistance(). */
dragcore_status dragcore_gyroscopic_spin(const dragcore_body* body, const double angular_velocity[3], double dt, double spin[3]);

/* Where motion.wind_gradient is not zero: what the matrix misses of the wrench that dragcore_evaluate() gives, to be added to `external` of the steps. */
dragcore_status dragcore_wind_excess(const dragcore_wrench* wrench, const double matrix[36], const dragcore_motion* motion, dragcore_wrench* excess);

/* Share in [0, 1] of the impulse dt * wrench that may be applied: impulse_share(). */
dragcore_status dragcore_impulse_share(const dragcore_wrench* wrench, const dragcore_body* body, const dragcore_motion* motion, double dt, double* share);

/* Message of the last error on this thread; "" if there was none. Valid until the next call on this thread. */
const char* dragcore_last_error(void);

#ifdef __cplusplus
}
#endif

#endif
