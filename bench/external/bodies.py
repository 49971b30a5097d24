"""Contact between two bodies beside one linear solve: two plates of other cells on one another, and the same plates bonded.

    python3 bench/external/bodies.py [--sizes 50k,200k,700k] [--elements hex8,tet4] [--threads 1] [--repeat 3]

builds `stiction` and solves every size with `stiction solve` on the multigrid path, pressed and sheared by its top: "block",
one block of about as many unknowns without contact, which as a block starts from a coarser one; "bonded", the two plates tied
to one another, a linear problem with the same unknowns; "constrained", the upper plate supported on one side, with Coulomb
friction; "floating", the upper plate carried by contact and friction alone; and "smooth", supported, without friction. The plates are eight
cells thick at every size, so that always about 5 % of the unknowns are at points in contact; the table has what the answer says.

All seconds are CPU seconds, so that others may use the machine: those of a phase are its wall seconds times what the whole run
took of the processor over its wall seconds, the least of all repetitions. A solve is set-up and iteration. Posing is all
between the assembled matrix and the contact problem, also done without contact; the mortar rows are reported as what posing takes
beyond that of "block"; where a body floats the search for its rigid motions is in it.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
TARGET = os.environ.get("CARGO_TARGET_DIR", os.path.join(ROOT, "target"))
# Cells along the sides of the lower plate; the upper one has other ones.
SIZES = {"6k": 12, "50k": 33, "200k": 66, "700k": 123, "2M": 208}
LAYERS = 8
MATERIAL = """[materials.steel]
young = 2.1e11
poisson = 0.3
[solver]
path = "multigrid"
"""
BODIES = """[mesh.parts.low]
block = {{ size = [1, 1, {1}], cells = [{0}, {0}, {3}], element = "{4}" }}
[mesh.parts.high]
block = {{ size = [1, 1, {1}], cells = [{2}, {2}, {3}], element = "{4}" }}
move = [0, 0, {1}]
[[contact]]
on = "high.z-min"
against = "low.z-max"
friction = {5}
[[fix]]
on = "low.z-min"
[[load]]
on = "high.z-max"
traction = [2e5, 5e4, -1e6]
"""
FIX = '[[fix]]\non = "high.x-max"\n'
BLOCK = """[mesh]
block = {{ size = [1, 1, {2}], cells = [{0}, {0}, {3}], element = "{1}" }}
[[fix]]
on = "z-min"
[[load]]
on = "z-max"
traction = [2e5, 5e4, -1e6]
"""
COULOMB = "{ coulomb = 0.3 }"
LOADS = {
    "block": None,
    "bonded": ('"bonded"', ""),
    "constrained": (COULOMB, FIX),
    "floating": (COULOMB, ""),
    "smooth": ('"none"', FIX),
}


def text(load, element, n):
    if load == "block":
        return BLOCK.format(round(n * 0.95), element, 2 * LAYERS / n, 2 * LAYERS) + MATERIAL
    friction, fix = LOADS[load]
    m = round(0.9 * n)
    return BODIES.format(n, LAYERS / n, m, LAYERS, element, friction) + fix + MATERIAL


def ours(load, element, n, threads, folder):
    case = os.path.join(folder, load + ".toml")
    with open(case, "w") as file:
        file.write(text(load, element, n))
    results = os.path.join(folder, load)
    command = [os.path.join(TARGET, "release", "stiction"), "solve", case, "-o", results]
    start, before = time.time(), os.times()
    done = subprocess.run([*command, "--threads", str(threads), "--progress", "none"], stdout=subprocess.DEVNULL)
    wall, after = time.time() - start, os.times()
    cpu = after.children_user + after.children_system - before.children_user - before.children_system
    with open(os.path.join(results, "summary.json")) as file:
        summary = json.load(file)
    summary["seconds"] = {phase: seconds * cpu / wall for phase, seconds in summary["seconds"].items()}
    if done.returncode != 0 or not summary["certificate"]["passed"]:
        print(f"{element} {n} {load}: {summary['status']} {summary['certificate']}", file=sys.stderr)
    return summary


HEAD = """| element | unknowns | load | points | in contact | unknowns in contact | solve s | of it set-up | cycles | solve / bonded | posing s | mortar, of the run | worst |
|---|---|---|---|---|---|---|---|---|---|---|---|---|"""


def size(element, name, threads, repeat):
    """The rows of one size; where numbers of unknowns differ, seconds an unknown are compared."""
    with tempfile.TemporaryDirectory() as folder:
        bonded = posing = None
        for load in LOADS:
            runs = [ours(load, element, SIZES[name], threads, folder) for _ in range(repeat)]
            s = runs[0]
            # The least of each phase: others that use the machine only ever add to it.
            seconds = {phase: min(run["seconds"][phase] for run in runs) for phase in s["seconds"]}
            solve = seconds["setup"] + seconds["iteration"]
            posing = posing or seconds["contact"] / s["dofs"]
            bonded = bonded or (solve / s["dofs"] if load == "bonded" else None)
            mortar = max(seconds["contact"] - posing * s["dofs"], 0)
            ratio = f"{solve / s['dofs'] / bonded:.2f}" if bonded else "-"
            points, touching = s["contact"]["points"], s["contact"]["stick"] + s["contact"]["slip"]
            print(
                f"| {element} | {s['dofs']} | {load} | {points} | {touching} | {300 * touching / s['dofs']:.1f} % | {solve:.2f} "
                f"| {seconds['setup']:.2f} | {s['counts']['cycles']} | **{ratio}** "
                f"| {seconds['contact']:.2f} | {100 * mortar / seconds['total']:.1f} % "
                f"| {s['certificate']['worst']:.1e} |",
                flush=True,
            )


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--sizes", default="50k,200k,700k")
    parser.add_argument("--elements", default="hex8,tet4")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--repeat", type=int, default=3)
    arguments = parser.parse_args()
    subprocess.run(["cargo", "build", "--release", "--quiet", "--bin", "stiction"], cwd=ROOT, check=True)
    print(HEAD)
    for element in arguments.elements.split(","):
        for name in arguments.sizes.split(","):
            size(element, name, arguments.threads, arguments.repeat)


main()
