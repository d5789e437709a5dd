#include <dragcore/field_file.hpp>

#include "fuzz.hpp"

/// HDF5 1.10.8 loses some hundred bytes whenever a checksum is wrong (its own h5dump too): not ours to report. Read by the leak sanitizer
/// alone.
extern "C" const char* __lsan_default_suppressions() { return "leak:libhdf5"; }

/// Wind fields as HDF5: what is accepted can be sampled.
int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace dragcore;
  static const fuzz::Scratch scratch(".h5");
  try {
    const GridField field = read_field_hdf5(scratch.holding(data, size));
    const Grid& grid = field.grid();
    const Eigen::Vector3d middle = 0.5 * grid.lower + 0.5 * grid.upper;
    const WindSample sample = field.sample(middle);
    if (grid.values.cwiseAbs().maxCoeff() < 1e100) fuzz::check(sample.velocity.allFinite(), "a field is finite inside its box");
    field.variation(middle, 1.0, Eigen::Array3d::Ones());
  } catch (const std::runtime_error& fault) {
    fuzz::check(std::strlen(fault.what()) < 1000, "a message is short");
  }
  return 0;
}
