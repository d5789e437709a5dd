#!/usr/bin/env bash
# Installs what is missing, builds and runs all tests, live OpenFOAM cases among them. Arguments go to ctest, e.g. scripts/test.sh -R pillow
set -euo pipefail
cd "$(dirname "$0")/.."

scripts/install.sh --with-slurm
# dragcore on its own proves that it needs nothing but Eigen (and Catch2 for its tests).
scripts/build.sh core
ctest --preset core --progress --output-on-failure -j "$(nproc)" | tail -n 4
# And that it is at home with clang and libc++, as on macOS, Android and the web: 230 CPU seconds.
scripts/libcxx.sh
scripts/build.sh libcxx
ctest --preset libcxx --progress --output-on-failure -j "$(nproc)" | tail -n 4
scripts/build.sh release
# The [cfd] tests drive solver processes of their own: one test at a time keeps them from fighting for two cores.
ctest --preset release --output-on-failure "$@"
