"""The linear model about a state of contact: frequencies of bars in closed form, small loads, masses."""

import pickle

import fem
import numpy as np
import pytest
import scipy.linalg
import scipy.sparse as sp
import scipy.sparse.linalg as spl

import stiction

YOUNG, DENSITY, LENGTH, CELLS = 2000.0, 2.5, 2.0, 6
FLOOR = {"plane": {"point": [0, 0, 0], "normal": [0, 0, 1]}}


def bar(friction, down, along=0.0, **changes):
    """A square bar above a floor, without Poisson's effect, whose upper end is held."""
    return stiction.Case(
        {
            "mesh": {"block": {"size": [1, 1, LENGTH], "cells": [2, 2, CELLS], "element": "hex8"}},
            "materials": {"soft": {"young": YOUNG, "poisson": 0.0, "density": DENSITY}},
            "fix": [{"on": "z-max", "value": [along, 0, -down]}],
            "contact": [{"name": "sole", "on": "z-min", "against": FLOOR, "friction": friction}],
            **changes,
        }
    )


def squares(modulus, wave_numbers, cells=CELLS, length=LENGTH):
    """Squared frequencies of linear elements with consistent masses that divide a bar evenly: the wave exp(i k x) has
    w² = 6 c² / h² (1 - cos kh) / (2 + cos kh), c² = modulus / density."""
    h = length / cells
    cosine = np.cos(np.asarray(wave_numbers) * h)
    return 6 * modulus / DENSITY / h**2 * (1 - cosine) / (2 + cosine)


def spectrum(result):
    K, free = result.tangent()
    mass = free.T @ result.mass() @ free
    return scipy.linalg.eigh(K.toarray(), mass.toarray(), eigvals_only=True)


def is_in(values, spectrum):
    return all(np.min(np.abs(spectrum - value)) < 1e-9 * value for value in values)


FIXED = np.pi / LENGTH * np.arange(1, 4)
LOOSE = np.pi / LENGTH * (np.arange(1, 4) - 0.5)


@pytest.mark.parametrize(
    ("friction", "down", "along", "ends"),
    [
        ("none", 5e-3, 0.0, (FIXED, LOOSE)),  # slides: tied along the bar, free across it
        ({"coulomb": 1e-6}, 5e-3, 1e-3, (FIXED, LOOSE)),  # slides with friction
        ({"coulomb": 0.3}, 5e-3, 0.0, (FIXED, FIXED)),  # sticks
        ({"coulomb": 0.3}, -5e-3, 0.0, (LOOSE, LOOSE)),  # is lifted
    ],
)
def test_a_bar_swings_as_its_end_is_held(friction, down, along, ends):
    """Along its axis and in torsion: a square of two by two elements does not warp, so that torsion is a wave of shear."""
    result = bar(friction, down, along).solve(matrices=True)
    found = spectrum(result)
    axial, torsion = squares(YOUNG, ends[0]), squares(YOUNG / 2, ends[1])
    assert is_in(axial, found) and is_in(torsion, found)
    # Those of the other end are not there.
    for modulus, own in ((YOUNG, ends[0]), (YOUNG / 2, ends[1])):
        other = squares(modulus, LOOSE if own is FIXED else FIXED)[0]
        assert np.min(np.abs(found - other)) > 1e-6 * other
    assert found[0] > 0


def test_sparse_iterations_take_what_is_returned():
    result = bar({"coulomb": 0.3}, 5e-3).solve(matrices=True)
    K, free = result.tangent()
    M = free.T @ result.mass() @ free
    found, shapes = spl.eigsh(K, 4, M=M, sigma=0.0)
    assert np.allclose(np.sort(found), spectrum(result)[:4])
    shape = (free @ shapes[:, 0]).reshape(-1, 3)
    assert shape.shape == result.points.shape
    # Prescribed and sticking nodes are at rest.
    ends = np.isin(result.points[:, 2], (0.0, LENGTH))
    assert np.abs(shape[ends]).max() < 1e-12 < np.abs(shape).max()


def test_two_bars_on_meshes_that_do_not_match_swing_as_one():
    parts = {
        "lower": {"block": {"size": [1, 1, 1], "cells": [3, 3, 3], "element": "hex8"}},
        "upper": {"block": {"size": [1, 1, 1], "cells": [2, 2, 3], "element": "hex8"}, "move": [0, 0, 1]},
    }

    def joined(friction, down=5e-3):
        contact = [{"name": "joint", "on": "upper.z-min", "against": "lower.z-max", "friction": friction}]
        fix = [{"on": "lower.z-min"}, {"on": "upper.z-max", "value": [0, 0, -down]}]
        return spectrum(bar(friction, down, mesh={"parts": parts}, fix=fix, contact=contact).solve(matrices=True))

    bonded, sticking, sliding, apart = joined("bonded"), joined({"coulomb": 0.4}), joined("none"), joined("none", -5e-3)
    assert np.allclose(bonded, sticking, rtol=1e-9)
    assert is_in(squares(YOUNG, FIXED), sticking) and is_in(squares(YOUNG, FIXED), sliding)
    # Each bar for itself, of half the length.
    assert is_in(squares(YOUNG, 2 * LOOSE, CELLS // 2, LENGTH / 2), apart)
    # What is tied less swings slower, each frequency of its own (Courant and Fischer).
    for tighter, looser in ((sticking, sliding), (sliding, apart)):
        assert len(tighter) < len(looser) and (tighter >= looser[: len(tighter)] * (1 - 1e-9)).all()
        assert tighter[0] > 1.01 * looser[0]


def test_a_plane_of_symmetry_across_no_axis_is_that_of_an_axis_turned():
    """Nodes on it have axes of their own; motions come out along x, y, z."""
    straight = bar("none", 5e-3, fix=[{"on": "z-max", "value": [0, 0, -5e-3]}, {"on": "x-min", "condition": "symmetry"}])
    straight = straight.solve(matrices=True)
    angle = np.pi / 6
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    [(_, cells)] = straight.cells
    corners = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
    faces = np.concatenate([cells[:, corner] for corner in corners])
    groups = {
        name: faces[np.isclose(straight.points[faces][:, :, axis], at).all(axis=1)]
        for name, axis, at in (("side", 0, 0), ("foot", 2, 0), ("head", 2, LENGTH))
    }
    keys = dict(
        materials={"soft": {"young": YOUNG, "poisson": 0.0, "density": DENSITY}},
        fix=[{"on": "head", "value": [0, 0, -5e-3]}, {"on": "side", "condition": "symmetry"}],
        contact=[{"name": "sole", "on": "foot", "against": FLOOR, "friction": "none"}],
    )
    result = stiction.Case(keys, mesh=(straight.points @ turn.T, cells, groups)).solve(matrices=True)
    assert np.allclose(spectrum(result), spectrum(straight), rtol=1e-9)
    _, free = result.tangent()
    motion = (free @ np.random.default_rng(1).normal(size=free.shape[1])).reshape(-1, 3)
    side = np.unique(groups["side"])
    assert np.abs(motion[side] @ turn[:, 0]).max() < 1e-12 * np.abs(motion).max()
    assert np.abs(motion[side] @ turn[:, 1]).max() > 0.1


def test_masses_are_those_of_the_block():
    result = bar("none", 5e-3).solve(matrices=True)
    M = result.mass()
    whole = DENSITY * LENGTH
    x, y, z = result.points.T
    zero = np.zeros_like(x)
    motions = [np.stack(m, axis=1).ravel() for m in [(1 + zero, zero, zero), (-y, x, zero), (zero, -z, y)]]
    # About the corner in the origin: m (a² + b²) / 3.
    exact = [whole, whole * 2 / 3, whole * (1 + LENGTH**2) / 3]
    assert np.allclose([v @ M @ v for v in motions], exact, rtol=1e-12)
    assert abs(M - M.T).max() == 0.0
    with pytest.raises(stiction.InputError, match="density"):
        bar("none", 5e-3, materials={"soft": {"young": YOUNG, "poisson": 0.0}}).solve(matrices=True).mass()


def test_matrices_are_kept_on_request_and_not_pickled():
    result = bar("none", 5e-3).solve()
    for ask in (result.tangent, result.mass):
        with pytest.raises(stiction.InputError, match="matrices=True"):
            ask()
    points, K, B, gap, top = fem.column((2, 2, 2))
    solution = stiction.Problem(K, B, np.zeros(K.shape[0]), gap, 0.3, held=top).solve()
    with pytest.raises(stiction.InputError, match="pickled"):
        pickle.loads(pickle.dumps(solution)).tangent()


@pytest.mark.parametrize("mu", [0.0, 50.0])
@pytest.mark.parametrize("reordered", [False, True])
def test_small_loads_move_a_joint_as_its_tangent_says(mu, reordered):
    """Without friction, and where all stick, the answer follows the load linearly as long as no state changes."""
    points, K, B, gap, top = fem.column((4, 3, 3), (2.0, 1.0, 1.0), poisson=0.3)
    n = K.shape[0]
    order = np.arange(n).reshape(3, -1).T.ravel() if reordered else np.arange(n)
    inverse = np.argsort(order)
    values = np.tile([0.0, 0.0, -5e-3], len(top) // 3)
    K, B = K[inverse][:, inverse].tocsr(), B[:, inverse].tocsr()
    problem = stiction.Problem(
        K, B, np.zeros(n), gap, mu, held=order[top], values=values, coordinates=points, dofs=order.reshape(-1, 3)
    )
    before = problem.solve(tolerance=1e-10)
    reduced, free = before.tangent()
    assert abs(problem.constraints(before) @ free).max() < 1e-12
    assert reduced.shape == (n - len(top) - problem.constraints(before).shape[0],) * 2
    assert abs(reduced - free.T @ K @ free).max() < 1e-9 * abs(K).max()
    load = np.zeros(n)
    load[order[3 * np.flatnonzero(np.isclose(points[:, 2], 1 / 3))[1]]] = 1e-3
    moved = problem.with_load(load).solve(tolerance=1e-11)
    assert np.array_equal(moved.state, before.state)
    expected = free @ spl.spsolve(reduced.tocsc(), free.T @ load)
    assert np.allclose(moved.u - before.u, expected, atol=1e-6 * np.abs(expected).max())


def test_free_motions_of_curved_surfaces_are_orthogonal_to_their_normals():
    """Rows in all directions, two bodies node by node: every motion that is left keeps the jump of the tied rows zero."""
    rng = np.random.default_rng(3)
    normals = rng.normal(size=(20, 3))
    rows = stiction.rows(np.arange(20), normals, 180, against=np.arange(20, 40))
    K = sp.diags_array(rng.uniform(1, 2, 180)).tocsr()
    f = -(rows.B[0::3].T @ rng.uniform(0.5, 1, 20)) * -1.0
    solution = stiction.Problem(K, rows.B, f, 0.0, np.where(np.arange(20) < 10, 0.0, 5.0)).solve()
    assert {1, 2} <= set(solution.state.tolist())
    K_t, free = solution.tangent()
    tied = np.concatenate([rows.B.toarray().reshape(20, 3, 180)[j][: 3 if s == 1 else 1] for j, s in enumerate(solution.state) if s])
    assert np.abs(tied @ free).max() < 1e-12 and np.linalg.matrix_rank(free.toarray()) == 180 - len(tied) == K_t.shape[0]
