// What the machine can do at best, in the same run as what is held against it: products and sums, reading from each cache and from memory,
// by one thread and by two.

#include "machine.hpp"
#include "rows.hpp"

namespace dragcore::bench {

namespace {

/// A row for one thread, and one for two: of these only the clock on the wall tells how long they took together.
/// Rates are judged by the most of the repetitions.
void add_rows(const std::string& name, const Row& row) {
  const auto most = [](const std::vector<double>& runs) { return *std::max_element(runs.begin(), runs.end()); };
  add_row(name, row)->ComputeStatistics("most", most);
  add_row(name, row)->ComputeStatistics("most", most)->UseRealTime()->Threads(2);
}

}  // namespace

void add_machine_rows() {
  add_rows("machine/fma", [](benchmark::State& state) {
    double operations = 0.0;
    for (auto _ : state) operations = multiply_and_add(100'000);
    state.SetItemsProcessed(static_cast<std::int64_t>(operations * static_cast<double>(state.iterations())));
    state.counters["bits"] = benchmark::Counter(32.0 * static_cast<double>(float_lanes()), benchmark::Counter::kAvgThreads);
  });

  // Half of a cache is surely in it. 32 MB is what the kernels read of a million triangles; memory begins where no cache can hold it.
  const std::vector<double> caches = cache_sizes();
  for (const auto& [level, bytes] : {std::pair<std::string, double>{"L1", 0.5 * caches[0]},
                                     {"L2", 0.5 * caches[1]},
                                     {"32MB", 32e6},
                                     {"memory", std::min(2e9, std::max(256e6, 4.0 * caches[2]))}})
    for (const std::size_t streams : {1, 7}) {
      const std::size_t size = static_cast<std::size_t>(bytes) / sizeof(float);
      add_rows("machine/read/" + level + "/streams:" + std::to_string(streams), [=](benchmark::State& state) {
        const std::vector<float> numbers(size, 1.0f);  // each thread its own
        for (auto _ : state) benchmark::DoNotOptimize(read_all(numbers.data(), size, streams));
        state.SetBytesProcessed(static_cast<std::int64_t>(state.iterations()) * static_cast<std::int64_t>(sizeof(float) * size));
      });
    }
}

}  // namespace dragcore::bench
