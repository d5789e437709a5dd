#!/usr/bin/env bash
# The whole campaign behind results/: hours of OpenFOAM, resumable at any point, and collected after each part so that little is lost.
# Usage: scripts/reproduce.sh [-jN] [--afresh]
#   -jN        cases side by side (all cores)
#   --afresh   solve what the committed files already hold, too
set -euo pipefail
cd "$(dirname "$0")/.."

jobs=-j$(nproc)
known=true
for argument in "$@"; do
  case $argument in
    -j*) jobs=$argument ;;
    --afresh) known=false ;;
    *) echo "unknown argument '$argument'; usage: scripts/reproduce.sh [-jN] [--afresh]" >&2; exit 2 ;;
  esac
done

scripts/install.sh
scripts/build.sh release dragval cfd_mesh
dragval=build/release/bin/dragval
status=0

# A case that failed is a result, too (exit code 4): the campaign goes on, and the failure is in the exit code at the end.
solve() {
  local matrix=$1 into=$2 code=0 skip=()
  if $known && [[ -e $into ]]; then skip=(--known "$into"); fi
  "$dragval" run "$matrix" "$jobs" "${skip[@]}" || code=$?
  ((code == 0 || code == 4)) || exit "$code"
  ((code == 0)) || status=$code
  # 5: nothing was solved here, since all of it is known.
  "$dragval" collect --matrix "$matrix" --into "$into" || (($? == 5))
}

solve reference results/reference.h5
solve scale_resolving results/reference.h5
solve spin results/reference.h5
solve concave results/reference.h5
solve low_reynolds results/reference.h5
solve kinds results/reference.h5
solve smooth results/reference.h5
"$dragval" import compare/reference/experiments.csv
solve studies results/studies.h5
exit "$status"
