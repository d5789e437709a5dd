#!/usr/bin/env bash
# Draws the figures of README and docs from the references: docs/figures/*.svg. Arguments go to `dragval report`: --matrix quick for the
# cone, cube and plate of the README, --cache .dragval for runs that are not collected yet.
set -euo pipefail
cd "$(dirname "$0")/.."

specs=$(mktemp -d)
trap 'rm -r "$specs"' EXIT
build/release/bin/dragval report "$@" --quick-cost --output "$specs/some.html" --specs "$specs"
# What is known of four bodies, and errors over all of them, whatever the arguments choose.
build/release/bin/dragval report --output "$specs/all.html" --specs "$specs/all"
mv "$specs"/all/{drag_against_reynolds,cost}.vl.json "$specs"
mkdir -p docs/figures
for name in drag_against_orientation drag_against_reynolds cost; do
  node compare/report/node_modules/vega-lite/bin/vl2svg "$specs/$name.vl.json" "docs/figures/$name.svg"
  echo "docs/figures/$name.svg"
done
