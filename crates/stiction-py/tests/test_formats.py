"""Arrays in every form that users have: types, strides, byte order, read-only memory, matrices of every format."""

import fem
import numpy as np
import pytest
import scipy.sparse as sp

import stiction
from stiction import discrete

POINTS, K, B, GAP, TOP = fem.column((3, 2, 2), (2.0, 1.0, 1.0), poisson=0.3, lift=1e-3)
N, M = K.shape[0], len(GAP)
VALUES = np.tile([3e-3, 1e-3, -5e-3], len(TOP) // 3)


def given(**changes):
    return {"K": K, "B": B, "f": np.zeros(N), "gap": GAP, "mu": 0.3, "held": TOP, "values": VALUES, "coordinates": POINTS, **changes}


@pytest.fixture(scope="module")
def expected():
    return stiction.Problem(**given()).solve(threads=1)


def strided(array):
    """Every second entry of twice as many, the others not numbers."""
    array = np.asarray(array)
    wide = np.full((2 * array.shape[0], *array.shape[1:]), 99 if array.dtype.kind in "iu" else np.nan, dtype=array.dtype)
    wide[::2] = array
    return wide[::2]


def frozen(array):
    copy = np.array(array)
    copy.flags.writeable = False
    return copy


def swapped(array):
    array = np.asarray(array)
    return array.astype(array.dtype.newbyteorder())


def unaligned(array):
    array = np.asarray(array)
    memory = np.zeros(array.nbytes + 1, dtype=np.uint8)
    view = memory[1:].view(array.dtype).reshape(array.shape)
    view[...] = array
    return view


FORMS = {
    "list": lambda a: np.asarray(a).tolist(),
    "strided": strided,
    "reversed": lambda a: np.asarray(a)[::-1].copy()[::-1],
    "readonly": frozen,
    "fortran": np.asfortranarray,
    "byte order": swapped,
    "unaligned": unaligned,
    "long double": lambda a: np.asarray(a).astype(np.longdouble) if np.asarray(a).dtype.kind == "f" else np.asarray(a).astype(np.int16),
}


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("name", ["f", "gap", "values", "held", "coordinates"])
def test_vectors_in_every_form_give_the_same_bits(expected, name, form):
    load = np.zeros(N)
    changed = given(f=load)
    changed[name] = FORMS[form](changed[name])
    got = stiction.Problem(**changed).solve(threads=1)
    assert np.array_equal(got.u, expected.u) and np.array_equal(got.forces, expected.forces)


def csr_with(index=np.int32, data=np.float64, readonly=False):
    def made(matrix):
        matrix = sp.csr_array(matrix)
        parts = [matrix.data.astype(data), matrix.indices.astype(index), matrix.indptr.astype(index)]
        if readonly:
            for part in parts:
                part.flags.writeable = False
        made = sp.csr_array(matrix.shape)
        made.data, made.indices, made.indptr = parts
        return made

    return made


MATRICES = {
    "csr int32": csr_with(),
    "csr int64": csr_with(np.int64),
    "csr readonly": csr_with(readonly=True),
    "csc": sp.csc_array,
    "csc_matrix": sp.csc_matrix,
    "coo": sp.coo_array,
    "coo_matrix": sp.coo_matrix,
    "lil": sp.lil_array,
    "dok": sp.dok_array,
    "bsr": lambda m: sp.bsr_array(m, blocksize=(3, 3)),
    "dia": sp.dia_array,
    "dense": lambda m: m.toarray(),
    "dense fortran": lambda m: np.asfortranarray(m.toarray()),
    "dense readonly": lambda m: frozen(m.toarray()),
    "dense strided": lambda m: strided(m.toarray()),
    "nested lists": lambda m: m.toarray().tolist(),
    "np.matrix": lambda m: np.matrix(m.toarray()),
    "tuple": lambda m: (m.tocsr().data, m.tocsr().indices, m.tocsr().indptr),
    "tuple uint32": lambda m: (m.tocsr().data, m.tocsr().indices.astype(np.uint32), m.tocsr().indptr.astype(np.uint64)),
    "tuple strided": lambda m: tuple(strided(part) for part in (m.tocsr().data, m.tocsr().indices, m.tocsr().indptr)),
    "explicit zeros": lambda m: with_zeros(m),
    "unsorted": lambda m: unsorted(m),
}


def with_zeros(matrix):
    """Zeros are stored at some places, the same in both triangles."""
    rows = np.arange(0, matrix.shape[0], 3)
    zeros = sp.coo_array((np.zeros(2 * len(rows)), (np.tile(rows, 2), np.concatenate([rows % matrix.shape[1], rows * 0]))), shape=matrix.shape)
    coo = matrix.tocoo()
    parts = [(one.data, one.row, one.col) for one in (coo, zeros)]
    data, row, col = (np.concatenate([part[i] for part in parts]) for i in range(3))
    if matrix.shape[0] == matrix.shape[1]:
        data, row, col = np.concatenate([data, 0 * data]), np.concatenate([row, col]), np.concatenate([col, row])
    return sp.coo_array((data, (row, col)), shape=matrix.shape).tocsr()


def unsorted(matrix):
    matrix = sp.csr_array(matrix, copy=True)
    for i in range(matrix.shape[0]):
        own = slice(matrix.indptr[i], matrix.indptr[i + 1])
        matrix.indices[own], matrix.data[own] = matrix.indices[own][::-1].copy(), matrix.data[own][::-1].copy()
    return sp.csr_array((matrix.data, matrix.indices, matrix.indptr), shape=matrix.shape)


@pytest.mark.parametrize("form", MATRICES)
@pytest.mark.parametrize("name", ["K", "B"])
def test_matrices_in_every_format_give_the_same_answer(expected, name, form):
    matrix = MATRICES[form]({"K": K, "B": B}[name])
    got = stiction.Problem(**given(**{name: matrix})).solve(threads=1)
    assert np.allclose(got.u, expected.u, rtol=0, atol=1e-12 * np.abs(expected.u).max())
    assert np.allclose(got.forces, expected.forces, rtol=0, atol=1e-9 * np.abs(expected.forces).max())


@pytest.mark.parametrize("data", [np.float32, np.int64, np.uint8, bool])
def test_other_types_of_numbers_are_the_same_numbers(data):
    """Whole numbers are the same in all of them."""
    springs = (np.eye(3) * (1 if data is bool else 100)).astype(data)
    rows = np.array([[0, 0, 1], [1, 0, 0], [0, 1, 0]]).astype(data)
    found = stiction.Problem(springs, rows, np.array([1, 0, 1], dtype=data), 0, 0.0).solve()
    exact = stiction.Problem(springs.astype(float), rows.astype(float), [1.0, 0.0, 1.0], 0.0, 0.0).solve()
    assert np.array_equal(found.u, exact.u) and found.u.dtype == np.float64
    assert found.forces[0, 0] == pytest.approx(1.0)


@pytest.mark.parametrize("data", [np.complex128, object, "datetime64[s]", "U3"])
@pytest.mark.parametrize("name", ["K", "B", "f", "gap", "mu", "values", "coordinates"])
def test_what_is_no_real_number_is_refused(name, data):
    changed = given()
    value = changed[name].toarray() if sp.issparse(changed[name]) else np.asarray(changed[name])
    changed[name] = value.astype(data) if data not in ("U3", "datetime64[s]") else np.zeros(value.shape).astype(np.int64).astype(data)
    with pytest.raises(stiction.InputError, match="type|real|array") as caught:
        stiction.Problem(**changed)
    assert caught.value.place == name and caught.value.remedy


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("name", ["K", "B", "f", "gap", "mu", "values", "coordinates"])
def test_what_is_not_finite_is_refused(name, bad):
    changed = given(mu=np.full(M, 0.3))
    value = changed[name].copy()
    (value.data if sp.issparse(value) else value.reshape(-1))[1] = bad
    changed[name] = value
    with pytest.raises(stiction.InputError) as caught:
        stiction.Problem(**changed)
    assert caught.value.remedy and caught.value.what


@pytest.mark.parametrize("form", FORMS)
def test_starts_and_answers_in_every_form(expected, form):
    problem = stiction.Problem(**given())
    made = FORMS[form]
    assert problem.check(made(expected.u), made(expected.forces)).passed
    warm = problem.solve(start=made(expected.forces), method="dense")
    assert np.allclose(warm.forces, expected.forces, atol=1e-6 * expected.forces.max())
    again = problem.with_load(made(np.zeros(N)), gap=made(GAP), slip_reference=made(np.zeros((M, 2)))).solve(threads=1)
    assert np.array_equal(again.u, expected.u)


@pytest.mark.parametrize("form", MATRICES)
def test_discrete_matrices_in_every_format(form):
    rng = np.random.default_rng(6)
    root = rng.normal(size=(6, 6))
    W = sp.csr_array(root @ root.T + np.eye(6))
    q = rng.normal(size=6)
    expected = discrete.solve(W=W, q=q, mu=0.4, tolerance=1e-11)
    got = discrete.solve(W=MATRICES[form](W), q=q, mu=0.4, tolerance=1e-11)
    assert np.allclose(got.r, expected.r, atol=1e-9)


@pytest.mark.parametrize("mask", [True, False])
def test_held_as_mask_and_as_numbers_are_one(expected, mask):
    chosen = np.isin(np.arange(N), TOP)
    values = np.zeros(N)
    values[TOP] = VALUES
    held = chosen if mask else np.flatnonzero(chosen).astype(np.uint16)
    got = stiction.Problem(**given(held=held, values=values[chosen])).solve(threads=1)
    assert np.array_equal(got.u, expected.u)


@pytest.mark.parametrize("name", ["u", "forces", "slip", "gap", "state", "jump", "reactions", "history"])
def test_results_are_arrays_of_their_own(expected, name):
    array = getattr(expected, name)
    assert array.flags.c_contiguous and array.flags.writeable and np.isfinite(array).all()
    shape = {"u": (N,), "forces": (M, 3), "slip": (M, 2), "gap": (M,), "state": (M,), "jump": (M, 2), "reactions": (len(TOP),)}
    assert name == "history" or array.shape == shape[name]
    assert array.dtype == (np.uint8 if name == "state" else np.float64)


@pytest.mark.parametrize("cells", [np.int32, np.uint64, "strided", "fortran", "unaligned", "byte order", "list"])
def test_meshes_in_every_form(cells):
    from test_case import FLOOR, arrays, described

    points, hexes, bottom, _ = arrays()
    if isinstance(cells, str):
        points, hexes, bottom = FORMS[cells](points), FORMS[cells](hexes), FORMS[cells](bottom)
        hexes = {"hex8": hexes}
    else:
        points, hexes, bottom = points.astype(np.float64)[::-1][::-1], hexes.astype(cells), bottom.astype(cells)
    keys = {key: value for key, value in described().items() if key != "mesh"}
    keys["contact"] = [{"name": "sole", "on": "foot", "against": FLOOR, "friction": {"coulomb": 0.3}}]
    keys["fix"] = [{"on": {"box": [[0, 0, 1], [2, 1, 1]]}, "value": [0, 0, -5e-3]}]
    result = stiction.Case(keys, mesh=(points, hexes, {"foot": bottom})).solve()
    assert np.allclose(result.contact["sole"].pressure, 10.0)
