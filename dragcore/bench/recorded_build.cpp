// The rows of wrench(), resistance() and the README's step that the library of commit 3f4dda5 had: before there were kernels.
// scripts/bench.sh compiles this file against that library, taken out of the repository's history.

#include "rows.hpp"

int main(int count, char** words) {
  using namespace dragcore;
  benchmark::Initialize(&count, words);
  benchmark::AddCustomContext("instruction_set", "recorded");
  bench::add_wrench_rows({"recorded",
                          {"cube-12", "ball-2048", "ball-12800", "sheet-3200"},
                          [](Model&) {},
                          1e-11,
                          [](const bench::Body& b, const Motion& motion, const Model& model) {
                            return reference::wrench(b.mesh, b.surface.sides, motion, {}, model).total();
                          }});
  bench::add_step_rows("recorded");
  const bool some = benchmark::RunSpecifiedBenchmarks() > 0;
  return some && !bench::any_wrong ? 0 : 1;
}
