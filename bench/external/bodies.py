"""Contact between two bodies beside one linear solve: two blocks of other cells on one another, and the same blocks bonded.

    python3 bench/external/bodies.py [--sizes 50k,200k,700k] [--threads 1]

builds `stiction` and solves every size with `stiction solve` on the multigrid path: "held", the upper block pressed and
sheared below and beyond its friction, some points slipping; "floating", the same block held by contact alone; and "bonded",
one block of as many unknowns without contact. Seconds of a solve are the wall seconds of set-up and iteration, those of
posing what the search for overlaps and the integration of the mortar rows take, with all that is posed beside them.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
TARGET = os.environ.get("CARGO_TARGET_DIR", os.path.join(ROOT, "target"))
# Cells along the sides of the base of the lower block, half as many upwards; the upper block has other ones.
SIZES = {"6k": 14, "50k": 30, "200k": 48, "700k": 74, "2M": 105}
MATERIAL = """[materials.steel]
young = 2.1e11
poisson = 0.3
[solver]
path = "multigrid"
"""
BODIES = """[mesh.parts.low]
block = {{ size = [1, 1, 0.5], cells = [{0}, {0}, {1}], element = "hex8" }}
[mesh.parts.high]
block = {{ size = [1, 1, 0.5], cells = [{2}, {2}, {3}], element = "hex8" }}
move = [0, 0, 0.5]
[[contact]]
on = "high.z-min"
against = "low.z-max"
friction = {{ coulomb = 0.3 }}
[[fix]]
on = "low.z-min"
[[load]]
on = "high.z-max"
traction = [2e5, 5e4, -1e6]
"""
HELD = '[[fix]]\non = "high.x-max"\n'
ONE = """[mesh]
block = {{ size = [1, 1, 1], cells = [{0}, {0}, {1}], element = "hex8" }}
[[fix]]
on = "z-min"
[[load]]
on = "z-max"
traction = [2e5, 5e4, -1e6]
"""


def text(load, n):
    if load == "bonded":
        return ONE.format(n, n) + MATERIAL
    m = round(0.9 * n)
    return BODIES.format(n, n // 2, m, m // 2) + (HELD if load == "held" else "") + MATERIAL


def ours(load, n, threads, folder):
    case = os.path.join(folder, load + ".toml")
    with open(case, "w") as file:
        file.write(text(load, n))
    results = os.path.join(folder, load)
    command = [os.path.join(TARGET, "release", "stiction"), "solve", case, "-o", results]
    done = subprocess.run([*command, "--threads", str(threads), "--progress", "none"], stdout=subprocess.DEVNULL)
    with open(os.path.join(results, "summary.json")) as file:
        summary = json.load(file)
    if done.returncode != 0 or not summary["certificate"]["passed"]:
        print(f"{n} {load}: {summary['status']} {summary['certificate']}", file=sys.stderr)
    return summary


HEAD = """| unknowns | load | points | in contact % | solve s | of it set-up | cycles | solve / bonded | posing s | of the run | worst |
|---|---|---|---|---|---|---|---|---|---|---|"""


def size(name, threads):
    """The rows of one size; seconds are compared an unknown, as the bonded block has a few more."""
    with tempfile.TemporaryDirectory() as folder:
        bonded = None
        for load in ("bonded", "held", "floating"):
            s = ours(load, SIZES[name], threads, folder)
            seconds = s["seconds"]
            solve = seconds["setup"] + seconds["iteration"]
            bonded = bonded or solve / s["dofs"]
            points = s["contact"]["points"]
            print(
                f"| {s['dofs']} | {load} | {points} | {300 * points / s['dofs']:.1f} | {solve:.2f} | {seconds['setup']:.2f} "
                f"| {s['counts']['cycles']} | **{solve / s['dofs'] / bonded:.2f}** | {seconds['contact']:.2f} "
                f"| {100 * seconds['contact'] / seconds['total']:.1f} % | {s['certificate']['worst']:.1e} |",
                flush=True,
            )


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--sizes", default="50k,200k,700k")
    parser.add_argument("--threads", type=int, default=1)
    arguments = parser.parse_args()
    subprocess.run(["cargo", "build", "--release", "--quiet", "--bin", "stiction"], cwd=ROOT, check=True)
    print(HEAD)
    for name in arguments.sizes.split(","):
        size(name, arguments.threads)


main()
