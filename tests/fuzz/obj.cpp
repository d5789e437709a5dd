#include <dragcore/mesh_file.hpp>

#include "fuzz.hpp"

/// OBJ files.
int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fuzz::Scratch scratch(".obj");
  try {
    const dragcore::MeshFile file = dragcore::read_mesh_file(scratch.holding(data, size));
    for (const std::string& note : file.notes) fuzz::check(note.size() < 1000, "a note is short");
    fuzz::evaluate(file.mesh);
  } catch (const std::runtime_error& fault) {
    fuzz::check(std::strlen(fault.what()) < 1000, "a message is short");
  }
  return 0;
}
