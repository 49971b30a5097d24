"""The brick family: our Coulomb solve, our linear solve and an external linear solve of the same matrix in one run.

    python3 bench/external/family.py [--sizes 6k,50k,200k,700k,1M,2M] [--elements tet4,hex8] [--threads 1] [--docs]

(a size may be for one element only, `tet4:2M`)

makes a virtual environment with numpy, scipy, pyamg and matplotlib beside the build (once), builds `stiction`, solves every
case with `stiction solve`, and K u = f without contact by pyamg's smoothed aggregation with the rigid motions (conjugate
gradients to 1e-8, one thread) and, up to 220 000 unknowns and where scikit-sparse can be built (Debian: libsuitesparse-dev), by
CHOLMOD. With --docs it writes the table and the plot to docs/benchmark.md and docs/benchmark.png.

"lift" and "press" start from the solution on a coarser block; ", as from a file" are the same without one, as meshes are that
are no blocks.

"further step" is the mean of the second to fourth of four load steps, pressed first and then dragged, with the hierarchy of the
first; its run is that of all four.

Seconds of a solve are the wall seconds of set-up (the coarser block of the nested iteration included) and iteration; pyamg's
are CPU seconds of one thread. On an idle machine with one thread both are the same, on a busy one ours are overstated. `run`
is the whole command, from the case file to the report; "around" is the share of it that is neither set-up nor iteration, of
the wall seconds and of the CPU seconds. They differ by the stiffness, which is written by a second thread while the iteration
runs.
"""

import argparse
import json
import os
import platform
import resource
import subprocess
import sys
import tempfile
import time

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
TARGET = os.environ.get("CARGO_TARGET_DIR", os.path.join(ROOT, "target"))
# Cells across: three times as many along.
SIZES = {"6k": 8, "50k": 17, "200k": 28, "700k": 42, "1M": 48, "2M": 60}
CASE = """title = "brick"
[mesh]
block = {{ size = [3, 1, 1], cells = [{0}, {1}, {1}], element = "{2}" }}
[materials.steel]
young = 21.19e10
poisson = 0.277
[[fix]]
on = "x-min"
[[load]]
on = "x-max"
traction = {3}
[[load]]
on = "z-max"
traction = {4}
{5}
[solver]
path = "multigrid"
"""
CONTACT = """[[contact]]
on = "z-min"
against = {{ plane = {{ point = [0, 0, 0], normal = [0, 0, 1] }} }}
friction = {0}
"""
LIFT = ("[0, 0, 1e6]", '[0, 0, "-2/3*1e6*(3 - x)"]')
PRESS = ("[1e6, 5e5, 0]", "[0, 0, -1e6]")
# Given friction of a tenth of the pressure: some points stick, most slip.
STEPS = "further step"
# A block that is turned, if by nothing, has no coarser one to start from: what a mesh from a file costs.
AS_FILE = ", as from a file"
TURN = "turn = { axis = [0, 0, 1], degrees = 0 }\n"
LOADS = {
    "linear": (*LIFT, ""),
    "lift": (*LIFT, CONTACT.format("{ coulomb = 0.35 }")),
    "press": (*PRESS, CONTACT.format("{ coulomb = 0.35 }")),
    "given": (*PRESS, CONTACT.format("{ tresca = 1e5 }")),
    "lift" + AS_FILE: (*LIFT, CONTACT.format("{ coulomb = 0.35 }")),
    "press" + AS_FILE: (*PRESS, CONTACT.format("{ coulomb = 0.35 }")),
    STEPS: ('["1e6*t", "5e5*t", 0]', PRESS[1], CONTACT.format("{ coulomb = 0.35 }") + "[[step]]\nuntil = 1\nincrements = 4\n"),
}
# The page in docs, up to the table.
PAGE = """# Contact at the cost of a linear solve

The model brick as a family: 6 000 to 2 million unknowns, linear tetrahedra and hexahedra. Written by

```sh
python3 bench/external/family.py --docs
```

- **Loads.** "linear": no contact. "lift": the source paper's load, Coulomb friction 0.35; much of the surface opens.
  "press": pressed down and dragged, the same friction. "given": the same load with given friction. "as from a file":
  without the start from a coarser block. "further step": the mean of the second to fourth of four load steps with the
  hierarchy of the first; its run is that of all four.
- **Solve** is set-up and iteration (wall seconds, the coarser block included), cycles are those of the finest level, and
  "/ linear" is their ratio to the linear load.
- **pyamg** solves `K u = f` without contact by smoothed aggregation with the rigid motions and conjugate gradients to
  1e-8, **CHOLMOD** by a sparse factor, both in CPU seconds of one thread in the same run.
- **Run** is the whole command, from the case file to the report. "Around" is the share of it that is neither set-up nor
  iteration; its wall and CPU values differ by the stiffness, which a second thread writes during the iteration.
- **Worst** is the largest measure of the certificate (tolerance 1e-8).

"""
# The largest systems a sparse factor is tried on: beyond, it takes minutes and most of the memory.
FACTOR = 220_000


def environment():
    """Runs this script again inside its own virtual environment."""
    folder = os.path.join(TARGET, "bench-venv")
    python = os.path.join(folder, "bin", "python")
    if sys.prefix == folder:
        return
    if not os.path.exists(python):
        subprocess.run([sys.executable, "-m", "venv", folder], check=True)
        install = [python, "-m", "pip", "install", "--quiet"]
        subprocess.run([*install, "numpy", "scipy", "pyamg", "matplotlib"], check=True)
        # The last that is for the libraries Debian has; without them there is no such column.
        subprocess.run([*install, "scikit-sparse==0.4.16"], stderr=subprocess.DEVNULL)
    os.environ["OMP_NUM_THREADS"] = "1"
    os.execv(python, [python, os.path.abspath(__file__), *sys.argv[1:]])


def ours(element, n, load, threads, folder):
    case = os.path.join(folder, "case.toml")
    with open(case, "w") as file:
        text = CASE.format(3 * n, n, element, *LOADS[load])
        file.write(text.replace("[materials", TURN + "[materials") if load.endswith(AS_FILE) else text)
    results = os.path.join(folder, load)
    command = [os.path.join(TARGET, "release", "stiction"), "solve", case, "-o", results]
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.time()
    done = subprocess.run([*command, "--threads", str(threads), "--progress", "none"], stdout=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    with open(os.path.join(results, "summary.json")) as file:
        summary = json.load(file)
    if done.returncode != 0 or not summary["certificate"]["passed"]:
        print(f"{element} {n} {load}: {summary['status']} {summary['certificate']}", file=sys.stderr)
    summary["cpu"] = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    summary["wall"] = time.time() - start
    return summary


def theirs(folder):
    import numpy as np
    import pyamg
    import scipy.sparse as sp

    with np.load(os.path.join(folder, "linear", "problem.npz")) as data:
        f, rigid = data["f"], data["rigid"].copy()
        lower = (data["K_lower_value"], data["K_lower_column"].astype(np.int32), data["K_lower_start"])
        lower = sp.csr_matrix(lower, shape=(len(f), len(f)))
        K = (lower + sp.tril(lower, -1).T).tobsr(blocksize=(3, 3))
    start = time.process_time()
    hierarchy = pyamg.smoothed_aggregation_solver(K, B=rigid, max_coarse=300)
    setup = time.process_time() - start
    residuals = []
    hierarchy.solve(f, tol=1e-8, accel="cg", residuals=residuals)
    total = time.process_time() - start
    return setup, total, len(residuals) - 1, factor(K, f) if len(f) <= FACTOR else None


def factor(K, f):
    """Seconds of ordering, factor and solve by CHOLMOD, or None."""
    try:
        from sksparse.cholmod import cholesky
    except ImportError:
        return None
    K = K.tocsc()
    start = time.process_time()
    cholesky(K, ordering_method="metis")(f)
    return time.process_time() - start


def size(arguments, element, name):
    """The rows of one size: our solves beside the external one."""
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        external = None
        for load in LOADS:
            s = ours(element, SIZES[name], load, arguments.threads, folder)
            if load == "linear":
                # In a process of its own: its memory is gone before the next solve.
                command = [sys.executable, os.path.abspath(__file__), "--external", folder]
                done = subprocess.run(command, capture_output=True, text=True)
                external = json.loads(done.stdout) if done.returncode == 0 else None
                linear_cycles = s["counts"]["cycles"]
            seconds, cpu = s["seconds"], s["cpu_seconds"]
            solve, setup, cycles = seconds["setup"] + seconds["iteration"], seconds["setup"], s["counts"]["cycles"]
            around = [1 - solve / s["wall"], 1 - (cpu["setup"] + cpu["iteration"]) / s["cpu"]]
            if load == STEPS:
                further = s["steps"][1:]
                setup, solve = 0.0, sum(e["seconds"]["iteration"] for e in further) / len(further)
                cycles = round(sum(e["counts"]["cycles"] for e in further) / len(further))
            rows.append({
                "element": element, "unknowns": s["dofs"], "load": load, "solve": solve, "setup": setup,
                "cycles": cycles, "over_linear": cycles / linear_cycles,
                "external": external, "ratio": solve / external[1] if external else None,
                "wall": s["wall"], "cpu": s["cpu"], "memory": s["peak_memory_bytes"],
                "around": around, "worst": s["certificate"]["worst"],
            })
            print(line(rows[-1]), flush=True)
    return rows


HEAD = """| element | unknowns | load | solve s | of it set-up | cycles | / linear | pyamg linear s | steps | CHOLMOD linear s | solve / pyamg | run wall s | run CPU s | GB | around, wall | around, CPU | worst |
|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|"""


def line(r):
    external = "- | - | - | -"
    if r["external"]:
        _, seconds, steps, factor = r["external"]
        external = f"{seconds:.2f} | {steps} | {f'{factor:.2f}' if factor else '-'} | **{r['ratio']:.2f}**"
    return (
        f"| {r['element']} | {r['unknowns']} | {r['load']} | {r['solve']:.2f} | {r['setup']:.2f} | {r['cycles']} "
        f"| {r['over_linear']:.2f} | {external} | {r['wall']:.2f} | {r['cpu']:.2f} | {r['memory'] / 1e9:.2f} "
        f"| {100 * r['around'][0]:.0f} % | {100 * r['around'][1]:.0f} % | {r['worst']:.1e} |"
    )


def machine():
    with open("/proc/cpuinfo") as file:
        model = next((l.split(":")[1].strip() for l in file if l.startswith("model name")), platform.processor())
    return f"{model}, {os.cpu_count()} threads, {time.strftime('%Y-%m-%d')}"


def plot(rows, path):
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(1, 2, figsize=(11, 4.2))
    for element, style in (("tet4", "-o"), ("hex8", "--s")):
        for load, colour in (("linear", "0.5"), ("lift", "C0"), ("press", "C1"), ("given", "C2"), (STEPS, "C3")):
            own = [r for r in rows if r["element"] == element and r["load"] == load]
            if not own:
                continue
            unknowns = [r["unknowns"] for r in own]
            axes[0].loglog(unknowns, [r["solve"] for r in own], style, color=colour, label=f"{load}, {element}", ms=4)
            known = [r for r in own if r["ratio"]]
            axes[1].semilogx([r["unknowns"] for r in known], [r["ratio"] for r in known], style, color=colour, ms=4)
        own = [r for r in rows if r["element"] == element and r["load"] == "linear" and r["external"]]
        label = f"pyamg, linear, {element}"
        axes[0].loglog([r["unknowns"] for r in own], [r["external"][1] for r in own], style, color="k", label=label, ms=4)
    axes[0].set(xlabel="unknowns", ylabel="set-up and iteration, seconds")
    axes[0].legend(fontsize=7)
    axes[1].axhline(1, color="k", lw=0.8)
    axes[1].set(xlabel="unknowns", ylabel="our solve / one linear solve by pyamg")
    axes[1].set_ylim(bottom=0)
    for a in axes:
        a.grid(alpha=0.3, which="both")
    figure.tight_layout()
    figure.savefig(path, dpi=120)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--sizes", default=",".join(SIZES))
    parser.add_argument("--elements", default="tet4,hex8")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--docs", action="store_true")
    parser.add_argument("--external", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.external:
        print(json.dumps(theirs(arguments.external)))
        return
    subprocess.run(["cargo", "build", "--release", "--quiet", "--bin", "stiction"], cwd=ROOT, check=True)
    title = f"{machine()}; our solves on {arguments.threads} thread(s)"
    print(title + "\n\n" + HEAD)
    rows = []
    for element in arguments.elements.split(","):
        for name in arguments.sizes.split(","):
            only, _, name = name.rpartition(":")
            if only in ("", element):
                rows += size(arguments, element, name)
    if arguments.docs:
        docs = os.path.join(ROOT, "docs")
        plot(rows, os.path.join(docs, "benchmark.png"))
        with open(os.path.join(docs, "benchmark.md"), "w") as file:
            file.write(
                PAGE + title + "\n\n"
                "![seconds and ratios over unknowns](benchmark.png)\n\n" + HEAD + "\n"
                + "\n".join(line(r) for r in rows) + "\n"
            )


environment()
main()
