#pragma once

// What the library uses of C++20 and libc++ 13, which comes with Emscripten 3.1.6, has not. Included before every file of the build for the
// web, by its CMakeLists.txt.

#include <version>

#if !defined(__cpp_lib_bit_cast)
namespace std {
template <class To, class From>
constexpr To bit_cast(const From& from) noexcept {
  static_assert(sizeof(To) == sizeof(From));
  return __builtin_bit_cast(To, from);
}
}  // namespace std
#endif
