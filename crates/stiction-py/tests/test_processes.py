"""Signals, forks, threads: nothing hangs, nothing is lost."""

import multiprocessing
import os
import subprocess
import sys
import textwrap
import threading
from concurrent.futures import ThreadPoolExecutor

import fem
import numpy as np
import pytest

import stiction

HERE = os.path.dirname(__file__)


def problem(cells=5):
    points, K, B, gap, top = fem.column((cells, cells, cells), poisson=0.3)
    values = np.tile([2e-3, 0.0, -5e-3], len(top) // 3)
    return stiction.Problem(K, B, np.zeros(K.shape[0]), gap, 0.4, held=top, values=values, coordinates=points)


def run(program, *arguments, seconds=240):
    """A program of its own, in which a hang is an end by force."""
    environment = {**os.environ, "PYTHONPATH": HERE}
    command = [sys.executable, "-c", textwrap.dedent(program), *arguments]
    return subprocess.run(command, env=environment, capture_output=True, text=True, timeout=seconds)


INTERRUPTED = """
import os, signal, sys, threading, time
import numpy as np
from test_processes import problem

# What a shell runs in the background ignores interrupts, and so do its children.
signal.signal(signal.SIGINT, signal.default_int_handler)
phase, method, cells = sys.argv[1], sys.argv[2], int(sys.argv[3])
large = problem(cells)
sent = []

def send():
    sent.append(time.perf_counter())
    os.kill(os.getpid(), signal.SIGINT)

def watch(progress):
    if progress.phase == phase and not sent:
        sent.append(None)
        threading.Timer(0.05, send).start()

try:
    while True:
        large.with_friction(0.4).solve(method=method, progress=watch)
except KeyboardInterrupt:
    print(time.perf_counter() - sent[-1])
    # The problem is as good as before.
    assert large.points == (cells + 1) ** 2
    sys.stdout.flush()
    raise
"""


@pytest.mark.parametrize(
    ("phase", "method", "cells"),
    [
        ("ordering", "dense", 24),
        ("factorisation", "dense", 24),
        ("newton", "solves", 16),
        ("set-up", "multigrid", 30),
        ("multigrid", "multigrid", 30),
    ],
)
def test_an_interrupt_ends_every_phase(phase, method, cells):
    ended = run(INTERRUPTED, phase, method, str(cells))
    assert ended.stderr.rstrip().endswith("KeyboardInterrupt"), ended.stderr
    assert ended.returncode != 0
    # Meant is a fifth of a second; other work on the machine may delay it.
    assert float(ended.stdout) < 3.0, ended.stdout


def test_a_problem_that_was_interrupted_is_solved_afterwards():
    ended = run(
        """
        import os, signal, threading
        from test_processes import problem
        large = problem(20)
        threading.Timer(0.1, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
        try:
            while True:
                large.with_friction(0.1).solve()
        except KeyboardInterrupt:
            print(large.solve().status)
        """
    )
    assert (ended.stdout, ended.returncode) == ("solved\n", 0), ended.stderr


def solve_here(cells):
    return float(problem(cells).solve(threads=2).forces.sum())


def test_a_forked_child_solves_after_its_parent_did():
    expected = solve_here(5)
    # Large enough that its checks are shared among threads, which a child does not have.
    large = problem(16)
    if "fork" not in multiprocessing.get_all_start_methods():
        pytest.skip("no fork on this system")
    with multiprocessing.get_context("fork").Pool(3) as pool:
        assert pool.map_async(solve_here, 12 * [5]).get(timeout=120) == 12 * [expected]
        [points] = pool.map_async(points_here, [16]).get(timeout=120)
        assert points == large.points
    assert solve_here(5) == expected


def points_here(cells):
    return problem(cells).with_friction(0.1).with_load(gap=0.0).points


def test_an_interrupt_ends_the_reading_of_matrices():
    ended = run(
        """
        import os, signal, threading, time
        import numpy as np
        import fem, stiction
        points, K, B, gap, top = fem.column((30, 30, 30), poisson=0.3)
        sent = []
        def send():
            sent.append(time.perf_counter())
            os.kill(os.getpid(), signal.SIGINT)
        threading.Timer(0.03, send).start()
        try:
            while True:
                stiction.Problem(K, B, np.zeros(K.shape[0]), gap, 0.3, held=top, coordinates=points)
        except KeyboardInterrupt:
            print(time.perf_counter() - sent[0])
        """
    )
    assert float(ended.stdout) < 3.0, ended.stderr


def test_a_spawned_child_solves():
    with multiprocessing.get_context("spawn").Pool(2) as pool:
        assert pool.map_async(solve_here, 2 * [4]).get(timeout=120) == 2 * [solve_here(4)]


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork on this system")
def test_forks_amid_solves_of_other_threads():
    """A child of a process whose other threads are solving solves the same problem object."""
    ended = run(
        """
        import os, threading, warnings
        from test_processes import problem
        warnings.simplefilter("ignore")
        shared, stop = problem(6), threading.Event()
        expected = shared.solve().forces.sum()

        def busy():
            while not stop.is_set():
                shared.solve()

        threads = [threading.Thread(target=busy) for _ in range(3)]
        [thread.start() for thread in threads]
        good = 0
        for _ in range(20):
            child = os.fork()
            if child == 0:
                os._exit(0 if shared.solve(threads=2).forces.sum() == expected else 1)
            good += os.waitpid(child, 0)[1] == 0
        stop.set()
        [thread.join() for thread in threads]
        print(good)
        """
    )
    assert ended.stdout == "20\n", ended.stderr


def test_threads_solve_one_problem_at_the_same_time():
    shared = problem()
    expected = shared.solve().forces
    coefficients = np.tile([0.1, 0.4, 0.7], 8)
    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(lambda mu: shared.with_friction(mu).solve(), coefficients))
    for mu, solution in zip(coefficients, found, strict=True):
        assert solution.solved
        if mu == 0.4:
            assert np.allclose(solution.forces, expected, atol=1e-9 * expected.max())


def test_other_threads_run_while_a_solve_does():
    ticks, done = [], threading.Event()

    def tick():
        while not done.wait(0.005):
            ticks.append(1)

    thread = threading.Thread(target=tick)
    thread.start()
    solution = problem(14).solve(method="dense")
    done.set()
    thread.join()
    # With the interpreter held there would be none, or one.
    assert len(ticks) > 20 * min(solution.seconds, 1.0)
