#!/usr/bin/env bash
# Measures how fast the library is: installs what is missing, builds, runs, and writes results/bench/rows.json and targets.md. For figures
# that count, leave the machine alone meanwhile: ten minutes.
#
# Usage: scripts/bench.sh [--quick | --accept-instructions]
#   --quick                 a smoke run of half a minute, small bodies alone; writes to build/bench/results
#   --accept-instructions   counts instructions by callgrind and accepts them: results/bench/instructions.json, which ctest holds
set -euo pipefail
cd "$(dirname "$0")/.."

mode=${1:-}
case $mode in
  '' | --quick | --accept-instructions) ;;
  *) echo "unknown argument '$mode'; usage: scripts/bench.sh [--quick | --accept-instructions]" >&2; exit 2 ;;
esac
scripts/install.sh --with-bench
bin=build/release/bin

if [[ $mode == --accept-instructions ]]; then
  scripts/build.sh release instruction_count
  exec /usr/bin/python3 tests/dragcore/kernels/instructions.py "$bin/instruction_count" results/bench/instructions.json --accept
fi

# The library before there were kernels, for ratios within one run.
recorded=build/bench/recorded
build_recorded() {
  local commit=3f4dda5
  git cat-file -e "$commit^{commit}" 2> /dev/null || {
    echo "commit $commit is not in this clone (a shallow one?): ratios to it are left out; git fetch --unshallow brings it" >&2
    return 1
  }
  local source=$recorded-source
  if [[ ! -e $source/built/libdragcore.a ]]; then
    rm -rf "$source"
    mkdir -p "$source"
    git archive "$commit" dragcore LICENSE docs | tar -x -C "$source"
    cmake -S "$source/dragcore" -B "$source/built" -DCMAKE_BUILD_TYPE=Release > "$source/log" 2>&1 &&
      cmake --build "$source/built" --target dragcore -j "$(nproc)" >> "$source/log" 2>&1 || { tail -n 20 "$source/log" >&2; exit 1; }
  fi
  g++ -std=c++20 -O3 -DNDEBUG -w -I"$source/dragcore/include" $(pkg-config --cflags eigen3) dragcore/bench/recorded_build.cpp \
    "$source/built/libdragcore.a" -lbenchmark -lpthread -o "$recorded" || exit 1
}

mkdir -p build/bench
rm -f build/bench/*.json
targets=(dragcore_benchmark)
[[ $mode == --quick ]] || targets+=(dragval)
scripts/build.sh release "${targets[@]}"
has_peers=false
if cmake --build build/release --target help | grep -q '^peers_benchmark:'; then
  scripts/build.sh release peers_benchmark
  has_peers=true
fi
has_recorded=true
build_recorded || has_recorded=false

awk -v cores="$(nproc)" '$1 > 0.3 * cores { print "other programs are running (load " $1 "): these figures are rough" }' /proc/loadavg >&2
options=(--benchmark_report_aggregates_only=true --benchmark_repetitions=7 --benchmark_min_time=0.1
  --benchmark_enable_random_interleaving=true)
results=results/bench
rows=. deforming=.
programs=(--dragval "$bin/dragval")
if [[ $mode == --quick ]]; then
  options=(--benchmark_report_aggregates_only=true --benchmark_repetitions=2 --benchmark_min_time=0.01)
  results=build/bench/results
  programs=()
  deforming=1058
  rows='/(cube-12|box-12|ball-2048|ball-12800|coherent|L1|L2|32MB|fma)'
fi
run() {  # PROGRAM NAME OPTION...
  local to=build/bench/$2
  "$1" "${options[@]}" --benchmark_out="$to.json" "${@:3}" > "$to.log" 2>&1 || { tail -n 20 "$to.log" >&2; exit 1; }
}
run "$bin/dragcore_benchmark" best --benchmark_filter="$rows"
raw=(build/bench/best.json)
if grep -q '"instruction_set": "AVX3' build/bench/best.json; then
  run "$bin/dragcore_benchmark" avx2 --target=AVX2 \
    --benchmark_filter='^machine/fma|^(textbook|wrench/single)/(cube-12|sheet|ball-2048|ball-12800)'
  raw+=(build/bench/avx2.json)
fi
if $has_recorded; then
  run "$recorded" recorded --benchmark_filter="$rows"
  raw+=(build/bench/recorded.json)
fi
if $has_peers; then
  run "$bin/peers_benchmark" peers --benchmark_filter="$deforming"
  raw+=(build/bench/peers.json)
fi
commit=$(git rev-parse --short HEAD 2> /dev/null || echo unknown)
git diff --quiet HEAD 2> /dev/null || commit="$commit, changed"
/usr/bin/python3 dragcore/bench/targets.py "$results" "${raw[@]}" --instructions results/bench/instructions.json --commit "$commit" \
  "${programs[@]}"
echo
echo "Written: $results/rows.json, $results/targets.md"
