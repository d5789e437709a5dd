#include <dragcore/dragcore_baked_file.h>

#include <dragcore/baked_file.hpp>

#include "c/handles.hpp"

using namespace dragcore::c;

extern "C" {

dragcore_status dragcore_baked_read(const char* file, dragcore_baked** baked) {
  return made(baked, "baked", [&] {
    require(file, "file");
    return new dragcore_baked{dragcore::read_baked(file)};
  });
}

dragcore_status dragcore_baked_write(const dragcore_baked* baked, const char* file) {
  return guarded([&] {
    require(baked, "baked");
    require(file, "file");
    dragcore::write_baked(file, baked->body);
  });
}

}  // extern "C"
