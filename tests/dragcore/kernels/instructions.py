#!/usr/bin/env python3
"""Instructions of fixed evaluations, by callgrind: no change unseen, and effects that are off cost none.

Counts per evaluation may differ from those in VALUES by 2 %: a better count must be accepted as well as a worse one, or the next loss would
hide behind it. Operations on floating-point numbers are counted beside them, for the share of what the machine could do. Masked off, an
effect costs what a law without it costs, to the instruction per triangle; felt, it costs more. Last, faults are seeded into what was
counted: each must be found.

Usage: instructions.py PROGRAM VALUES.json [--accept]
"""
import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

TOLERANCE = 0.02  # counts repeat to the instruction; other patch levels of the compiler and of libm move them by parts of a per cent


LANES = {"zmm": 64, "ymm": 32, "xmm": 16}  # bytes


def arithmetic(program):
    """{address: operations on floating-point numbers} of the program's instructions that have any."""
    operations = {}
    listing = subprocess.run(["objdump", "-d", "--no-show-raw-insn", program], capture_output=True, text=True, check=True).stdout
    for address, fused, kind, operands in re.findall(
            r"^ *([0-9a-f]+):\tv?(?:(fn?m(?:add|sub)\d*)|add|sub|mul|div|sqrt)([ps][sd]) +(.*)$", listing, re.M):
        width = max(size for name, size in LANES.items() if name in operands)
        lanes = width // (4 if kind[1] == "s" else 8) if kind[0] == "p" else 1
        operations[int(address, 16)] = (2 if fused else 1) * lanes
    return operations


def costs(dump, program):
    """(address, instructions) of what a dump says of the program itself, not of libraries."""
    inside = called = False
    for line in dump.splitlines():
        if line.startswith("ob="):
            inside = line[3:] == str(Path(program).resolve())
        elif line.startswith("calls="):
            called = True  # the next line has the cost of what was called, which has its own
        elif line.startswith("0x"):
            if inside and not called:
                yield int(line.split()[0], 16), int(line.split()[1])
            called = False


def counted(program):
    """{name: {"instructions", "operations"}} of every evaluation of the program."""
    per_address = arithmetic(program)
    with tempfile.TemporaryDirectory() as folder:
        command = ["valgrind", "--tool=callgrind", "--collect-atstart=no", "--instr-atstart=no", "--dump-instr=yes", "--dump-line=no",
                   "--compress-strings=no", "--compress-pos=no", f"--callgrind-out-file={folder}/out", program]
        run = subprocess.run(command, capture_output=True, text=True)
        if run.returncode == 77:
            print(run.stderr, file=sys.stderr)
            sys.exit(77)
        if run.returncode:
            sys.exit(f"{' '.join(command)} failed with exit code {run.returncode}:\n{run.stderr}")
        counts = {}
        for dump in (path.read_text() for path in Path(folder).iterdir()):
            name = re.search(r"^desc: Trigger: Client Request: (.*)$", dump, re.M)
            if name:
                counts[name[1]] = {"instructions": int(re.search(r"^(?:summary|totals): (\d+)", dump, re.M)[1]),
                                   "operations": sum(per_address.get(address, 0) * cost for address, cost in costs(dump, program))}
        return counts


def gate_faults(counts, accepted):
    faults = [f"{name}: not among the accepted counts" for name in counts.keys() - accepted.keys()]
    faults += [f"{name}: accepted, but not counted any more" for name in accepted.keys() - counts.keys()]
    for name in sorted(counts.keys() & accepted.keys()):
        for what, before in accepted[name].items():
            change = counts[name][what] / before - 1.0
            if abs(change) > TOLERANCE:
                faults.append(f"{name}: {counts[name][what]} {what}, {before} accepted: {change:+.1%}, allowed ±{TOLERANCE:.0%}")
    return faults


def effect_faults(counts):
    """Of growth from the small ball to the large one."""
    growth = {name[:-len("/ball-2048")]: counts[name[:-len("2048")] + "4608"] - count
              for name, count in counts.items() if name.endswith("/ball-2048")}
    faults = [] if growth else ["no effect was counted"]
    for name in (n[:-len("/felt")] for n in growth if n.endswith("/felt")):
        felt, masked, lacking = (growth[f"{name}/{variant}"] for variant in ("felt", "masked", "lacking"))
        if masked != lacking:
            faults.append(f"{name}: masked off it costs {masked - lacking:+d} instructions in 2560 triangles; needed: none")
        if felt <= lacking:
            faults.append(f"{name}: costs nothing although it is felt ({felt - lacking:+d} in 2560 triangles): the case does not have it")
    return faults


def missed_seeds(gated, accepted, effects):
    """Seeded faults that the checks do not find."""
    name, effect = next(iter(gated)), next(n for n in effects if n.endswith("/masked/ball-4608"))
    felt = effect.replace("/masked/", "/felt/")
    seeds = {
        **{f"{factor} of the {what}": gate_faults({**gated, name: {**gated[name], what: round(factor * accepted[name][what])}}, accepted)
           for factor in (0.97, 1.03) for what in accepted[name]},
        "a count that is gone": gate_faults({n: c for n, c in gated.items() if n != name}, accepted),
        "one instruction for all of an effect that is off": effect_faults({**effects, effect: effects[effect] + 1}),
        "an effect that is not there": effect_faults({**effects, felt: effects[felt.replace("/felt/", "/lacking/")]}),
    }
    return [f"a seeded fault was not found: {seed}" for seed, found in seeds.items() if not found]


program, values = sys.argv[1], Path(sys.argv[2])
counts = counted(program)
effects = {name: count["instructions"] for name, count in counts.items() if name.startswith("effect/")}
gated = {name: count for name, count in sorted(counts.items()) if name not in effects}
if "--accept" in sys.argv[3:]:
    values.write_text(json.dumps(gated, indent=2) + "\n")
accepted = json.loads(values.read_text())
changed = gate_faults(gated, accepted)
faults = changed + effect_faults(effects)
faults = faults or missed_seeds(gated, accepted, effects)
print("\n".join(faults) or f"{len(gated)} evaluations cost what is accepted, {len(effects) // 6} effects cost nothing when they are off")
if changed:
    print("If this is meant: scripts/bench.sh --accept-instructions, and say why in the commit.")
sys.exit(bool(faults))
