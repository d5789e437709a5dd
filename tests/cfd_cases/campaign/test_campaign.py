#!/usr/bin/python3
"""Drives the program dragval through a campaign: kill -9 and resume, divergence, a missing OpenFOAM, a wrong matrix.

Usage: test_campaign.py DRAGVAL. Needs OpenFOAM; takes about half a minute.
"""
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time

DRAGVAL = os.path.abspath(sys.argv[1])

TWO_CASES = """
[defaults]
mesh = "coarse"
reynolds = 100
flow_model = "laminar"
[[sweep]]
shape = "sphere"
[[sweep]]
shape = "cube"
"""

DIVERGES = """
[[sweep]]
shape = "sphere"
mesh = "coarse"
reynolds = 100
flow_model = "laminar"
retries = 0
variant = "unstable"
numerics = { relaxation_velocity = 1.0, relaxation_pressure = 1.0 }
"""


def dragval(folder, *arguments, **options):
    return subprocess.run([DRAGVAL, *arguments], cwd=folder, capture_output=True, text=True, timeout=300, **options)


def expect(condition, message, result=None):
    if not condition:
        sys.exit(f"FAILED: {message}" + (f"\n{result.stdout}\n{result.stderr}" if result else ""))


def solvers_below(folder):
    """Processes that work in the folder."""
    found = []
    for process in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            state = (process / "stat").read_text().rsplit(")", 1)[1].split()[0]
            if state != "Z" and os.readlink(process / "cwd").startswith(str(folder / ".dragval")):
                found.append(process.name)
        except OSError:
            pass
    return found


def wait_for(condition, seconds, message):
    end = time.monotonic() + seconds
    while not condition():
        expect(time.monotonic() < end, message)
        time.sleep(0.05)


def kill_and_resume(folder):
    (folder / "two.toml").write_text(TWO_CASES)
    runs = folder / ".dragval/runs"
    campaign = subprocess.Popen([DRAGVAL, "run", "two.toml"], cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    # One case done, the other one at work.
    wait_for(lambda: runs.exists() and any(runs.glob("*.h5")) and solvers_below(folder), 200, "the first case does not end")
    campaign.send_signal(signal.SIGKILL)
    campaign.wait()
    wait_for(lambda: not solvers_below(folder), 10, "kill -9 of the program left its solver running")
    stored = {path.name: path.stat().st_mtime_ns for path in runs.glob("*.h5")}
    expect(len(stored) == 1, f"{len(stored)} runs are stored after the kill, needed 1")

    plan = json.loads(dragval(folder, "plan", "two.toml", "--json").stdout)
    expect(plan["to_solve"] == 1, "the plan after the kill does not name one case to solve")

    resumed = dragval(folder, "run", "two.toml")
    expect(resumed.returncode == 0, "the resumed campaign fails", resumed)
    expect("1 solved, 1 were in the cache" in resumed.stdout, "the resumed campaign solved something twice", resumed)
    for path in runs.glob("*.h5"):
        expect(path.stat().st_mtime_ns == stored.get(path.name, path.stat().st_mtime_ns), "a finished run was written again")
    expect(not list((folder / ".dragval/work").iterdir()), "a finished case left its folder")

    began = time.monotonic()
    again = dragval(folder, "run", "two.toml")
    expect(again.returncode == 0 and "0 solved, 2 were in the cache" in again.stdout, "a second run solves again", again)
    # A promise of the program; it takes 0.2 s on an idle machine, the rest is room for busy ones.
    expect(time.monotonic() - began < 5.0, "a second run takes more than 5 s")


def interrupt(folder):
    (folder / "two.toml").write_text(TWO_CASES.replace("100\n", "120\n"))
    campaign = subprocess.Popen([DRAGVAL, "run", "two.toml"], cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    wait_for(lambda: solvers_below(folder), 30, "no case begins")

    def states():
        return sorted(case["state"] for case in json.loads(dragval(folder, "explain", "re-1.2e2", "--matrix", "two.toml", "--json").stdout))

    expect(states() == ["running", "to solve"], f"explain during a run says {states()}")
    campaign.send_signal(signal.SIGINT)
    _, messages = campaign.communicate(timeout=30)
    expect(campaign.returncode == 130 and "interrupted" in messages, f"Ctrl-C ends with {campaign.returncode}: {messages}")
    expect(not solvers_below(folder), "Ctrl-C left a solver running")
    expect(states() == ["interrupted", "to solve"], f"explain after Ctrl-C says {states()}")


def divergence(folder):
    (folder / "diverges.toml").write_text(DIVERGES)
    result = dragval(folder, "run", "diverges.toml")
    expect(result.returncode == 4, f"a diverging case ends with code {result.returncode}, needed 4", result)
    expect("diverged" in result.stderr and "--retry-failed" in result.stderr, "the divergence is not reported with the command to repeat it", result)
    cached = dragval(folder, "run", "diverges.toml")
    expect(cached.returncode == 4 and "0 solved, 1 were in the cache" in cached.stdout, "a stored failure is solved again unasked, or forgotten", cached)
    explained = json.loads(dragval(folder, "explain", "sphere", "--matrix", "diverges.toml", "--json").stdout)[0]
    expect(explained["state"] == "diverged" and explained["reason"] and explained["attempts"][0]["recipe"] == "standard", f"explain says {explained}")
    expect(pathlib.Path(folder / explained["log"]).is_file() and explained["folder"], "the folder of a failed case is not kept")


def stale(folder):
    (folder / "two.toml").write_text(TWO_CASES.replace('[[sweep]]\nshape = "cube"', "").replace('"laminar"', '"laminar"\nmax_iterations = 900'))
    explained = json.loads(dragval(folder, "explain", "sphere", "--matrix", "two.toml", "--json").stdout)[0]
    expect(any("/stop/max_iterations: 800 then, 900 now" in line for line in explained["differs_from_stored"]), f"explain does not say why the case is stale: {explained}")


def faults(folder):
    (folder / "wrong.toml").write_text('[[sweep]]\nshape = "sphere"\nincidense_deg = 3\n')
    wrong = dragval(folder, "run", "wrong.toml")
    expect(wrong.returncode == 2 and "wrong.toml:3:1: unknown key 'incidense_deg'" in wrong.stderr, "an unknown key is not refused with its place", wrong)

    bare = dict(os.environ, PATH="/nowhere")
    missing = dragval(folder, "run", "two.toml", env=bare)
    expect(missing.returncode == 3 and "apt-get install openfoam" in missing.stderr, "a missing OpenFOAM is not reported with its fix", missing)
    doctor = dragval(folder, "doctor", "--json", env=bare)
    expect(doctor.returncode == 3 and any(check["fix"] for check in json.loads(doctor.stdout)), "doctor does not see that OpenFOAM is missing", doctor)

    run = next((folder / ".dragval/runs").glob("*.h5"))
    run.write_bytes(run.read_bytes()[:1000])
    (folder / "two.toml").write_text(TWO_CASES)
    truncated = dragval(folder, "run", "two.toml")
    expect(truncated.returncode == 3 and run.name in truncated.stderr, "a truncated run is not refused by name", truncated)
    expect(run.stat().st_size == 1000, "a truncated run was overwritten")


with tempfile.TemporaryDirectory() as name:
    place = pathlib.Path(name).resolve()
    for step in (kill_and_resume, interrupt, divergence, stale, faults):
        step(place)
        print("passed:", step.__name__.replace("_", " "), flush=True)
