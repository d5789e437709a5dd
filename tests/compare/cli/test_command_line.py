#!/usr/bin/python3
"""The program as a user sees it: exit codes, messages without stack noise, nothing created or overwritten by mistake."""
import json
import os
import subprocess
import sys
import tempfile

program, writer = sys.argv[1:3]


def run(*words, code):
    done = subprocess.run([program, *words], capture_output=True, text=True)
    assert done.returncode == code, f"dragval {' '.join(words)}: exit {done.returncode}, {code} needed\n{done.stdout}{done.stderr}"
    if code in (2, 3):
        assert done.stderr.strip() and "terminate" not in done.stderr, done.stderr
    return done


with tempfile.TemporaryDirectory() as folder:
    os.chdir(folder)
    subprocess.run([writer, folder], check=True)
    collect = ("collect", "--cache", "cache", "--into", "results/reference.h5")
    assert "13 cases" in run(*collect, code=0).stdout
    before = open("results/reference.h5", "rb").read()
    assert "nothing changed" in run(*collect, code=0).stdout
    assert open("results/reference.h5", "rb").read() == before

    # Mesh files: a sound one is described, a cut one is refused by name.
    with open("box.obj", "w") as box:
        box.write("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
    assert "4 triangles, closed" in run("mesh", "box.obj", code=0).stdout
    with open("cut.stl", "wb") as cut:
        cut.write(bytes(80) + (12).to_bytes(4, "little") + bytes(100))
    refused = run("mesh", "cut.stl", code=3).stderr
    assert "cut.stl" in refused and "truncated" in refused and "12 triangles" in refused, refused

    table = run("compare", code=0)
    assert "plate, Re 100000, k_omega_sst" in table.stdout and "\x1b" not in table.stdout, table.stdout
    assert os.path.exists("results/comparison.h5")
    for format in ("md", "csv", "json"):
        assert run("compare", "--format", format, "--output", "", code=0).stdout
    document = json.loads(run("compare", "--json", "--law", "consistent", "--cache", "cache", code=0).stdout)
    rows = document["rows"]
    assert {row["case"] for row in rows if row["error"] is not None} and len({row["case"] for row in rows}) == 12
    # A body that spins has a table of its own and no row anywhere else.
    assert [row["case"] for row in document["spin"]] == ["sphere_spin-z_re-4-laminar_medium"]
    assert "spin" not in json.dumps(rows) and "Bodies that spin" in table.stdout

    # A baseline is made only on request, and with a reason.
    assert "baseline accept" in run("gate", code=2).stderr
    assert not os.path.exists("results/baselines/quick.json")
    run("baseline", "accept", code=2)
    run("baseline", "accept", "--reason", "first", code=0)
    assert json.loads(run("gate", "--json", code=0).stdout)["passed"]
    assert "no difference" in run("baseline", "diff", code=0).stdout
    baseline = json.load(open("results/baselines/quick.json"))
    some_case = baseline["planned"][0]
    baseline["models"]["note"]["cases"][some_case]["C_D"]["model"] += 1e-6
    json.dump(baseline, open("changed.json", "w"))
    assert "FAIL" in run("gate", "--baseline", "changed.json", code=1).stdout
    baseline["planned"].append("a case that nobody solved")
    json.dump(baseline, open("changed.json", "w"))
    assert "a case that nobody solved" in run("gate", "--baseline", "changed.json", code=5).stdout

    open("truncated.h5", "wb").write(before[: len(before) // 2])
    assert "truncated.h5" in run("compare", "--store", "truncated.h5", code=3).stderr
    assert "text.json" in run("compare", "--store", "text.json", code=3).stderr
    os.mkdir("empty")
    run("compare", "--cache", "empty", "--output", "", code=5)
    run("collect", "--cache", "empty", code=5)
    assert "note, consistent" in run("compare", "--law", "nonsense", code=2).stderr
    run("compare", "--pillow", "nonsense", code=2)
    run("compare", "--by", "nonsense", code=2)
    run("compare", "--format", "nonsense", code=2)
    run("compare", "--nonsense", code=2)
    run("nonsense", code=2)
    run(code=2)
    assert "Example" in run("compare", "--help", code=0).stdout
