#ifndef DRAGCORE_DRAGCORE_H
#define DRAGCORE_DRAGCORE_H

/* dragcore for C and for everything that can call C. SI units; body frame; docs/conventions.md.
 *
 * Functions return DRAGCORE_OK or an error; dragcore_last_error() then says, for the calling thread, what was found and what is needed.
 * A surface may be used by any number of threads at once. The library is C++ inside: gcc program.c -ldragcore -lstdc++ -lm, in this order.
 * Matrices are row by row; a symmetric one reads the same either way. 6-vectors and 6 x 6 matrices have the linear part first, then the
 * angular: entry 6 i + j of a matrix belongs to component i of (force, torque) and j of (velocity, angular velocity). Orientations are 3 x
 * 3 matrices whose columns are the body's axes in the world, r_world = to_world r_body; there is no quaternion in this interface.
 * docs/embedding.md is for engines that are left-handed or count in centimetres. */

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum dragcore_status {
  DRAGCORE_OK = 0,
  DRAGCORE_INVALID_ARGUMENT = 1, /* a value out of range, a null pointer, a mesh that is not usable */
  DRAGCORE_FAILED = 2            /* anything else: out of memory, a result beyond the range of numbers, a file that cannot be read */
} dragcore_status;

typedef struct dragcore_mesh dragcore_mesh;       /* triangles over shared vertices [m] */
typedef struct dragcore_surface dragcore_surface; /* a mesh prepared for drag */
typedef struct dragcore_correction dragcore_correction; /* what one body was found to feel beyond its law: dragcore/correction.hpp */
typedef struct dragcore_baked dragcore_baked;     /* force and torque of a surface by a model, over direction */
typedef struct dragcore_wind dragcore_wind;       /* wind fields in the world */

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
  /* Wind at the middle of every triangle of the surface, x y z each, in place of the two above; NULL: not used. The steps do not read it
   * [m/s]. */
  const double* triangle_wind;
  double viscosity; /* of the air, dynamic: 1.8e-5 at 15 C; 0: not known, and no force depends on it: Medium in drag.hpp [Pa s] */
} dragcore_motion; /* set all of it to zero first */

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
  double stokes, layer, layer_curvature; /* where motion.viscosity is not 0 */
} dragcore_law;

typedef enum dragcore_pillow {
  DRAGCORE_PILLOW_NONE = 0,
  DRAGCORE_PILLOW_TRIANGLE = 1,
  DRAGCORE_PILLOW_PATCH = 2,
  DRAGCORE_PILLOW_TILT = 3,
  DRAGCORE_PILLOW_ECCENTRICITY = 4
} dragcore_pillow;

typedef enum dragcore_falloff { DRAGCORE_FALLOFF_CIRCULAR = 0, DRAGCORE_FALLOFF_LINEAR = 1 } dragcore_falloff;

/* Of the sum over the triangles: enum class Precision in dragcore/drag.hpp. */
typedef enum dragcore_precision { DRAGCORE_PRECISION_FULL = 0, DRAGCORE_PRECISION_SINGLE = 1 } dragcore_precision;

#define DRAGCORE_ALL_EFFECTS 2047u /* bits of enum Effect in dragcore/effects.hpp */

typedef struct dragcore_model {
  dragcore_law law;
  int pillow; /* one of enum dragcore_pillow; int, since C lets any number into an enum and C++ none */
  double pillow_factor;
  int falloff;      /* one of enum dragcore_falloff */
  int quadrature;   /* points per triangle where the velocity varies over it: 1, 3 or 6, or 0 for adaptive */
  unsigned effects; /* DRAGCORE_ALL_EFFECTS, or the bits of those to evaluate */
  int precision;    /* one of enum dragcore_precision */
  int sheets;       /* 1: parts of class sheet have the next four in place of the law and the pillow above */
  dragcore_law sheet_law;
  int sheet_pillow;
  double sheet_pillow_factor;
  int sheet_falloff;
  double pillow_viscous_gain, sheet_pillow_viscous_gain; /* where motion.viscosity is not 0 */
  const dragcore_correction* correction;                 /* of dragcore_calibrated_read(); NULL: none. Not owned */
} dragcore_model;

typedef struct dragcore_wrench {
  double force[3];  /* [N] */
  double torque[3]; /* about reference_point [N m] */
} dragcore_wrench;

typedef struct dragcore_body {
  double mass;           /* [kg] */
  double inertia[9];     /* about reference_point, which must be the centre of mass; body axes [kg m^2] */
  double added_mass[36]; /* of the air carried along, for light bodies; zeros: none [kg, kg m, kg m^2] */
} dragcore_body;

/* The note's law, no pillow, three points. */
dragcore_model dragcore_note_model(void);

/* "note", "consistent", "sheet" or "closed". */
dragcore_status dragcore_named_law(const char* name, dragcore_law* law);

void dragcore_correction_destroy(dragcore_correction* correction); /* NULL is fine; of models in use by nobody */

/* What validation found best for the class of a surface: law, pillow, three points. */
dragcore_status dragcore_model_for(const dragcore_surface* surface, dragcore_model* model);

/* Meshes. vertices: 3 * vertex_count coordinates; triangles: 3 * triangle_count indices, counterclockwise from outside. Both arrays are
 * copied. *mesh is to be given to dragcore_mesh_destroy(), and is NULL after an error. dragcore_mesh_file.h reads STL and OBJ files. */
dragcore_status dragcore_mesh_create(const double* vertices, size_t vertex_count, const int* triangles, size_t triangle_count,
                                     dragcore_mesh** mesh);
void dragcore_mesh_destroy(dragcore_mesh* mesh); /* NULL is allowed */

/* Shapes: dragcore/shapes.hpp has frames and ranges. Lengths in metres, along x, y, z; angles in radians; the centroid is the origin,
 * bodies of revolution have their axis along x and their nose at -x. divisions: segments of a side, or of a quarter turn of a round body.
 */
dragcore_status dragcore_mesh_plate(double chord, double span, double thickness, int divisions,
                                    dragcore_mesh** mesh); /* thickness 0: a sheet */
dragcore_status dragcore_mesh_box(double length, double width, double height, int divisions, dragcore_mesh** mesh);
dragcore_status dragcore_mesh_cone(double diameter, double apex_angle, int divisions, dragcore_mesh** mesh); /* the full angle */
dragcore_status dragcore_mesh_sphere(double diameter, int divisions, dragcore_mesh** mesh);
dragcore_status dragcore_mesh_cylinder(double diameter, double length, int divisions, dragcore_mesh** mesh);
dragcore_status dragcore_mesh_ellipsoid(double semi_x, double semi_y, double semi_z, int divisions, dragcore_mesh** mesh);
dragcore_status dragcore_mesh_teardrop(double diameter, double length, int divisions, dragcore_mesh** mesh);
dragcore_status dragcore_mesh_prism(double base, double span, double apex_angle, int divisions, dragcore_mesh** mesh);

/* How many vertices and triangles there are, and all of them, into arrays of 3 times as many. NULL: not wanted. */
dragcore_status dragcore_mesh_size(const dragcore_mesh* mesh, size_t* vertex_count, size_t* triangle_count);
dragcore_status dragcore_mesh_copy(const dragcore_mesh* mesh, double* vertices, int* triangles);

/* Moves the mesh so that `origin` is the origin of its frame; NULL: its centroid, of the volume of a closed mesh, else of the area. */
dragcore_status dragcore_mesh_recentre(dragcore_mesh* mesh, const double origin[3]);

/* Mass and inertia about the centre of mass of a solid of uniform density [kg/m^3] in a closed mesh, and of a skin of uniform mass per area
 * [kg/m^2] on any; added_mass is zero. centre_of_mass: in the mesh's frame, for motion.reference_point; NULL: not wanted.
 * dragcore/mass_properties.hpp. */
dragcore_status dragcore_mass_properties(const dragcore_mesh* mesh, double density, dragcore_body* body, double centre_of_mass[3]);
dragcore_status dragcore_sheet_mass_properties(const dragcore_mesh* mesh, double area_density, dragcore_body* body,
                                               double centre_of_mass[3]);

/* Prepares a mesh, which may then go, or arrays as for dragcore_mesh_create(). sides: one of enum dragcore_sides.
 * *surface is to be given to dragcore_surface_destroy(), and is NULL after an error. */
dragcore_status dragcore_surface_from_mesh(const dragcore_mesh* mesh, int sides, dragcore_surface** surface);
dragcore_status dragcore_surface_create(const double* vertices, size_t vertex_count, const int* triangles, size_t triangle_count, int sides,
                                        dragcore_surface** surface);
void dragcore_surface_destroy(dragcore_surface* surface); /* NULL is allowed */

/* Triangles that have an area: the others are dropped. */
dragcore_status dragcore_surface_triangles(const dragcore_surface* surface, size_t* count);

/* What was found or asked for: one-sided or two-sided. */
dragcore_status dragcore_surface_sides(const dragcore_surface* surface, dragcore_sides* sides);
dragcore_status dragcore_surface_class(const dragcore_surface* surface, dragcore_body_class* body_class);

/* Force and torque of the air; see wrench() in dragcore/drag.hpp. */
dragcore_status dragcore_evaluate(const dragcore_surface* surface, const dragcore_motion* motion, double density,
                                  const dragcore_model* model, dragcore_wrench* result);

/* 6 x 6 secant matrix: (force, torque) = S (wind - velocity, -angular_velocity) in a uniform wind; see dragcore/stepping.hpp. */
dragcore_status dragcore_resistance(const dragcore_surface* surface, const dragcore_motion* motion, double density,
                                    const dragcore_model* model, double matrix[36]);

/* 6 x 6 derivative of (force, torque) by (velocity, angular velocity), row by row: for engines that step implicitly themselves. */
dragcore_status dragcore_force_jacobian(const dragcore_surface* surface, const dragcore_motion* motion, double density,
                                        const dragcore_model* model, double matrix[36]);

/* Force and torque baked into maps over direction, which cost the same whatever the model and the number of triangles: dragcore/bake.hpp.
 * rms_error: of force and torque without spin, 0.01 for 1 %; 0: the best that most_bytes allow. *baked is to be given to
 * dragcore_baked_destroy(), and is NULL after an error; the surface may then go. dragcore_baked_file.h reads and writes files. */
dragcore_status dragcore_bake(const dragcore_surface* surface, const dragcore_model* model, double rms_error, size_t most_bytes,
                              dragcore_baked** baked);
void dragcore_baked_destroy(dragcore_baked* baked); /* NULL is allowed */

/* *matches: 1 where it was baked from this surface and this model, 0 where it is stale. */
dragcore_status dragcore_baked_matches(const dragcore_baked* baked, const dragcore_surface* surface, const dragcore_model* model,
                                       int* matches);

/* Measured when it was baked: force by the rms force, torque by that times the farthest corner's distance. */
typedef struct dragcore_bake_error {
  double rms_force, worst_force, rms_torque, worst_torque;
} dragcore_bake_error;
/* Size of the maps; errors without spin, and at spin ratios of 0.1, 0.3 and 1. NULL: not wanted. */
dragcore_status dragcore_baked_errors(const dragcore_baked* baked, size_t* bytes, dragcore_bake_error* straight,
                                      dragcore_bake_error spinning[3]);

/* As dragcore_evaluate() and dragcore_resistance(); motion->triangle_wind must be NULL, and the wind must not strain. */
dragcore_status dragcore_baked_wrench(const dragcore_baked* baked, const dragcore_motion* motion, double density, dragcore_wrench* result);
dragcore_status dragcore_baked_resistance(const dragcore_baked* baked, const dragcore_motion* motion, double density, double matrix[36]);

/* New velocity and angular velocity after dt [s] under drag and a constant external wrench (gravity, say): step_secant_implicit(), and the
 * cheaper step_scalar_implicit(). Never gains energy from the air, at any dt. */
dragcore_status dragcore_step_secant_implicit(const double matrix[36], const dragcore_body* body, const dragcore_motion* motion,
                                              const dragcore_wrench* external, double dt, double velocity[3], double angular_velocity[3]);
dragcore_status dragcore_step_scalar_implicit(const double matrix[36], const dragcore_body* body, const dragcore_motion* motion,
                                              const dragcore_wrench* external, double dt, double velocity[3], double angular_velocity[3]);

/* Added mass about the centre of an ellipsoid with semi-axes along the body's, for dragcore_body: added_mass() in dragcore/fluid_terms.hpp.
 * A sheet is about an ellipsoid of its area with one short semi-axis. */
dragcore_status dragcore_ellipsoid_added_mass(const double semi_axes[3], double density, double matrix[36]);

/* Spin after dt by inertia alone: gyroscopic_spin() in dragcore/stepping.hpp. Replace motion.angular_velocity with it before
 * dragcore_resistance(). */
dragcore_status dragcore_gyroscopic_spin(const dragcore_body* body, const double angular_velocity[3], double dt, double spin[3]);

/* Where motion.wind_gradient is not zero: what the matrix misses of the wrench that dragcore_evaluate() gives, to be added to `external` of
 * the steps. */
dragcore_status dragcore_wind_excess(const dragcore_wrench* wrench, const double matrix[36], const dragcore_motion* motion,
                                     dragcore_wrench* excess);

/* Share in [0, 1] of the impulse dt * wrench that may be applied: impulse_share(). */
dragcore_status dragcore_impulse_share(const dragcore_wrench* wrench, const dragcore_body* body, const dragcore_motion* motion, double dt,
                                       double* share);

/* Many bodies at once: wrenches() and step_free_bodies() of dragcore/batch.hpp. Sixteen of one small shape cost little more than one, so
 * bodies had better share their surface and model. `results` and `velocities` (velocity, then angular velocity, of each) have room for all.
 */
typedef struct dragcore_body_in_flow {
  const dragcore_surface* surface;
  const dragcore_model* model;
  dragcore_motion motion;
} dragcore_body_in_flow;

dragcore_status dragcore_evaluate_many(const dragcore_body_in_flow* bodies, size_t count, double density, dragcore_wrench* results);

typedef struct dragcore_free_body {
  const dragcore_surface* surface;
  const dragcore_model* model;
  const dragcore_body* body;
  dragcore_motion motion;
  dragcore_wrench external; /* what else acts, body frame */
} dragcore_free_body;

/* What dragcore_gyroscopic_spin(), dragcore_resistance() and dragcore_step_secant_implicit() do one after the other, with what
 * dragcore_wind_excess() says. */
dragcore_status dragcore_step_free_bodies(const dragcore_free_body* bodies, size_t count, double density, double dt, double* velocities);

/* Meshes whose vertices move each by itself, cloth: class DeformingMesh in dragcore/deforming.hpp. World frame. One object is one piece of
 * cloth, for one thread at a time. */
typedef struct dragcore_deforming dragcore_deforming;

/* triangles: 3 * triangle_count indices below vertex_count, copied. sides: DRAGCORE_TWO_SIDED, sheets, or DRAGCORE_ONE_SIDED, skins of
 * inflated bodies. *mesh is to be given to dragcore_deforming_destroy(), and is NULL after an error. */
dragcore_status dragcore_deforming_create(const int* triangles, size_t triangle_count, size_t vertex_count, int sides,
                                          dragcore_deforming** mesh);
void dragcore_deforming_destroy(dragcore_deforming* mesh); /* NULL is allowed */

/* A vector of every vertex, x y z, where the engine keeps it. */
typedef struct dragcore_vertex_vectors {
  const float* first; /* x of the first vertex */
  size_t stride;      /* from one x to the next, in numbers: 3 where they lie side by side */
} dragcore_vertex_vectors;

typedef struct dragcore_deforming_motion {
  dragcore_vertex_vectors position;    /* [m] */
  dragcore_vertex_vectors velocity;    /* [m/s] */
  double wind[3];                      /* velocity of the undisturbed air [m/s] */
  dragcore_vertex_vectors vertex_wind; /* the same at each vertex, in place of it; first = NULL: not used */
} dragcore_deforming_motion;           /* set all of it to zero first */

/* Force of the air on every vertex [N], written over what is there, `force_stride` numbers from one x to the next; untouched after an
 * error. law: with aspect_gain, recovery, shelter and curvature 0, "sheet" above all. */
dragcore_status dragcore_deforming_forces(dragcore_deforming* mesh, const dragcore_deforming_motion* motion, double density,
                                          const dragcore_law* law, float* force, size_t force_stride);

/* Wind fields of the world: the sum of any number of sources. What a dragcore_wind* is used for may run on many threads at once, but not
 * beside a function that changes it. Velocities are those of the undisturbed air. */
dragcore_status dragcore_wind_create(dragcore_wind** wind); /* still air; to be given to dragcore_wind_destroy() */
void dragcore_wind_destroy(dragcore_wind* wind);            /* NULL is allowed */

/* Where a source lies, x_world = position + to_world (scale * x_field), and how strong it is: Placement and WindSource in
 * dragcore/wind.hpp. */
typedef struct dragcore_placement {
  double position[3]; /* [m] */
  double to_world[9]; /* a rotation */
  double scale[3];    /* per axis of the field, negative mirrors, never 0 */
  double intensity;   /* factor on the velocity */
  double fade_radius; /* where it has faded to zero; 0: it does not fade [m] */
} dragcore_placement;
dragcore_placement dragcore_no_placement(void); /* at the origin, not turned, scale and intensity 1; what NULL stands for below */

dragcore_status dragcore_wind_add_uniform(dragcore_wind* wind, const double velocity[3], const dragcore_placement* placement);
/* About the z axis, right-handed: circulation [m^2/s], core_radius [m]. */
dragcore_status dragcore_wind_add_vortex(dragcore_wind* wind, double circulation, double core_radius, const dragcore_placement* placement);
/* From a nozzle at the origin along +x: exit_speed [m/s], diameter [m]. */
dragcore_status dragcore_wind_add_jet(dragcore_wind* wind, double exit_speed, double diameter, const dragcore_placement* placement);

typedef struct dragcore_grid {
  int points[3];             /* per axis, at least 1 */
  double lower[3], upper[3]; /* first and last point [m] */
  const double* values;      /* copied; x y z of the velocity at every point, x fastest: 3 ((k ny + j) nx + i) [m/s] */
  int clamp;                 /* outside the box: 0 nothing, 1 the value of its nearest point */
} dragcore_grid;
dragcore_status dragcore_wind_add_grid(dragcore_wind* wind, const dragcore_grid* grid, const dragcore_placement* placement);

typedef struct dragcore_dryden {
  unsigned long long seed;
  double intensity[3]; /* standard deviations along the mean wind, to its starboard, up [m/s] */
  double length[3];    /* scale lengths of the three [m] */
  double mean_wind[3]; /* carries the eddies past; not part of the field: add a uniform one [m/s] */
  int waves;           /* multiple of 3; 0: the default of dragcore/turbulence.hpp */
} dragcore_dryden;
dragcore_status dragcore_wind_add_turbulence(dragcore_wind* wind, const dragcore_dryden* dryden, const dragcore_placement* placement);

/* Turbulence moves with time [s]; gusts are intensities that change. Sources count from 0 in the order in which they were added. */
dragcore_status dragcore_wind_set_time(dragcore_wind* wind, double time);
dragcore_status dragcore_wind_set_intensity(dragcore_wind* wind, size_t source, double intensity);
/* (1 - cos)/2 between start and start + duration, 0 outside: for the intensity of a source that is a gust. */
dragcore_status dragcore_gust_factor(double time, double start, double duration, double* factor);

/* gradient: entry 3 i + j, change of component i along axis j [1/s]. NULL: not wanted. */
dragcore_status dragcore_wind_sample(const dragcore_wind* wind, const double point[3], double velocity[3], double gradient[9]);

/* What a body at position, turned by to_world, meets about motion->reference_point: sets wind, wind_gradient and triangle_wind of a motion,
 * in the body frame, with the cheapest sampling within tolerance [m/s]. triangle_wind: room for 3 * dragcore_surface_triangles() numbers,
 * which must live as long as the motion is used; NULL: no more than a gradient is wanted, whatever the tolerance. BodyWind in
 * dragcore/body_wind.hpp. */
dragcore_status dragcore_wind_over_body(const dragcore_wind* wind, const dragcore_surface* surface, const double position[3],
                                        const double to_world[9], double tolerance, double* triangle_wind, dragcore_motion* motion);

/* The question to dragcore_required_effects(): struct Scene in dragcore/required_effects.hpp. Set all of it to zero first. */
typedef struct dragcore_scene {
  const dragcore_surface* surface;
  const dragcore_motion* motion; /* with the largest relative speed and spin to expect */
  const dragcore_model* model;
  double density;            /* of the air [kg/m^3] */
  int held;                  /* 0: the air moves the body; 1: it always moves as in `motion` */
  const dragcore_wind* wind; /* looked at around `place`; NULL: none but that of the motion */
  double place[3];           /* of the surface's middle in the world [m] */
  const dragcore_body* body; /* for added mass; NULL: not judged */
  double viscosity;          /* dynamic; 0: that of air [Pa s] */
  double tolerance;          /* share of force and torque that leaving an effect out may cost; 0: 0.01 */
} dragcore_scene;

typedef struct dragcore_needs {
  unsigned effects;                 /* for dragcore_model.effects */
  int wind_sampling;                /* 0: one velocity for the body, 1: a gradient too, 2: one per triangle */
  double force_scale, torque_scale; /* of which the tolerance is a share [N], [N m] */
} dragcore_needs;

/* Which effects a scene calls for: ask once for a kind of body, not every frame. text: a line for each effect with the reason, as many
 * whole lines as `size` bytes hold; NULL: not wanted. */
dragcore_status dragcore_required_effects(const dragcore_scene* scene, dragcore_needs* needs, char* text, size_t size);

/* Looks for values that are possible but usually mistakes: units, frames, reference points, speeds, density: dragcore/diagnose.hpp. *count:
 * how many were found; text: a sentence on each, as above. to_world and world_velocity, of the reference point: to check the motion
 * against, or NULL. */
dragcore_status dragcore_diagnose(const dragcore_surface* surface, const dragcore_motion* motion, double density, const double to_world[9],
                                  const double world_velocity[3], size_t* count, char* text, size_t size);

/* Message of the last error on this thread, its first 511 bytes; "" if there was none. Never NULL; it stands in a buffer of the thread,
 * which the next call on this thread writes over. */
const char* dragcore_last_error(void);

#ifdef __cplusplus
}
#endif

#endif
