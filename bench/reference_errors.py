#!/usr/bin/env python3
"""Estimated errors of refined runs beside their distance from a fine reference, and forces beside their error bars.

    python3 bench/reference_errors.py [target/release/stiction] [--only lug,joint]

Needs numpy and pyvista; the bracket needs gmsh. Each case is refined to several accuracies. The last run is the reference. The stress of
every other run, from the displacements in `result.vtu`, is compared with that of the reference at four points of each cell of the
reference; the estimated error of the reference is added as if both were orthogonal. Points outside of the coarser mesh (facets that
were made round) and cells at the cuts of bolts are left out and counted. Of several load steps the one is compared whose estimate decides on refinement. All cases are of one isotropic material without initial strain.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pyvista as pv

ROOT = Path(__file__).resolve().parent.parent
CASES = ROOT / "cases"
YOUNG, POISSON = 210e3, 0.3
# Name, file, accuracies in percent; the last run is the reference.
RUNS = [
    ("lug", CASES / "lug/lug.toml", [8, 5, 3, 2]),
    ("rings", CASES / "rings/rings.toml", [4, 2, 1, 0.05]),
    ("joint", CASES / "joint/joint.toml", [15, 10, 6]),
    ("cattaneo", CASES / "cattaneo/cattaneo.toml", [2, 1.2]),
    ("bracket", "bracket", [20, 15, 9]),
]
# The edges of the middles of a quadratic tetrahedron in VTK's order.
EDGES = [(0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)]
# Factor on the length of edges of the bracket's first mesh.
SIZE = "2"
# Four points exact for second degree (Hammer and Stroud 1956).
A, B = (5 + 3 * 5**0.5) / 20, (5 - 5**0.5) / 20
POINTS = np.full((4, 4), B) + (A - B) * np.eye(4)


def solved(program, case, accuracy, folder):
    """The folder of a run."""
    command = [program, "solve", case, "-o", folder, "--accuracy", f"{accuracy}%", "--no-report", "--no-pictures"]
    run = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    if not (Path(folder) / "summary.json").exists():
        raise SystemExit(f"{case}: {run.stderr}")
    return Path(folder)


class Field:
    """Stress of the displacements of a result of quadratic tetrahedra."""

    def __init__(self, folder, step):
        mesh = pv.read(folder / (f"result-{step:04}.vtu" if step else "result.vtu"))
        cells = mesh.cells_dict
        if set(cells) != {24}:
            raise SystemExit(f"{folder}: cells that are no quadratic tetrahedra: {set(cells)}")
        self.cells, self.x, self.u = cells[24], np.asarray(mesh.points, float), np.asarray(mesh["displacement"], float)
        corners = self.x[self.cells[:, :4]]
        edges = corners[:, 1:] - corners[:, :1]
        self.volume = np.abs(np.linalg.det(edges)) / 6
        inner = np.linalg.inv(edges).transpose(0, 2, 1)
        self.gradient = np.concatenate([-inner.sum(axis=1, keepdims=True), inner], axis=1)
        linear = pv.UnstructuredGrid({pv.CellType.TETRA: self.cells[:, :4]}, self.x)
        # Bodies in contact have no node in common.
        self.body = self.bodies()
        # The displacements of a bolt jump at its cut: cells there do not have the stress of their nodes' displacements.
        centre = self.stress(np.arange(len(self.cells)), np.full((len(self.cells), 4), 0.25))
        own = np.stack([centre[:, a, b] for a, b in [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2)]], axis=1)
        stored = np.asarray(mesh.cell_data["stress"], float)
        off, size = np.abs(own - stored).max(axis=1), np.abs(stored).max(axis=1)
        self.stored = stored
        jumps = off > 0.05 * size + 0.1 * np.median(size)
        # A corner's function has no slope in the centre: what has a node in common is left out too.
        at_jumps = np.zeros(len(self.x), bool)
        at_jumps[self.cells[jumps]] = True
        self.whole = ~at_jumps[self.cells].any(axis=1)
        self.parts = []
        for body in np.unique(self.body):
            own = np.flatnonzero(self.body == body)
            self.parts.append((own, linear.extract_cells(own)))

    def bodies(self):
        """A number for each cell that is the same in all that hangs together."""
        from scipy.sparse import coo_matrix
        from scipy.sparse.csgraph import connected_components

        first, rest = self.cells[:, 0], self.cells[:, 1:4]
        rows = np.repeat(first, 3)
        count = len(self.x)
        graph = coo_matrix((np.ones(rows.size), (rows, rest.ravel())), shape=(count, count))
        return connected_components(graph, directed=False)[1][first]

    def centres(self):
        return {int(body): self.x[self.cells[self.body == body, :4]].mean(axis=(0, 1)) for body in np.unique(self.body)}

    def stress(self, cells, w):
        """At points with barycentric coordinates `w` of these cells."""
        nodes = self.cells[cells]
        # Derivatives of the functions of the nodes by the four coordinates, of these by the last three alone.
        by = np.zeros((len(w), 10, 4))
        by[:, range(4), range(4)] = 4 * w - 1
        for k, (i, j) in enumerate(EDGES):
            by[:, 4 + k, i], by[:, 4 + k, j] = 4 * w[:, j], 4 * w[:, i]
        by = by[:, :, 1:] - by[:, :, :1]
        to_places = np.einsum("pna,pni->pai", self.x[nodes], by)
        slope = np.einsum("pna,pni,pib->pab", self.u[nodes], by, np.linalg.inv(to_places))
        strain = 0.5 * (slope + slope.transpose(0, 2, 1))
        shear = YOUNG / (2 * (1 + POISSON))
        lame = YOUNG * POISSON / ((1 + POISSON) * (1 - 2 * POISSON))
        trace = np.trace(strain, axis1=1, axis2=2)
        return 2 * shear * strain + lame * trace[:, None, None] * np.eye(3)


def tensors(components):
    return components[:, [[0, 3, 5], [3, 1, 4], [5, 4, 2]]]


def squared(stress):
    """Density of the squared energy norm."""
    trace = np.trace(stress, axis1=1, axis2=2)
    return ((1 + POISSON) * np.einsum("pab,pab->p", stress, stress) - POISSON * trace**2) / YOUNG


def distance(coarse, fine):
    """Energy norm of the difference over that of the reference, and the part of the volume outside."""
    total = apart = lost = 0.0
    centres = {number: x for number, x in enumerate(coarse.centres().values())}
    for body, centre in fine.centres().items():
        number = min(centres, key=lambda n: np.linalg.norm(centres[n] - centre))
        own, grid = coarse.parts[number]
        cells = np.flatnonzero(fine.body == body)
        for w in POINTS:
            places = np.einsum("i,pia->pa", w, fine.x[fine.cells[cells, :4]])
            found = np.asarray(grid.find_containing_cell(places))
            inside = (found >= 0) & fine.whole[cells] & coarse.whole[own[found]]
            at = own[found[inside]]
            first = fine.stress(cells[inside], np.tile(w, (inside.sum(), 1)))
            inner = np.einsum("pia,pa->pi", coarse.gradient[at, 1:], places[inside] - coarse.x[coarse.cells[at, 0]])
            weights = np.concatenate([1 - inner.sum(axis=1, keepdims=True), inner], axis=1)
            second = coarse.stress(at, weights)
            volume = fine.volume[cells] / 4
            total += (squared(first) * volume[inside]).sum()
            total += (squared(tensors(fine.stored[cells[~inside]])) * volume[~inside]).sum()
            apart += (squared(first - second) * volume[inside]).sum()
            lost += volume[~inside].sum()
    return (apart / total) ** 0.5, lost / fine.volume.sum()


def read(folder):
    """Estimates by time, unknowns, and the values with their bars."""
    summary = json.loads((folder / "summary.json").read_text())
    record = summary["accuracy"]
    steps = summary.get("steps") or [{"t": None, "step": 0, **summary}]
    errors = {step["t"]: (step["discretisation_error"], step["step"]) for step in steps}
    return errors, record["levels"][-1]["unknowns"], {value["name"]: value for value in record["values"]}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", nargs="?", default=ROOT / "target/release/stiction")
    parser.add_argument("--only", default="", help="cases whose names contain one of these words")
    arguments = parser.parse_args()
    words = [word for word in arguments.only.split(",") if word]
    print("| case | unknowns | estimate | from the reference | estimate over error | values inside | outside |\n|---|--:|--:|--:|--:|--:|--:|")
    for name, case, accuracies in RUNS:
        if words and not any(word in name for word in words):
            continue
        with tempfile.TemporaryDirectory() as top:
            if not isinstance(case, Path):
                case = assembly(case, Path(top))
            folders = [solved(arguments.program, case, accuracy, Path(top) / str(accuracy)) for accuracy in accuracies]
            fine_errors, unknowns, exact = read(folders[-1])
            largest = max(error for error, _ in fine_errors.values())
            print(f"| {name} | {unknowns} | {100 * largest:.1f} % | the reference |", flush=True)
            done = {unknowns}
            for folder in folders[:-1]:
                errors, unknowns, values = read(folder)
                if unknowns in done:
                    continue
                done.add(unknowns)
                # The step that decides on refinement; halved steps are in one run alone.
                t = max(set(errors) & set(fine_errors), key=lambda t: errors[t][0])
                (error, step), (fine_error, fine_step) = errors[t], fine_errors[t]
                apart, lost = distance(Field(folder, step), Field(folders[-1], fine_step))
                true = (apart**2 + fine_error**2) ** 0.5
                bars = [
                    (abs(values[name]["value"] - exact[name]["value"]), values[name]["bar"])
                    for name in exact
                    if exact[name]["value"] is not None and values.get(name, {}).get("bar") is not None and values[name]["value"] is not None
                ]
                inside = sum(off <= bar for off, bar in bars)
                print(f"| | {unknowns} | {100 * error:.1f} % | {100 * true:.1f} % | {error / true:.2f} | {inside} of {len(bars)} | {100 * lost:.2f} % |", flush=True)


def assembly(name, folder):
    """The case of an assembly of `bench/assemblies`, on its coarsest mesh."""
    built = folder / name
    subprocess.run([sys.executable, ROOT / "bench/assemblies/build.py", name, SIZE, built], check=True, capture_output=True)
    return built / f"{name}.toml"


if __name__ == "__main__":
    main()
