#pragma once

#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <dragcore/drag.hpp>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

/// What the fuzz targets share. A target is one function that is given arbitrary bytes: it may refuse them by the exceptions that its
/// reader promises, and must otherwise keep what the reader promises. Called by libFuzzer in the preset `fuzz`, and by replay.cpp
/// everywhere else.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace fuzz {

/// Ends the process with a message: libFuzzer keeps the input, ctest sees a failure.
inline void check(bool ok, const std::string& promise) {
  if (ok) return;
  std::fprintf(stderr, "broken promise: %s\n", promise.c_str());
  std::abort();
}

/// A file of this process for readers that take a path, in memory where the system has such a place.
class Scratch {
 public:
  explicit Scratch(const std::string& extension)
      : path_((std::filesystem::is_directory("/dev/shm") ? std::filesystem::path("/dev/shm") : std::filesystem::temp_directory_path()) /
              ("dragcore_fuzz_" + std::to_string(::getpid()) + extension)) {}
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  ~Scratch() {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }
  const std::filesystem::path& holding(const std::uint8_t* data, std::size_t size) const {
    std::ofstream out(path_, std::ios::binary);
    check(static_cast<bool>(out.write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size)).flush()),
          "the scratch file can be written");
    return path_;
  }

 private:
  std::filesystem::path path_;
};

/// One evaluation on whatever mesh a file held, with every effect that a law can have, from an oblique wind and with spin.
inline void evaluate(const dragcore::TriangleMesh& mesh) {
  using namespace dragcore;
  for (const Surface::Sides sides : {Surface::Sides::automatic, Surface::Sides::one, Surface::Sides::two}) {
    try {
      const Surface surface(mesh, sides);
      Model model = model_for(surface);
      model.law.leeward = {0.0, 0.2, -0.1, 0.0, 0.0};
      model.quadrature = Quadrature::adaptive;
      const Wrench total = wrench(surface, {.wind = {3.0, -1.0, 2.0}, .angular_velocity = {0.5, 0.0, -0.25}}, {}, model).total();
      check(total.force.allFinite() && total.torque.allFinite(), "the wrench on a mesh from a file is finite");
    } catch (const std::invalid_argument&) {  // inside out, wound inconsistently
    } catch (const std::overflow_error&) {    // so large that its wrench is beyond the numbers
    }
  }
}

}  // namespace fuzz
