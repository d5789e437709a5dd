#!/usr/bin/env python3
"""The table of targets from outputs made here: met, missed with its reason, not measured, bits that differ; of repetitions the least time
and the highest rate.

Usage: test_targets.py TARGETS.py
"""
import json
import subprocess
import sys
import tempfile
from pathlib import Path


def output(folder, name, instruction_set, rows):
    """As google-benchmark writes it; `rows`: (name, ns, triangles, hash)."""
    runs = [{"run_name": row, "family_index": 1, "aggregate_name": statistic, "time_unit": "us", "real_time": 9e9,
             "cpu_time": 1e-3 * ns * factor, "per_triangle": 1e-9 * ns * factor / triangles, "error": 1e-8, "label": digits}
            for row, ns, triangles, digits in rows for statistic, factor in (("mean", 2.0), ("least", 1.0))]
    runs += [{"run_name": "machine/fma", "family_index": 0, "aggregate_name": statistic, "time_unit": "us", "real_time": 1.0,
              "cpu_time": 1.0, "items_per_second": rate} for statistic, rate in (("least", 1e9), ("most", 160e9))]
    caches = [{"type": "Data", "level": 1, "size": 48000}, {"type": "Unified", "level": 2, "size": 2000000}]
    path = folder / f"{name}.json"
    path.write_text(json.dumps({"context": {"instruction_set": instruction_set, "date": "2026-01-01T00:00:00", "caches": caches,
                                            "load_avg": [0.1, 0.1, 0.1]}, "benchmarks": runs}))
    return path


with tempfile.TemporaryDirectory() as name:
    folder = Path(name)
    ball, n = "wrench/{}/ball-12800/straight/{}", 12800
    loop = ("textbook/ball-12800/straight", 10.0 * n, n, "a")
    raw = [output(folder, "wide", "AVX3", [loop, (ball.format("single", "note"), 0.25 * n, n, "b"),
                                           (ball.format("single", "class+pillow"), 2.0 * n, n, "c")]),
           output(folder, "narrow", "AVX2", [loop, (ball.format("single", "note"), 0.5 * n, n, "b"),
                                             (ball.format("single", "class+pillow"), 2.0 * n, n, "d")]),
           output(folder, "old", "recorded", [(ball.format("recorded", "class+pillow"), 200.0 * n, n, "e")])]
    counted = folder / "instructions.json"
    counted.write_text(json.dumps({"wrench/single/ball-2048/straight/note": {"instructions": 1, "operations": 20 * 2048}}))
    subprocess.run([sys.executable, sys.argv[1], folder / "made", *raw, "--instructions", counted], check=True, capture_output=True)
    table = (folder / "made/targets.md").read_text()
    stored = json.loads((folder / "made/rows.json").read_text())

needed = [
    "against the textbook loop, AVX-512 | 0.4 | ≥ 30 x | 40 | 1.33 | met |  |",
    "against the textbook loop, AVX2 | 0.4 | ≥ 24 x | 20 | 0.83 | missed | ",
    "ball-12800, AVX-512 | 170 to 220 | ≤ 1.6 ns/triangle | 2 | 1.25 | missed | ",
    "ball-12800, AVX2 | 170 to 220 | ≤ 2.5 ns/triangle | 2 | 0.80 | met |  |",
    "| the same, against 3f4dda5 | 1 | ≥ 70 x | 100 | 1.43 | met |  |",
    "| baked ball-2048, best model, one call | - | ≤ 10 ns | - | - | not measured | no row `baked/ball-2048/straight` |",
    "rows with the same hash | - | ≥ 100 % | 50 | 0.50 | missed | not known |",
    "| ball-12800 | straight, note | 0.25 | 40.0 |  | 80.0 |  | 80.0 | 50% |",  # 20 bytes and 20 operations in a quarter of a ns
]
faults = [f"not in the table: {line}" for line in needed if line not in table]
if stored["AVX-512"]["textbook/ball-12800/straight"] != {"ns": 128000.0, "hash": "a", "per_triangle": 10.0, "error": 1e-08}:
    faults.append(f"rows.json has {stored['AVX-512']['textbook/ball-12800/straight']}")
print("\n".join([*faults, table] if faults else ["the table is as its outputs say"]))
sys.exit(bool(faults))
