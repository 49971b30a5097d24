"""Whether the judge sees altered answers: `altered.py PROGRAM FIRST LAST`. Of every answer called solved one thing is changed at
a time; what the judge accepts has to be proven to be no change of the problem or of the answer."""

import pathlib
import subprocess
import sys
import tempfile

import numpy as np

from judge import ANSWER, BONDED, LIMITED, NONE, POSED, Judge, csr


def rounding(problem, solution):
    """What the rounding of K u leaves of forces."""
    lower, u = csr(problem, "K_lower", len(solution["u"])), np.abs(solution["u"])
    internal = abs(lower) @ u + abs(lower).T @ u - np.abs(lower.diagonal()) * u
    return 30e-15 * np.linalg.norm(internal)


def reversed_friction(problem, solution):
    m = len(solution["lambda"]) // 3
    largest = np.abs(solution["lambda"][m:]).max(initial=0)
    solution["lambda"][m:] *= -1
    return "no friction force but rounding" if largest <= rounding(problem, solution) else None


def bounds(problem, solution):
    problem["friction_value"] = problem["friction_value"] * (1 + 1e-4)
    bounded = ~np.isin(problem["friction_law"], [NONE, BONDED]) & (problem["friction_value"] != 0)
    return None if bounded.any() else "no law with a bound"


def limits(problem, solution):
    problem["friction_limit"] = problem["friction_limit"] * (1 + 1e-4)
    return None if np.any(problem["friction_law"] == LIMITED) else "no law with a limit"


def largest_force(problem, solution):
    at = np.argmax(np.abs(solution["lambda"])) if len(solution["lambda"]) else None
    if at is None or solution["lambda"][at] == 0:
        return "no force"
    solution["lambda"][at] *= 1 + 1e-4
    return "no force but rounding" if abs(solution["lambda"][at]) <= rounding(problem, solution) else None


def displacement(problem, solution):
    solution["u"] = solution["u"] * (1 + 1e-5)
    return "no displacement" if not np.any(solution["u"]) else None


def gaps(problem, solution):
    problem["gap"] = problem["gap"] + 1e-7
    return None if len(problem["gap"]) else "no contact"


ALTERATIONS = [reversed_friction, bounds, limits, largest_force, displacement, gaps]


def refusal(text, history, problem, solution, t):
    """Names of what the judge refuses; `history` are the steps before."""
    judge = Judge(text)
    judge.slid = history
    errors, posed = judge.posed(problem, t)
    measured = judge.measures(problem, solution, posed) if posed else {"unknowns": 1.0}
    return [k for k, v in errors.items() if v > POSED] + [k for k, v in measured.items() if v > ANSWER], judge.slid


def main():
    program, first, last = sys.argv[1:4]
    counts = {alter.__name__: {} for alter in ALTERATIONS}
    blind = 0
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        lines = subprocess.run([program, str(folder), first, last], capture_output=True, text=True, check=True).stdout
        slid, past, seed = None, 0.0, None
        for line in lines.splitlines():
            kind, name, rest = line.split(" ", 2)
            if kind != "answer":
                continue
            t, status = rest.split(" ")
            if name.split("-")[0] != seed or float(t) <= past:
                slid = None
            seed, past = name.split("-")[0], float(t)
            text = (folder / f"{seed}.toml").read_text()
            load = lambda kind: dict(np.load(folder / f"{name}-{kind}.npz"))
            before, (refused, slid) = slid, refusal(text, slid, load("problem"), load("solution"), float(t))
            if status != "Solved" or refused:
                continue
            for alter in ALTERATIONS:
                problem, solution = load("problem"), load("solution")
                nothing = alter(problem, solution)
                seen = refusal(text, before, problem, solution, float(t))[0]
                what = "refused" if seen else f"accepted: {nothing}" if nothing else "BLIND"
                counts[alter.__name__][what] = counts[alter.__name__].get(what, 0) + 1
                if what == "BLIND":
                    blind += 1
                    print(f"BLIND to {alter.__name__} in {name}, t = {t}")
    for name, found in counts.items():
        print(f"{name}:", ", ".join(f"{number} {what}" for what, number in sorted(found.items())))
    sys.exit(0 if blind == 0 and all(found.get("refused") for found in counts.values()) else 1)


if __name__ == "__main__":
    main()
