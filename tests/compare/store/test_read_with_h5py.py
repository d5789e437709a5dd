#!/usr/bin/python3
"""Runs the reader printed in docs/results.md on a sample file and checks what it prints, and the attributes of every dataset."""
import re
import subprocess
import sys
import tempfile

import h5py

page, writer = sys.argv[1:3]
blocks = re.findall(r"```python\n(.*?)```", open(page, encoding="utf-8").read(), re.S)
assert len(blocks) == 1, f"{page} has {len(blocks)} python blocks, 1 is needed"
lines = [line for line in blocks[0].splitlines() if line.strip()]
assert len(lines) <= 10, f"the reader has {len(lines)} lines, the page promises ten"

with tempfile.TemporaryDirectory() as folder:
    subprocess.run([writer, folder], check=True)
    reader = blocks[0].replace("results/reference.h5", f"{folder}/reference.h5")
    printed = subprocess.run(["/usr/bin/python3", "-c", reader], check=True, capture_output=True, text=True).stdout
    rows = printed.strip().splitlines()
    assert len(rows) == 13, f"{len(rows)} rows printed, 13 cases are in the sample:\n{printed}"
    # The face of the cube: C_p = 2 c^2 - 0.5 in front, -0.5 behind, shear 0.01 on all six faces: C_D = 2 + 0.06.
    cube = next(row for row in rows if row.startswith("cube_yaw-000"))
    drag = float(re.search(r"C_D\s+(\S+)", cube).group(1))
    assert abs(drag - 2.06) < 1e-3, f"C_D {drag} of the cube, 2.06 expected: {cube}"  # the reader prints four digits

    def check(name, item):
        if isinstance(item, h5py.Dataset):
            for needed in ("units", "long_name"):
                assert needed in item.attrs, f"{name} has no attribute {needed}"
            if name.startswith("cases/") and "uncertainty" in item.attrs:
                named = item.attrs["uncertainty"].decode()
                assert named in item.parent, f"{name} names an uncertainty {named} that is not there"
            if item.dtype.kind == "f" and item.shape[1:] == (3,):
                assert "frame" in item.attrs, f"the vector {name} has no frame"

    for file in ("reference.h5", "run.h5"):
        with h5py.File(f"{folder}/{file}") as store:
            store.visititems(check)
            assert store["cases/force_pressure"].dims[0][0].name == "/cases/name", "rows are not labelled with case names"
    with h5py.File(f"{folder}/reference.h5") as store:
        # Patches carry the pressure force of their case.
        cases, patches = store["cases"], store["patches"]
        q = 0.5 * cases["density"][:] * cases["speed"][:] ** 2
        first = patches["case_index"][:] == 0
        size = sum(patches["pressure_force"][first] * q[0])
        expected = cases["last_force_pressure"][0]
        assert abs((size**2).sum() ** 0.5 - (expected**2).sum() ** 0.5) < 1e-9, f"{size} against {expected}"
