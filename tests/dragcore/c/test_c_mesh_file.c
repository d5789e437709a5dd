/* The reader of mesh files, from C. */
#include <dragcore/dragcore_mesh_file.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

int main(int count, char** arguments) {
  const char* file = count > 1 ? arguments[1] : "test_c_mesh_file.obj";
  dragcore_mesh* mesh = NULL;
  dragcore_body body;
  double centre[3];
  int good;
  FILE* out = fopen(file, "w");
  if (!out) return 1;
  /* A tetrahedron of 1 m^3 / 6, in millimetres. */
  fputs("v 0 0 0\nv 1000 0 0\nv 0 1000 0\nv 0 0 1000\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n", out);
  fclose(out);
  good = dragcore_mesh_read(file, 0.001, &mesh) == DRAGCORE_OK && dragcore_mass_properties(mesh, 6, &body, centre) == DRAGCORE_OK &&
         fabs(body.mass - 1) < 1e-6 && fabs(centre[0] - 0.25) < 1e-6; /* single precision */
  if (!good) printf("FAILED: a tetrahedron is read (%s)\n", dragcore_last_error());
  dragcore_mesh_destroy(mesh);
  remove(file);
  if (dragcore_mesh_read(file, 1.0, &mesh) != DRAGCORE_FAILED || mesh != NULL || !strstr(dragcore_last_error(), file)) {
    printf("FAILED: a file that is not there is named (%s)\n", dragcore_last_error());
    good = 0;
  }
  if (dragcore_mesh_read(file, 0.0, &mesh) != DRAGCORE_INVALID_ARGUMENT ||
      dragcore_mesh_read(NULL, 1.0, &mesh) != DRAGCORE_INVALID_ARGUMENT) {
    printf("FAILED: no unit of nothing, no name that is NULL\n");
    good = 0;
  }
  return !good;
}
