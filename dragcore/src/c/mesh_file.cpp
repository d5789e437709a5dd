#include <dragcore/dragcore_mesh_file.h>

#include <dragcore/mesh_file.hpp>

#include "c/handles.hpp"

using namespace dragcore::c;

extern "C" dragcore_status dragcore_mesh_read(const char* file, double unit_m, dragcore_mesh** mesh) {
  return made(mesh, "mesh", [&] {
    require(file, "file");
    return new dragcore_mesh{dragcore::read_mesh(file, unit_m)};
  });
}
