#!/usr/bin/env python3
"""The proven bound beside the true error, on the meshes that refinement makes of the model brick.

    python3 bench/bound_errors.py [target/release/stiction]                  # needs numpy, scipy and pyvista

Without friction, with given friction and with Coulomb friction the brick is refined until each of some numbers of unknowns is
exceeded, with `proven = true`, and far beyond them for a reference. The true error is the distance in the energy norm of the strain of the
displacements from that of the reference, at four points of each cell of the reference, with the estimated error of the
reference added as a right angle. Energies are not compared: displacements that were found may be in the obstacle between their nodes by
a little, so that their energy may lie below the exact one.

Ends with code 1 where a bar is missed: the bound at least the true error, at most 2.2 times the true
error and 1.9 below 4 %, bound of the mean stress at most 1.05 times it.
"""

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import reference_errors
from reference_errors import ROOT, Field, distance

CASE = ROOT / "cases" / "brick" / "brick.toml"
reference_errors.YOUNG, reference_errors.POISSON = 21.19e10, 0.277
FRICTION = {"none": '"none"', "given": "{tresca=1e5}", "Coulomb": "{coulomb=0.35}"}
UNKNOWNS = [980, 1900, 3500, 7500, 23000]
REFERENCE = 200000


def solve(program, folder, friction, unknowns):
    """Displacements, the bounds of the error and of that of the mean stress, the norm of the latter, and the number of unknowns."""
    command = [program, "solve", str(CASE), "-o", str(folder), "--no-report", "--no-pictures", "--set", "mesh.block.cells=[6,2,2]"]
    command += ["--set", "contact.0.friction=" + friction]
    command += ["--set", 'accuracy={energy="0.3%%",proven=true,max_unknowns=%d}' % unknowns]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    if not (folder / "bound.npz").exists():
        raise SystemExit(done.stdout.decode()[-1000:])
    judged = subprocess.run([program, "check", str(folder)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    if judged.returncode != 0:
        raise SystemExit(judged.stdout.decode()[-1000:])
    data = np.load(folder / "bound.npz")
    return Field(folder, 0), data["claim"], len(data["unknown_of"])


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program", nargs="?", default=str(ROOT / "target" / "release" / "stiction"))
    program = parser.parse_args().program
    missed = False
    print("| friction | unknowns | true error | bound/true | mean stress: bound/true |\n|---|--:|--:|--:|--:|")
    for name, friction in FRICTION.items():
        with tempfile.TemporaryDirectory() as folder:
            fine, _, _ = solve(program, Path(folder) / "reference", friction, REFERENCE)
            estimate = reference_errors.read(Path(folder) / "reference")[0][None][0]
            for unknowns in UNKNOWNS:
                coarse, (error, mean_error, norm, _, _), count = solve(program, Path(folder) / str(unknowns), friction, unknowns)
                apart, lost = distance(coarse, fine)
                assert lost == 0
                true = np.hypot(apart, estimate)
                bound, mean = error / norm / true, mean_error / norm / true
                print(f"| {name} | {count} | {100 * true:.2f} % | {bound:.2f} | {mean:.2f} |", flush=True)
                missed |= not (1 <= bound <= (1.9 if true < 0.04 else 2.2) and mean <= 1.05)
    sys.exit(missed)


if __name__ == "__main__":
    main()
