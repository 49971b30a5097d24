"""Discrete problems: closed forms, both forms, FCLib's files, errors."""

import fem
import h5py
import numpy as np
import pytest
import scipy.sparse as sp

import stiction
from stiction import discrete


def test_a_block_sticks_slides_and_lifts_as_the_law_says():
    def block(q, mu=0.5):
        return discrete.solve(W=np.eye(3), q=q, mu=mu)

    sliding = block([-2, 3, 0])
    assert np.allclose(sliding.r, [[2, -1, 0]]) and np.allclose(sliding.u, [[0, 2, 0]])
    assert np.allclose(block([-2, 0.5, 0.5]).u, 0, atol=1e-7)
    assert np.allclose(block([1, 3, 0]).r, 0) and np.allclose(block([1, 3, 0]).u, [[1, 3, 0]])
    plane = discrete.solve(W=np.eye(2), q=[-2, 3], mu=0.5, dimension=2)
    assert np.allclose(plane.r, [[2, -1]]) and plane.r.shape == (1, 2)


def stack(count=4):
    """Unit masses one upon another on a table, moved along with their own velocities: points one below each."""
    rows, columns, values = [], [], []
    for k in range(count):
        for c, axis in enumerate((2, 0, 1)):
            rows += [3 * k + axis]
            columns += [3 * k + c]
            values += [1.0]
            if k:
                rows += [3 * (k - 1) + axis]
                columns += [3 * k + c]
                values += [-1.0]
    H = sp.csr_array((values, (rows, columns)), shape=(3 * count, 3 * count))
    return sp.eye_array(3 * count), H, np.tile([0.3, 0.1, -1.0], count)


def test_both_forms_are_one_problem():
    M, H, f = stack()
    bodies = discrete.solve(M=M, H=H, f=f, mu=0.2)
    W = H.T @ H
    points = discrete.solve(W=W, q=H.T @ f, mu=0.2)
    assert np.allclose(bodies.r, points.r, atol=1e-7)
    # The table carries the momentum of all, each point that of those above it.
    assert np.allclose(bodies.r[:, 0], [4, 3, 2, 1])
    assert np.allclose(bodies.v, H @ bodies.r.ravel() + f) and np.allclose(bodies.u.ravel(), H.T @ bodies.v)
    for method in ("newton", "gauss-seidel", "gradient", "admm"):
        other = discrete.solve(M=M, H=H, f=f, mu=0.2, method=method, tolerance=1e-6)
        assert np.allclose(other.r, bodies.r, atol=1e-4), method
    sparse = discrete.solve(M=M, H=H, f=f, mu=0.2, form="sparse")
    assert np.allclose(sparse.r, bodies.r, atol=1e-7)


def test_elastic_contact_is_a_discrete_problem():
    """M = K, H = -B', w = gap: the same answer by solvers that share little."""
    points, K, B, gap, top = fem.column((3, 2, 2), poisson=0.3)
    values = np.tile([3e-3, 0.0, -5e-3], len(top) // 3)
    elastic = stiction.Problem(K, B, np.zeros(K.shape[0]), gap, 0.3, held=top, values=values).solve()
    free = np.setdiff1d(np.arange(K.shape[0]), top)
    jump = B[:, top] @ values
    offset = -jump
    offset[0::3] += gap
    found = discrete.solve(
        M=K[free][:, free], H=-B[:, free].T, f=-K[free][:, top] @ values, w=offset, mu=0.3, tolerance=1e-10
    )
    assert np.allclose(found.v, elastic.u[free], atol=1e-7 * np.abs(elastic.u).max())
    # Impulses act on the body, forces on the counterpart.
    assert np.allclose(found.r, elastic.forces, atol=1e-6 * elastic.forces.max())


def test_a_start_from_the_last_time_step_saves_iterations():
    M, H, f = stack(8)
    problem = discrete.Problem(M=M, H=H, f=f, mu=0.2)
    cold = problem.solve()
    warm = problem.solve(start=cold)
    assert warm.counts["newton_steps"] < cold.counts["newton_steps"]
    heard = []
    problem.solve(progress=heard.append)
    assert [p.iteration for p in heard] == list(range(len(heard))) and heard[-1].residual < 0.1 * heard[0].residual


def test_impulses_follow_their_contacts():
    r = np.arange(6.0).reshape(2, 3)
    start = discrete.matched(r, ["a-b", "b-c"], ["c-d", "a-b"])
    assert (start == [[0, 0, 0], r[0]]).all()
    assert discrete.matched(np.zeros((0, 3)), np.zeros(0, dtype=int), [3, 1]).shape == (2, 3)
    for names, now, word in (([1], [1], "r has the shape"), ([1, 1], [1], "named twice"), ([1, 2], [1, 1], "named twice")):
        with pytest.raises(stiction.InputError, match=word):
            discrete.matched(r, names, now)


def fclib(path, W, q, mu):
    """A file as the collection's own library lays it out, written by h5py."""
    W = sp.csc_array(W)
    with h5py.File(path, "w") as file:
        group = file.create_group("fclib_local")
        group["spacedim"] = np.array([3], dtype=np.int32)
        matrix = group.create_group("W")
        sizes = {"nzmax": W.nnz, "m": W.shape[0], "n": W.shape[1], "nz": -1}
        for name, value in {**sizes, "p": W.indptr, "i": W.indices}.items():
            matrix[name] = np.atleast_1d(np.asarray(value, dtype=np.int32))
        matrix["x"] = W.data
        group["vectors/q"], group["vectors/mu"] = q, mu
        file["solution/r"] = np.zeros(len(q))


def test_files_of_fclib_are_read(tmp_path):
    M, H, f = stack()
    W, q = H.T @ H, H.T @ f
    fclib(tmp_path / "stack.hdf5", W, q, np.full(4, 0.2))
    problem = discrete.read(tmp_path / "stack.hdf5")
    assert (problem.points, problem.dimension) == (4, 3)
    assert np.allclose(problem.solve().r, discrete.solve(M=M, H=H, f=f, mu=0.2).r, atol=1e-7)
    data = problem.data
    assert (data["W"] != W).nnz == 0 and np.array_equal(data["q"], q) and not data["solution"].any()


def test_files_that_cannot_be_read_are_named(tmp_path):
    for name, content in (("absent.hdf5", None), ("damaged.hdf5", b"no HDF5")):
        if content:
            (tmp_path / name).write_bytes(content)
        with pytest.raises(stiction.InputError) as caught:
            discrete.read(tmp_path / name)
        assert name in caught.value.place and caught.value.remedy


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ({"W": np.eye(3)}, "q: missing"),
        ({"M": np.eye(3), "f": [0, 0, 0]}, "H: missing"),
        ({}, "missing"),
        ({"W": np.eye(3), "q": [0, 0, 0], "M": np.eye(3)}, "both forms"),
        ({"W": np.eye(4), "q": [0, 0, 0]}, "4 columns where 3"),
        ({"W": np.eye(4), "q": [0, 0, 0, 0]}, "no multiple of 3"),
        ({"W": np.eye(3), "q": [0, np.nan, 0]}, r"q\[1\] is NaN"),
        ({"W": np.eye(3), "q": [0, 0, 0], "mu": -1}, r"mu\[0\] is -1"),
        ({"W": np.eye(3), "q": [0, 0, 0], "dimension": 4}, "2 or 3"),
        ({"W": np.eye(3), "q": [0, 0, 0], "method": "best"}, "auto, newton"),
        ({"W": np.eye(3), "q": [0, 0, 0], "form": "best"}, "condensed"),
        ({"W": np.eye(3), "q": [0, 0, 0], "tolerance": 0}, "positive"),
        ({"W": np.eye(3), "q": [0, 0, 0], "start": [1.0]}, "start"),
        ({"M": np.zeros((3, 3)), "H": np.eye(3), "f": [0, 0, 1]}, "singular|regular"),
    ],
)
def test_what_cannot_be_posed_is_named(arguments, text):
    with pytest.raises(stiction.InputError, match=text):
        discrete.solve(**{"mu": 0.5, **arguments})


def test_what_is_not_solved_raises_with_what_was_found():
    # Pressed with a velocity that no impulse can take away.
    with pytest.raises(stiction.NotCertified) as caught:
        discrete.solve(W=np.zeros((3, 3)), q=[-1, 0, 0], mu=0.5, max_iterations=20)
    assert not caught.value.result.solved and "penetration" in caught.value.result.certificate.measures
    short = discrete.solve(W=np.zeros((3, 3)), q=[-1, 0, 0], mu=0.5, max_iterations=20, check=False)
    assert short.status != "solved" and "not passed" in repr(short)
