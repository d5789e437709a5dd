#!/usr/bin/python3
"""Drives the program dragval on a real Slurm of one node: equal results, lost nodes, cancelled and failing jobs, refusals, overhead.

Usage: test_slurm.py DRAGVAL. Needs OpenFOAM, Slurm and munge; at least the minute of the shortest time limit, eight under load.
"""
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time

import h5py
import numpy

from one_node_slurm import OneNodeSlurm

DRAGVAL = os.path.abspath(sys.argv[1])

# One case of a few seconds; the Reynolds number makes it a new one for each test.
ONE_CASE = """
[[sweep]]
shape = "{shape}"
mesh = "coarse"
reynolds = {reynolds}
flow_model = "laminar"
"""


class Place:
    """A folder in which dragval works, with the cluster's configuration in the environment."""

    def __init__(self, folder, slurm):
        self.folder, self.slurm = folder, slurm

    def command(self, *arguments):
        return [DRAGVAL, *arguments]

    def start(self, *arguments):
        return subprocess.Popen(self.command(*arguments), cwd=self.folder, env=self.slurm.environment, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)

    def dragval(self, *arguments, environment=None):
        return subprocess.run(self.command(*arguments), cwd=self.folder, env=environment or self.slurm.environment, text=True, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, timeout=300)

    def finish(self, process):
        output, _ = process.communicate(timeout=300)
        return subprocess.CompletedProcess(process.args, process.returncode, output)

    def matrix(self, name, shape, reynolds):
        (self.folder / name).write_text(ONE_CASE.format(shape=shape, reynolds=reynolds))
        return name

    def submissions(self, cache):
        return sorted((self.folder / cache / "slurm").glob("dragval-*"))

    def plan(self, matrix, cache):
        return json.loads(self.dragval("plan", matrix, "--json", "--cache", cache).stdout)["cases"]


def expect(condition, message, result=None):
    if not condition:
        raise SystemExit(f"FAILED: {message}" + (f"\n{result.stdout}" if result else ""))


def wait_for(condition, seconds, message):
    end = time.monotonic() + seconds
    while not (found := condition()):
        expect(time.monotonic() < end, message)
        time.sleep(0.1)
    return found


def values(run):
    """What a case determines: all that is stored but its cost and date, which are of the day, and what belongs to the last iteration, of which
    the solver does one or two more before it hears that it is to stop."""
    found = {}

    def visit(name, item):
        of_the_day = "cost" in name or name.endswith("finished")
        of_the_last = "last_" in name or name.startswith("surface/") or name == "cases/iterations"
        if isinstance(item, h5py.Dataset) and not of_the_day and not of_the_last:
            found[name] = item[()]

    with h5py.File(run) as file:
        file.visititems(visit)
    return found


def expect_equal_runs(first, second):
    ours, theirs = ({path.name: path for path in pathlib.Path(folder).glob("*.h5")} for folder in (first, second))
    expect(ours and ours.keys() == theirs.keys(), f"the keys differ: {sorted(ours)} and {sorted(theirs)}")
    count = 0
    for name in ours:
        a, b = values(ours[name]), values(theirs[name])
        expect(a.keys() == b.keys(), f"the datasets of {name} differ")
        for dataset in a:
            expect(numpy.array_equal(a[dataset], b[dataset]), f"{dataset} of {name} differs: {a[dataset]} and {b[dataset]}")
            count += numpy.size(a[dataset])
    print(f"  {len(ours)} runs equal to the bit in {count} values")


def same_as_local(place):
    # Both at the same time, which is also what two people do. The second driver on Slurm's cache must submit nothing.
    local = place.start("run", "smoke", "--cache", "local")
    submitted = place.dragval("run", "smoke", "--executor", "slurm", "--slots", "2", "--detach", "--cache", "shared")
    expect(submitted.returncode == 0, "the jobs are not submitted", submitted)
    folders = place.submissions("shared")
    expect(all("in Slurm, job" in case["slurm"] for case in place.plan("smoke", "shared")), f"plan does not show what Slurm holds: {place.plan('smoke', 'shared')}")
    followed = place.dragval("run", "smoke", "--executor", "slurm", "--cache", "shared")
    expect(followed.returncode == 0 and "2 cases are with Slurm already" in followed.stdout and "2 solved" in followed.stdout, "the jobs are not followed to their end", followed)
    expect(place.submissions("shared") == folders, "a case was submitted twice")
    local = place.finish(local)
    expect(local.returncode == 0, "the local run fails", local)
    expect_equal_runs(place.folder / "shared/runs", place.folder / "local/runs")
    again = place.dragval("run", "smoke", "--executor", "slurm", "--cache", "shared")
    expect(again.returncode == 0 and "0 solved, 2 were in the cache" in again.stdout, "a second run solves again", again)


def overhead(place):
    # The jobs above once more: each finds its case in the cache, and what is left is Slurm and the start of the program.
    arrays = 5
    script = sorted((folder / "script" for folder in place.submissions("shared")), key=lambda path: "array=1-2" in path.read_text())[-1]
    tasks = arrays * int(script.read_text().split("--array=1-")[1].split("%")[0].split("\n")[0])
    command = ["sbatch", "--parsable", f"--chdir={script.parent}", "--job-name=overhead", "--output=/dev/null", str(script)]
    began = time.monotonic()
    for _ in range(arrays):
        place.slurm.ask(*command)
    accepted = time.monotonic()
    wait_for(lambda: "RUNNING" in place.slurm.ask("squeue", "--noheader", "--format=%T"), 60, "no job starts")
    started = time.monotonic()
    wait_for(lambda: not place.slurm.ask("squeue", "--noheader", "--format=%T"), 100, "the jobs do not end")
    ended = time.monotonic()
    log = script.parent / "1.log"
    begin = time.monotonic()
    place.dragval("plan", "smoke", "--cache", "shared")
    print(f"  overhead on {os.cpu_count()} cores: submission of an array {(accepted - began) / arrays:.2f} s, to the first start {started - accepted:.1f} s, "
          f"then {(ended - started) * min(os.cpu_count(), tasks) / tasks:.2f} s of a slot per case; the program alone starts in {time.monotonic() - begin:.2f} s")
    expect(log.exists(), "the jobs wrote no log")


def processes_of(job, slurm):
    """slurmstepd of a job and all it started, by what only they have."""
    found = []
    for process in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            environment = (process / "environ").read_bytes().split(b"\0")
            ours = f"SLURM_CONF={slurm.folder}/slurm.conf".encode() in environment and f"SLURM_JOB_ID={job}".encode() in environment
            stepd = (process / "cmdline").read_bytes().startswith(f"slurmstepd: [{job}.".encode())
            if ours or stepd:
                found.append(int(process.name))
        except OSError:
            pass
    return found


def lost_node(place):
    matrix = place.matrix("lost.toml", "cube", 110)
    follower = place.start("run", matrix, "--executor", "slurm", "--cache", "lost")
    work = place.folder / "lost/work"
    wait_for(lambda: any(work.glob("*/standard/log.simpleFoam")), 90, "the case does not come to be solved")
    job = place.slurm.ask("squeue", "--noheader", "--states=running", "--format=%A")
    restarts = lambda: int(place.slurm.ask("scontrol", "show", "job", job).split("Restarts=")[1].split()[0])
    expect(restarts() == 0, "the job was restarted before anything happened")
    # slurmd first, so that it reports nothing; then everything of the job.
    place.slurm.stop("slurmd", signal.SIGKILL)
    for pid in processes_of(job, place.slurm):
        try:
            os.kill(pid, signal.SIGKILL)
        except ProcessLookupError:
            pass
    expect(not list((place.folder / "lost/runs").glob("*.h5")), "the case was solved before its node was lost: nothing is tested")
    place.slurm.wait_for("down", 60)
    place.slurm.start_node()
    result = place.finish(follower)
    expect(result.returncode == 0 and "1 solved" in result.stdout, "the case of a lost node does not finish", result)
    expect(restarts() == 1, f"the job was restarted {restarts()} times, needed 1")
    local = place.dragval("run", matrix, "--cache", "lost_local")
    expect(local.returncode == 0, "the local run fails", local)
    expect_equal_runs(place.folder / "lost/runs", place.folder / "lost_local/runs")


def interrupt_and_cancel(place):
    matrix = place.matrix("cancel.toml", "sphere", 130)
    follower = place.start("run", matrix, "--executor", "slurm", "--sbatch-option=--hold", "--cache", "cancel")
    held = lambda: [folder for folder in place.submissions("cancel") if place.slurm.ask("squeue", "--noheader", "--name=" + folder.name)]
    wait_for(held, 60, "no job is submitted")  # its own, not one of an earlier step
    follower.send_signal(signal.SIGINT)
    result = place.finish(follower)
    expect(result.returncode == 130 and "go on in Slurm" in result.stdout, f"Ctrl-C ends with {result.returncode}", result)
    follower = place.start("run", matrix, "--executor", "slurm", "--cache", "cancel")
    expect("1 cases are with Slurm already" in follower.stdout.readline(), "the second driver does not find the job of the first")
    place.slurm.ask("scancel", "--name=" + place.submissions("cancel")[0].name)
    result = place.finish(follower)
    expect(result.returncode == 4 and "CANCELLED" in result.stdout and "0 solved" in result.stdout, "a cancelled job is not told", result)
    expect(not list((place.folder / "cancel/runs").glob("*.h5")), "a cancelled job became a record")


def chain(place):
    # The second case starts from the fields of the first: its job waits for that one.
    (place.folder / "chain.toml").write_text(ONE_CASE.format(shape="plate", reynolds=100) + "incidence_deg = [80, 90]\nchain = true\n")
    result = place.dragval("run", "chain.toml", "--executor", "slurm", "--cache", "chain")
    expect(result.returncode == 0 and "2 solved" in result.stdout and "after job" in result.stdout, "a chain of cases is not solved in order", result)


def failing_job(place):
    # The node does not find what the job needs: submitted while held, then its copy of the matrix is taken away.
    matrix = place.matrix("fails.toml", "sphere", 140)
    place.dragval("run", matrix, "--executor", "slurm", "--sbatch-option=--hold", "--detach", "--cache", "fails")
    (folder,) = place.submissions("fails")
    (folder / matrix).unlink()
    place.slurm.ask("scontrol", "release", "JobName=" + folder.name)
    result = place.dragval("run", matrix, "--executor", "slurm", "--cache", "fails")
    expect(result.returncode == 4 and "no such matrix" in result.stdout, "a job that fails is not told with its log", result)
    explained = json.loads(place.dragval("explain", "sphere", "--matrix", matrix, "--json", "--cache", "fails").stdout)[0]
    expect(explained["state"] == "failed" and "FAILED" in explained["reason"] and "no such matrix" in explained["slurm_log_excerpt"], f"explain says {explained}")
    again = place.dragval("run", matrix, "--executor", "slurm", "--cache", "fails")
    expect(again.returncode == 4 and "0 solved, 1 were in the cache" in again.stdout, "the failure is forgotten, or solved again unasked", again)
    retried = place.dragval("run", matrix, "--executor", "slurm", "--retry-failed", "--cache", "fails")
    expect(retried.returncode == 0 and "1 solved" in retried.stdout, "--retry-failed does not solve it", retried)


def refusals(place):
    matrix = place.matrix("refused.toml", "sphere", 150)
    refused = place.dragval("run", matrix, "--executor", "slurm", "--partition", "nowhere", "--cache", "refused")
    expect(refused.returncode == 3 and "invalid partition" in refused.stdout, "sbatch refuses, and its words are lost", refused)
    expect(not place.submissions("refused"), "a refused submission is kept")
    # A controller that does not answer: nobody listens at this port.
    dead = place.folder / "dead.conf"
    dead.write_text(re.sub("SlurmctldPort=.*", "SlurmctldPort=1", (place.slurm.folder / "slurm.conf").read_text()))
    without = dict(place.slurm.environment, SLURM_CONF=str(dead))
    absent = place.dragval("run", matrix, "--executor", "slurm", "--cache", "refused", environment=without)
    expect(absent.returncode == 3 and "DOWN" in absent.stdout and "docs/cluster.md" in absent.stdout, "a Slurm that does not answer is not reported with its fix", absent)
    for environment, state in ((place.slurm.environment, "ok"), (without, "absent")):
        doctor = {check["name"]: check for check in json.loads(place.dragval("doctor", "--json", environment=environment).stdout)}
        expect(doctor["Slurm"]["state"] == state, f"doctor says {doctor['Slurm']}")


def past_the_time_limit(place):
    """Begun first, judged last: Slurm's shortest limit is a minute, and a job past it may live for another. A million steps in time outlast that
    on any machine; a steady case on a fine mesh did not on a fast one."""
    matrix = place.matrix("slow.toml", "cube", 160)
    text = (place.folder / matrix).read_text().replace('"laminar"', '"laminar_unsteady"')
    (place.folder / matrix).write_text(text + "time = { step = 0.01, duration = 10000, discard = 10 }\ntimeout_s = 7200\n")
    submitted = place.dragval("run", matrix, "--executor", "slurm", "--sbatch-option=--time=1", "--detach", "--cache", "slow")
    expect(submitted.returncode == 0, "the job is not submitted", submitted)

    def judge(place):
        result = place.dragval("run", matrix, "--executor", "slurm", "--cache", "slow")
        expect(result.returncode == 4 and "TIMEOUT" in result.stdout and "--time=" in result.stdout, "a job past its limit is not told", result)
        (case,) = place.plan(matrix, "slow")
        expect(case["state"] == "timed_out", f"the table says {case}")
        # Under a name that Slurm does not know, as after MinJobAge: the log still tells.
        shutil.copytree(place.submissions("slow")[0], place.folder / "forgotten/slurm/dragval-forgotten")
        result = place.dragval("run", matrix, "--executor", "slurm", "--cache", "forgotten")
        expect(result.returncode == 4 and "TIMEOUT" in result.stdout, "a job that Slurm forgot is not judged by its log", result)

    return judge


signal.signal(signal.SIGTERM, lambda *_: sys.exit("ended by SIGTERM"))  # through `with`, which stops the daemons
with tempfile.TemporaryDirectory() as name, tempfile.TemporaryDirectory() as cluster, OneNodeSlurm(cluster) as slurm:
    place = Place(pathlib.Path(name).resolve(), slurm)
    began = time.monotonic()
    try:
        judge = past_the_time_limit(place)
        for step in (same_as_local, refusals, interrupt_and_cancel, chain, failing_job):
            step(place)
            print(f"passed: {step.__name__.replace('_', ' ')} ({time.monotonic() - began:.0f} s)", flush=True)
        judge(place)
        print(f"passed: past the time limit ({time.monotonic() - began:.0f} s)", flush=True)
        for step in (overhead, lost_node):
            step(place)
            print(f"passed: {step.__name__.replace('_', ' ')} ({time.monotonic() - began:.0f} s)", flush=True)
    except BaseException:
        print(slurm.log_of("slurmctld"), slurm.log_of("slurmd"), sep="\n", file=sys.stderr)
        raise
