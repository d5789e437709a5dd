#pragma once

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "kernels/wrench_kernel.hpp"

namespace on_targets {

/// Every instruction set in turn, and the best again at the end.
template <class Check>
void each(Check&& check) {
  for (const std::string& target : dragcore::kernels::targets()) {
    dragcore::kernels::force_target(target);
    INFO("target " << target);
    check();
  }
  dragcore::kernels::force_target("");
}

/// The same work on a wide and on a narrow set of each family must give the same: products and sums are fused in the first family, 16 and 8
/// at once, and not in the second, 4 and 1. The second is everywhere.
template <class Work>
void same_bits(const Work& work) {
  const std::vector<std::string> here = dragcore::kernels::targets();
  int families = 0;
  for (const std::array<std::string, 2>& family : {std::array<std::string, 2>{"AVX3", "AVX2"}, {"SSE4", "SCALAR"}}) {
    if (!std::all_of(family.begin(), family.end(),
                     [&](const auto& name) { return std::find(here.begin(), here.end(), name) != here.end(); }))
      continue;
    ++families;
    dragcore::kernels::force_target(family[0]);
    const auto wide = work();
    dragcore::kernels::force_target(family[1]);
    const auto narrow = work();
    INFO(family[0] << " and " << family[1]);
    REQUIRE(wide.size() == narrow.size());
    CHECK(std::equal(wide.begin(), wide.end(), narrow.begin()));
  }
  dragcore::kernels::force_target("");
  CHECK(families > 0);
}

}  // namespace on_targets
