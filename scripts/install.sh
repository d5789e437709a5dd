#!/usr/bin/env bash
# Installs what a Debian 12 machine still lacks: packages through apt-get, the report's JavaScript through npm. Does nothing when all is there.
# Usage: scripts/install.sh [--without-cfd | --with-slurm | --with-bench]
#   --with-bench   without OpenFOAM, with what the benchmarks need: google-benchmark and valgrind
#   --with-slurm   also what only the tests need: those two, the daemons of a one-node Slurm, and clang
set -euo pipefail
cd "$(dirname "$0")/.."

packages=(build-essential cmake ninja-build pkg-config git ca-certificates
  libeigen3-dev libhwy-dev libtbb-dev libembree-dev catch2 libhdf5-dev hdf5-tools libcli11-dev libtomlplusplus-dev nlohmann-json3-dev libfmt-dev
  libssl-dev zlib1g-dev libboost-dev libceres-dev libgmsh-dev libmujoco-dev libbullet-dev python3 python3-h5py chromium fonts-dejavu-core)
# The library for pages and the report: 900 MB unpacked, most of it Emscripten's own libraries.
[[ ${1:-} == --with-bench ]] || packages+=(emscripten)
[[ ${1:-} == --without-cfd || ${1:-} == --with-bench ]] || packages+=(openfoam openmpi-bin)
[[ ${1:-} != --with-bench && ${1:-} != --with-slurm ]] || packages+=(libbenchmark-dev valgrind)
[[ ${1:-} != --with-slurm ]] || packages+=(slurmctld slurmd slurm-client munge)
[[ ${1:-} != --with-slurm ]] || command -v clang++ > /dev/null || packages+=(clang)
# Node.js from elsewhere is as good as Debian's.
command -v npm > /dev/null || packages+=(nodejs npm)

missing=()
for package in "${packages[@]}"; do
  [[ $(dpkg-query -W -f '${db:Status-Status}' "$package" 2> /dev/null) == installed ]] || missing+=("$package")
done
if ((${#missing[@]})); then
  echo "installing: ${missing[*]}" >&2
  as_root=()
  ((EUID == 0)) || as_root=(sudo)
  "${as_root[@]}" apt-get update -qq
  DEBIAN_FRONTEND=noninteractive "${as_root[@]}" apt-get install -y -qq --no-install-recommends "${missing[@]}" > /dev/null
fi

stamp=compare/report/node_modules/.package-lock.json  # npm's own record of what it installed
if [[ ! -e $stamp || compare/report/package-lock.json -nt $stamp ]]; then
  npm ci --prefix compare/report --no-audit --no-fund --silent >&2
  touch "$stamp"
fi
