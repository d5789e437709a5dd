#pragma once

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#ifdef DRAGCORE_WITH_KERNELS
#include "kernels/wrench_kernel.hpp"
#endif

namespace dragcore::kernels {

#ifdef DRAGCORE_WITH_KERNELS

constexpr bool built = true;

/// Every instruction set of this machine in turn, and the best again at the end.
template <class Check>
void on_every_target(Check&& check) {
  for (const std::string& target : targets()) {
    force_target(target);
    INFO("target " << target);
    check();
  }
  force_target("");
}

/// Calls same(wide, narrow) with `result()` on two sets whose bits must be the same: products and sums are fused in the first pair, 16 and
/// 8 at once, and not in the second, 4 and 1. The second is everywhere.
template <class Result, class Same>
void on_equal_targets(Result&& result, Same&& same) {
  const std::vector<std::string> here = targets();
  int pairs = 0;
  for (const auto& pair : {std::array<std::string, 2>{"AVX3", "AVX2"}, {"SSE4", "SCALAR"}}) {
    if (!std::all_of(pair.begin(), pair.end(), [&](const auto& name) { return std::find(here.begin(), here.end(), name) != here.end(); }))
      continue;
    ++pairs;
    force_target(pair[0]);
    const auto wide = result();
    force_target(pair[1]);
    const auto narrow = result();
    INFO(pair[0] << " and " << pair[1]);
    same(wide, narrow);
  }
  force_target("");
  CHECK(pairs > 0);
}

#else  // the library was built with Eigen alone: the same promises, kept by plain loops

constexpr bool built = false;

template <class Check>
void on_every_target(Check&& check) {
  check();
}

template <class Result, class Same>
void on_equal_targets(Result&& result, Same&& same) {
  same(result(), result());
}

#endif

/// The same for what has an ==.
template <class Result>
void same_bits(Result&& result) {
  on_equal_targets(result, [](const auto& wide, const auto& narrow) { CHECK(wide == narrow); });
}

}  // namespace dragcore::kernels
