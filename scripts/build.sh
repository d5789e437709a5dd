#!/usr/bin/env bash
# Configures (once) and builds a preset on all cores; says how far it is, and nothing when all is built.
# Usage: scripts/build.sh PRESET [TARGET...]   (everything without TARGET)
set -euo pipefail
cd "$(dirname "$0")/.."
preset=${1:?preset, see CMakePresets.json}
shift
log=build.$preset.log

# Ninja's lines "[12/80] Building ..." on stderr: one line that counts on a terminal, else a line at every tenth of the way.
progress() {
  local line done all tenth=0 terminal=false
  [[ ! -t 2 ]] || terminal=true
  while IFS= read -r line; do
    [[ $line =~ ^\[([0-9]+)/([0-9]+)\]\ (Building|Linking) ]] || continue
    done=${BASH_REMATCH[1]} all=${BASH_REMATCH[2]}
    if $terminal; then
      printf '\rbuild (%s): [%d/%d] ' "$preset" "$done" "$all" >&2
    elif ((done * 10 / all > tenth)); then
      tenth=$((done * 10 / all))
      echo "build ($preset): [$done/$all]" >&2
    fi
  done
  if $terminal && [[ -n ${done:-} ]]; then echo >&2; fi
}

cmake --preset "$preset" > "$log" 2>&1 && cmake --build --preset "$preset" ${1:+--target "$@"} 2>&1 | tee -a "$log" | progress || {
  tail -n 60 "$log" >&2
  echo "build of preset '$preset' failed; whole log in $log" >&2
  exit 1
}
