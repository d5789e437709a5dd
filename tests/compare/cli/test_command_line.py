#!/usr/bin/python3
"""The program as a user sees it: exit codes, messages without stack noise, nothing created or overwritten by mistake."""
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import xml.etree.ElementTree

program, writer = sys.argv[1:3]
SOURCE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../..")


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

    # A measurement enters the store like a run, once; a table that cannot be right changes nothing.
    with open("tunnel.csv", "w") as tunnel:
        tunnel.write("shape,parameters,reynolds,area_m2,C_D,u_C_D,source\nsphere,diameter=1,1e5,0.785398,0.5,0.02,me_2026\n")
    assert "14 cases, 1 measurements entered\n" in run("import", "tunnel.csv", code=0).stdout
    assert "nothing changed" in run("import", "tunnel.csv", code=0).stdout
    assert "sphere_incidence-000_re-1e5_me_2026" in run("compare", "--only", "sphere", "--format", "csv", code=0).stdout
    assert "tunnel.csv" in run("import", "no/tunnel.csv", code=3).stderr
    with open("tunnel.csv", "a") as tunnel:
        tunnel.write("sphere,diameter=1,1e5,0.785398,0.5,,me_2026\n")
    assert "tunnel.csv, line 3" in run("import", "tunnel.csv", code=2).stderr
    os.remove("results/reference.h5")
    run(*collect, code=0)

    # One body from a wind tunnel: a law, a pillow, a map and its error on what was left out; what cannot be told apart is refused.
    with open("box.csv", "w") as tunnel:
        tunnel.write("shape,parameters,incidence_deg,reynolds,area_m2,C_D,u_C_D,C_L,u_C_L,source\n")
        for incidence, drag, lift in ((0, 0.95, 0), (30, 1.6, -0.5), (60, 2.2, -0.45), (90, 2.3, 0), (45, 1.95, -0.6)):
            tunnel.write(f"box,length=2 width=1 height=1,{incidence},1e5,1,{drag},0.03,{lift},0.03,me_2026\n")
    words = run("calibrate", "--wind-tunnel", "box.csv", "--write", "box.h5", code=0).stdout
    for needed in ("5 poses at Re 100000", "class law, pillow fitted", "each pose left out", "no moment tells", "Least sure", "read_calibrated()"):
        assert needed in words, words
    assert os.path.getsize("box.h5") > 10000
    with open("box.csv", "a") as tunnel:
        tunnel.write("cube,side=1,0,1e5,1,1.05,0.03,0,0.03,me_2026\n")
    assert "two bodies" in run("calibrate", "--wind-tunnel", "box.csv", code=2).stderr
    assert "cannot be read" in run("calibrate", "--wind-tunnel", "no.csv", code=3).stderr
    assert "there are: " in run("calibrate", "--stored", "wing", code=2).stderr
    assert "not of one body" in run("calibrate", "--stored", "cube", "--class-laws", code=2).stderr

    # What accuracy costs: an answer first; a wanted error that is no number, or a body that nobody has, is said so.
    words = run("cost", "--quick", code=0).stdout
    assert words.startswith("Nearest without CFD: ") and "Half the error of" in words and "C_D of the body" in words, words
    assert "nothing that was measured reaches it" in run("cost", "--quick", "--target", "0.01%", "--body", "cone", code=0).stdout
    assert "reached by a law" in run("cost", "--quick", "--target", "99", code=0).stdout
    assert json.loads(run("cost", "--quick", "--target", "99%", "--json", code=0).stdout)["target"]["cheapest_law"]["name"]
    assert "such as 2%" in run("cost", "--target", "little", code=2).stderr
    assert "known are" in run("cost", "--quick", "--body", "wing", code=2).stderr

    # Mesh files: a sound one is described, a cut one is refused by name.
    with open("box.obj", "w") as box:
        box.write("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
    described = run("mesh", "box.obj", code=0).stdout
    assert "4 triangles, closed" in described and "extents   1 x 1 x 1 m" in described, described
    assert "class     sharp" in described and "closed with the tilt pillow" in described and "question" not in described, described
    mesh = json.loads(run("mesh", "box.obj", "--json", code=0).stdout)
    assert mesh["law"] == "closed" and mesh["closed"] and abs(mesh["volume_m3"] - 1 / 6) < 1e-12 and mesh["question"] is None, mesh
    assert mesh["centroid_m"] == [0.25, 0.25, 0.25], mesh  # of a tetrahedron: the mean of its corners
    # What is printed is what the forces see: an inside-out copy is turned, a face said twice counts once.
    with open("twice.obj", "w") as twice:
        twice.write("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n" + "f 1 2 3\nf 1 4 2\nf 1 3 4\nf 2 4 3\n" * 2)
    mended = json.loads(run("mesh", "twice.obj", "--json", code=0).stdout)
    assert mended["triangles_of_file"] == 8 and mended["triangles"] == 4 and abs(mended["volume_m3"] - 1 / 6) < 1e-12, mended
    assert mended["closed"] and mended["centroid_m"] == mesh["centroid_m"] and len(mended["findings"]) == 2, mended
    for unit, metres in {"mm": 0.001, "cm": 0.01, "in": 0.0254, "ft": 0.3048, "m": 1.0, "0.5": 0.5}.items():
        scaled = json.loads(run("mesh", "box.obj", "--unit", unit, "--json", code=0).stdout)
        assert scaled["extents_m"] == [metres] * 3, scaled
    assert "mm, cm, m, in, ft" in run("mesh", "box.obj", "--unit", "furlong", code=2).stderr
    run("mesh", "box.obj", "--unit", "-1", code=2)

    # A force of nothing is no force of 0.
    with open("line.obj", "w") as line:
        line.write("v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n")
    for words in (("mesh", "line.obj"), ("drag", "line.obj", "--wind", "1", "0", "0"), ("drag", "line.obj", "--sheet", "--wind", "1", "0", "0")):
        assert "no triangle has an area" in run(*words, code=3).stderr

    # A file in millimetres read as metres raises the question, and an answer ends it.
    with open("large.obj", "w") as large:
        large.write("v 0 0 0\nv 250 0 0\nv 0 250 0\nv 0 0 250\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
    assert "--unit mm" in run("mesh", "large.obj", code=0).stdout
    assert "--unit mm" in run("drag", "large.obj", "--wind", "1", "0", "0", code=0).stderr
    for answer in ("mm", "m"):
        assert "--unit" not in run("drag", "large.obj", "--wind", "1", "0", "0", "--unit", answer, code=0).stderr

    # What the forces see can be written; the file itself stays.
    run("mesh", "box.obj", "--unit", "cm", "--repair", "box.stl", code=0)
    assert json.loads(run("mesh", "box.stl", "--json", code=0).stdout)["triangles"] == 4
    before_repair = open("box.obj").read()
    assert "overwrite" in run("mesh", "box.obj", "--repair", "./box.obj", code=2).stderr
    assert ".stl" in run("mesh", "box.obj", "--repair", "box.ply", code=2).stderr
    assert open("box.obj").read() == before_repair

    # A body baked into a map: its size and its errors are said, files come out by their names, and what cannot be is refused.
    baked = run("bake", "box.obj", "--error", "2%", "--output", "box.h5", code=0)
    assert "KiB" in baked.stdout and "spin ratio 0.3" in baked.stdout and "ns each" in baked.stdout, baked.stdout
    assert open("box.h5", "rb").read(4) == b"\x89HDF" and "wrote box.h5" in baked.stderr
    run("bake", "box.obj", "--error", "0.05", "--law", "note", "--output", "a-box.h", code=0)
    assert "a_box_wrench(" in open("a-box.h").read()
    for word in ("0", "-1%", "100%", "x", "1%%", ""):
        assert "such as 2%" in run("bake", "box.obj", "--error", word, "--output", "no.h5", code=2).stderr, word
    assert ".h5 or .h" in run("bake", "box.obj", "--output", "no.stl", code=2).stderr
    assert "allow more bytes" in run("bake", "box.obj", "--error", "0.01%", "--output", "no.h5", code=2).stderr
    assert "no triangle has an area" in run("bake", "line.obj", "--output", "no.h5", code=3).stderr
    run("bake", "none.stl", code=3)
    run("bake", "box.obj", "--output", "no/such.h5", "--error", "5%", code=3)
    assert not os.path.exists("no.h5")

    # The drag of a cube by the note's law: C_D 1 on its face, q A = 1/2 1.2 10^2 (0.5 m)^2 = 15 N.
    corners = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    faces = ["1 2 4 3", "5 7 8 6", "1 5 6 2", "3 4 8 7", "1 3 7 5", "2 6 8 4"]
    with open("cube.obj", "w") as cube:
        cube.write("".join("v %d %d %d\n" % corner for corner in corners) + "".join("f " + face + "\n" for face in faces))
    air = ("--unit", "0.5", "--density", "1.2", "--law", "note")
    drag = json.loads(run("drag", "cube.obj", "--wind", "-10", "0", "0", *air, "--format", "json", code=0).stdout)
    row = drag["rows"][0]
    assert abs(row["force_N"][0] + 15) < 1e-9 and abs(row["coefficients"]["C_D"] - 1) < 1e-12, row
    assert all(abs(x - 0.25) < 1e-12 for x in drag["moment_centre_m"]) and max(map(abs, row["torque_N_m"])) < 1e-9, drag
    assert abs(drag["area_m2"] - 0.25) < 1e-12 and "frontal" in drag["area_is"] and drag["length_m"] == 0.5, drag
    # About another point: r x F with r = (0.25, 0.25, 0.25) from the corner gives M = (0, -15/4, 15/4) N m.
    head_on = ("drag", "cube.obj", "--wind", "-10", "0", "0", *air, "--format", "json")
    about = json.loads(run(*head_on, "--centre", "0", "0", "0", code=0).stdout)
    assert all(abs(a - b) < 1e-9 for a, b in zip(about["rows"][0]["torque_N_m"], (0, -3.75, 3.75))), about
    # A pose and the wind that it means are the same; areas and lengths scale coefficients, and nothing else.
    as_json = ("drag", "cube.obj", *air, "--format", "json")
    posed = run(*as_json, "--yaw", "30", "--incidence", "10", "--area", "2", "--length", "3", code=0).stdout
    posed = json.loads(posed)["rows"][0]
    by_wind = run(*as_json, "--wind", *map(str, posed["wind_m_s"]), "--area", "1", "--length", "1", code=0).stdout
    by_wind = json.loads(by_wind)["rows"][0]
    for name, value in posed["coefficients"].items():
        assert abs(by_wind["coefficients"][name] - value * (2 if name[2].isupper() else 6)) < 1e-9, (name, posed, by_wind)
    # A cube of 1 mm at 2 cm/s, Re 1.4: air with viscosity drags it as creeping flow does, C_D about 30; without, as at Re 1e5.
    slow = ("drag", "cube.obj", "--unit", "0.001", "--speed", "0.02", "--format", "json")
    thick, thin = (json.loads(run(*slow, *known, code=0).stdout)["rows"][0] for known in (("--viscosity", "1.8e-5"), ()))
    assert 15 < thick["coefficients"]["C_D"] < 35 and 0.8 < thin["coefficients"]["C_D"] < 1.2, (thick, thin)
    sweep = run("drag", "cube.obj", "--sweep", "yaw", "0:90:22.5", *air, "--format", "csv", code=0).stdout.splitlines()
    columns = sweep[0].split(",")
    values = [dict(zip(columns, line.split(","))) for line in sweep[1:]]
    assert [float(row["yaw_deg"]) for row in values] == [0, 22.5, 45, 67.5, 90], sweep
    # One area for the sweep, the cube edge-on; a quarter turn gives the same drag and, mirrored, the opposite side force.
    assert all(abs(float(row["area_m2"]) - 0.25 * 2**0.5) < 1e-8 for row in values), sweep
    assert abs(float(values[0]["C_D"]) - float(values[4]["C_D"])) < 1e-8, sweep
    assert abs(float(values[1]["C_S"]) + float(values[3]["C_S"])) < 1e-8 and abs(float(values[1]["C_S"])) > 0.01, sweep
    shown = run("drag", "cube.obj", "--sweep", "yaw", "0:90:22.5", "--speed", "20", code=0).stdout
    assert "law closed" in shown and "tilt pillow" in shown and "22.5°" in shown, shown
    assert "the largest of the sweep, at yaw 45°" in shown, shown
    assert max(map(len, shown.splitlines()[6:])) <= 132, shown
    still = run("drag", "cube.obj", "--spin", "0", "0", "20", code=0).stdout
    assert "still air" in still and "no coefficients" in still, still
    with open("sheet.obj", "w") as sheet:
        sheet.write("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n")
    edge_on = ("drag", "sheet.obj", "--incidence", "180", "--format", "json")
    assert json.loads(run(*edge_on, code=0).stdout)["rows"][0]["coefficients"] is None
    assert abs(json.loads(run(*edge_on, "--area", "1", code=0).stdout)["rows"][0]["coefficients"]["C_D"]) < 0.1
    assert "--wind 10 0 2" in run("drag", "cube.obj", code=2).stderr
    assert "did you mean yaw" in run("drag", "cube.obj", "--sweep", "yav", "0:90:5", code=2).stderr
    for range_ in ("0:90", "90:0:5", "0:90:0", "0:90:5:1", "a:b:c", "0:90:1e-9"):
        assert "--sweep" in run("drag", "cube.obj", "--sweep", "yaw", range_, code=2).stderr
    run("drag", "cube.obj", "--wind", "10", "0", code=2)
    run("drag", "cube.obj", "--wind", "10", "0", "0", "--speed", "3", code=2)
    assert "nothing.stl" in run("drag", "nothing.stl", "--wind", "1", "0", "0", code=3).stderr
    # Normals that point inwards are turned, and that is said.
    with open("inside_out.obj", "w") as inverted:
        inverted.write("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 4 2\nf 1 3 4\nf 2 4 3\n")
    turned = run("mesh", "inside_out.obj", "--repair", "outside.stl", code=0).stdout
    assert "inside out" in turned and "turned" in turned and "1 x 1 x 1 m" in turned, turned
    assert "found" not in run("mesh", "outside.stl", code=0).stdout
    with open("cut.stl", "wb") as cut:
        cut.write(bytes(80) + (12).to_bytes(4, "little") + bytes(100))
    refused = run("mesh", "cut.stl", code=3).stderr
    assert "cut.stl" in refused and "truncated" in refused and "12 triangles" in refused, refused

    table = run("compare", code=0)
    assert "plate, Re 100000, k_omega_sst" in table.stdout and "\x1b" not in table.stdout, table.stdout
    assert os.path.exists("results/comparison.h5")
    lines = table.stdout.splitlines()
    assert lines[0].startswith("error = model - CFD") and "by class, tilt pillow" in lines[3], table.stdout
    assert table.stdout.index("rms error of") < table.stdout.index("Errors by group") < table.stdout.index("incidence 30")
    cubes = json.loads(run("compare", "--only", "cube", "--json", "--output", "", code=0).stdout)
    every = json.loads(run("compare", "--json", "--output", "", code=0).stdout)
    assert cubes["compared"] == 4 and {row["shape"] for row in cubes["rows"]} == {"cube"} and not cubes["spin"], cubes
    assert cubes["rows"] == [row for row in every["rows"] if row["shape"] == "cube"]
    pattern = json.loads(run("compare", "--only", "cone_*-06?_*", "--json", "--output", "", code=0).stdout)
    assert {row["case"] for row in pattern["rows"]} == {"cone_incidence-060_re-1e5_medium"}, pattern
    assert "'zeppelin' in its name" in run("compare", "--only", "zeppelin", "--output", "", code=5).stderr
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
    assert "no difference" in run("baseline", "diff", "--all", code=0).stdout
    assert "no error of a case that both have changes" in run("baseline", "diff", code=0).stdout
    # A law of one's own has a baseline of its own, and its constants are watched.
    law = open(os.path.join(SOURCE, "dragcore/laws/closed.toml")).read()
    open("mine.toml", "w").write(law)
    run("baseline", "accept", "--law", "mine.toml", "--baseline", "mine.json", "--reason", "a fork", code=0)
    assert list(json.load(open("mine.json"))["models"]) == ["mine.toml"]
    assert "gate passed" in run("gate", "--law", "mine.toml", "--baseline", "mine.json", code=0).stdout
    open("mine.toml", "w").write(re.sub(r"(base_suction *= *)([0-9.]+)", lambda m: m[1] + str(1.1 * float(m[2])), law))
    assert "mine.toml: case error" in run("gate", "--law", "mine.toml", "--baseline", "mine.json", code=1).stdout
    changed = run("baseline", "diff", "--law", "mine.toml", "--baseline", "mine.json", code=0).stdout
    assert "The largest changes" in changed and "mine.toml" in changed, changed
    assert "not in the baseline" in run("gate", "--baseline", "mine.json", code=5).stdout
    junit = xml.etree.ElementTree.fromstring(run("gate", "--format", "junit", code=0).stdout).find("testsuite")
    assert int(junit.get("tests")) == len(junit.findall("testcase")) > 10 and junit.get("failures") == "0"
    assert "gate passed" in run("gate", "--format", "md", code=0).stdout
    assert "junit" in run("gate", "--format", "xml", code=2).stderr
    assert "--solved" in run("gate", "--solved-budget", "1%", code=2).stderr
    precious = open("mine.json").read()
    refused = run("calibrate", "--stored", "cube", "--write", "mine.json", code=2).stderr
    assert "mine.json" in refused and "no calibrated model" in refused and open("mine.json").read() == precious, refused
    # A typo leaves nothing behind, and poses of one body are not those of another of the same name.
    bracket = os.path.join(SOURCE, "cfd_cases/bodies/l_bracket.stl")
    of_mesh = ("calibrate", "--mesh", bracket, "--dry-run", "--poses", "3", "--cache", "of_mesh")
    assert "coarze" in run(*of_mesh, "--levels", "coarze", code=2).stderr
    run(*of_mesh, "--levels", "coarse", code=0)
    os.mkdir("alt")
    shutil.copy(os.path.join(SOURCE, "cfd_cases/bodies/cup.stl"), "alt/l_bracket.stl")
    refused = run("calibrate", "--mesh", "alt/l_bracket.stl", "--dry-run", "--cache", "of_mesh", code=2).stderr
    assert "other triangles" in refused and "--cache" in refused, refused
    assert "finite" in run("calibrate", "--stored", "cube", "--reynolds", "nan", code=2).stderr
    assert "above 0" in run("explain", "cube", "yaw 30", "--re", "nan", code=2).stderr
    assert "nocache" in run("gate", "--solved", "nocache", code=3).stderr
    assert "dragval run seeds" in run("odds", "--solved", "cache", code=2).stderr
    baseline = json.load(open("results/baselines/quick.json"))
    some_case = baseline["planned"][0]
    baseline["models"]["note"]["cases"][some_case]["C_D"]["model"] += 1e-6
    json.dump(baseline, open("changed.json", "w"))
    assert "FAIL" in run("gate", "--baseline", "changed.json", code=1).stdout
    widened = json.load(open("results/baselines/quick.json"))
    widened["case_budget"] = 1e9
    json.dump(widened, open("widened.json", "w"))
    refused = run("gate", "--baseline", "widened.json", code=1).stdout
    assert "budget 1e+09" in refused and "at most 0.01" in refused, refused
    baseline["planned"].append("a case that nobody solved")
    json.dump(baseline, open("changed.json", "w"))
    assert "a case that nobody solved" in run("gate", "--baseline", "changed.json", code=5).stdout

    open("truncated.h5", "wb").write(before[: len(before) // 2])
    assert "truncated.h5" in run("compare", "--store", "truncated.h5", code=3).stderr
    gone = run("compare", "--store", "text.json", code=3).stderr
    assert "text.json" in gone and os.getcwd() in gone and "--store" in gone, gone
    assert "--cache" in run("compare", "--cache", "gone", code=3).stderr
    os.mkdir("empty")
    run("compare", "--cache", "empty", "--output", "", code=5)
    run("collect", "--cache", "empty", code=5)
    assert "note, consistent" in run("compare", "--law", "nonsense", code=2).stderr
    assert "did you mean consistent?" in run("compare", "--law", "consistant", code=2).stderr
    assert "--factor" in run("compare", "--pillow", "tilt", code=2).stderr
    assert "--pillow" in run("compare", "--factor", "0.5", code=2).stderr
    run("compare", "--pillow", "nonsense", code=2)
    run("compare", "--by", "nonsense", code=2)
    run("compare", "--format", "nonsense", code=2)
    run("compare", "--nonsense", code=2)
    unknown = run("nonsense", code=2).stderr
    assert "did you mean" not in unknown and "compare" in unknown and "drag" in unknown, unknown
    assert "did you mean compare?" in run("comapre", code=2).stderr
    assert "did you mean accept?" in run("baseline", "acept", "--reason", "x", code=2).stderr
    run(code=2)
    assert "Example" in run("compare", "--help", code=0).stdout
