// Prints the hash of all results of the seeded cases. Linked with the library, or with a build of its core that lacks effects:
// CMakeLists.txt.

#include <cstdio>
#include <cstdlib>

#include "tests/dragcore/drag/effects_cases.hpp"

/// @param argv[1]  bits of the effects to leave out by Model::effects; 0 when none is named
int main(int argc, char** argv) {
  dragcore::Effects effects = dragcore::Effects::all();
  const unsigned long left_out = argc > 1 ? std::strtoul(argv[1], nullptr, 10) : 0;
  for (unsigned i = 0; i < dragcore::effect_count; ++i)
    if (left_out >> i & 1u) effects = effects.without(static_cast<dragcore::Effect>(1u << i));
  std::printf("%016llx\n", static_cast<unsigned long long>(effects_cases::hash_of_results(effects)));
}
