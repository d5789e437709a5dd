#include <dragcore/mesh_file.hpp>

#include "fuzz.hpp"

/// assimp 5.2.5 loses the scene it was building when it meets a fault: not ours to report. Read by the leak sanitizer alone.
extern "C" const char* __lsan_default_suppressions() { return "leak:libassimp"; }

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
