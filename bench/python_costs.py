#!/usr/bin/env python3
"""What the package of Python costs beside the command, and what a large stiffness matrix takes to enter.

    python3 bench/python_costs.py times [--pairs N] [--program target/release/stiction]
    python3 bench/python_costs.py memory [--cells N]

Run by an interpreter that has the package, NumPy and SciPy.

`times` solves the same case files by the command and by `stiction.Case`, in turn, each in a process of its own on one thread,
and prints medians of user CPU seconds and of their ratio pair by pair: of the phases that solve (by `cpu_seconds` of the summary), and of everything from the case file to the files of the results (of the command the
whole process, of Python what `Case(..)` and `solve(..)` take: the start of the interpreter is not in it).

`memory` makes the stiffness of a block of linear hexahedra from Kronecker products of matrices of one direction, as CSR with
32-bit indices, forgets everything else, sets the peak of the process back (`/proc/self/clear_refs`), and makes a
`stiction.Problem`. Counted is how far the peak of resident memory (VmHWM) then rises above the resident memory before
(VmRSS), over the bytes of `K.data`, `K.indices` and `K.indptr`. Linux only.
"""

import argparse
import json
import os
import pathlib
import resource
import statistics
import subprocess
import sys
import tempfile
import time

CASE = """
title = "Block pushed along a plane"
units = "mm, N, MPa"

[mesh]
block = {{ size = [40, 40, 20], cells = {cells}, element = "hex8" }}

[materials.steel]
young = 210e3
poisson = 0.3

[[fix]]
on = "z-max"
value = [1e-3, 0, -2e-3]

[[contact]]
on = "z-min"
against = {{ plane = {{ point = [0, 0, 0], normal = [0, 0, 1] }} }}
friction = {{ coulomb = 0.3 }}

[solver]
path = "{path}"
"""
PATHS = {"multigrid": "[40, 40, 20]", "dense": "[24, 24, 12]"}


def solved(folder):
    """Processor seconds of the phases."""
    seconds = json.loads((folder / "summary.json").read_text())["cpu_seconds"]
    return {name: value for name, value in seconds.items() if isinstance(value, (int, float))}


def command(program, case, folder):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    call = [program, "solve", case, "-o", folder, "--threads", "1", "--progress", "none"]
    subprocess.run(call, check=True, stdout=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime - before.ru_utime, after.ru_stime - before.ru_stime


INSIDE = """
import resource, sys
import stiction
case, folder = sys.argv[1:]
before = resource.getrusage(resource.RUSAGE_SELF)
stiction.Case(case).solve(folder=folder, threads=1)
after = resource.getrusage(resource.RUSAGE_SELF)
print(after.ru_utime - before.ru_utime, after.ru_stime - before.ru_stime)
"""


def python(case, folder):
    done = subprocess.run([sys.executable, "-c", INSIDE, case, folder], check=True, capture_output=True, text=True)
    user, system = map(float, done.stdout.split())
    return user, system


def times(given):
    for path, cells in PATHS.items():
        rows = []
        with tempfile.TemporaryDirectory() as name:
            work = pathlib.Path(name)
            case = work / "case.toml"
            case.write_text(CASE.format(cells=cells, path=path))
            for pair in range(given.pairs + 1):
                calls = [("command", lambda f: command(given.program, case, f)), ("python", lambda f: python(case, f))]
                row = {}
                # A B, B A, ...: a machine that slows down does so for both.
                for who, call in calls if pair % 2 == 0 else reversed(calls):
                    folder = work / f"{who}-{pair}"
                    user, system = call(folder)
                    row[who] = {"user": user, "system": system, **solved(folder)}
                if pair > 0:  # the first is a warm-up
                    rows.append(row)
        print(f"{path}, {cells} cells, {len(rows)} pairs: median of command, of Python, of the ratio; least and largest ratio")
        for key in rows[0]["command"]:
            values = [[row[who][key] for row in rows] for who in ("command", "python")]
            if min(values[0] + values[1]) > 0.01:
                ratios = [b / a for a, b in zip(*values, strict=True)]
                middle = [statistics.median(v) for v in (*values, ratios)]
                print(f"  {key:22} {middle[0]:9.3f} {middle[1]:9.3f} {middle[2]:7.3f}   {min(ratios):.3f} .. {max(ratios):.3f}")


def status(key):
    """A line of /proc/self/status in bytes."""
    for line in pathlib.Path("/proc/self/status").read_text().splitlines():
        if line.startswith(key + ":"):
            return int(line.split()[1]) * 1024
    raise SystemExit(f"/proc/self/status has no {key}: this needs Linux")


def block(cells):
    """K of a cube of so many cells along each edge (unit cells, E = 1, nu = 0.3), and its nodes."""
    import numpy as np
    import scipy.sparse as sp

    n = cells + 1

    def line(element):
        """Assembled along one direction; the zeros that cancel stay, so that all products have the same places."""
        i = np.arange(n - 1)
        rows = np.concatenate([i, i, i + 1, i + 1])
        columns = np.concatenate([i, i + 1, i, i + 1])
        return sp.csr_array((np.repeat(element, n - 1), (rows, columns)), shape=(n, n))

    mass = line([1 / 3, 1 / 6, 1 / 6, 1 / 3])
    stiffness = line([1.0, -1.0, -1.0, 1.0])
    slope = line([-0.5, 0.5, -0.5, 0.5])  # row: function, column: derivative
    lame, shear = 0.3 / (1.3 * 0.4), 1 / 2.6

    def product(*factors):  # the first direction varies slowest
        return sp.kron(sp.kron(factors[0], factors[1], format="csr"), factors[2], format="csr")

    pattern = product(mass, mass, mass)
    values = np.zeros((pattern.nnz, 3, 3))
    for a in range(3):
        for b in range(3):
            if a == b:
                for c in range(3):
                    factors = [mass] * 3
                    factors[c] = stiffness
                    values[:, a, a] += (lame + 2 * shear if c == a else shear) * product(*factors).data
            else:
                # The integral of lame v_a,a u_b,b + shear v_a,b u_b,a.
                factors = [mass] * 3
                factors[a], factors[b] = slope.T.tocsr(), slope
                values[:, a, b] += lame * product(*factors).data
                factors[a], factors[b] = slope, slope.T.tocsr()
                values[:, a, b] += shear * product(*factors).data
    K = sp.bsr_array((values, pattern.indices, pattern.indptr)).tocsr()
    nodes = np.stack(np.meshgrid(*[np.arange(n, dtype=float)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    return K, nodes


def memory(given):
    import numpy as np
    import scipy.sparse as sp

    import stiction

    K, nodes = block(given.cells)
    # SciPy's products have indices of 64 bits.
    K = sp.csr_array((K.data, K.indices.astype(np.int32), K.indptr.astype(np.int32)), shape=K.shape)
    n = K.shape[0]
    # A body that is moved and strained without stress shows a wrong matrix.
    rotation = np.cross([0.3, -0.2, 0.5], nodes).ravel()
    assert abs(K @ rotation).max() < 1e-9 * abs(rotation).max(), "a rotation strains"
    foot = np.flatnonzero(nodes[:, 2] == 0)
    top = np.flatnonzero(nodes[:, 2] == given.cells)
    m = len(foot)
    B = sp.csr_array(
        (np.tile([-1.0, 1.0, 1.0], m), (np.arange(3 * m), (3 * foot[:, None] + [2, 0, 1]).ravel())), shape=(3 * m, n)
    )
    f = np.zeros(n)
    held = (3 * top[:, None] + np.arange(3)).ravel()
    values = np.tile([1e-4, 0.0, -2e-4], len(top))
    entries = K.data.nbytes + K.indices.nbytes + K.indptr.nbytes
    print(f"{n} unknowns, {K.nnz} entries, indices of {K.indices.itemsize} bytes: K takes {entries / 1e6:.0f} MB")
    for name, more in (("no support", {}), ("held=", {"held": held, "values": values})):
        pathlib.Path("/proc/self/clear_refs").write_text("5")
        before, start = status("VmRSS"), time.process_time()
        problem = stiction.Problem(K, B, f, 0.0, mu=0.3, coordinates=nodes, **more)
        seconds = time.process_time() - start
        peak, after = status("VmHWM") - before, status("VmRSS") - before
        print(
            f"  {name:11} peak rises by {peak / 1e6:6.0f} MB = {peak / entries:.2f} K, "
            f"{after / 1e6:.0f} MB = {after / entries:.2f} K stay, {seconds:.1f} CPU seconds"
        )
        del problem


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    kinds = parser.add_subparsers(required=True)
    kind = kinds.add_parser("times")
    kind.add_argument("--pairs", type=int, default=9)
    kind.add_argument("--program", default="target/release/stiction")
    kind.set_defaults(run=times)
    kind = kinds.add_parser("memory")
    kind.add_argument("--cells", type=int, default=87, help="along each edge; 87 make 2 044 416 unknowns")
    kind.set_defaults(run=memory)
    given = parser.parse_args()
    given.run(given)


if __name__ == "__main__":
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    main()
