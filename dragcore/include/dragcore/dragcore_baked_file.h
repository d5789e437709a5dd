#ifndef DRAGCORE_DRAGCORE_BAKED_FILE_H
#define DRAGCORE_DRAGCORE_BAKED_FILE_H

/* Files of baked bodies for C; part of the component that dragcore/baked_file.hpp belongs to, not of the library itself. */

#include <dragcore/dragcore.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Reads an HDF5 file: read_baked() in dragcore/baked_file.hpp. *baked is to be given to dragcore_baked_destroy(), and is NULL after an
 * error. */
dragcore_status dragcore_baked_read(const char* file, dragcore_baked** baked);
dragcore_status dragcore_baked_write(const dragcore_baked* baked, const char* file);

#ifdef __cplusplus
}
#endif

#endif
