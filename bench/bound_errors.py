#!/usr/bin/env python3
"""The proven bound beside the true error, on the meshes that refinement makes of the model brick.

    python3 bench/bound_errors.py [target/release/stiction]                  # needs numpy and pyvista

Without friction, with given friction and with Coulomb friction the brick is refined until each of some numbers of unknowns is
exceeded, with `proven = true`, and far beyond them for a reference. The true error is the distance in the energy norm of the strain of the
displacements from that of the reference, at four points of each cell of the reference, with the estimated error of the
reference added as a right angle. Energies are not compared: displacements that were found may be in the obstacle between their nodes by
a little, so that their energy may lie below the exact one.

Ends with code 1 where a bar is missed: the bound at least the true error, at most 2.2 times the true
error and 1.9 below 4 %, bound of the mean stress at most 1.05 times it.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pyvista

ROOT = Path(__file__).resolve().parent.parent
CASE = ROOT / "cases" / "brick" / "brick.toml"
FRICTION = {"none": '"none"', "given": "{tresca=1e5}", "Coulomb": "{coulomb=0.35}"}
UNKNOWNS = [980, 1900, 3500, 7500, 23000]
REFERENCE = 200000
PAIRS = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)]


def solve(program, folder, friction, unknowns):
    command = [program, "solve", str(CASE), "-o", str(folder), "--no-report", "--no-pictures", "--set", "mesh.block.cells=[6,2,2]"]
    command += ["--set", "contact.0.friction=" + friction]
    command += ["--set", 'accuracy={energy="0.3%%",proven=true,max_unknowns=%d}' % unknowns]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    if not (folder / "bound.npz").exists():
        raise RuntimeError(done.stdout.decode()[-1000:])
    judged = subprocess.run([program, "check", str(folder)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    if judged.returncode != 0:
        raise RuntimeError(judged.stdout.decode()[-1000:])
    return Mesh(folder)


class Mesh:
    """Displacements of quadratic tetrahedra with what is said of their error."""

    def __init__(self, folder):
        data = np.load(folder / "bound.npz")
        self.error, self.mean_error = data["claim"][:2]
        self.unknowns = len(data["unknown_of"])
        self.x = data["nodes"].reshape(-1, 3)
        self.corners = data["corners"].reshape(-1, 4).astype(int)
        middles = data["middles"].reshape(-1, 6).astype(int)
        at = [next(k for k in range(6) if np.allclose(self.x[middles[:, k]], self.x[self.corners[:, [i, j]]].mean(1))) for i, j in PAIRS]
        self.middles = middles[:, at]
        self.u = data["found"].reshape(-1, 3)
        self.estimate = json.loads((folder / "summary.json").read_text())["discretisation_error"]

    def strain(self, cells, points):
        """At one point in each of some cells."""
        x = self.x[self.corners[cells]]
        system = np.concatenate([np.ones((len(cells), 4, 1)), x], 2)
        inverse = np.linalg.inv(system)
        gradient = np.swapaxes(inverse[:, 1:], 1, 2)
        weight = np.einsum("ni,nij->nj", np.concatenate([np.ones((len(points), 1)), points], 1), inverse)
        of_u = np.einsum("nic,nid,ni->ncd", self.u[self.corners[cells]], gradient, 4 * weight - 1)
        for k, (i, j) in enumerate(PAIRS):
            of_middle = 4 * (weight[:, i, None] * gradient[:, j] + weight[:, j, None] * gradient[:, i])
            of_u += np.einsum("nc,nd->ncd", self.u[self.middles[cells, k]], of_middle)
        return 0.5 * (of_u + np.swapaxes(of_u, 1, 2))

    def cells_at(self, points):
        cells = np.hstack([np.full((len(self.corners), 1), 4), self.corners]).ravel()
        grid = pyvista.UnstructuredGrid(cells, np.full(len(self.corners), pyvista.CellType.TETRA), self.x)
        found = grid.find_containing_cell(points)
        assert (found >= 0).all()
        return found


def energy(strain, weights):
    young, poisson = 21.19e10, 0.277
    shear = young / 2 / (1 + poisson)
    trace = np.trace(strain, axis1=1, axis2=2)
    return (weights * (2 * shear * poisson / (1 - 2 * poisson) * trace**2 + 2 * shear * (strain**2).sum((1, 2)))).sum()


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program", nargs="?", default=str(ROOT / "target" / "release" / "stiction"))
    program = parser.parse_args().program
    missed = False
    print("| friction | unknowns | true error | bound/true | mean stress: bound/true |\n|---|--:|--:|--:|--:|")
    for name, friction in FRICTION.items():
        with tempfile.TemporaryDirectory() as folder:
            fine = solve(program, Path(folder) / "reference", friction, REFERENCE)
            near, far = 0.13819660112501053, 0.5854101966249684
            rule = near + (far - near) * np.eye(4)
            corners = fine.x[fine.corners]
            volume = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])) / 6
            cells, weights = np.tile(np.arange(len(volume)), 4), np.tile(volume / 4, 4)
            points = np.concatenate([np.einsum("i,nij->nj", of, corners) for of in rule])
            exact = fine.strain(cells, points)
            norm2 = energy(exact, weights)
            for unknowns in UNKNOWNS:
                mesh = solve(program, Path(folder) / str(unknowns), friction, unknowns)
                found = mesh.strain(mesh.cells_at(points), points)
                true = np.sqrt(energy(found - exact, weights) + fine.estimate**2 * norm2)
                part, bound, mean = true / np.sqrt(norm2), mesh.error / true, mesh.mean_error / true
                print(f"| {name} | {mesh.unknowns} | {100 * part:.2f} % | {bound:.2f} | {mean:.2f} |", flush=True)
                missed |= not (1 <= bound <= (1.9 if part < 0.04 else 2.2) and mean <= 1.05)
    sys.exit(missed)


if __name__ == "__main__":
    main()
