#!/usr/bin/env bash
# Builds the preset `fuzz` (Debian packages clang and libclang-rt-14-dev) and gives each target arbitrary bytes, made from its corpus by mutation, for an equal
# share of the time. An input that breaks a target is kept and named; put it into tests/fuzz/corpus/<target>/ once it is mended.
# Usage: tests/fuzz/run.sh [SECONDS]     all targets together, 600 unless told
# FUZZ_BUILD: the build folder, build/fuzz unless told; what earlier runs found worth keeping is in FUZZ_BUILD/corpus
set -euo pipefail
cd "$(dirname "$0")/../.."

seconds=${1:-600}
[[ $seconds =~ ^[1-9][0-9]*$ ]] || { echo "'$seconds' is no number of seconds; usage: tests/fuzz/run.sh [SECONDS]" >&2; exit 2; }
build=${FUZZ_BUILD:-build/fuzz}
mkdir -p "$build"
{ cmake --preset fuzz -B "$build" && cmake --build "$build" --target fuzzers -j "$(nproc)"; } > "$build/build.log" 2>&1 || {
  tail -n 40 "$build/build.log" >&2
  echo "build of the fuzz targets failed; whole log in $build/build.log" >&2
  exit 1
}

targets=("$build"/bin/fuzz_*)
share=$((seconds / ${#targets[@]}))
((share > 0)) || share=1
status=0
printf '%-12s %12s %12s %8s\n' target executions 'per second' 'peak MB'
for program in "${targets[@]}"; do
  name=${program##*/fuzz_}
  seeds=tests/fuzz/corpus/$name
  mkdir -p "$build/corpus/$name" "$build/found"
  options=(-max_total_time="$share" -max_len=8192 -timeout=10 -rss_limit_mb=2048 -malloc_limit_mb=512 -print_final_stats=1
    -artifact_prefix="$build/found/$name-")
  [[ ! -e tests/fuzz/$name.dict ]] || options+=(-dict="tests/fuzz/$name.dict")
  result=clean
  "$program" "${options[@]}" "$build/corpus/$name" "$seeds" > "$build/found/$name.log" 2>&1 || { result="BROKEN, see $build/found/$name.log"; status=1; }
  stat() { sed -n "s/^stat::$1: *//p" "$build/found/$name.log"; }
  printf '%-12s %12s %12s %8s  %s\n' "$name" "$(stat number_of_executed_units)" "$(stat average_exec_per_sec)" "$(stat peak_rss_mb)" "$result"
done
exit "$status"
