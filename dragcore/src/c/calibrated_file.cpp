#include <dragcore/dragcore_calibrated_file.h>

#include <dragcore/calibrated_file.hpp>

#include "c/handles.hpp"

using namespace dragcore::c;

extern "C" {

dragcore_status dragcore_calibrated_read(const char* file, dragcore_model* model, dragcore_correction** correction) {
  return made(correction, "correction", [&] {
    require(file, "file");
    require(model, "model");
    const dragcore::Model found = dragcore::read_calibrated(file).model;
    auto* kept = new dragcore_correction{found.correction};
    *model = model_from(found);
    model->correction = kept;
    return kept;
  });
}

}  // extern "C"
