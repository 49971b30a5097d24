#!/usr/bin/env python3
"""How often error bars of refined runs hold, and how near the estimated error is to the true one.

    python3 bench/error_bars.py [target/release/stiction] [--only hertz,lug]

Each case is refined to an estimated error far below what is usual. Its last mesh is the reference. Every mesh before it is
judged by the bars that a run ending there prints (`bars` of each level in `summary.json`); meshes whose estimate is not 1.5
times that of the reference are left out, which could not tell. A value that grows without bound at the end has no reference.

True errors are known by the energy where load, support and contact store none: the squared norm of the answer then is twice the energy, and
that of the error twice the energy above its limit. The ratio of estimate and error is taken from the fall of both to the last mesh, so no
limit is needed.
"""

import argparse
import json
import statistics
import subprocess
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
CASES = ROOT / "cases"
STEEL = "[materials.steel]\nyoung = 210e3\npoisson = 0.3\n"
BRICK = """
[mesh]
block = { size = [3, 1, 1], cells = [6, 2, 2], element = "tet10" }
[materials.steel]
young = 21.19e10
poisson = 0.277
[[fix]]
on = "x-min"
[[load]]
on = "x-max"
traction = [0, 0, 1e6]
[[load]]
on = "z-max"
traction = [0, 0, "-2/3*1e6*(3 - x)"]
[[contact]]
on = "z-min"
against = { plane = { point = [0, 0, 0], normal = [0, 0, 1] } }
friction = FRICTION
"""
QUARTER = """
[[fix]]
on = "x-min"
components = "x"
[[fix]]
on = "y-min"
components = "y"
[[fix]]
on = "z-max"
components = "z"
value = -DEPTH
"""
PUNCH = """
[mesh]
block = { size = [2, 2, 2], cells = [4, 4, 4], element = "tet10" }
""" + STEEL + QUARTER.replace("DEPTH", "1e-3") + """
[[contact]]
on = { box = [[0, 0, 0], [1, 1, 0]] }
against = { plane = { point = [0, 0, 0], normal = [0, 0, 1] } }
friction = "none"
"""
HERTZ = """
[mesh]
block = { size = [1, 1, 1], cells = [4, 4, 4], element = "tet10" }
""" + STEEL + QUARTER + """
[[contact]]
on = "z-min"
against = { sphere = { center = [0, 0, -10], radius = 10 } }
friction = FRICTION
"""
BLOCKS = """
[mesh.parts.cube]
block = { size = [1, 1, 1], cells = [2, 2, 2], element = "tet10" }
move = [0.5, 0.5, 1]
[mesh.parts.base]
block = { size = [2, 2, 1], cells = [3, 3, 2], element = "tet10" }
""" + STEEL + """
[[fix]]
on = "base.z-min"
[[fix]]
on = "cube.z-max"
components = "xy"
[[load]]
on = "cube.z-max"
traction = [0, 0, -100]
[[contact]]
on = "cube.z-min"
against = "base.z-max"
friction = { coulomb = 0.3 }
"""
# Name, text or file of the case, accuracy in percent, the factor between energy and squared norm where there is one.
RUNS = [
    ("brick, no friction", BRICK.replace("FRICTION", '"none"'), 0.6, -2),
    ("brick, given friction", BRICK.replace("FRICTION", "{ tresca = 1e5 }"), 0.6, None),
    ("brick, Coulomb 0.35", BRICK.replace("FRICTION", "{ coulomb = 0.35 }"), 0.6, None),
    ("brick, Coulomb 0.1", BRICK.replace("FRICTION", "{ coulomb = 0.1 }"), 0.6, None),
    ("Hertz, 0.7 um", HERTZ.replace("DEPTH", "0.7e-3").replace("FRICTION", '"none"'), 0.8, 2),
    ("Hertz, 1.0 um", HERTZ.replace("DEPTH", "1.0e-3").replace("FRICTION", '"none"'), 0.8, 2),
    ("Hertz, 1.15 um, Coulomb 0.2", HERTZ.replace("DEPTH", "1.15e-3").replace("FRICTION", "{ coulomb = 0.2 }"), 0.8, None),
    ("flat punch", PUNCH, 2.5, 2),
    ("cube on block", BLOCKS, 2, None),
    ("cube that lifts off", BLOCKS.replace("[0, 0, -100]", "[25, 0, -100]"), 2.5, None),
    ("rings", CASES / "rings/rings.toml", 2, None),
    ("lug", CASES / "lug/lug.toml", 3, None),
    ("joint", CASES / "joint/joint.toml", 5, None),
    ("Cattaneo", CASES / "cattaneo/cattaneo.toml", 4, None),
]
# Part of a value that solvers leave: forces that the loads prescribe have no other error.
ROUNDING = 1e-6
# The estimate of a judged mesh over that of the reference at least.
ABOVE = 1.5


def refined(program, name, case, accuracy, folder):
    """The record `accuracy` of a run."""
    if isinstance(case, str):
        path = Path(folder) / "case.toml"
        path.write_text(case)
        case = path
    command = [program, "solve", case, "-o", Path(folder) / "results", "--accuracy", f"{accuracy}%"]
    command += ["--threads", "1", "--no-report", "--no-pictures"]
    run = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    summary = Path(folder) / "results/summary.json"
    if not summary.exists():
        raise SystemExit(f"{name}: {run.stderr}")
    return json.loads(summary.read_text())["accuracy"]


def judged(record):
    """(kind of value, bar, error) of all judged meshes."""
    levels = record["levels"]
    errors = [level["error"] for level in levels]
    unbounded = {value["name"] for value in record["values"] if value["value"] is None}
    for name, reference in levels[-1]["values"].items():
        if name in unbounded:
            continue
        for level, error in zip(levels[:-1], errors):
            half = level["bars"].get(name)
            if half is not None and error >= ABOVE * errors[-1]:
                left = ROUNDING * abs(reference)
                yield name.split(" of ")[0], max(half, left), abs(level["values"][name] - reference)


def ratios(record, factor):
    """Estimate over error of the meshes before the last, from the second on: by the fall of both."""
    levels = record["levels"]
    squares = [factor * level["values"]["energy"] for level in levels]
    # The estimate is given over the root of the sum of both squares.
    estimates = [square * level["error"] ** 2 / (1 - level["error"] ** 2) for square, level in zip(squares, levels)]
    falls = [(estimate - estimates[-1], abs(square - squares[-1])) for estimate, square in zip(estimates, squares)]
    return [(estimate / energy) ** 0.5 for estimate, energy in falls[1:-1] if energy > 0 < estimate]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", nargs="?", default=ROOT / "target/release/stiction")
    parser.add_argument("--only", default="", help="cases whose names contain one of these words")
    arguments = parser.parse_args()
    words = [word for word in arguments.only.split(",") if word]
    everything = {}
    print("| case | meshes | unknowns | error | values inside | bar over error | estimate over error |\n|---|--:|--:|--:|--:|--:|---|")
    for name, case, accuracy, factor in RUNS:
        if words and not any(word in name for word in words):
            continue
        with tempfile.TemporaryDirectory() as folder:
            record = refined(arguments.program, name, case, accuracy, folder)
        found = list(judged(record))
        for kind, half, error in found:
            everything.setdefault(kind, []).append((half, error))
        last = record["levels"][-1]
        inside = sum(error <= half for _, half, error in found)
        over = ratios(record, factor) if factor else []
        told = f"{min(over):.2f} to {max(over):.2f}" if over else ""
        wide = statistics.median(half / error if error else float("inf") for _, half, error in found) if found else float("nan")
        print(f"| {name} | {len(record['levels'])} | {last['unknowns']} | {100 * last['error']:.2f} % | {inside} of {len(found)} | {wide:.1f} | {told} |", flush=True)
    print("\n| value | inside | bar over error, median | worst error over bar |\n|---|--:|--:|--:|")
    everything["all"] = [pair for pairs in list(everything.values()) for pair in pairs]
    for kind, pairs in everything.items():
        inside = sum(error <= half for half, error in pairs)
        wide = statistics.median(half / error if error else float("inf") for half, error in pairs)
        worst = max(error / half if half else (0.0 if error == 0 else float("inf")) for half, error in pairs)
        print(f"| {kind} | {inside} of {len(pairs)} | {wide:.1f} | {worst:.2f} |")


if __name__ == "__main__":
    main()
