#!/usr/bin/env bash
# From a bare Debian 12 machine to error tables: installs what is missing, builds, solves the quick tier on OpenFOAM, compares, calibrates,
# measures cost and writes the report. Interrupt it at any time: the next call goes on where it stopped.
#
# Usage: scripts/run.sh [--stored]
#   --stored   take the committed references (results/reference.h5) instead of solving: no OpenFOAM needed
set -euo pipefail
cd "$(dirname "$0")/.."

stored=false
case ${1:-} in
  '') ;;
  --stored) stored=true ;;
  *) echo "unknown argument '$1'; usage: scripts/run.sh [--stored]" >&2; exit 2 ;;
esac

lap() { local now=$EPOCHREALTIME; printf -v "$1" '%.1f' "$(awk "BEGIN { print $now - $last }")"; last=$now; }
last=$EPOCHREALTIME
status=0

if $stored; then scripts/install.sh --without-cfd; else scripts/install.sh; fi
lap install
scripts/build.sh release dragval cfd_mesh dragcore_wasm
lap build
dragval=build/release/bin/dragval

if $stored; then
  source=(--store results/reference.h5)
else
  "$dragval" doctor >&2
  # A case that failed is shown in every table; the tables are still worth printing, and the failure is in the exit code.
  "$dragval" run quick -j "$(nproc)" || status=$?
  ((status == 0 || status == 4)) || exit "$status"
  source=(--cache .dragval --matrix quick)
fi
lap cfd

"$dragval" compare "${source[@]}" --output results/comparison.h5
"$dragval" calibrate "${source[@]}"
"$dragval" cost "${source[@]}"
"$dragval" report "${source[@]}" --output results/report/index.html
lap compare

echo
echo "Report: results/report/index.html"
echo "Wall time: install $install s, build $build s, CFD $cfd s, compare $compare s"
exit "$status"
