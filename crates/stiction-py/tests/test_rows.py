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
    with pytest.raises(stiction.InputError, match="12 unknowns"):
        stiction.rows([0], [0, 0, 1], 12, dofs=[[10, 11, 12]])
