#!/usr/bin/env python3
"""Drag of mesh files beside the shadow they cast: a Markdown table, one line a file.

    scripts/real_meshes.py [--unit mm] FILE...      # DRAGVAL=... for a program that is not in build/release

Drag area C_D A over the silhouette area is near 0.3 to 1.6 for nearly every body; what lies outside is a fault or deserves a reason. The
silhouette is counted here, on a grid, from the mesh that `dragval mesh --repair` writes: not by the code that is judged. Processor time
and peak memory are those of `dragval mesh`: reading, preparation and rays. Exit code 1 when a file is refused or a ratio lies outside.
"""
import argparse
import json
import math
import os
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

DRAGVAL = Path(os.environ.get("DRAGVAL", Path(__file__).resolve().parent.parent / "build/release/bin/dragval"))
SPEED, DENSITY = 10.0, 1.225  # m/s, kg/m^3: the ratio depends on neither
LEAST, MOST = 0.3, 1.6
CELLS = 1000  # along the larger side of the silhouette's grid: 0.5 % of a body as slender as 1 : 5


class Refused(Exception):
    pass


def run(*arguments):
    """Standard output of dragval, seconds of all its threads, peak memory [MB]."""
    with tempfile.TemporaryFile("w+") as errors:
        process = subprocess.Popen([DRAGVAL, *arguments], stdout=subprocess.PIPE, stderr=errors, text=True)
        text = process.stdout.read()
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode != 0:
            errors.seek(0)
            said = errors.read().strip() or "no message"
            raise Refused(f"exit code {process.returncode}: {said.splitlines()[0]}")
    return text, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def read_binary_stl(path):
    content = path.read_bytes()
    return [corners[3:12] for corners in struct.iter_unpack("<12fH", content[84:])]


def silhouette_area(triangles, axis):
    """Cells of a grid across `axis` whose centre some triangle covers [m^2]."""
    u, v = (k for k in range(3) if k != axis)
    low = [min(min(t[k], t[k + 3], t[k + 6]) for t in triangles) for k in (u, v)]
    high = [max(max(t[k], t[k + 3], t[k + 6]) for t in triangles) for k in (u, v)]
    cell = max(high[0] - low[0], high[1] - low[1]) / CELLS
    rows = [bytearray(CELLS + 1) for _ in range(CELLS + 1)]
    for t in triangles:
        corners = [((t[k + u] - low[0]) / cell, (t[k + v] - low[1]) / cell) for k in (0, 3, 6)]
        bottom, top = min(c[1] for c in corners), max(c[1] for c in corners)
        for row in range(math.ceil(bottom - 0.5), math.floor(top - 0.5) + 1):
            crossings = []
            for (x0, y0), (x1, y1) in zip(corners, corners[1:] + corners[:1]):
                if y0 != y1 and min(y0, y1) <= row + 0.5 <= max(y0, y1):
                    crossings.append(x0 + (x1 - x0) * (row + 0.5 - y0) / (y1 - y0))
            first, last = math.ceil(min(crossings) - 0.5), math.floor(max(crossings) - 0.5)
            rows[row][first:last + 1] = b"\1" * (last + 1 - first)
    return sum(sum(row) for row in rows) * cell * cell


def drag_areas(file, unit):
    """C_D A [m^2] in the winds along x, y and z, each both ways."""
    areas = [[], [], []]
    for angle, turns in (("incidence", "0:270:90"), ("yaw", "90:270:180")):
        text, _, _ = run("drag", file, *unit, "--sweep", angle, turns, "--speed", str(SPEED), "--density", str(DENSITY), "--format", "json")
        for row in json.loads(text)["rows"]:
            wind = row["wind_m_s"]
            axis = max(range(3), key=lambda k: abs(wind[k]))
            along = sum(f * w for f, w in zip(row["force_N"], wind)) / SPEED
            areas[axis].append((-wind[axis], along / (0.5 * DENSITY * SPEED**2)))
    return [[area for _, area in sorted(both)] for both in areas]  # the wind towards + first


def short(findings):
    """Kind and count of all findings: "welded 12, capped 3"; shells have a finding each, which begins with "a"."""
    counts = {}
    for finding in findings:
        kind, _, text = finding.partition(": ")
        count = text.split(" ", 1)[0]
        counts[kind] = counts.get(kind, 0) + (int(count) if count.isdigit() else 1)
    return ", ".join(f"{kind} {count:,}" for kind, count in counts.items()) or "nothing"


def line(file, unit, folder):
    """Cells of the table, and whether all ratios are as expected."""
    repaired = Path(folder) / "repaired.stl"
    text, seconds, memory = run("mesh", file, *unit, "--json", "--repair", str(repaired))
    mesh = json.loads(text)
    triangles = read_binary_stl(repaired)
    ratios = []
    for axis, areas in enumerate(drag_areas(file, unit)):
        silhouette = silhouette_area(triangles, axis)
        ratios.append([area / silhouette if silhouette > 0.0 else math.nan for area in areas])
    cells = [f"{mesh['triangles']:,}", short(mesh["findings"]), mesh["class"]]
    cells += [" / ".join(f"{ratio:.2f}" for ratio in both) for both in ratios]
    cells += [f"{seconds:.2f}", f"{memory:.0f}"]
    return cells, all(LEAST <= ratio <= MOST for both in ratios for ratio in both)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="+", metavar="FILE")
    parser.add_argument("--unit", help="as for dragval")
    options = parser.parse_args()
    if not DRAGVAL.exists():
        sys.exit(f"{DRAGVAL} is not there: scripts/run.sh builds it")
    unit = ["--unit", options.unit] if options.unit else []
    print("| File | Triangles | Found | Class | C_D A / silhouette, +x / -x | +y / -y | +z / -z | CPU s | MB |")
    print("|---|--:|---|---|---|---|---|--:|--:|")
    expected = 0
    with tempfile.TemporaryDirectory() as folder:
        for file in options.files:
            try:
                cells, good = line(file, unit, folder)
            except Refused as refusal:
                cells, good = ["", f"refused: {refusal}".replace("|", "/")] + [""] * 6, False
            expected += good
            print("| " + " | ".join([Path(file).name, *cells]) + " |", flush=True)
    print(f"\n{expected} of {len(options.files)} files have all ratios within {LEAST} to {MOST}.")
    sys.exit(0 if expected == len(options.files) else 1)


if __name__ == "__main__":
    main()
