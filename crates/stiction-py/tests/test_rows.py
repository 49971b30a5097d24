"""Rows at nodes: known axes, obstacles in any direction, bodies node by node."""

import fem
import numpy as np
import pytest
import scipy.sparse as sp

import stiction


def test_axes_are_orthonormal_and_right_handed():
    normals = np.random.default_rng(2).normal(size=(50, 3))
    B, unit, tangents = stiction.rows(np.arange(50), normals, 150)
    frames = np.concatenate([unit[:, None], tangents], axis=1)
    assert np.allclose(frames @ frames.transpose(0, 2, 1), np.eye(3)) and np.allclose(np.linalg.det(frames), 1)
    u = np.random.default_rng(3).normal(size=(50, 3))
    assert np.allclose((B @ u.ravel()).reshape(-1, 3), np.einsum("kij,kj->ki", frames, u))


def test_a_floor_may_lie_in_any_direction():
    """The same problem seen from rotated axes has the same forces."""
    points, K, B, gap, top = fem.column((3, 2, 2), poisson=0.3)
    foot = np.flatnonzero(points[:, 2] == 0)
    n, values = K.shape[0], np.tile([3e-3, 0.0, -5e-3], len(top) // 3)
    plain = stiction.Problem(K, B, np.zeros(n), gap, 0.3, held=top, values=values).solve()
    turn, _ = np.linalg.qr(np.random.default_rng(4).normal(size=(3, 3)))
    whole = sp.block_diag([turn] * len(points), format="csr")
    rotated = (whole @ K @ whole.T).tocsr()
    rotated = 0.5 * (rotated + rotated.T)
    made = stiction.rows(foot, turn @ [0, 0, -1.0], n)
    values = (values.reshape(-1, 3) @ turn.T).ravel()
    seen = stiction.Problem(rotated, made.B, np.zeros(n), gap, 0.3, held=top, values=values).solve()
    assert np.allclose(seen.forces[:, 0], plain.forces[:, 0], atol=1e-6 * plain.forces.max())
    sizes = [np.hypot(*solution.forces[:, 1:].T) for solution in (seen, plain)]
    assert np.allclose(*sizes, atol=1e-6 * plain.forces.max())


def test_two_columns_node_upon_node_press_as_springs_in_a_row():
    points, K = fem.block((2, 2, 2), (1, 1, 1), 2000.0)
    nodes, n = len(points), 2 * K.shape[0]
    both = sp.block_diag([K, K], format="csr")
    low, high = np.flatnonzero(points[:, 2] == 1), nodes + np.flatnonzero(points[:, 2] == 0)
    bottom, top = np.flatnonzero(points[:, 2] == 0), nodes + np.flatnonzero(points[:, 2] == 1)
    made = stiction.rows(high, [0, 0, -1], n, against=low)
    held = np.concatenate([3 * of[:, None] + np.arange(3) for of in (bottom, top)]).ravel()
    values = np.zeros((len(held) // 3, 3))
    values[len(bottom) :, 2] = -4e-3
    solution = stiction.Problem(both, made.B, np.zeros(n), 0.0, 0.3, held=held, values=values.ravel()).solve()
    assert solution.forces[:, 0].sum() == pytest.approx(2000 * 4e-3 / 2, rel=1e-9)


def test_gaps_and_normals_of_round_obstacles_are_the_distance_and_its_gradient():
    points = np.random.default_rng(5).normal(size=(40, 3))
    obstacles = [stiction.Plane([0.1, 0, -2], [1, 2, 3])]
    for inside in (False, True):
        obstacles.append(stiction.Sphere([0.2, -0.1, 3], 1.5, inside=inside))
        obstacles.append(stiction.Cylinder([4, 0, 0.5], [1, -1, 2], 0.7, inside=inside))
    for obstacle in obstacles:
        gap, normals = obstacle.meet(points)
        assert np.allclose(np.linalg.norm(normals, axis=1), 1)
        # Along the normal the gap closes by the way gone: onto the surface.
        assert np.allclose(obstacle.meet(points + gap[:, None] * normals).gap, 0, atol=1e-12)
        for c, way in enumerate(1e-6 * np.eye(3)):
            slope = (obstacle.meet(points + way).gap - obstacle.meet(points - way).gap) / 2e-6
            assert np.allclose(slope, -normals[:, c], atol=1e-8)


def test_a_block_in_a_bore_presses_as_case_files_say():
    """A block in a hollow cylinder, pressed down: the same answer as the obstacle of a case file."""
    bore = {"cylinder": {"point": [0.5, 0, 2.0], "axis": [0, 1, 0], "radius": 2.2, "side": "inside"}}
    case = stiction.Case({
        "mesh": {"block": {"size": [1, 1, 1], "cells": [3, 3, 3], "element": "hex8"}},
        "materials": {"steel": {"young": 1000.0, "poisson": 0.3}},
        "fix": [{"on": "z-max", "value": [0, 0, -0.3]}],
        "contact": [{"on": "z-min", "against": bore, "friction": {"coulomb": 0.3}}],
    })  # fmt: skip
    result = case.solve()
    points, K = fem.block((3, 3, 3), (1, 1, 1), 1000.0, 0.3)
    foot = np.flatnonzero(points[:, 2] == 0)
    gap, normals = stiction.Cylinder([0.5, 0, 2.0], [0, 1, 0], 2.2, inside=True).meet(points[foot])
    made = stiction.rows(foot, normals, K.shape[0])
    top = (3 * np.flatnonzero(points[:, 2] == 1)[:, None] + np.arange(3)).ravel()
    values = np.tile([0, 0, -0.3], len(top) // 3)
    solution = stiction.Problem(K, made.B, np.zeros(K.shape[0]), gap, 0.3, held=top, values=values).solve()
    u = solution.u.reshape(-1, 3)
    ours, theirs = (np.lexsort(at.round(9).T) for at in (points, result.points))
    assert np.allclose(points[ours], result.points[theirs]) and (solution.forces[:, 0] > 0).any()
    assert np.allclose(u[ours], result.displacement[theirs], atol=1e-6 * 0.3)


def test_obstacles_that_make_no_sense_are_refused():
    for make, word in (
        (lambda: stiction.Plane([0, 0, 0], [0, 0, 0]), "normal"),
        (lambda: stiction.Sphere([0, 0], 1.0), "center"),
        (lambda: stiction.Cylinder([0, 0, 0], [0, 0, 1], -1.0), "radius"),
        (lambda: stiction.Sphere([0, 0, 0], 1.0).meet([[0, 0, 0]]), "centre"),
        (lambda: stiction.Plane([0, 0, 0], [0, 0, 1]).meet([[0, 0, np.nan]]), "finite"),
    ):
        with pytest.raises(stiction.InputError, match=word):
            make()


def test_other_numberings_of_unknowns():
    dofs = np.arange(12).reshape(3, 4).T
    made = stiction.rows([2], [0, 0, 2.0], 12, dofs=dofs)
    assert made.B.toarray()[0].nonzero()[0].tolist() == [dofs[2, 2]]


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        (([4], [0, 0, 1], 12), "nodes: there is no node 4 among 4"),
        (([0], [0, 0, 0], 12), "length 0"),
        (([0], [0, 0, np.nan], 12), "length nan"),
        (([0, 1], [[0, 0, 1]], 12), r"\(2, 3\)"),
    ],
)
def test_what_cannot_be_used_is_named(arguments, text):
    with pytest.raises(stiction.InputError, match=text):
        stiction.rows(*arguments)
    with pytest.raises(stiction.InputError, match="against"):
        stiction.rows([0], [0, 0, 1], 12, against=[1, 2])
    with pytest.raises(stiction.InputError, match="node 1 is against itself"):
        stiction.rows([0, 1], [0, 0, 1], 12, against=[2, 1])
    with pytest.raises(stiction.InputError, match="12 unknowns"):
        stiction.rows([0], [0, 0, 1], 12, dofs=[[10, 11, 12]])
