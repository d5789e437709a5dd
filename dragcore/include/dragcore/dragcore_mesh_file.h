#ifndef DRAGCORE_DRAGCORE_MESH_FILE_H
#define DRAGCORE_DRAGCORE_MESH_FILE_H

/* Mesh files for C; part of the component that dragcore/mesh_file.hpp belongs to, not of the library itself. */

#include <dragcore/dragcore.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Reads an STL or OBJ file: read_mesh() in dragcore/mesh_file.hpp. unit_m: the file's unit in metres, 0.001 for millimetres.
 * *mesh is to be given to dragcore_mesh_destroy(), and is NULL after an error. */
dragcore_status dragcore_mesh_read(const char* file, double unit_m, dragcore_mesh** mesh);

#ifdef __cplusplus
}
#endif

#endif
