"""Our contact solve beside one linear elastic solve by an external multigrid, in the same run.

    python3 -m venv venv && venv/bin/pip install numpy scipy pyamg
    cargo build --release && venv/bin/python bench/external/linear_solve.py target/release/stiction 16 28 42

For each number of cells across, the model brick with Coulomb friction is solved by `stiction solve --threads 1`, and K u = f
without contact by pyamg's smoothed aggregation with the rigid motions (conjugate gradients to 1e-8), one thread. Seconds
are CPU seconds of pyamg's process part and, for ours, the wall seconds of set-up and iteration: on an idle machine the
same; on a busy one ours are overstated.
"""

import json
import os
import subprocess
import sys
import tempfile
import time

os.environ.setdefault("OMP_NUM_THREADS", "1")
import numpy as np
import pyamg
import scipy.sparse as sp

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
LOADS = {
    "lift": [],
    "press": ["load.0.traction=[1e6, 5e5, 0]", "load.1.traction=[0, 0, -1e6]"],
}


def ours(program, n, load, folder):
    case = os.path.join(ROOT, "cases", "brick", "brick.toml")
    settings = [f"mesh.block.cells=[{3 * n},{n},{n}]", "solver.path=multigrid"] + LOADS[load]
    changes = [part for s in settings for part in ("--set", s)]
    command = [program, "solve", case, "-o", folder, "--threads", "1", "--progress", "none", *changes]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    with open(os.path.join(folder, "summary.json")) as file:
        return json.load(file)


def theirs(folder):
    data = np.load(os.path.join(folder, "problem.npz"))
    size = len(data["f"])
    K = sp.csr_matrix((data["K_value"], data["K_column"].astype(np.int32), data["K_start"]), shape=(size, size))
    K = K.tobsr(blocksize=(3, 3))
    start = time.process_time()
    hierarchy = pyamg.smoothed_aggregation_solver(K, B=data["rigid"].copy(), max_coarse=300)
    ready = time.process_time()
    residuals = []
    hierarchy.solve(data["f"], tol=1e-8, accel="cg", residuals=residuals)
    return ready - start, time.process_time() - ready, len(residuals) - 1


def main():
    program, sizes = sys.argv[1], [int(n) for n in sys.argv[2:]]
    print("| unknowns | load | our contact s | set-up | cycles | pyamg linear s | set-up | steps | ratio |")
    print("|---|---|---|---|---|---|---|---|---|")
    for n in sizes:
        linear = None
        for load in LOADS:
            with tempfile.TemporaryDirectory() as folder:
                folder = os.path.join(folder, "results")
                summary = ours(program, n, load, folder)
                assert summary["certificate"]["passed"], summary["certificate"]
                linear = linear or theirs(folder)
            seconds = summary["seconds"]["setup"] + summary["seconds"]["iteration"]
            setup, solve, steps = linear
            print(
                f"| {summary['dofs']} | {load} | {seconds:.2f} | {summary['seconds']['setup']:.2f} "
                f"| {summary['counts']['cycles']} | {setup + solve:.2f} | {setup:.2f} | {steps} "
                f"| {seconds / (setup + solve):.2f} |",
                flush=True,
            )


main()
