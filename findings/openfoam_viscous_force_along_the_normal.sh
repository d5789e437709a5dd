#!/usr/bin/env bash
# OpenFOAM 1912 (Debian 12): the function object `forces` reports a viscous force along the normal of a flat wall at rest, where there is
# none: no-slip and continuity leave only shear. At an edge it fades slower than the first power of the cell. Leaving it out, as theory
# says, makes the drag worse: the wall's pressure is that of its cell (zero gradient), and the two errors partly cancel. The momentum
# balance of the discrete equations holds for the sum.
#
# Case: square cylinder, Re 40, half of it above a symmetry line, steady, three grids of ratio 2. Sides square to the wind: front and rear.
#
# Why it matters: a split of drag into pressure and friction taken from `forces` at low Reynolds numbers books several per cent of the drag
# as friction that is none, and projecting the wall shear stress onto the wall does not give the better total. Judge totals over grids;
# judge friction by the shear's tangential part.
#
# Installs the pinned packages into a temporary folder, runs them on a valid case made here, and fails if the behaviour changes.
set -euo pipefail
version=1912.200626-1+b1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"

apt-get download -qq "openfoam=$version" "libopenfoam=$version" > /dev/null 2>&1 ||
  { echo "cannot download openfoam $version; run apt-get update first" >&2; exit 2; }
# What its libraries link: open MPI and the mathematics of CGAL are on Debian's mirrors, too.
needed=$(apt-cache depends --recurse --no-recommends --no-suggests --no-conflicts --no-breaks --no-replaces --no-enhances "libopenfoam=$version" |
  grep '^lib' | grep -v -E '^(libc6|libgcc-s1|libstdc\+\+6|libopenfoam|libcrypt1)$' | sort -u)
# Names that only other packages provide have no file: without a library that counts, blockMesh below does not start, which is an error.
for package in $needed; do apt-get download -qq "$package" > /dev/null 2>&1 || true; done
for package in ./*.deb; do dpkg-deb -x "$package" root; done
export WM_PROJECT_DIR=$work/root/usr/share/openfoam
LD_LIBRARY_PATH=$(find root -name '*.so*' -printf "$work/%h\n" | sort -u | paste -sd:)
export LD_LIBRARY_PATH
export PATH="$work/root/usr/bin:$PATH"

mkdir -p case/system case/constant case/0
cd case
head() { echo "FoamFile { version 2.0; format ascii; class $1; object $2; }"; }

{ head dictionary controlDict; cat << 'D'
application simpleFoam; startFrom startTime; startTime 0; stopAt endTime; endTime 1500; deltaT 1;
writeControl timeStep; writeInterval 1500; writeFormat ascii; writePrecision 10; timePrecision 6; runTimeModifiable false;
functions
{
  square { type forces; libs (forces); patches (front rear); rho rhoInf; rhoInf 1; CofR (0 0 0); writeControl timeStep; writeInterval 1500; log no; }
  along { type forces; libs (forces); patches (side); rho rhoInf; rhoInf 1; CofR (0 0 0); writeControl timeStep; writeInterval 1500; log no; }
}
D
} > system/controlDict
{ head dictionary fvSchemes; cat << 'D'
ddtSchemes { default steadyState; } gradSchemes { default Gauss linear; }
divSchemes { default none; div(phi,U) bounded Gauss linearUpwind grad(U); div((nuEff*dev2(T(grad(U))))) Gauss linear; }
laplacianSchemes { default Gauss linear corrected; } interpolationSchemes { default linear; } snGradSchemes { default corrected; }
D
} > system/fvSchemes
{ head dictionary fvSolution; cat << 'D'
solvers { p { solver GAMG; smoother GaussSeidel; tolerance 1e-9; relTol 0.05; } U { solver PBiCGStab; preconditioner DILU; tolerance 1e-9; relTol 0.1; } }
SIMPLE { consistent yes; nNonOrthogonalCorrectors 0; residualControl { p 1e-7; U 1e-7; } }
relaxationFactors { fields { p 0.9; } equations { U 0.9; } }
D
} > system/fvSolution
{ head dictionary transportProperties; echo "transportModel Newtonian; nu 0.025;"; } > constant/transportProperties
{ head dictionary turbulenceProperties; echo "simulationType laminar;"; } > constant/turbulenceProperties
wall='front { type noSlip; } rear { type noSlip; } side { type noSlip; }'
zero='front { type zeroGradient; } rear { type zeroGradient; } side { type zeroGradient; }'
{ head volVectorField U; echo "dimensions [0 1 -1 0 0 0 0]; internalField uniform (1 0 0); boundaryField { inlet { type fixedValue; value uniform (1 0 0); } outlet { type zeroGradient; } top { type slip; } line { type symmetryPlane; } flat { type empty; } $wall }"; } > 0/U
{ head volScalarField p; echo "dimensions [0 2 -2 0 0 0 0]; internalField uniform 0; boundaryField { inlet { type zeroGradient; } outlet { type fixedValue; value uniform 0; } top { type slip; } line { type symmetryPlane; } flat { type empty; } $zero }"; } > 0/p

cat > mesh.py << 'PY'
import math, sys
h, growth = float(sys.argv[1]), float(sys.argv[2])
x, y = [-8, -0.5, 0.5, 15], [0, 0.5, 8]
def cells(length): return max(1, round(math.log(1 + length * (growth - 1) / h) / math.log(growth)))
def ratio(n): return growth ** (n - 1)
n = [cells(7.5), round(1 / h), cells(14.5)]
m = [round(0.5 / h), cells(7.5)]
gx, gy = [1 / ratio(n[0]), 1, ratio(n[2])], [1, ratio(m[1])]
v = lambda i, j, k: k * 12 + j * 4 + i
out = ["FoamFile { version 2.0; format ascii; class dictionary; object blockMeshDict; }", "vertices ("]
out += ["(%g %g %g)" % (x[i], y[j], z) for z in (0, 0.1) for j in range(3) for i in range(4)] + [");", "blocks ("]
for j in range(2):
    for i in range(3):
        if (i, j) != (1, 0):
            corners = [v(i, j, 0), v(i + 1, j, 0), v(i + 1, j + 1, 0), v(i, j + 1, 0), v(i, j, 1), v(i + 1, j, 1), v(i + 1, j + 1, 1), v(i, j + 1, 1)]
            out.append("hex (%s) (%d %d 1) simpleGrading (%.12g %.12g 1)" % (" ".join(map(str, corners)), n[i], m[j], gx[i], gy[j]))
def across(i, j): return "(%d %d %d %d)" % (v(i, j, 0), v(i, j + 1, 0), v(i, j + 1, 1), v(i, j, 1))
def along(i, j): return "(%d %d %d %d)" % (v(i, j, 0), v(i + 1, j, 0), v(i + 1, j, 1), v(i, j, 1))
patches = {"inlet patch": [across(0, 0), across(0, 1)], "outlet patch": [across(3, 0), across(3, 1)], "top patch": [along(i, 2) for i in range(3)],
           "line symmetryPlane": [along(0, 0), along(2, 0)], "front wall": [across(1, 0)], "rear wall": [across(2, 0)], "side wall": [along(1, 1)]}
out += [");", "boundary ("]
for name, faces in patches.items():
    out.append("%s { type %s; faces (%s); }" % (*name.split(), " ".join(faces)))
out += [");", "defaultPatch { name flat; type empty; }"]
open("system/blockMeshDict", "w").write("\n".join(out))
PY

# Drag coefficients: pressure, shear on the side, and what is said of the front and rear along their normal.
last() { tail -n 1 "$1" | tr -d '()'; }
for grid in "0.05 1.2" "0.025 1.0954451" "0.0125 1.0466351"; do
  # shellcheck disable=SC2086
  /usr/bin/python3 mesh.py $grid
  rm -rf postProcessing [1-9]*
  blockMesh > log.mesh 2>&1 && simpleFoam > log.solve 2>&1 || { tail -n 20 log.*; exit 2; }
  square=$(last postProcessing/square/0/force.dat) along=$(last postProcessing/along/0/force.dat)
  echo "${grid% *} $square $along"
done > rows
# Columns: h, then time, total, pressure, viscous (x y z each) of the two.
awk '{ p = $6 / 0.025; normal = $9 / 0.025; shear = $19 / 0.025
       printf "cell %.4f: pressure %.4f, shear on the side %.4f, viscous along the normal %.4f; sum %.4f, without it %.4f\n", $1, p, shear, normal, p + shear + normal, p + shear
       all[NR] = p + shear + normal; bare[NR] = p + shear; n[NR] = normal }
     END { limit = all[3] + (all[3] - all[2]) / 3
           printf "limit of the sum, second order: %.4f; on the coarsest grid the sum is %+.1f %% off, without the normal part %+.1f %%\n", limit, 100 * (all[1] / limit - 1), 100 * (bare[1] / limit - 1)
           exit !(n[1] > 0.02 * all[1] && n[3] > n[1] / 4) }' rows || { echo "changed: the normal part is gone, or fades with the cell" >&2; exit 1; }
