"""Real assemblies beside one bonded linear solve of the same parts, and beside CalculiX.

    python3 bench/external/assemblies.py [--sizes 50k,200k,700k] [--only press_fit,flange] [--no-calculix] [--docs]

makes a virtual environment with numpy, scipy, gmsh and pyamg beside the build (once), builds `stiction`, makes the meshes of
the scripts in `bench/assemblies/` and solves every case with `stiction solve` by its default path on one thread. In the same
run pyamg's smoothed aggregation with the rigid motions solves the linear problem in which the parts are tied to one another
at the contact points (`bonded.py`), by conjugate gradients to 1e-8, and CalculiX solves the 50k size of each
(`calculix.py`; Debian: calculix-ccx), for 20 times our CPU seconds or `--calculix-seconds`, whichever is longer.

All seconds are CPU seconds of one thread, so that others may use the machine. A solve is set-up (or ordering and factor) and
iteration of all load steps, all attempts and all solves for bolts in it; "s a step" is its mean over the load steps. Cycles
are counted from the progress, since the summary leaves out attempts that failed.

With --docs the table is written to docs/assemblies.md. `--program PATH` takes a program instead of building one, `--folder
DIR` keeps meshes, results and what CalculiX took, which the next run uses; the table then has the rows of all runs in that
folder (`--sizes "" --docs` writes it without a run). With ASSEMBLIES_PYTHON=1 it stays in the Python it was started by.
"""

import argparse
import itertools
import json
import os
import platform
import re
import resource
import shutil
import subprocess
import sys
import tempfile
import time

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
TARGET = os.environ.get("CARGO_TARGET_DIR", os.path.join(ROOT, "target"))
SCRIPTS = os.path.join(ROOT, "bench", "assemblies")
SIZES = ["50k", "200k", "700k"]
SOLVE = ["setup", "ordering", "factorisation", "iteration"]
PAGE = """# Assemblies

Assemblies in quadratic tetrahedra (tet10), from the scripts in `bench/assemblies/`: meshes that do not match, Coulomb
friction, bolts that are tightened to a force and then locked, interference, bodies that contact alone holds. Written by

```sh
python3 bench/external/assemblies.py --docs
```

- **Path**: "multigrid", or "solves" and "dense", which go by a sparse factor.
- **Cycles** are those of multigrid in each load step (with bolts: of all solves of the step), and Newton steps on the
  direct path.
- **s a step**: CPU seconds of set-up and iteration over the number of load steps, on one thread.
- **Ratio**: that over the CPU seconds of one *linear* solve (set-up and solve) of the same parts tied to one another, by
  pyamg's smoothed aggregation with the rigid motions and conjugate gradients to 1e-8, in the same run.
- **Run**: CPU seconds of the whole command, from the case file to the report.
- **Worst**: the largest measure of the certificate (tolerance 1e-8).
- **CalculiX** 2.20 with the same meshes, loads and steps, face-to-face penalty contact, one thread: its CPU seconds
  over those of our whole run. It is stopped after 24 times the seconds that our run took then, by the system's count, which may run a tenth ahead
  of what is measured.

"""
HEAD = """| assembly | unknowns | contact points | path | cycles | s a step | pyamg s | ratio | run s | GB | status | worst | CalculiX |
|---|---|---|---|---|---|---|---|---|---|---|---|---|"""


def environment():
    """Runs this script again inside its own virtual environment."""
    folder = os.path.join(TARGET, "assemblies-venv")
    python = os.path.join(folder, "bin", "python")
    if sys.prefix == folder or os.environ.get("ASSEMBLIES_PYTHON"):
        return
    if not os.path.exists(python):
        subprocess.run([sys.executable, "-m", "venv", folder], check=True)
        subprocess.run([python, "-m", "pip", "install", "--quiet", "numpy", "scipy", "gmsh", "pyamg"], check=True)
    os.environ["OMP_NUM_THREADS"] = "1"
    os.execv(python, [python, os.path.abspath(__file__), *sys.argv[1:]])


def timed(command, **settings):
    """The finished process and its CPU seconds."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(command, text=True, **settings)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return done, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def ours(program, case, results, limit):
    command = [program, "solve", case, "-o", results, "--threads", "1", "--progress", "plain"]
    try:
        done, cpu = timed(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, preexec_fn=lambda: stop_after(limit))
    except OSError as error:
        sys.exit(f"{program}: {error}")
    if not os.path.exists(os.path.join(results, "summary.json")):
        return {"failed": next((l for l in done.stderr.splitlines() if l.startswith("error")), f"stopped after {cpu:.0f} s")}
    with open(os.path.join(results, "summary.json")) as file:
        s = json.load(file)
    steps = s["steps"] or [s]
    # One line an iteration; the zeroth has done nothing yet.
    cycles = [0]
    for text in done.stderr.splitlines():
        if re.match(r"  (multigrid|newton) +[1-9]", text):
            cycles[-1] += 1
        elif text.startswith("  step ") and " t = " in text and "iterations" in text:
            cycles.append(0)
    solve = sum(sum(step["cpu_seconds"][phase] for phase in SOLVE) for step in steps)
    return {
        "unknowns": s["dofs"], "points": s["contact"]["points"], "path": ", ".join(dict.fromkeys(step["path"] for step in steps)),
        "cycles": cycles[: len(steps)], "step": solve / len(steps), "run": cpu, "memory": s["peak_memory_bytes"],
        "status": s["status"] if s["status"] == "solved" else s["status"] + f" in step {len(steps)}",
        "passed": s["certificate"]["passed"], "worst": max(step["certificate"]["worst"] for step in steps),
    }


def stop_after(seconds):
    resource.setrlimit(resource.RLIMIT_CPU, (int(seconds), int(seconds) + 5))


def theirs(results):
    # Threads of the linear algebra that wait for work would count as CPU seconds.
    alone = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    command = [sys.executable, os.path.join(HERE, "bonded.py"), os.path.join(results, "problem.npz")]
    done = subprocess.run(command, capture_output=True, text=True, env=alone)
    if done.returncode != 0:
        print(done.stderr.strip().splitlines()[-1], file=sys.stderr)
        return None
    return json.loads(done.stdout)


def calculix(case, folder, limit):
    """What CalculiX takes for the case: CPU seconds, whether it came to the end, and the load step it was in."""
    deck = os.path.join(folder, "deck")
    kept = deck + ".json"
    if os.path.exists(kept):
        with open(kept) as file:
            r = json.load(file)
        if not r["stopped"] or r["limit"] >= limit:
            return r
    subprocess.run([sys.executable, os.path.join(HERE, "calculix.py"), case, deck + ".inp"], check=True)
    with open(deck + ".log", "w") as log:
        done, cpu = timed(
            ["nice", "-n", "19", "ccx", "deck"], cwd=folder, stdout=log, stderr=log,
            env={**os.environ, "OMP_NUM_THREADS": "1"}, preexec_fn=lambda: stop_after(limit),
        )
    with open(deck + ".log") as file:
        text = file.read()
    with open(deck + ".sta") as file:
        steps = [int(l.split()[0]) for l in file if l.strip() and l.split()[0].isdigit()]
    finished = "Job finished" in text and "*ERROR" not in text
    # A signal ends it where its time is over; its own failures end with an exit code.
    r = {"seconds": cpu, "finished": finished, "stopped": done.returncode < 0, "step": max(steps, default=1), "limit": limit}
    with open(kept, "w") as file:
        json.dump(r, file)
    return r


def beside(r, run):
    """The words of the table for what CalculiX took."""
    if r["finished"]:
        return f"{r['seconds'] / run:.0f} times"
    how = "stopped" if r["stopped"] else "failed"
    return f"{how} after {r['seconds'] / run:.0f} times, in step {r['step']}"


def line(name, r):
    if "failed" in r:
        return f"| {name} | {r.get('size', '')} | | | | | | | | | {r['failed']} | | |"
    external, ratio = (f"{r['external']['seconds']:.2f}", f"**{r['ratio']:.2f}**") if r["external"] else ("-", "-")
    verdict = f"{r['worst']:.1e}" + ("" if r["passed"] else " (not passed)")
    return (
        f"| {name} | {r['unknowns']} | {r['points']} | {r['path']} | {', '.join(map(str, r['cycles']))} | {r['step']:.2f} "
        f"| {external} | {ratio} | {r['run']:.1f} | {r['memory'] / 1e9:.2f} | {r['status']} | {verdict} | {r['calculix']} |"
    )


def machine():
    with open("/proc/cpuinfo") as file:
        model = next((l.split(":")[1].strip() for l in file if l.startswith("model name")), platform.processor())
    return f"{model}, one thread, {time.strftime('%Y-%m-%d')}"


def main():
    sys.path.insert(0, SCRIPTS)
    from build import NAMES, build

    parser = argparse.ArgumentParser()
    parser.add_argument("--sizes", default=",".join(SIZES))
    parser.add_argument("--only", default=",".join(NAMES))
    parser.add_argument("--no-calculix", action="store_true")
    parser.add_argument("--calculix-seconds", type=float, default=600)
    parser.add_argument("--limit", type=float, default=3600, help="CPU seconds that one of our runs may take")
    parser.add_argument("--program")
    parser.add_argument("--folder")
    parser.add_argument("--docs", action="store_true")
    arguments = parser.parse_args()
    program = arguments.program or os.path.join(TARGET, "release", "stiction")
    if not arguments.no_calculix and not shutil.which("ccx"):
        sys.exit("CalculiX (ccx) is not installed; --no-calculix leaves it out")
    if not arguments.program:
        subprocess.run(["cargo", "build", "--release", "--quiet", "--bin", "stiction"], cwd=ROOT, check=True)
    keep = arguments.folder or tempfile.mkdtemp()
    print(machine() + "\n\n" + HEAD)
    for name in arguments.only.split(","):
        for size in filter(None, arguments.sizes.split(",")):
            folder = os.path.join(keep, f"{name}-{size}")
            case = os.path.join(folder, f"{name}.toml")
            if not os.path.exists(case):
                # In a process of its own: Gmsh keeps what it has taken.
                subprocess.run([sys.executable, os.path.join(SCRIPTS, "build.py"), name, size, folder], check=True)
            results = os.path.join(folder, "results")
            r = ours(os.path.abspath(program), case, results, arguments.limit)
            r["size"] = size
            if "failed" not in r:
                r["external"] = theirs(results)
                r["ratio"] = r["step"] / r["external"]["seconds"] if r["external"] else None
                r["calculix"] = "-"
                if size == SIZES[0] and not arguments.no_calculix:
                    # The system's count of CPU seconds runs up to a tenth ahead of what is measured.
                    limit = max(24 * r["run"], arguments.calculix_seconds)
                    r["calculix"] = beside(calculix(case, folder, limit), r["run"])
            print(line(name.replace("_", " "), r), flush=True)
            with open(folder + ".json", "w") as file:
                json.dump(r, file)
            if not arguments.folder:
                shutil.rmtree(folder)
    if arguments.docs:
        rows = []
        for name, size in itertools.product(NAMES, SIZES):
            kept = os.path.join(keep, f"{name}-{size}.json")
            if os.path.exists(kept):
                with open(kept) as file:
                    r = json.load(file)
                deck = os.path.join(keep, f"{name}-{size}", "deck.json")
                if os.path.exists(deck):
                    with open(deck) as file:
                        r["calculix"] = beside(json.load(file), r["run"])
                rows.append(line(name.replace("_", " "), r))
        with open(os.path.join(ROOT, "docs", "assemblies.md"), "w") as file:
            file.write(PAGE + machine() + "\n\n" + HEAD + "\n" + "\n".join(rows) + "\n")


if __name__ == "__main__":
    environment()
    main()
