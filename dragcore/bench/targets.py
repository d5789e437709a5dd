#!/usr/bin/env python3
"""What scripts/bench.sh measured, made small, and held against the targets of speed: FOLDER/rows.json and FOLDER/targets.md.

Usage: targets.py FOLDER RAW.json... --instructions FILE [--commit C] [--dragval PROGRAM]

RAW are outputs of google-benchmark: of dragcore_benchmark by the best instruction set, then by others, of the recorded build and of peers.
Of every row the least time of the repetitions counts, or the highest rate. --instructions has the operations of some rows, as counted by
callgrind. --dragval times the program's commands, too. A row that was not measured is shown as such.
"""
import argparse
import json
import os
import subprocess
import tempfile
from pathlib import Path

# The least that a sum must read of a triangle of a closed body, in single precision [bytes]. Of all: normal; where the flow varies on them,
# place and edges. Of those that feel something: area and moment; the law by class lets all feel something. Of the windward half: curvature
# and second moment, where the law by class and the pillow want them.
READ = {"straight/note": 20, "straight/class": 40, "straight/class+pillow": 52,
        "spinning/note": 52, "spinning/class": 64, "spinning/class+pillow": 76}
THREADS = {1: "", 2: "/real_time/threads:2"}
FRAME = 1e9 / 60.0  # ns


class Missing(Exception):
    """A row that no run had."""


class Rows(dict):
    """{name: {"ns", "per_triangle", ...}} of one instruction set; times in ns."""

    def value(self, name, what="ns"):
        if what not in self.get(name, {}):
            raise Missing(name)
        return self[name][what]

    def ratio(self, slow, fast):
        return self.value(slow) / self.value(fast)

    def bandwidth(self, level, threads=1):
        """Bytes per ns, of the better number of streams."""
        return max(self.value(f"machine/read/{level}/streams:{n}{THREADS[threads]}", "bytes_per_second") for n in (1, 7)) * 1e-9

    def peak(self, threads=1):
        """Products and sums per ns."""
        return self.value(f"machine/fma{THREADS[threads]}", "items_per_second") * 1e-9


def condensed(raw):
    """Instruction set and rows of an output of google-benchmark."""
    rows = Rows()
    for run in sorted(raw["benchmarks"], key=lambda run: run["family_index"]):  # they ran in any order
        row = rows.setdefault(run["run_name"], {})
        if run.get("aggregate_name") == "least":
            to_ns = {"ns": 1.0, "us": 1e3, "ms": 1e6}[run["time_unit"]]
            row["ns"] = run["real_time" if "/real_time" in run["run_name"] else "cpu_time"] * to_ns
            row |= {name: run[name] * 1e9 for name in ("per_triangle", "per_body", "per_sample") if name in run}
            row |= {name: run[name] for name in ("error", "bytes_per_triangle", "bits", "rms", "KiB") if name in run}
            row["hash"] = run.get("label", "differs")
        elif run.get("aggregate_name") == "most":
            row |= {name: run[name] for name in ("bytes_per_second", "items_per_second") if name in run}
    for row in rows.values():
        row |= {name: float(f"{value:.4g}") for name, value in row.items() if name != "hash"}
    return raw["context"]["instruction_set"].replace("AVX3", "AVX-512"), rows


def processor_seconds(dragval):
    """Of the program's commands, all threads, the least of two."""
    rows = Rows()
    with tempfile.TemporaryDirectory() as folder:
        for name, arguments in {"compare": ["compare"], "gate": ["gate"], "report": ["report", "--output", f"{folder}/index.html"]}.items():
            for _ in range(2):
                process = subprocess.Popen([dragval, *arguments], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
                _, status, usage = os.wait4(process.pid, 0)
                if os.waitstatus_to_exitcode(status) not in (0, 4):  # 4: it says that a case is bad
                    raise SystemExit(f"'dragval {name}' failed with exit code {os.waitstatus_to_exitcode(status)}")
                seconds = usage.ru_utime + usage.ru_stime
                rows[f"dragval {name}"] = {"s": min(seconds, rows.get(f"dragval {name}", {"s": seconds})["s"])}
    return rows


def best(body, way, law="class+pillow", kind="single"):
    return f"wrench/{kind}/{body}/{way}/{law}"


def targets(by_set, recorded, programs):
    """(what, at 3f4dda5, unit, bound, measured by, what stands in the way of it). Bounds: ("<=", x) or (">=", x)."""
    fast, medium = next(iter(by_set.values())), "ball-12800"
    textbook, note = f"textbook/{medium}/straight", best(medium, "straight", "note")
    whole, spinning = best(medium, "straight"), best(medium, "spinning")
    cubes, frame = "batch/cubes/straight/threads:{}/real_time", "batch/frame/unique/straight/threads:{}/real_time"
    roots = "every vector waits for a chain of roots, divisions and an exponential: 36 % of the peak, 20 % of the bandwidth"
    points = "three points, each with a velocity, two roots and two divisions of its own, in such a chain"
    lanes = "half of it is reading motions of 184 bytes and writing wrenches"
    alone = "resistance() and the step work on matrices of six by six in double, one body after the other"
    call = "silhouette, descriptors, six terms and their balance are worked out in every call: four fifths of its instructions"
    for name, least, most in (("AVX-512", 30, 1.6), ("AVX2", 24, 2.5)):
        rows = by_set.get(name, Rows())
        yield (f"note's law, uniform, {medium}, against the textbook loop, {name}", "0.4", "x", (">=", least),
               lambda rows=rows: rows.ratio(textbook, note), "half of the time is reading from the second cache")
        yield (f"law by class with pillow, uniform, {medium}, {name}", "170 to 220", "ns/triangle", ("<=", most),
               lambda rows=rows: rows.value(whole, "per_triangle"), roots)
    yield "the same, against 3f4dda5", "1", "x", (">=", 70), lambda: recorded.value(whole) / fast.value(whole), roots
    yield "the same, against the textbook loop of the note's law", "0.1", "x", (">=", 7), lambda: fast.ratio(textbook, whole), roots
    yield "the same, spinning, 3 points", "340 to 470", "ns/triangle", ("<=", 8), lambda: fast.value(spinning, "per_triangle"), points
    yield "the same, spinning, against 3f4dda5", "1", "x", (">=", 45), lambda: recorded.value(spinning) / fast.value(spinning), points
    yield "cube of 12 triangles, best model, one call", "5000", "ns", ("<=", 120), lambda: fast.value(best("cube-12", "straight")), call
    yield "the same, in a batch of instances", "-", "ns/body", ("<=", 25), lambda: fast.value(cubes.format(1), "per_body"), lanes
    yield "whole step of a free box, one by one", "16000 to 20000", "ns", ("<=", 400), lambda: fast.value("step/now/box-12"), alone
    yield ("whole step of a free box, in a batch, 2 threads", "-", "ns/body", ("<=", 400),
           lambda: fast.value("batch/steps/box-12/threads:2/real_time", "per_body"), lanes)
    motion = "reading a motion of 184 bytes, checks, and moving the torque to its reference point take more than the map"
    for body in ("ball-2048", "cube-12"):
        baked = f"baked/{body}/straight"
        yield f"baked {body}, best model, one call", "-", "ns", ("<=", 10), lambda baked=baked: fast.value(baked, "per_body"), motion
        yield "the same, many at once", "-", "ns/body", ("<=", 10), lambda baked=baked: fast.value(baked + "/batch", "per_body"), motion
        yield "the same, rms error", "-", "%", ("<=", 1), lambda baked=baked: 100.0 * fast.value(baked, "rms"), ""
        yield "the same, size", "-", "KiB", ("<=", 64), lambda baked=baked: fast.value(baked, "KiB"), ""
    million = best("ball-1002528", "straight", "note")
    yield ("beyond the second cache, note's law, a million triangles: of the measured bandwidth", "-", "%", (">=", 90),
           lambda: 100.0 * READ["straight/note"] / fast.value(million, "per_triangle") / fast.bandwidth("32MB"),
           "seven cache lines of every twenty are read, which the prefetcher does not foresee")
    yield "two threads, in cache", "1", "x", (">=", 1.85), lambda: fast.ratio(cubes.format(1), cubes.format(2)), "one thread sorts the bodies by shape before two work"
    yield "two threads, from memory", "1", "x", (">=", 1.5), lambda: fast.ratio(frame.format(1), frame.format(2)), ""
    for faces, least in ((10082, 4), (100352, 6)):
        yield (f"deforming mesh against Bullet, {faces} faces", "-", "x", (">=", least),
               lambda faces=faces: fast.ratio(f"deforming/bullet/{faces}", f"deforming/dragcore/{faces}/real_time"),
               "rows of vertices are read three times each, and forces gathered for every vertex")
    yield ("trilinear sample, coherent", "-", "ns", ("<=", 7), lambda: fast.value("wind/coherent/32", "per_sample"),
           "points are located, summed and turned in double")
    yield "Surface of 100,000 triangles, prepared", "-", "s", ("<=", 0.3), lambda: 1e-9 * fast.value("surface/ball-100352"), ""
    yield ("the same, memory", "-", "bytes/triangle", ("<=", 200), lambda: fast.value("surface/ball-100352", "bytes_per_triangle"),
           "every triangle is there in double precision for the exact sums and once more in single precision for the kernels")
    for name, before in (("compare", 0.9), ("gate", 2.6), ("report", 24.0)):
        yield f"dragval {name}", str(before), "CPU s", ("<=", before / 2), lambda name=name: programs.value(f"dragval {name}", "s"), "surfaces, and rays of five concave bodies, are made anew in every run: 60 %"
    yield ("float against double, largest error of force and torque, 12 to 1,000,000 triangles", "-", "", ("<=", 1e-6),
           lambda: max(row["error"] for name, row in fast.items() if name.startswith("wrench/single/")), "")
    yield "AVX2 gives the bits of AVX-512: rows with the same hash", "-", "%", (">=", 100), lambda: same_bits(*by_set.values()), ""


def same_bits(fast, other=Rows()):
    """Per cent of the rows of single precision that two instruction sets have."""
    names = [name for name in fast if name in other and name.startswith("wrench/single/")]
    if not names:
        raise Missing("of another instruction set")
    return 100.0 * sum(fast[name]["hash"] == other[name]["hash"] for name in names) / len(names)


def number(value):
    return f"{value:.3g}" if value < 100 else f"{value:.0f}"


def target_lines(all_targets):
    yield from ("| | at 3f4dda5 | target | measured | of the target | | what stands in its way |", "|---|--:|--:|--:|--:|---|---|")
    for what, before, unit, (sense, bound), measure, obstacle in all_targets:
        start = f"| {what} | {before} | {sense.replace('<=', '≤').replace('>=', '≥')} {number(bound)} {unit} |"
        try:
            value = measure()
        except Missing as row:
            yield f"{start} - | - | not measured | no row `{row}` |"
            continue
        met = value <= bound if sense == "<=" else value >= bound
        yield f"{start} {number(value)} | {value / bound:.2f} | {'met' if met else 'missed'} | {'' if met else obstacle or 'not known'} |"


def share_lines(fast, recorded, caches, operations):
    """Every wrench() in single precision beside the textbook loop, commit 3f4dda5 and the machine."""
    yield from ("| body | motion, law | ns/triangle | x textbook | x 3f4dda5 | read, at least [GB/s] | of the bandwidth there | GFLOP/s |"
                " of the peak |", "|---|---|--:|--:|--:|--:|--:|--:|--:|")
    for name in (n for n in fast if n.startswith("wrench/single/")):
        _, _, body, way, law = name.split("/")
        row, (shape, triangles) = fast[name], body.split("-")
        triangles = float(triangles)
        # A triangle of a larger ball has the same: of 2048, what belongs to the call is lost among them.
        counted, of = ("ball-2048", 2048) if shape == "ball" else (body, triangles)
        floating = operations.get(best(counted, way, law), {"operations": 0})["operations"] * triangles / of
        read = READ[f"{way}/{law}"]
        level = next((level for level, size in zip(("L1", "L2"), caches) if read * triangles < size), "32MB")
        others = fast.get(f"textbook/{body}/{way}"), recorded.get(best(body, way, law))
        cells = [number(row["per_triangle"]), *(f"{other['ns'] / row['ns']:.1f}" if other else "" for other in others)]
        # Flat faces count as one in straight flow: what is read of a cube or sheet is not known here.
        for rate, limit, where in ((shape == "ball" and read / row["per_triangle"], lambda: fast.bandwidth(level), f" of {level}"),
                                   (floating / row["ns"], fast.peak, "")):
            try:
                cells += [f"{rate:.1f}", f"{rate / limit():.0%}{where}"] if rate else ["", ""]
            except Missing:
                cells += [f"{rate:.1f}", ""]
        yield f"| {body} | {way}, {law} | {' | '.join(cells)} |"


def frame_lines(fast):
    """A frame of 10,000 bodies. Empty without threads."""
    yield from ("| 10,000 bodies | ms, 1 thread | 2 threads | of a 60 Hz frame, 2 threads |", "|---|--:|--:|--:|")
    for what, name in (*((f"{what}, {way}", f"{name}/{way}") for way in ("straight", "spinning")
                         for what, name in (("4 million triangles, ten shapes shared", "frame/shared"),
                                            ("4 million triangles, each its own", "frame/unique"), ("cubes", "cubes"))),
                       ("whole steps of free boxes", "steps/box-12")):
        times = [fast.get(f"batch/{name}/threads:{n}/real_time", {}).get("ns") for n in (1, 2)]
        if None not in times:
            yield f"| {what} | {times[0] * 1e-6:.2f} | {times[1] * 1e-6:.2f} | {times[1] / FRAME:.0%} |"


def machine_lines(fast):
    yield from ("| limit | 1 thread | 2 threads |", "|---|--:|--:|")
    bits = fast.get("machine/fma", {}).get("bits", 0)
    for what, limit in ((f"products and sums, {bits:.0f} bit [GFLOP/s]", fast.peak),
                        *((f"reading, {level} [GB/s]", lambda threads, level=level: fast.bandwidth(level, threads))
                          for level in ("L1", "L2", "32MB", "memory"))):
        try:
            yield f"| {what} | {limit(1):.0f} | {limit(2):.0f} |"
        except Missing:
            pass


def processor():
    names = [line.split(":")[1].strip() for line in Path("/proc/cpuinfo").read_text().splitlines() if line.startswith("model name")]
    return f"{names[0] if names else 'processor without a name'}, {len(os.sched_getaffinity(0))} cores"


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("folder", type=Path)
    options.add_argument("raw", type=Path, nargs="+")
    options.add_argument("--commit", default="unknown")
    options.add_argument("--dragval", type=Path)
    options.add_argument("--instructions", type=Path, required=True)
    chosen = options.parse_args()

    raws = [json.loads(path.read_text()) for path in chosen.raw]
    by_set = dict(condensed(raw) for raw in raws)
    chosen_set, fast = next(iter(by_set.items()))
    fast.update(by_set.pop("best", {}))  # of programs that do not choose
    # As if they were rows of today.
    recorded = Rows({name.replace("/recorded/", "/single/"): row for name, row in by_set.pop("recorded", {}).items()})
    programs = processor_seconds(chosen.dragval) if chosen.dragval else Rows()
    context = {"processor": processor(), "date": raws[0]["context"]["date"][:16], "commit": chosen.commit,
               "load_before": raws[0]["context"]["load_avg"][0]}
    caches = [0.0, 0.0]
    for cache in raws[0]["context"]["caches"]:
        if cache["type"] in ("Data", "Unified") and cache["level"] <= 2:
            caches[cache["level"] - 1] = cache["size"]

    chosen.folder.mkdir(parents=True, exist_ok=True)
    (chosen.folder / "rows.json").write_text(
        json.dumps({"context": context, **by_set, "3f4dda5": recorded, "programs": programs}, indent=1) + "\n")
    lines = ["# Speed, measured", "",
             f"{context['processor']}; {chosen_set}; {context['date']}; commit {chosen.commit}; load {context['load_before']:.1f} before."
             " Written by `scripts/bench.sh`; every row with the hash of its result in `rows.json`.",
             "", "## Targets", "", *target_lines(targets(by_set, recorded, programs)),
             "", "## One body", "", *share_lines(fast, recorded, caches, json.loads(chosen.instructions.read_text())),
             "", "## A frame", "", *frame_lines(fast), "", "## The machine", "", *machine_lines(fast)]
    (chosen.folder / "targets.md").write_text("\n".join(lines) + "\n")
    print("\n".join(lines))


if __name__ == "__main__":
    main()
