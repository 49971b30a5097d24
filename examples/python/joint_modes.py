"""Modes of joints in their contact state: two bars pressed end to end on meshes that do not match, then a bolted lap joint.

What to see: bars that stick swing as one bar of the whole length, by the formulas of beams; lubricated ones bend more easily. The
bolted joint slides around its bolt and swings with what still sticks. What to try next: another preload, `friction`, a pull that
is larger.
"""

from pathlib import Path

import numpy as np
import scipy.sparse.linalg as spl

import stiction

LENGTH, SIDE, YOUNG, DENSITY = 200.0, 10.0, 210e3, 7.85e-9  # mm, mm, MPa, tonnes per mm³


def frequencies(result, count):
    """The lowest ones, Hz."""
    K, free = result.tangent()
    M = free.T @ result.mass() @ free
    squares = spl.eigsh(K, count, M=M, sigma=0.0, return_eigenvectors=False)
    return np.sqrt(np.sort(squares)) / (2 * np.pi)


def bars(friction):
    """Both ends are held, one of them pressed 0.02 mm towards the other; the joint is a third of the way along."""
    block = {"size": [LENGTH / 3, SIDE, SIDE], "cells": [7, 2, 2], "element": "hex20"}
    other = {"size": [2 * LENGTH / 3, SIDE, SIDE], "cells": [12, 3, 2], "element": "hex20"}
    return stiction.Case(
        {
            "units": "mm, N, MPa",
            "mesh": {"parts": {"left": {"block": block}, "right": {"block": other, "move": [LENGTH / 3, 0, 0]}}},
            "materials": {"steel": {"young": YOUNG, "poisson": 0.3, "density": DENSITY}},
            "fix": [{"on": "left.x-min"}, {"on": "right.x-max", "value": [-0.02, 0, 0]}],
            "contact": [{"on": "left.x-max", "against": "right.x-min", "friction": friction}],
        }
    )


speed = np.sqrt(YOUNG / DENSITY)  # of waves along a thin bar
axial = speed / (2 * LENGTH)
bending = 4.730041**2 / (2 * np.pi) * speed * SIDE / np.sqrt(12) / LENGTH**2  # Euler and Bernoulli, both ends clamped
stick = frequencies(bars({"coulomb": 0.3}).solve(matrices=True), 12)
slide = frequencies(bars("none").solve(matrices=True), 20)
print(f"bars that stick: bending {stick[0]:.0f} Hz (thin beam {bending:.0f})")
print(f"bars that slide: bending {slide[0]:.0f} Hz")
assert 0.95 * bending < stick[0] < bending  # shear and rotary inertia, which thin beams do not have, lower it
assert abs(stick[0] / stick[1] - 1) < 0.01  # the same in both directions across a square
assert np.min(np.abs(stick - axial)) < 0.01 * axial and np.min(np.abs(slide - axial)) < 0.01 * axial
assert (slide[:12] <= stick).all() and slide[0] < 0.8 * stick[0]  # what is tied less swings slower (Courant and Fischer)

joint = Path(__file__).parents[2] / "cases" / "joint" / "joint.toml"
result = stiction.Case(joint, overrides={"materials.steel.density": DENSITY}).solve(matrices=True)
K, free = result.tangent()
assert np.isclose(result.mass().sum() / 3, DENSITY * stiction.Case(joint).facts().volume)
squares, shapes = spl.eigsh(K, 3, M=free.T @ result.mass() @ free, sigma=0.0)
print(f"bolted joint, {result.contact}: {np.sqrt(squares[0]) / (2 * np.pi):.0f} Hz")
shape = (free @ shapes[:, 0]).reshape(-1, 3)  # of the nodes result.points, for a picture
assert squares[0] > 0 and len(shape) == len(result.points)  # the bolt leaves no rigid motion to plates and bolt
