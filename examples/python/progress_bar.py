"""A progress bar of tqdm over the load steps of a case.

What to see: `progress=` is called at each phase and iteration, the bar advances with each load step and shows the iteration
between; where the output is no terminal there is no bar. What to try next: `tqdm.notebook`; return False to stop.
"""

import io
import sys

import stiction

try:
    from tqdm import tqdm
except ImportError:
    print("not run: tqdm is not there")
    raise SystemExit(0) from None

STEPS = 6
case = stiction.Case(
    {
        "mesh": {"block": {"size": [2, 1, 1], "cells": [10, 5, 5], "element": "hex8"}},
        "materials": {"soft": {"young": 2000, "poisson": 0.3}},
        "fix": [{"on": "z-max", "value": ["4e-3*t", 0, -5e-3]}],
        "contact": [{"on": "z-min", "against": {"plane": {"point": [0, 0, 0], "normal": [0, 0, 1]}}, "friction": {"coulomb": 0.3}}],
        "step": [{"name": "drag", "until": 1, "increments": STEPS}],
    }
)


def solved(case, steps, **bar):
    """The result, with a bar as tqdm's keywords say."""
    with tqdm(total=steps, unit="step", **bar) as shown:

        def watch(p):
            if p.phase == "step finished":
                shown.update()
            elif p.iteration:
                shown.set_postfix(phase=p.phase, iteration=p.iteration, residual=f"{p.residual:.1e}", refresh=False)

        return case.solve(progress=watch), shown.n


result, finished = solved(case, STEPS, disable=None, file=sys.stderr)  # None: on terminals only
seen = io.StringIO()
_, finished = solved(case, STEPS, file=seen, mininterval=0, ncols=80)
print(result)
print(seen.getvalue().split("\r")[-1].split("[")[0].strip())
assert finished == STEPS == len(result.steps) and f"{STEPS}/{STEPS}" in seen.getvalue() and "residual=" in seen.getvalue()
