"""The command that comes with the package, and what else the wheel brings."""

import json
import os
import signal
import subprocess
import sys
from importlib import metadata

import pytest
from test_case import described

import stiction
from stiction._case import toml


def command(*arguments, **more):
    return subprocess.run([sys.executable, "-m", "stiction", *map(str, arguments)], capture_output=True, text=True, timeout=240, **more)


def test_it_is_the_program_of_this_version():
    said = command("--version")
    assert said.returncode == 0 and said.stdout.startswith(f"stiction {stiction.__version__}") and "fclib, plots, report" in said.stdout
    [entry] = metadata.entry_points(group="console_scripts", name="stiction")
    assert entry.value == "stiction.__main__:main"


def test_it_solves_as_the_case_does(tmp_path):
    (tmp_path / "block.toml").write_text(toml(described()))
    done = command("solve", "block.toml", "-o", "out", "--progress", "none", cwd=tmp_path)
    assert done.returncode == 0 and "certificate  passed" in done.stdout, done.stderr
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    ours = stiction.Case(described()).solve().summary
    assert summary["certificate"] == ours["certificate"] and summary["contact"] == ours["contact"]
    assert "stiction solve block.toml -o out --progress none" in (tmp_path / "out" / "summary.json").read_text()
    assert command("check", tmp_path / "out").returncode == 0


@pytest.mark.parametrize(
    ("arguments", "code", "text"),
    [
        (["solve", "absent.toml"], 2, "absent.toml"),
        (["solv"], 2, "solve"),
        (["new", "--list"], 0, "press-fit"),
        (["schema"], 0, "$schema"),
        (["check", "."], 2, "problem.npz"),
    ],
)
def test_its_exit_codes_come_through(arguments, code, text, tmp_path):
    done = command(*arguments, cwd=tmp_path)
    assert done.returncode == code and text in done.stdout + done.stderr


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_an_interrupt_ends_it_with_its_own_code(tmp_path):
    big = described(mesh={"block": {"size": [1, 1, 1], "cells": [24, 24, 24], "element": "hex8"}})
    (tmp_path / "big.toml").write_text(toml(big))
    # It says when it iterates; more digits than there are keep it at that.
    exact = ["--set", "solver.path=solves", "--set", "solver.tolerance=1e-12", "--progress", "plain"]
    arguments = [sys.executable, "-m", "stiction", "solve", "big.toml", "-o", "out", *exact]
    with subprocess.Popen(arguments, cwd=tmp_path, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as started:
        said = next(line for line in started.stderr if "newton  " in line)
        started.send_signal(signal.SIGINT)
        rest = started.stderr.read()
        assert started.wait(timeout=60) == 130, said + rest
    assert "interrupted" in rest and "Traceback" not in rest, rest


def test_the_licences_are_in_the_package():
    package = metadata.distribution("stiction")
    assert package.metadata["License-Expression"] == "MIT OR Apache-2.0"
    for name, text in (
        ("LICENSE-MIT", "Permission is hereby granted"),
        ("LICENSE-APACHE", "Apache License"),
        ("THIRD-PARTY-LICENSES.txt", "METIS"),
    ):
        assert text in package.read_text(f"licenses/{name}"), name
