#!/usr/bin/env bash
# assimp 5.2.5 (Debian 12) reads ascii STL into single precision, without a word: a ball of 1 m at map coordinates (UTM, x 512 km, y 4123 km)
# comes back with a fifth more area than the file says, since 4123 km leaves steps of 0.25 to 0.5 m.
#
# Why it matters: scans and buildings are often stored in map coordinates. Text holds them exactly; who reads them through assimp gets
# another body, and no error. Move the coordinates near the origin before they become floats, or read the text yourself.
#
# Installs the pinned packages into a temporary folder, runs them on a valid file made here, and fails if the behaviour changes.
set -euo pipefail
version=5.2.5~ds0-1+b1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"

# The library, its headers and what it links, of which Debian's libc and libstdc++ are on every machine with a compiler.
apt-get download -qq "libassimp5=$version" "libassimp-dev=$version" libminizip1 libdraco7 zlib1g > /dev/null 2>&1 ||
  { echo "cannot download libassimp5 $version; run apt-get update first" >&2; exit 2; }
for package in ./*.deb; do dpkg-deb -x "$package" root; done
lib=$(dirname "$(find root -name 'libassimp.so.5' | head -n 1)")

cat > ball.py << 'PY'
import math
n, m, r, at = 16, 32, 0.5, (512345.3, 4123456.7, 312.6)
def p(i, j):
    t, f = math.pi * i / n, 2 * math.pi * (j % m) / m
    return (r * math.sin(t) * math.cos(f), r * math.sin(t) * math.sin(f), r * math.cos(t))
area = 0.0
with open('ball.stl', 'w') as out:
    out.write('solid ball\n')
    for i in range(n):
        for j in range(m):
            a, b, c, d = p(i, j), p(i + 1, j), p(i + 1, j + 1), p(i, j + 1)
            for t in ([] if i == n - 1 else [(a, b, c)]) + ([] if i == 0 else [(a, c, d)]):
                u, v = [t[1][k] - t[0][k] for k in range(3)], [t[2][k] - t[0][k] for k in range(3)]
                x = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
                area += math.sqrt(sum(y * y for y in x)) / 2
                out.write('facet normal 0 0 0\n outer loop\n')
                for q in t: out.write('  vertex %.9f %.9f %.9f\n' % tuple(s + o for s, o in zip(q, at)))
                out.write(' endloop\nendfacet\n')
    out.write('endsolid ball\n')
print('%.4f' % area)
PY
said=$(/usr/bin/python3 ball.py)

cat > read.cpp << 'CPP'
#include <assimp/Importer.hpp>
#include <assimp/scene.h>
#include <cmath>
#include <cstdio>
int main() {
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFile("ball.stl", 0);
  if (!scene) return std::printf("refused: %s\n", importer.GetErrorString()), 0;
  double area = 0.0;
  const aiMesh& mesh = *scene->mMeshes[0];
  for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
    double p[3][3];
    for (int k = 0; k < 3; ++k)
      for (int a = 0; a < 3; ++a) p[k][a] = mesh.mVertices[mesh.mFaces[f].mIndices[k]][a];
    double u[3], v[3];
    for (int a = 0; a < 3; ++a) u[a] = p[1][a] - p[0][a], v[a] = p[2][a] - p[0][a];
    area += 0.5 * std::hypot(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]);
  }
  std::printf("%.4f\n", area);
}
CPP
g++ -std=c++17 -Iroot/usr/include read.cpp -o read "$lib/libassimp.so.5" -Wl,--allow-shlib-undefined
found=$(LD_LIBRARY_PATH="$lib" ./read)

echo "assimp $version: area in the file $said m^2, as read $found m^2"
awk -v said="$said" -v found="$found" 'BEGIN { exit !(found > 1.1 * said || found < 0.9 * said) }' || {
  echo "changed: assimp no longer loses the shape" >&2
  exit 1
}
