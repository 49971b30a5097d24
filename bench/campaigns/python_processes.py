#!/usr/bin/env python3
"""Forks, spawns and threads in random mixtures, and interrupts at random times, against the installed package of Python.

    python3 bench/campaigns/python_processes.py [--seed S] [--mixtures N] [--interrupts N]

A mixture is right if every solve in it gives the same bits as the parent alone; an interrupt if KeyboardInterrupt comes through, the
problem is solved afterwards, and the delay is told. A hang ends a child by force and counts as wrong.
"""

import argparse
import multiprocessing
import os
import pathlib
import random
import statistics
import subprocess
import sys
import threading
import time
import warnings

TESTS = pathlib.Path(__file__).resolve().parents[2] / "crates" / "stiction-py" / "tests"
sys.path.insert(0, str(TESTS))
PATIENCE = 120.0  # seconds


def force(cells, threads=1):
    from test_processes import problem

    return float(problem(cells).solve(threads=threads).forces.sum())


def mixture(rng, expected):
    """One of four ways, with the sums of all that solved."""
    cells = rng.choice(sorted(expected))
    kind = rng.choice(["fork", "spawn", "threads", "fork amid threads"])
    jobs = [(cells, rng.randint(1, 3)) for _ in range(rng.randint(1, 4))]
    if kind in ("fork", "spawn"):
        with multiprocessing.get_context(kind).Pool(rng.randint(1, 3)) as pool:
            found = pool.starmap_async(force, jobs).get(timeout=PATIENCE)
        return kind, cells, found
    found, stop = [], threading.Event()

    def work():
        while not stop.is_set():
            found.append(force(cells, rng.randint(1, 2)))

    busy = [threading.Thread(target=work, daemon=True) for _ in range(rng.randint(1, 3))]
    [thread.start() for thread in busy]
    if kind == "threads":
        found.extend(force(*job) for job in jobs)
    else:
        for job in jobs:
            child = os.fork()
            if child == 0:
                os._exit(0 if force(*job) == expected[cells] else 1)
            end = time.monotonic() + PATIENCE
            while (state := os.waitpid(child, os.WNOHANG)) == (0, 0) and time.monotonic() < end:
                time.sleep(0.005)
            if state == (0, 0):
                os.kill(child, 9)
                os.waitpid(child, 0)
            found.append(expected[cells] if state != (0, 0) and state[1] == 0 else float("nan"))
    stop.set()
    [thread.join(PATIENCE) for thread in busy]
    return kind, cells, found


INTERRUPTED = """
import os, signal, sys, threading, time
from test_processes import problem
cells, method, delay = int(sys.argv[1]), sys.argv[2], float(sys.argv[3])
large, sent, phases = problem(cells), [], ["none"]

def send():
    sent.append(time.perf_counter())
    os.kill(os.getpid(), signal.SIGINT)

def watch(p):
    phases.append(p.phase)

threading.Timer(delay, send).start()
try:
    while True:
        large.with_friction(0.4).solve(method=method, progress=watch)
except KeyboardInterrupt:
    delay, phase = time.perf_counter() - sent[0], phases[-1]
    assert large.solve(method=method).solved
    print(delay, phase.replace(" ", "-"), flush=True)
"""


def interrupt(rng):
    method, cells = rng.choice([("dense", 16), ("dense", 20), ("solves", 12), ("multigrid", 22)])
    command = [sys.executable, "-c", INTERRUPTED, str(cells), method, f"{rng.uniform(0.0, 1.5):.3f}"]
    ended = subprocess.run(command, env={**os.environ, "PYTHONPATH": str(TESTS)}, capture_output=True, text=True, timeout=2 * PATIENCE)
    if ended.returncode:
        return None, f"{method} {command[-1]}: {ended.stderr.strip().splitlines()[-1:]}"
    delay, phase = ended.stdout.split()
    return float(delay), f"{method} {phase}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--mixtures", type=int, default=100)
    parser.add_argument("--interrupts", type=int, default=100)
    given = parser.parse_args()
    warnings.simplefilter("ignore", DeprecationWarning)  # of forks beside threads, which is what is tried
    rng, wrong = random.Random(given.seed), 0
    expected, counts = {cells: force(cells) for cells in (3, 5, 7)}, {}
    for number in range(given.mixtures):
        kind, cells, found = mixture(rng, expected)
        counts[kind] = counts.get(kind, 0) + len(found)
        if any(one != expected[cells] for one in found):
            wrong += 1
            print(f"mixture {number}, {kind}: {found} in place of {expected[cells]}")
    print(f"{given.mixtures} mixtures, {wrong} wrong; solves: {counts}", flush=True)
    delays, lost = {}, 0
    for number in range(given.interrupts):
        delay, where = interrupt(rng)
        if delay is None:
            lost += 1
            print(f"interrupt {number}: {where}")
        else:
            delays.setdefault(where, []).append(delay)
    for where, list_ in sorted(delays.items()):
        print(f"  {where:24} {len(list_):3}  median {statistics.median(list_):.3f} s  largest {max(list_):.3f} s")
    print(f"{given.interrupts} interrupts, {lost} wrong")
    sys.exit(bool(wrong or lost))


if __name__ == "__main__":
    main()
