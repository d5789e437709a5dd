/* A C program: compiles the header as C99 and drives the library through it. */
#include <dragcore/dragcore.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int failures = 0;
static void check(int good, const char* what) {
  if (!good) {
    printf("FAILED: %s (last error: \"%s\")\n", what, dragcore_last_error());
    ++failures;
  }
}

static int says(const char* words) { return strstr(dragcore_last_error(), words) != NULL; }

static void baked_bodies(void) {
  dragcore_mesh* mesh = NULL;
  dragcore_surface* surface = NULL;
  dragcore_baked* baked = NULL;
  dragcore_model model;
  dragcore_motion motion;
  dragcore_wrench exact, map;
  dragcore_bake_error straight, spinning[3];
  double matrix[36], wind[3] = {1, 0, 0};
  size_t bytes = 0;
  int fresh = 0, i;

  memset(&motion, 0, sizeof motion);
  motion.wind[0] = 10, motion.wind[2] = 3;
  check(dragcore_mesh_box(2, 1, 0.5, 1, &mesh) == DRAGCORE_OK &&
            dragcore_surface_from_mesh(mesh, DRAGCORE_SIDES_AUTOMATIC, &surface) == DRAGCORE_OK &&
            dragcore_model_for(surface, &model) == DRAGCORE_OK,
        "a box to bake");
  check(dragcore_bake(surface, &model, 0.01, 65536, &baked) == DRAGCORE_OK, "it is baked");
  check(dragcore_baked_errors(baked, &bytes, &straight, spinning) == DRAGCORE_OK && bytes <= 65536 && straight.rms_force <= 0.01 &&
            spinning[2].rms_force > straight.rms_force,
        "and says how well");
  check(dragcore_evaluate(surface, &motion, 1.2, &model, &exact) == DRAGCORE_OK &&
            dragcore_baked_wrench(baked, &motion, 1.2, &map) == DRAGCORE_OK &&
            fabs(map.force[0] - exact.force[0]) < 3 * straight.worst_force * exact.force[0],
        "the map has the drag of the mesh");
  check(dragcore_baked_resistance(baked, &motion, 1.2, matrix) == DRAGCORE_OK, "its matrix can be had");
  for (i = 0; i < 3; ++i)
    check(fabs(matrix[6 * i] * 10 + matrix[6 * i + 2] * 3 - map.force[i]) < 1e-9 * fabs(map.force[0]), "and makes the force");
  check(dragcore_baked_matches(baked, surface, &model, &fresh) == DRAGCORE_OK && fresh == 1, "it is fresh");
  model.law.friction += 0.01;
  check(dragcore_baked_matches(baked, surface, &model, &fresh) == DRAGCORE_OK && fresh == 0, "until the law is another");
  motion.triangle_wind = wind;
  check(dragcore_baked_wrench(baked, &motion, 1.2, &map) == DRAGCORE_INVALID_ARGUMENT && says("triangle_wind"), "it knows no triangles");
  dragcore_baked_destroy(baked);
  check(dragcore_bake(surface, &model, 1e-6, 65536, &baked) == DRAGCORE_INVALID_ARGUMENT && baked == NULL && says("allow more bytes"),
        "what cannot be is refused");
  check(dragcore_baked_wrench(NULL, &motion, 1.2, &map) == DRAGCORE_INVALID_ARGUMENT, "so is NULL");
  dragcore_baked_destroy(NULL);
  dragcore_surface_destroy(surface);
  dragcore_mesh_destroy(mesh);
}

static void meshes_and_masses(void) {
  dragcore_mesh* mesh = NULL;
  dragcore_surface* surface = NULL;
  dragcore_body body;
  size_t vertices = 0, triangles = 0, felt = 0;
  double centre[3] = {9, 9, 9}, corners[24], aside[3] = {1, 0, 0};
  int indices[36], i;

  check(dragcore_mesh_box(2, 1, 0.5, 1, &mesh) == DRAGCORE_OK, "a box can be made");
  check(dragcore_mesh_size(mesh, &vertices, &triangles) == DRAGCORE_OK && vertices == 8 && triangles == 12,
        "of 8 corners and 12 triangles");
  check(dragcore_mesh_copy(mesh, corners, indices) == DRAGCORE_OK && fabs(fabs(corners[0]) - 1) + fabs(fabs(corners[23]) - 0.25) < 1e-15,
        "its corners can be had");
  check(dragcore_mesh_copy(mesh, NULL, NULL) == DRAGCORE_OK, "or not");
  check(dragcore_mass_properties(mesh, 500, &body, centre) == DRAGCORE_OK && fabs(body.mass - 500) < 1e-9,
        "a box of 1 m^3 has the mass of its density");
  check(fabs(body.inertia[0] - 500.0 / 12 * 1.25) + fabs(body.inertia[4] - 500.0 / 12 * 4.25) + fabs(body.inertia[1]) < 1e-9,
        "and the inertia of its formula");
  check(fabs(centre[0]) + fabs(centre[1]) + fabs(centre[2]) < 1e-14 && body.added_mass[0] == 0, "about its middle");
  check(dragcore_mesh_recentre(mesh, aside) == DRAGCORE_OK && dragcore_mass_properties(mesh, 500, &body, centre) == DRAGCORE_OK &&
            fabs(centre[0] + 1) < 1e-14,
        "about another point it lies aside");
  check(dragcore_mesh_recentre(mesh, NULL) == DRAGCORE_OK && dragcore_mass_properties(mesh, 500, &body, centre) == DRAGCORE_OK &&
            fabs(centre[0]) < 1e-14,
        "and comes back to its centroid");
  check(dragcore_sheet_mass_properties(mesh, 2, &body, NULL) == DRAGCORE_OK && fabs(body.mass - 14) < 1e-12, "as a skin it has 7 m^2");
  check(dragcore_mass_properties(mesh, -1, &body, NULL) == DRAGCORE_INVALID_ARGUMENT && says("density = -1"), "no negative density");
  check(dragcore_surface_from_mesh(mesh, DRAGCORE_SIDES_AUTOMATIC, &surface) == DRAGCORE_OK &&
            dragcore_surface_triangles(surface, &felt) == DRAGCORE_OK && felt == 12,
        "a surface is made of it");
  dragcore_surface_destroy(surface);
  dragcore_mesh_destroy(mesh);
  check(dragcore_mesh_create(corners, 8, indices, 11, &mesh) == DRAGCORE_OK, "a mesh of arrays");
  check(dragcore_mass_properties(mesh, 500, &body, NULL) == DRAGCORE_INVALID_ARGUMENT && says("close the holes"),
        "with a hole has no volume");
  dragcore_mesh_destroy(mesh);
  indices[4] = 8;
  check(dragcore_mesh_create(corners, 8, indices, 12, &mesh) == DRAGCORE_INVALID_ARGUMENT && mesh == NULL && says("vertex 8"),
        "a corner that is not there is named");
  for (i = 0; i < 7; ++i) {
    const dragcore_status status = i == 0   ? dragcore_mesh_plate(1, 2, 0, 2, &mesh)
                                   : i == 1 ? dragcore_mesh_cone(1, 1, 4, &mesh)
                                   : i == 2 ? dragcore_mesh_sphere(1, 4, &mesh)
                                   : i == 3 ? dragcore_mesh_cylinder(1, 2, 4, &mesh)
                                   : i == 4 ? dragcore_mesh_ellipsoid(1, 2, 3, 4, &mesh)
                                   : i == 5 ? dragcore_mesh_teardrop(1, 2, 4, &mesh)
                                            : dragcore_mesh_prism(1, 2, 1, 2, &mesh);
    const double volume[] = {0, 0.2396, 0.5236, 1.5708, 25.133, 0.6981, 0.9152}; /* by their formulas */
    check(status == DRAGCORE_OK, "every shape can be made");
    check(dragcore_mass_properties(mesh, 1, &body, NULL) == (i == 0 ? DRAGCORE_INVALID_ARGUMENT : DRAGCORE_OK),
          "and but for the sheet is a solid");
    check(i == 0 || fabs(body.mass / volume[i] - 1) < 0.1, "of its volume, less what sixteen chords cut off a circle");
    dragcore_mesh_destroy(mesh);
  }
  check(dragcore_mesh_sphere(-1, 4, &mesh) == DRAGCORE_INVALID_ARGUMENT && mesh == NULL && says("diameter = -1"),
        "no ball of negative diameter");
  check(dragcore_mesh_sphere(1, 4, NULL) == DRAGCORE_INVALID_ARGUMENT && says("mesh is NULL"), "nor without a place for it");
  dragcore_mesh_destroy(NULL);
}

/* A square of cloth whose corners are an engine's vertices, position, velocity and force in one structure, broadside in the wind. */
static void cloth(void) {
  typedef struct vertex {
    float position[3], velocity[3], force[3];
  } vertex;
  vertex corners[4] = {{{0, 0, 0}, {0}, {0}}, {{1, 0, 0}, {0}, {0}}, {{1, 1, 0}, {0}, {0}}, {{0, 1, 0}, {0}, {0}}};
  const int triangles[] = {0, 1, 2, 0, 2, 3};
  const size_t stride = sizeof(vertex) / sizeof(float);
  const float winds[12] = {0, 0, 2, 0, 0, 2, 0, 0, 2, 0, 0, 2};
  dragcore_deforming* mesh = NULL;
  dragcore_deforming_motion motion;
  dragcore_law law;
  double total = 0;
  int i;
  memset(&motion, 0, sizeof motion);
  motion.position.first = corners[0].position, motion.position.stride = stride;
  motion.velocity.first = corners[0].velocity, motion.velocity.stride = stride;
  motion.wind[2] = 4;

  check(dragcore_named_law("note", &law) == DRAGCORE_OK, "the note's law");
  check(dragcore_deforming_create(triangles, 2, 4, DRAGCORE_TWO_SIDED, &mesh) == DRAGCORE_OK && mesh, "a cloth is made");
  check(dragcore_deforming_forces(mesh, &motion, 1.2, &law, corners[0].force, stride) == DRAGCORE_OK, "and feels the air");
  for (i = 0; i < 4; ++i) total += corners[i].force[2];
  check(fabs(total - 0.5 * 1.2 * 16) < 1e-5, "broadside, C_N = 1"); /* float */
  check(fabs(corners[0].force[2] - total / 3) < 1e-5 && fabs(corners[1].force[2] - total / 6) < 1e-5, "by how many triangles meet");
  motion.vertex_wind.first = winds, motion.vertex_wind.stride = 3;
  check(dragcore_deforming_forces(mesh, &motion, 1.2, &law, corners[0].force, stride) == DRAGCORE_OK &&
            fabs(corners[0].force[2] - total / 12) < 1e-5,
        "of half the wind a quarter");

  corners[2].position[1] = (float)HUGE_VAL;
  check(dragcore_deforming_forces(mesh, &motion, 1.2, &law, corners[0].force, stride) == DRAGCORE_INVALID_ARGUMENT &&
            says("position of vertex 2") && fabs(corners[0].force[2] - total / 12) < 1e-5,
        "a place that is none is named, and forces stay");
  corners[2].position[1] = 1;
  check(
      dragcore_deforming_forces(mesh, &motion, 1.2, &law, corners[0].force, 2) == DRAGCORE_INVALID_ARGUMENT && says("stride of force = 2"),
      "no vectors of two numbers");
  check(dragcore_deforming_forces(mesh, &motion, 1.2, &law, NULL, 3) == DRAGCORE_INVALID_ARGUMENT && says("force is null"), "none nowhere");
  check(dragcore_deforming_forces(mesh, NULL, 1.2, &law, corners[0].force, stride) == DRAGCORE_INVALID_ARGUMENT && says("motion is NULL"),
        "nor without a motion");
  check(dragcore_named_law("closed", &law) == DRAGCORE_OK &&
            dragcore_deforming_forces(mesh, &motion, 1.2, &law, corners[0].force, stride) == DRAGCORE_INVALID_ARGUMENT &&
            says("sheet_law()"),
        "nor by the law of bodies");
  dragcore_deforming_destroy(mesh);
  check(dragcore_deforming_create(triangles, 2, 3, DRAGCORE_TWO_SIDED, &mesh) == DRAGCORE_INVALID_ARGUMENT && !mesh &&
            says("vertex of triangle 1 = 3"),
        "a vertex that is not there is named");
  check(dragcore_deforming_create(triangles, 2, 4, 7, &mesh) == DRAGCORE_INVALID_ARGUMENT && says("sides = 7"), "no seventh side");
  dragcore_deforming_destroy(NULL);
}

/* A cube and, three metres beside it, a sheet: each has its own law, in either precision. */
static void bodies_and_sheets(void) {
  dragcore_mesh *cube = NULL, *plate = NULL, *both = NULL;
  dragcore_surface *surface = NULL, *cube_alone = NULL, *plate_alone = NULL;
  dragcore_model model, own;
  dragcore_motion motion = {{0}, {0}, {0}, {0}, {0}, NULL, 0};
  dragcore_wrench wrench, expected, part;
  double corners[3 * (8 + 4)];
  int indices[3 * (12 + 2)], i;

  motion.wind[2] = 10.0;
  check(dragcore_mesh_box(1, 1, 1, 1, &cube) == DRAGCORE_OK && dragcore_mesh_plate(0.5, 4, 0, 1, &plate) == DRAGCORE_OK, "two shapes");
  check(dragcore_mesh_copy(cube, corners, indices) == DRAGCORE_OK && dragcore_mesh_copy(plate, corners + 24, indices + 36) == DRAGCORE_OK,
        "in one pair of arrays");
  for (i = 24; i < 36; i += 3) corners[i] += 3.0;
  for (i = 36; i < 42; ++i) indices[i] += 8;
  check(dragcore_mesh_create(corners, 12, indices, 14, &both) == DRAGCORE_OK &&
            dragcore_surface_from_mesh(both, DRAGCORE_SIDES_AUTOMATIC, &surface) == DRAGCORE_OK &&
            dragcore_surface_from_mesh(cube, DRAGCORE_SIDES_AUTOMATIC, &cube_alone) == DRAGCORE_OK &&
            dragcore_surface_from_mesh(plate, DRAGCORE_SIDES_AUTOMATIC, &plate_alone) == DRAGCORE_OK,
        "and as one body");
  check(dragcore_model_for(surface, &model) == DRAGCORE_OK && model.sheets == 1 && model.precision == DRAGCORE_PRECISION_SINGLE,
        "its model knows of sheets");
  check(dragcore_model_for(cube_alone, &own) == DRAGCORE_OK && own.sheets == 0 &&
            dragcore_evaluate(cube_alone, &motion, 1.2, &own, &expected) == DRAGCORE_OK,
        "the cube alone");
  check(dragcore_model_for(plate_alone, &own) == DRAGCORE_OK && dragcore_evaluate(plate_alone, &motion, 1.2, &own, &part) == DRAGCORE_OK,
        "the sheet alone");
  expected.force[2] += part.force[2];
  for (i = 0; i < 2; ++i) {
    model.precision = i;
    /* The balance of energy is drawn over both together, which moves a thousandth. */
    check(dragcore_evaluate(surface, &motion, 1.2, &model, &wrench) == DRAGCORE_OK && fabs(wrench.force[2] / expected.force[2] - 1) < 1e-3,
          "the force is the sum of both");
  }
  model.precision = 2;
  check(dragcore_evaluate(surface, &motion, 1.2, &model, &wrench) == DRAGCORE_INVALID_ARGUMENT && says("precision = 2"),
        "there are two precisions");
  dragcore_surface_destroy(surface), dragcore_surface_destroy(cube_alone), dragcore_surface_destroy(plate_alone);
  dragcore_mesh_destroy(cube), dragcore_mesh_destroy(plate), dragcore_mesh_destroy(both);
}

static void winds(void) {
  const double along[3] = {4, 0, 0}, point[3] = {0, 2, 0}, identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, up[9] = {1, 0, 0, 0, 0, -1, 0, 1, 0};
  double velocity[3], gradient[9], values[6] = {0, 0, 0, 6, 0, 0}, *per_triangle, factor = -1;
  dragcore_wind* wind = NULL;
  dragcore_mesh* mesh = NULL;
  dragcore_surface* surface = NULL;
  dragcore_placement placement = dragcore_no_placement();
  dragcore_grid grid = {{2, 1, 1}, {0, -1, -1}, {3, 1, 1}, NULL, 0};
  dragcore_dryden dryden = {7, {1, 1, 1}, {10, 10, 10}, {5, 0, 0}, 0};
  dragcore_model model = dragcore_note_model();
  dragcore_motion motion;
  dragcore_wrench affine, exact, still;
  size_t count = 0;

  check(dragcore_wind_create(&wind) == DRAGCORE_OK && dragcore_wind_sample(wind, point, velocity, gradient) == DRAGCORE_OK &&
            velocity[0] == 0,
        "air is still at first");
  check(dragcore_wind_add_uniform(wind, along, NULL) == DRAGCORE_OK, "a uniform wind");
  check(dragcore_wind_add_vortex(wind, 2 * 3.14159265358979323846 * 2 * 3, 1e-3, NULL) == DRAGCORE_OK, "and a vortex");
  check(dragcore_wind_sample(wind, point, velocity, gradient) == DRAGCORE_OK && fabs(velocity[0] - 1) < 1e-12 &&
            fabs(gradient[1] - 1.5) < 1e-9,
        "at 2 m above it takes 3 m/s, and falls off with 1/r");
  check(dragcore_wind_set_intensity(wind, 1, 0.0) == DRAGCORE_OK && dragcore_wind_sample(wind, point, velocity, NULL) == DRAGCORE_OK &&
            velocity[0] == 4,
        "it can be switched off");
  check(dragcore_wind_set_intensity(wind, 2, 0.0) == DRAGCORE_INVALID_ARGUMENT && says("source = 2"), "what is not there can not");
  grid.values = values;
  check(dragcore_wind_add_grid(wind, &grid, NULL) == DRAGCORE_OK, "a grid");
  {
    const double inside[3] = {1, 0, 0};
    check(dragcore_wind_sample(wind, inside, velocity, gradient) == DRAGCORE_OK && fabs(velocity[0] - 6) < 1e-12 &&
              fabs(gradient[0] - 2) < 1e-12,
          "is interpolated");
  }
  grid.points[1] = 0;
  check(dragcore_wind_add_grid(wind, &grid, NULL) == DRAGCORE_INVALID_ARGUMENT && says("2 x 0 x 1"), "an empty grid is refused");
  memcpy(placement.to_world, up, sizeof up); /* a quarter turn about x takes the field's y to z */
  placement.position[0] = 100;
  placement.intensity = 2;
  check(dragcore_wind_add_jet(wind, 10, 1, &placement) == DRAGCORE_OK, "a jet elsewhere");
  {
    const double nozzle[3] = {100, 0, 0};
    check(dragcore_wind_sample(wind, nozzle, velocity, NULL) == DRAGCORE_OK && fabs(velocity[0] - 24) < 1e-9, "of twice the speed");
  }
  placement.to_world[0] = 2;
  check(dragcore_wind_add_uniform(wind, along, &placement) == DRAGCORE_INVALID_ARGUMENT, "a placement that is no rotation is refused");
  check(dragcore_wind_sample(wind, point, velocity, NULL) == DRAGCORE_OK && fabs(velocity[0] - 4) < 1e-9, "and leaves the wind as it was");
  check(dragcore_wind_add_turbulence(wind, &dryden, NULL) == DRAGCORE_OK &&
            dragcore_wind_sample(wind, point, velocity, NULL) == DRAGCORE_OK && velocity[1] != 0,
        "turbulence");
  {
    double later[3];
    check(dragcore_wind_set_time(wind, 1.0) == DRAGCORE_OK && dragcore_wind_sample(wind, point, later, NULL) == DRAGCORE_OK &&
              later[1] != velocity[1],
          "moves with time");
  }
  dryden.waves = 4;
  check(dragcore_wind_add_turbulence(wind, &dryden, NULL) == DRAGCORE_INVALID_ARGUMENT && says("waves"), "waves come in threes");
  dragcore_wind_destroy(wind);

  /* A body in a vortex: what is exact differs from an affine wind, and that from a uniform one. */
  check(dragcore_mesh_box(1, 1, 1, 2, &mesh) == DRAGCORE_OK &&
            dragcore_surface_from_mesh(mesh, DRAGCORE_SIDES_AUTOMATIC, &surface) == DRAGCORE_OK &&
            dragcore_surface_triangles(surface, &count) == DRAGCORE_OK,
        "a body");
  per_triangle = malloc(3 * count * sizeof *per_triangle);
  memset(&motion, 0, sizeof motion);
  check(dragcore_wind_create(&wind) == DRAGCORE_OK && dragcore_wind_add_vortex(wind, 40, 0.5, NULL) == DRAGCORE_OK, "and a vortex");
  check(dragcore_wind_over_body(wind, surface, point, identity, 1e6, per_triangle, &motion) == DRAGCORE_OK &&
            motion.triangle_wind == NULL && dragcore_evaluate(surface, &motion, 1.2, &model, &still) == DRAGCORE_OK,
        "whatever the error, one velocity will do");
  check(dragcore_wind_over_body(wind, surface, point, identity, 1e-3, NULL, &motion) == DRAGCORE_OK && motion.triangle_wind == NULL &&
            motion.wind_gradient[1] != 0 && dragcore_evaluate(surface, &motion, 1.2, &model, &affine) == DRAGCORE_OK,
        "without room, a gradient");
  check(dragcore_wind_over_body(wind, surface, point, identity, 1e-3, per_triangle, &motion) == DRAGCORE_OK &&
            motion.triangle_wind == per_triangle && dragcore_evaluate(surface, &motion, 1.2, &model, &exact) == DRAGCORE_OK,
        "with room, one per triangle");
  check(fabs(still.torque[2]) < 1e-9 && fabs(affine.torque[2]) > 0.1 && fabs(exact.torque[2] - affine.torque[2]) > 1e-3 &&
            fabs(exact.force[0] / still.force[0] - 1) < 0.5,
        "which all have their own torque");
  check(dragcore_wind_over_body(wind, surface, point, placement.to_world, 1e-3, per_triangle, &motion) == DRAGCORE_INVALID_ARGUMENT &&
            says("rotation"),
        "a pose that is no rotation");
  check(dragcore_gust_factor(1.5, 1, 1, &factor) == DRAGCORE_OK && factor == 1 && dragcore_gust_factor(3, 1, 1, &factor) == DRAGCORE_OK &&
            factor == 0,
        "a gust comes and goes");
  check(dragcore_gust_factor(1.5, 1, 0, &factor) == DRAGCORE_INVALID_ARGUMENT, "not in no time");

  /* What the scene calls for. */
  {
    dragcore_scene scene;
    dragcore_needs needs;
    char text[4000], little[100];
    memset(&scene, 0, sizeof scene);
    memset(&motion, 0, sizeof motion);
    motion.velocity[0] = 10;
    scene.surface = surface;
    scene.motion = &motion;
    scene.model = &model;
    scene.density = 1.2;
    scene.held = 1;
    check(dragcore_required_effects(&scene, &needs, text, sizeof text) == DRAGCORE_OK && needs.effects == 0 && needs.wind_sampling == 0,
          "held in a steady wind nothing is needed");
    check(strstr(text, "spin: not needed; ") != NULL && text[strlen(text) - 1] == '\n', "each with its reason, line by line");
    check(fabs(needs.force_scale - 0.5 * 1.2 * 100 * 6 / 4) < 1e-9, "a cube's mean projected area is a quarter of its surface");
    scene.held = 0;
    scene.wind = wind;
    scene.place[1] = 2;
    check(dragcore_required_effects(&scene, &needs, little, sizeof little) == DRAGCORE_OK && needs.effects != 0 && needs.wind_sampling == 2,
          "let go in a vortex some are");
    check(strlen(little) < sizeof little && (little[0] == '\0' || little[strlen(little) - 1] == '\n'), "little room holds whole lines");
    scene.tolerance = -1;
    check(dragcore_required_effects(&scene, &needs, NULL, 0) == DRAGCORE_INVALID_ARGUMENT && says("tolerance"), "no negative tolerance");
  }

  /* What looks like a mistake. */
  {
    const double turned[9] = {0, -1, 0, 1, 0, 0, 0, 0, 1}, in_world[3] = {0, 10, 0};
    char text[1000];
    check(dragcore_diagnose(surface, &motion, 1.2, NULL, NULL, &count, text, sizeof text) == DRAGCORE_OK && count == 0 && text[0] == '\0',
          "10 m/s is no mistake");
    check(dragcore_diagnose(surface, &motion, 1.2, turned, in_world, &count, text, sizeof text) == DRAGCORE_OK && count == 0,
          "nor seen from a turned frame");
    motion.velocity[0] = -10;
    check(dragcore_diagnose(surface, &motion, 1.2, turned, in_world, &count, text, sizeof text) == DRAGCORE_OK && count == 1 &&
              strstr(text, "transposed") != NULL,
          "the other way round it is");
    motion.velocity[0] = 1000;
    motion.reference_point[2] = 5;
    check(dragcore_diagnose(surface, &motion, 1200, NULL, NULL, &count, text, sizeof text) == DRAGCORE_OK && count == 2 &&
              strstr(text, "Mach 2.9") != NULL && strstr(text, "recentred") != NULL,
          "two mistakes are two lines");
  }
  free(per_triangle);
  dragcore_wind_destroy(wind);
  dragcore_wind_destroy(NULL);
  dragcore_surface_destroy(surface);
  dragcore_mesh_destroy(mesh);
}

/* A message longer than the buffer is cut, not within a character of more than one byte. */
static void long_messages(void) {
  char name[1500];
  dragcore_law law;
  size_t length, shift;
  for (shift = 0; shift < 2; ++shift) {
    memset(name, 'x', shift);
    for (length = shift; length + 2 < sizeof name; length += 2) memcpy(name + length, "\xC3\xA9", 2);
    name[length] = '\0';
    check(dragcore_named_law(name, &law) == DRAGCORE_INVALID_ARGUMENT, "no law has a name of 1500 bytes");
    length = strlen(dragcore_last_error());
    check(length > 500 && length < 512 && (unsigned char)dragcore_last_error()[length - 1] == 0xA9,
          "its message is cut behind a whole character");
  }
}

static void many_bodies(const dragcore_surface* surface) {
  enum { count = 20 };
  dragcore_body_in_flow bodies[count];
  dragcore_free_body free_bodies[count];
  dragcore_wrench found[count], alone;
  dragcore_model model;
  dragcore_body body;
  double velocities[6 * count], s[36], velocity[3], spin[3], wrong = 0;
  int i, k, viscous;
  memset(bodies, 0, sizeof bodies);
  memset(free_bodies, 0, sizeof free_bodies);
  memset(&body, 0, sizeof body);
  body.mass = body.inertia[0] = body.inertia[4] = body.inertia[8] = 1;
  check(dragcore_model_for(surface, &model) == DRAGCORE_OK, "a model for many");
  for (viscous = 0; viscous < 2; ++viscous) {
    for (i = 0; i < count; ++i) {
      bodies[i].surface = free_bodies[i].surface = surface;
      bodies[i].model = free_bodies[i].model = &model;
      bodies[i].motion.velocity[0] = 1 + i;
      bodies[i].motion.velocity[2] = 3;
      bodies[i].motion.viscosity = 0.05 * viscous; /* Re of some hundred */
      bodies[i].motion.angular_velocity[1] = i;
      free_bodies[i].motion = bodies[i].motion;
      free_bodies[i].body = &body;
      free_bodies[i].external.force[2] = -9.81;
    }
    check(dragcore_evaluate_many(bodies, count, 1.2, found) == DRAGCORE_OK, "many bodies at once");
    check(dragcore_step_free_bodies(free_bodies, count, 1.2, 0.01, velocities) == DRAGCORE_OK, "and a step of each");
    for (i = 0; i < count; ++i) {
      dragcore_motion motion = bodies[i].motion;
      check(dragcore_evaluate(surface, &motion, 1.2, &model, &alone) == DRAGCORE_OK, "one by one");
      for (k = 0; k < 3; ++k) wrong = fmax(wrong, fabs(found[i].force[k] - alone.force[k]) + fabs(found[i].torque[k] - alone.torque[k]));
      check(dragcore_gyroscopic_spin(&body, motion.angular_velocity, 0.01, motion.angular_velocity) == DRAGCORE_OK &&
                dragcore_resistance(surface, &motion, 1.2, &model, s) == DRAGCORE_OK &&
                dragcore_step_secant_implicit(s, &body, &motion, &free_bodies[i].external, 0.01, velocity, spin) == DRAGCORE_OK,
            "a step by itself");
      for (k = 0; k < 3; ++k) wrong = fmax(wrong, fabs(velocities[6 * i + k] - velocity[k]) + fabs(velocities[6 * i + 3 + k] - spin[k]));
    }
    check(wrong < 1e-3, "give the same"); /* of forces of 500 N, in single precision: 2e-6 of them */
  }
  bodies[6].motion.viscosity = 0.2;
  check(dragcore_evaluate_many(bodies, count, 1.2, found) == DRAGCORE_INVALID_ARGUMENT && says("motion.viscosity of body 6"),
        "all are in one medium");
  bodies[7].model = NULL;
  check(dragcore_evaluate_many(bodies, count, 1.2, found) == DRAGCORE_INVALID_ARGUMENT && says("model is NULL"), "each has a model");
  check(dragcore_evaluate_many(NULL, 0, 1.2, NULL) == DRAGCORE_OK, "none is none");
  check(dragcore_step_free_bodies(free_bodies, count, 1.2, -1, velocities) == DRAGCORE_INVALID_ARGUMENT && says("dt = -1"),
        "no steps back");
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
  check(dragcore_resistance(sheet, &motion, 1.2, &model, s) == DRAGCORE_OK && fabs(s[14] * 10.0 - 60.0) < 1e-12,
        "the secant matrix gives the same force");

  /* Tilted with the pillow, the force moves forward. */
  motion.wind[0] = 10.0;
  model.pillow = DRAGCORE_PILLOW_TILT;
  model.pillow_factor = 0.8;
  check(dragcore_evaluate(sheet, &motion, 1.2, &model, &wrench) == DRAGCORE_OK && wrench.torque[1] > 0.1,
        "the pillow lifts the leading edge");

  /* Laws by name, the class of a body and what suits it. */
  {
    dragcore_law law;
    dragcore_body_class body_class;
    dragcore_model best;
    check(dragcore_named_law("closed", &law) == DRAGCORE_OK && law.base_suction > 0.0, "the closed law has base suction");
    check(dragcore_surface_class(sheet, &body_class) == DRAGCORE_OK && body_class == DRAGCORE_SHEET, "an open sheet is a sheet");
    check(dragcore_model_for(sheet, &best) == DRAGCORE_OK && best.law.friction > 0.0 && best.pillow == DRAGCORE_PILLOW_TILT,
          "the sheet's model has friction");
    check(best.effects == DRAGCORE_ALL_EFFECTS, "and all effects");
    check(dragcore_evaluate(sheet, &motion, 1.2, &best, &wrench) == DRAGCORE_OK && wrench.force[0] > 0.0, "friction drags the sheet along");
    best.effects = 0;
    check(dragcore_evaluate(sheet, &motion, 1.2, &best, &wrench) == DRAGCORE_OK && fabs(wrench.force[0]) < 1e-12,
          "not with the effect off");
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
    check(dragcore_step_secant_implicit(s, &paper, &motion, &nothing, 10.0, velocity, spin) == DRAGCORE_OK && velocity[2] > 9.0 &&
              velocity[2] < 10.0,
          "an implicit step");
    check(dragcore_step_scalar_implicit(s, &paper, &motion, &nothing, 10.0, velocity, spin) == DRAGCORE_OK && velocity[2] > 0.0 &&
              velocity[2] < 10.0,
          "a scalar one");
    check(dragcore_evaluate(sheet, &motion, 1.2, &model, &wrench) == DRAGCORE_OK, "wrench for the impulse");
    check(dragcore_impulse_share(&wrench, &paper, &motion, 10.0, &share) == DRAGCORE_OK && share > 0.0 && share < 0.01,
          "an impulse is cut down");
    check(dragcore_force_jacobian(sheet, &motion, 1.2, &model, jacobian) == DRAGCORE_OK && fabs(jacobian[14] + 12.0) < 1e-9,
          "d force / d velocity = -2 F/U");
    check(dragcore_ellipsoid_added_mass(ellipsoid, 1.2, paper.added_mass) == DRAGCORE_OK &&
              fabs(paper.added_mass[14] / (8.0 / 3 * 1.2 * 0.56 * 0.56 * 0.56) - 1) < 0.01,
          "a thin ellipsoid carries as much air as a disc");
    check(dragcore_step_secant_implicit(s, &paper, &motion, &nothing, 0.01, velocity, spin) == DRAGCORE_OK && velocity[2] > 0.0 &&
              velocity[2] < 3.0,
          "and starts slowly with it");
    {
      const double turning[3] = {3, 4, 5};
      dragcore_wrench excess;
      check(dragcore_gyroscopic_spin(&paper, turning, 0.01, spin) == DRAGCORE_OK && fabs(spin[2] - 5) < 1e-6 && spin[0] > 3.05,
            "spin goes on by inertia");
      check(dragcore_evaluate(sheet, &motion, 1.2, &model, &wrench) == DRAGCORE_OK &&
                dragcore_resistance(sheet, &motion, 1.2, &model, s) == DRAGCORE_OK &&
                dragcore_wind_excess(&wrench, s, &motion, &excess) == DRAGCORE_OK && fabs(excess.force[2]) < 1e-9,
            "nothing is missing in a uniform wind");
    }
    check(dragcore_step_secant_implicit(s, &paper, &motion, &nothing, -1.0, velocity, spin) == DRAGCORE_INVALID_ARGUMENT,
          "no step back in time");
  }

  many_bodies(sheet);
  check(dragcore_evaluate(NULL, &motion, 1.2, &model, &wrench) == DRAGCORE_INVALID_ARGUMENT, "no surface");
  check(dragcore_last_error()[0] != '\0', "the last error is kept");
  check(dragcore_evaluate(sheet, &motion, 1.2, &model, &wrench) == DRAGCORE_OK && dragcore_last_error()[0] == '\0',
        "until the next success");
  check(dragcore_evaluate(sheet, &motion, -1.0, &model, &wrench) == DRAGCORE_INVALID_ARGUMENT, "a negative density is refused");
  check(strstr(dragcore_last_error(), "density") != NULL, "by name");
  model.quadrature = 2;
  check(dragcore_evaluate(sheet, &motion, 1.2, &model, &wrench) == DRAGCORE_INVALID_ARGUMENT, "two points are refused");
  check(dragcore_evaluate(NULL, &motion, 1.2, &model, &wrench) == DRAGCORE_INVALID_ARGUMENT, "so is NULL");
  dragcore_surface_destroy(sheet);

  {
    const int wild[] = {0, 1, 7};
    check(dragcore_surface_create(vertices, 4, triangles, 2, 3, &sheet) == DRAGCORE_INVALID_ARGUMENT &&
              strstr(dragcore_last_error(), "sides = 3") != NULL,
          "no third side");
    check(dragcore_surface_create(vertices, 4, wild, 1, DRAGCORE_TWO_SIDED, &sheet) == DRAGCORE_INVALID_ARGUMENT && sheet == NULL,
          "an index out of range is refused");
    check(strstr(dragcore_last_error(), "vertex 7") != NULL, "and named");
  }
  dragcore_surface_destroy(NULL);
  baked_bodies();
  meshes_and_masses();
  cloth();
  bodies_and_sheets();
  winds();
  long_messages();
  printf("%s\n", failures ? "the C interface is broken" : "the C interface holds");
  return failures != 0;
}
