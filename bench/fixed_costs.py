#!/usr/bin/env python3
"""CPU seconds (user and system, one thread) of what a run costs beside its solves, and ratios.

    python3 bench/fixed_costs.py [target/release/stiction]

- The brick of 12 x 4 x 4 cells as a whole run, with and without pictures and report.
- 100 load steps of two blocks with friction under a load that grows and turns, about 48 000 unknowns, over the first step:
  as a whole run of that step alone, and as its set-up and iteration alone. Memory after five steps and at the end.

Each short run is the least of several: the machine may be shared.
"""

import json
import os
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
BRICK = ROOT / "cases/brick/brick.toml"
STEPS = """
title = "Two bodies, a load that grows and turns"
units = "mm, N, MPa"

[mesh.parts.low]
block = { size = [40, 40, 14], cells = [28, 28, 10], element = "hex8" }

[mesh.parts.high]
block = { size = [30, 30, 14], cells = [24, 24, 11], element = "hex8" }
move = [5, 5, 14]

[materials.steel]
young = 210e3
poisson = 0.3

[[fix]]
on = "low.z-min"

[[load]]
on = "high.z-max"
traction = ["3*t*cos(12*t)", "3*t*sin(12*t)", "-5 - 20*t"]

[[contact]]
on = "high.z-min"
against = "low.z-max"
friction = { coulomb = 0.2 }

[[step]]
name = "turn"
until = 1
increments = 100
"""
ONE_STEP = ["--set", "step.0.until=0.01", "--set", "step.0.increments=1"]
BARE = ["--no-report", "--no-pictures"]


def cpu(command, arguments):
    """CPU seconds of one run."""
    line = [command, "solve", *map(str, arguments), "--threads", "1", "--progress", "none"]
    quiet = [(os.POSIX_SPAWN_OPEN, 1, os.devnull, os.O_WRONLY, 0)]
    _, status, usage = os.wait4(os.posix_spawn(command, line, os.environ, file_actions=quiet), 0)
    if status != 0:
        sys.exit(f"{' '.join(line)} ended with {os.waitstatus_to_exitcode(status)}")
    return usage.ru_utime + usage.ru_stime


def main():
    command = sys.argv[1] if len(sys.argv) > 1 else str(ROOT / "target/release/stiction")
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        small = [BRICK, "--set", "mesh.block.cells=[12,4,4]", "-o", folder / "brick"]
        for name, options in [("bare", BARE), ("without report", BARE[:1]), ("whole", [])]:
            seconds = min(cpu(command, [*small, *options]) for _ in range(10))
            print(f"brick 12 x 4 x 4, {name:15} {seconds:.3f} CPU s")
        case = folder / "steps.toml"
        case.write_text(STEPS)
        first = min(cpu(command, [case, "-o", folder / "one", *BARE, *ONE_STEP]) for _ in range(3))
        whole = cpu(command, [case, "-o", folder / "steps", *BARE])
        summary = json.loads((folder / "steps/summary.json").read_text())
        steps = summary["steps"]
        solve = sum(steps[0]["cpu_seconds"][phase] for phase in ("setup", "iteration"))
        cycles = [step["counts"]["cycles"] for step in steps]
        memory = [step["peak_memory_bytes"] / 1e6 for step in (steps[4], steps[-1])]
        print(f"{len(steps)} load steps, {summary['dofs']} unknowns: {whole:.2f} CPU s, {sum(cycles)} cycles, the first {cycles[0]}")
        print(f"  over a whole run of the first step, {first:.3f} s: {whole / first:.1f}")
        print(f"  over set-up and iteration of the first, {solve:.3f} s: {whole / solve:.1f}")
        print(f"  memory after five steps {memory[0]:.0f} MB, at the end {memory[1]:.0f} MB: {memory[1] / memory[0]:.3f}")


if __name__ == "__main__":
    main()
