// Time of the library beside what the machine can do at best, by google-benchmark: `dragcore_benchmark --help`. Its own option
// --target=AVX2 forces an instruction set: AVX3 (AVX-512), AVX2, SSE4. scripts/bench.sh runs all and makes the table of targets.

#include <benchmark/benchmark.h>

#include <cstdio>
#include <string>
#ifdef DRAGCORE_BENCHMARK_BATCH
#include <tbb/task_arena.h>
#endif

#include "kernels/wrench_kernel.hpp"
#include "rows.hpp"

namespace dragcore::bench {
void add_machine_rows();
void add_drag_rows();
void add_surface_rows();
void add_wind_rows();
void add_batch_rows();
void add_baked_rows();
}  // namespace dragcore::bench

int main(int count, char** words) {
  using namespace dragcore;
  benchmark::Initialize(&count, words);
  std::string target = kernels::targets().front();
  for (int k = 1; k < count; ++k) {
    const std::string word = words[k];
    if (!word.starts_with("--target=")) {
      std::fprintf(stderr, "unknown option '%s'; options are --target=SET and those of --help\n", words[k]);
      return 2;
    }
    target = word.substr(9);
  }
  try {
    kernels::force_target(target);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
  benchmark::AddCustomContext("instruction_set", target);
  bench::add_machine_rows();
  bench::add_drag_rows();
  bench::add_surface_rows();
  bench::add_wind_rows();
#ifdef DRAGCORE_BENCHMARK_BATCH
  bench::add_batch_rows();
#endif
  bench::add_baked_rows();
  bool some = false;  // rows that met the filter
  const auto run = [&] { some = benchmark::RunSpecifiedBenchmarks() > 0; };
#ifdef DRAGCORE_BENCHMARK_BATCH
  tbb::task_arena(1).execute(run);  // on one thread, but for rows that say otherwise
#else
  run();
#endif
  return some && !bench::any_wrong ? 0 : 1;
}
