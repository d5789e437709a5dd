#include <dragcore/mesh_file.hpp>

#include "fuzz.hpp"


/// STL files, ascii and binary.
int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fuzz::Scratch scratch(".stl");
  try {
    fuzz::evaluate(dragcore::read_mesh(scratch.holding(data, size)));
  } catch (const std::runtime_error& fault) {
    fuzz::check(std::strlen(fault.what()) < 1000, "a message is short");
  }
  return 0;
}
