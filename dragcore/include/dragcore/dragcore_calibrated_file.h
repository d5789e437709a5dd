#ifndef DRAGCORE_DRAGCORE_CALIBRATED_FILE_H
#define DRAGCORE_DRAGCORE_CALIBRATED_FILE_H

/* Files of calibrated models for C; part of the component that dragcore/calibrated_file.hpp belongs to, not of the library itself. */

#include <dragcore/dragcore.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Reads an HDF5 file: read_calibrated() in dragcore/calibrated_file.hpp. *correction is what model->correction points to: keep it as long as
 * the model is used, then give it to dragcore_correction_destroy(). NULL after an error. */
dragcore_status dragcore_calibrated_read(const char* file, dragcore_model* model, dragcore_correction** correction);

#ifdef __cplusplus
}
#endif

#endif
