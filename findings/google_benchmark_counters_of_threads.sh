#!/usr/bin/env bash
# google-benchmark 1.7.1 (Debian 12): a counter kIsIterationInvariantRate under Threads(n) is n times too high: it multiplies the sum over
# the threads by the sum of their iterations. SetItemsProcessed() of the same work is right.
#
# Why it matters: this counter is how one gives work per iteration as a rate. For two threads a machine's peak came out as four times that
# of one, and a perfect speed-up looks like the square of the number of threads. Rows of several threads here use SetItemsProcessed().
#
# Installs the pinned packages into a temporary folder, runs threads that take a millisecond an iteration, and fails if the behaviour
# changes.
set -euo pipefail
version=1.7.1-1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"

apt-get download -qq "libbenchmark1debian=$version" "libbenchmark-dev=$version" > /dev/null 2>&1 ||
  { echo "cannot download libbenchmark-dev $version; run apt-get update first" >&2; exit 2; }
for package in ./*.deb; do dpkg-deb -x "$package" root; done
lib=$(dirname "$(find root -name 'libbenchmark.so*' | head -n 1)")

cat > threads.cpp << 'CPP'
#include <benchmark/benchmark.h>

#include <chrono>
#include <thread>

void sleeps(benchmark::State& state) {
  for (auto _ : state) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  state.counters["by_counter"] = benchmark::Counter(1.0, benchmark::Counter::kIsIterationInvariantRate);
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(sleeps)->UseRealTime()->Threads(1)->Threads(2);
BENCHMARK_MAIN();
CPP
g++ -std=c++17 -Iroot/usr/include threads.cpp -o threads -L"$lib" -lbenchmark -lpthread
LD_LIBRARY_PATH="$lib" ./threads --benchmark_format=json > said.json 2> /dev/null

/usr/bin/python3 - << 'PY'
import json
import sys
one, two = json.load(open("said.json"))["benchmarks"]
counter, items = two["by_counter"] / one["by_counter"], two["items_per_second"] / one["items_per_second"]
print(f"two sleepers against one: x {counter:.2f} by the counter, x {items:.2f} by SetItemsProcessed; right is 2")
if not (3.5 < counter < 4.5 and 1.7 < items < 2.3):
    sys.exit("changed: the counter no longer counts threads twice")
PY
