#!/usr/bin/env bash
# What each public header costs those who include it: CPU seconds of a file that includes nothing else, the least of five, and as a multiple of Eigen's
# Core and Geometry. Aim: drag.hpp within 1.2. Usage: dragcore/bench/compile_cost.sh [COMPILER] [HEADER...]
set -euo pipefail
cd "$(dirname "$0")/../include"
compiler=${1:-g++}
(($# == 0)) || shift
headers=("$@")
((${#headers[@]})) || headers=(drag stepping body_wind shapes mass_properties diagnose required_effects)
eigen=$(pkg-config --cflags-only-I eigen3 2> /dev/null || echo -I/usr/include/eigen3)
TIMEFORMAT='%U %S'

seconds() {  # of what stands in the argument
  for _ in 1 2 3 4 5; do
    { time "$compiler" -std=c++20 -fsyntax-only -x c++ -I. $eigen - <<< "$1"; } 2>&1
  done | awk '{ t = $1 + $2; if (NR == 1 || t < least) least = t } END { print least }'
}

base=$(seconds $'#include <Eigen/Core>\n#include <Eigen/Geometry>')
printf '%-28s %5.2f s\n' 'Eigen/Core, Eigen/Geometry' "$base"
for header in "${headers[@]}"; do
  cost=$(seconds "#include <dragcore/$header.hpp>")
  printf '%-28s %5.2f s  %4.2f\n' "$header.hpp" "$cost" "$(awk "BEGIN { print $cost / $base }")"
done
