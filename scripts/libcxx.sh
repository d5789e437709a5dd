#!/usr/bin/env bash
# Unpacks Debian's libc++ into build/libcxx-14, for the preset `libcxx`; does nothing when it is there.
# Not installed: libc++-14-dev needs LLVM's libunwind-14-dev, which drives out the libunwind-dev that Ceres is linked with.
set -euo pipefail
cd "$(dirname "$0")/.."

folder=$PWD/build/libcxx-14
[[ ! -e $folder/usr/lib/llvm-14/include/c++/v1/vector || ! -e $folder/usr/lib/llvm-14/lib/libc++.so ]] || exit 0
rm -rf "$folder" "$folder.new"
mkdir -p "$folder.new/packages"
cd "$folder.new/packages"
apt-get download -qq -o APT::Sandbox::User="$(id -un)" \
  libc++-14-dev libc++abi-14-dev libunwind-14-dev libc++1-14 libc++abi1-14 libunwind-14
for package in *.deb; do dpkg-deb -x "$package" ..; done
rm -r ../packages
mv "$folder.new" "$folder"  # whole or not at all
