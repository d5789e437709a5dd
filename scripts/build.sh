#!/usr/bin/env bash
# Configures (once) and builds a preset on all cores. Usage: scripts/build.sh PRESET
set -euo pipefail
cd "$(dirname "$0")/.."
preset=${1:?preset, see CMakePresets.json}
cmake --preset "$preset" > "build.$preset.log" 2>&1 && cmake --build --preset "$preset" >> "build.$preset.log" 2>&1 || {
  tail -n 60 "build.$preset.log" >&2
  echo "build of preset '$preset' failed; whole log in build.$preset.log" >&2
  exit 1
}
