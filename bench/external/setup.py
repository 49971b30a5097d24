"""Set-up of the hierarchy beside other programs' on the same matrices, in one run.

    python3 bench/external/setup.py [--sizes 200k,700k] [--elements tet4,hex8] [--docs]

solves the pressed brick with friction by `stiction solve` on one thread, and `K u = f` of the same brick without contact, to
1e-8, by

- PETSc's GAMG with the rigid motions (Debian: python3-petsc4py),
- hypre's BoomerAMG for systems, through PETSc: nodal coarsening, and the rotations interpolated (its second variant),
- AMGCL's smoothed aggregation with blocks of three and its damped Jacobi relaxation (`pip install pyamgcl`),
- pyamg's smoothed aggregation with the rigid motions,

each by conjugate gradients on one thread. Of each the seconds of set-up and of set-up and iteration together, each the least
of three runs in turn: the first touch of memory takes from a tenth to half of a second here, as the machine likes. Where a
program cannot be had the row says so. Ours contains everything from K and the contact rows to the first cycle, the start on a
coarser block included.

It makes a virtual environment with pyamg and pyamgcl beside the build (once), with the system's Python, whose PETSc it uses.
"""

import argparse
import glob
import json
import os
import platform
import subprocess
import sys
import tempfile
import time

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
TARGET = os.environ.get("CARGO_TARGET_DIR", os.path.join(ROOT, "target"))
SIZES = {"50k": 17, "200k": 28, "700k": 42}
CASE = """[mesh]
block = {{ size = [3, 1, 1], cells = [{0}, {1}, {1}], element = "{2}" }}
[materials.steel]
young = 21.19e10
poisson = 0.277
[[fix]]
on = "x-min"
[[load]]
on = "x-max"
traction = [1e6, 5e5, 0]
[[load]]
on = "z-max"
traction = [0, 0, -1e6]
{3}
[solver]
path = "multigrid"
"""
CONTACT = """[[contact]]
on = "z-min"
against = {{ plane = {{ point = [0, 0, 0], normal = [0, 0, 1] }} }}
friction = {{ coulomb = 0.35 }}
""".format()
TOLERANCE = 1e-8
RUNS = 3
PAGE = """# Set-up beside other programs

The pressed brick with Coulomb friction by Stiction, and the same brick without contact, one linear solve to 1e-8, by others;
one thread, seconds, each the least of three runs in turn in one run of

```sh
python3 bench/external/setup.py --docs --sizes {sizes} --elements {elements}
```

GAMG and pyamg have the rigid motions, BoomerAMG coarsens by nodes and interpolates the rotations, AMGCL has blocks of three.
Set-up of Stiction is everything between the assembled matrices and the first cycle, with the start on a coarser block.

"""


def environment():
    folder = os.path.join(TARGET, "setup-venv")
    python = os.path.join(folder, "bin", "python")
    if sys.prefix == folder:
        return
    if not os.path.exists(python):
        system = "/usr/bin/python3" if os.path.exists("/usr/bin/python3") else sys.executable
        subprocess.run([system, "-m", "venv", "--system-site-packages", folder], check=True)
        install = [python, "-m", "pip", "install", "--quiet"]
        subprocess.run([*install, "scipy", "pyamg", "pybind11", "setuptools", "wheel"], check=True)
        subprocess.run([*install, "--no-build-isolation", "pyamgcl"], stderr=subprocess.DEVNULL)
    os.environ["OMP_NUM_THREADS"] = "1"
    os.execv(python, [python, os.path.abspath(__file__), *sys.argv[1:]])


def solve(folder, name, element, cells, contact):
    case = os.path.join(folder, name + ".toml")
    with open(case, "w") as file:
        file.write(CASE.format(3 * cells, cells, element, contact))
    results = os.path.join(folder, name)
    command = [os.path.join(TARGET, "release", "stiction"), "solve", case, "-o", results, "--threads", "1"]
    subprocess.run([*command, "--no-report", "--progress", "none"], stdout=subprocess.DEVNULL, check=True)
    with open(os.path.join(results, "summary.json")) as file:
        summary = json.load(file)
    assert summary["certificate"]["passed"]
    seconds = summary["seconds"]
    return seconds["setup"], seconds["setup"] + seconds["iteration"], summary["counts"]["cycles"]


def matrix(folder):
    import numpy as np
    import scipy.sparse as sp

    with np.load(os.path.join(folder, "problem.npz")) as data:
        lower = (data["K_lower_value"], data["K_lower_column"].astype(np.int32), data["K_lower_start"].astype(np.int32))
        lower = sp.csr_matrix(lower, shape=(len(data["f"]),) * 2)
        K = (lower + sp.tril(lower, -1).T).tocsr()
        K.sort_indices()
        return K, data["f"].copy(), data["rigid"].copy()


def residual(K, f, u):
    import numpy as np

    return float(np.linalg.norm(f - K @ u) / np.linalg.norm(f))


def pyamg_(K, f, rigid):
    import pyamg

    K = K.tobsr(blocksize=(3, 3))
    start = time.perf_counter()
    hierarchy = pyamg.smoothed_aggregation_solver(K, B=rigid, max_coarse=300)
    setup, residuals = time.perf_counter() - start, []
    u = hierarchy.solve(f, tol=TOLERANCE, accel="cg", residuals=residuals)
    return setup, time.perf_counter() - start, len(residuals) - 1, residual(K, f, u)


def amgcl(K, f, _):
    import pyamgcl

    options = {"coarsening.type": "smoothed_aggregation", "coarsening.aggr.block_size": 3, "relax.type": "damped_jacobi"}
    start = time.perf_counter()
    hierarchy = pyamgcl.amg(K, options)
    setup = time.perf_counter() - start
    solver = pyamgcl.solver(hierarchy, {"type": "cg", "tol": TOLERANCE, "maxiter": 2000})
    u = solver(f)
    return setup, time.perf_counter() - start, solver.iters, residual(K, f, u)


def petsc(K, f, rigid, kind):
    import numpy as np

    for place in glob.glob("/usr/lib/petscdir/*/*/lib/python3/dist-packages"):
        sys.path.insert(0, place)
    import petsc4py

    petsc4py.init([])
    from petsc4py import PETSc

    options = PETSc.Options()
    if kind == "gamg":
        options["mg_levels_ksp_type"] = "chebyshev"
        options["mg_levels_pc_type"] = "jacobi"
    else:
        for key, value in {"numfunctions": 3, "nodal_coarsen": 4, "vec_interp_variant": 2, "strong_threshold": 0.5, "P_max": 4}.items():
            options["pc_hypre_boomeramg_" + key] = value
        options["pc_hypre_boomeramg_coarsen_type"] = "HMIS"
        options["pc_hypre_boomeramg_interp_type"] = "ext+i"
    A = PETSc.Mat().createAIJ(size=K.shape, bsize=3, csr=(K.indptr, K.indices, K.data))
    A.assemble()
    vectors = []
    for column in np.linalg.qr(rigid)[0].T:
        vector = A.createVecRight()
        vector.setArray(column)
        vectors.append(vector)
    A.setNearNullSpace(PETSc.NullSpace().create(vectors=vectors))
    b, u = A.createVecRight(), A.createVecRight()
    b.setArray(f)
    ksp = PETSc.KSP().create()
    ksp.setOperators(A)
    ksp.setType("cg")
    ksp.setNormType(PETSc.KSP.NormType.UNPRECONDITIONED)
    ksp.setTolerances(rtol=TOLERANCE, max_it=2000)
    pc = ksp.getPC()
    pc.setType("gamg" if kind == "gamg" else "hypre")
    ksp.setFromOptions()
    start = time.perf_counter()
    ksp.setUp()
    setup = time.perf_counter() - start
    ksp.solve(b, u)
    return setup, time.perf_counter() - start, ksp.getIterationNumber(), residual(K, f, u.getArray())


EXTERNAL = {
    "GAMG": lambda *system: petsc(*system, "gamg"),
    "BoomerAMG": lambda *system: petsc(*system, "hypre"),
    "AMGCL": amgcl,
    "pyamg": pyamg_,
}


def external(name, folder):
    """Runs one program in a process of its own, whose memory is gone afterwards."""
    command = [sys.executable, os.path.abspath(__file__), "--external", name, folder]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        print(f"{name}: {done.stderr.strip().splitlines()[-1:]}", file=sys.stderr)
        return None
    return json.loads(done.stdout.splitlines()[-1])


def least(runs):
    return [min(values) for values in list(zip(*runs))[:2]] + list(runs[0][2:])


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--sizes", default="200k,700k")
    parser.add_argument("--elements", default="tet4,hex8")
    parser.add_argument("--docs", action="store_true")
    parser.add_argument("--external", nargs=2)
    arguments = parser.parse_args()
    if arguments.external:
        name, folder = arguments.external
        print(json.dumps(EXTERNAL[name](*matrix(folder))))
        return
    subprocess.run(["cargo", "build", "--release", "-p", "stiction-cli"], cwd=ROOT, check=True)
    names = ["Stiction, with contact", *EXTERNAL]
    rows = ["| element | unknowns | program | set-up s | solve s | steps | set-up over Stiction's | solve over Stiction's |",
            "|---|---|---|---|---|---|---|---|"]
    for element in arguments.elements.split(","):
        for size in arguments.sizes.split(","):
            with tempfile.TemporaryDirectory() as folder:
                solve(folder, "linear", element, SIZES[size], "")
                linear = os.path.join(folder, "linear")
                unknowns = len(matrix(linear)[1])
                found = {name: [] for name in names}
                for _ in range(RUNS):
                    found[names[0]].append(solve(folder, "pressed", element, SIZES[size], CONTACT))
                    for name in EXTERNAL:
                        found[name].append(external(name, linear))
                ours = least(found[names[0]])
                for name in names:
                    if None in found[name]:
                        rows.append(f"| {element} | {unknowns} | {name} | not to be had here |||||")
                        continue
                    setup, total, steps, *_ = least(found[name])
                    if name != names[0]:
                        assert found[name][0][3] < 10 * TOLERANCE, (name, found[name])
                    rows.append(f"| {element} | {unknowns} | {name} | {setup:.2f} | {total:.2f} | {steps} "
                                f"| {setup / ours[0]:.1f} | {total / ours[1]:.1f} |")
                    print(rows[-1], flush=True)
    if arguments.docs:
        cpu = [line.split(":")[1].strip() for line in open("/proc/cpuinfo") if line.startswith("model name")]
        head = f"{cpu[0] if cpu else platform.machine()}, {time.strftime('%Y-%m-%d')}\n\n"
        with open(os.path.join(ROOT, "docs", "set-up.md"), "w") as file:
            file.write(PAGE.format(sizes=arguments.sizes, elements=arguments.elements) + head + "\n".join(rows) + "\n")


environment()
main()
