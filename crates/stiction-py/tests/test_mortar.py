"""Two surfaces whose meshes do not match: patch tests, the same meshes as a case, faces and numberings of all kinds, errors."""

import numpy as np
import pytest
import scipy.sparse as sp
import skfem
from skfem.models.elasticity import lame_parameters, linear_elasticity

import stiction

YOUNG, POISSON, DOWN = 2000.0, 0.3, 4e-3


def axes(*lengths_and_counts):
    return [np.linspace(0.0, length, count + 1) for length, count in lengths_and_counts]


class Blocks:
    """A block of hexahedra or tetrahedra upon another, assembled by scikit-fem: the upper one is the slave."""

    def __init__(self, kind=skfem.MeshHex, lower=(3, 3, 2), upper=(4, 5, 2), gap=0.0, size=(1.0, 1.0)):
        low = kind.init_tensor(*axes((1, lower[0]), (1, lower[1]), (1, lower[2])))
        high = kind.init_tensor(*axes((size[0], upper[0]), (size[1], upper[1]), (1, upper[2]))).translated((0, 0, 1 + gap))
        element = {skfem.MeshHex: skfem.ElementHex1, skfem.MeshTet: skfem.ElementTetP1}[kind]
        self.bases = [skfem.Basis(mesh, skfem.ElementVector(element())) for mesh in (low, high)]
        law = linear_elasticity(*lame_parameters(YOUNG, POISSON))
        self.K = sp.block_diag([law.assemble(basis) for basis in self.bases], format="csr")
        self.points = np.concatenate([low.p.T, high.p.T])
        self.dofs = np.concatenate([self.bases[0].nodal_dofs.T, self.bases[0].N + self.bases[1].nodal_dofs.T])
        of_hexes = [0, 3, 6, 2, 1, 5, 7, 4]  # scikit-fem's order of corners in VTK's
        order = of_hexes if kind is skfem.MeshHex else [0, 1, 2, 3]
        cells = [mesh.t[order].T for mesh in (low, high)]
        self.cells = np.concatenate([turned(self.points, cells[0]), turned(self.points, cells[1] + low.p.shape[1])])
        at = low.facets_satisfying(lambda x: np.isclose(x[2], 1.0))
        self.master = low.facets[:, at].T
        at = high.facets_satisfying(lambda x: np.isclose(x[2], 1.0 + gap))
        self.slave = high.facets[:, at].T + low.p.shape[1]
        x, y, z = self.points.T
        self.top = np.isclose(z, 2.0 + gap)
        self.held = np.unique(np.concatenate([self.dofs[z == 0, 2], self.dofs[self.top, 2], self.dofs[x == 0, 0], self.dofs[y == 0, 1]]))
        self.values = np.where(np.isin(self.held, self.dofs[self.top, 2]), -DOWN, 0.0)

    def rows(self, **changes):
        given = dict(cells=self.cells, dofs=self.dofs, held=self.held)
        return stiction.mortar(self.points, self.slave, self.master, **(given | changes))

    def solve(self, rows, mu=0.0):
        n = self.K.shape[0]
        return stiction.Problem(
            self.K, rows.B, np.zeros(n), rows.gap, mu, held=self.held, values=self.values, coordinates=self.points, dofs=self.dofs
        ).solve(tolerance=1e-12, method="dense")


def turned(points, cells):
    """Tetrahedra with positive volume."""
    if cells.shape[1] == 8:
        return cells
    a, b, c, d = np.moveaxis(points[cells % len(points)], 1, 0)
    inverted = np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) < 0
    cells[inverted] = cells[inverted][:, [0, 2, 1, 3]]
    return cells


@pytest.mark.parametrize("kind", [skfem.MeshHex, skfem.MeshTet])
@pytest.mark.parametrize("mu", [0.0, 0.3])
def test_a_uniform_pressure_passes_through_meshes_that_do_not_match(kind, mu):
    blocks = Blocks(kind)
    rows = blocks.rows()
    assert rows.area.sum() == pytest.approx(1.0, rel=1e-12) and np.abs(rows.gap).max() < 1e-14
    solution = blocks.solve(rows, mu)
    pressure = YOUNG * DOWN / 2  # strain over both, of length two
    assert np.allclose(solution.forces[:, 0] / rows.area, pressure, rtol=1e-10)
    # Both expand alike: u is linear, and nothing slips.
    exact = blocks.points * [POISSON * DOWN / 2, POISSON * DOWN / 2, -DOWN / 2]
    assert np.allclose(solution.u[blocks.dofs], exact, atol=1e-10 * DOWN)
    assert np.abs(solution.forces[:, 1:]).max() < 1e-8 * solution.forces[:, 0].max()


@pytest.mark.parametrize(("mu", "drag"), [(0.0, 0.0), (0.3, 1e-4), (0.3, 4e-3)])
def test_it_is_what_a_case_takes(mu, drag):
    """The same meshes and materials assembled by the library, the upper body smaller than the lower one and dragged."""
    blocks = Blocks(upper=(3, 4, 2), size=(0.7, 0.8))
    blocks.held = np.unique(np.concatenate([blocks.dofs[blocks.points[:, 2] == 0].ravel(), blocks.dofs[blocks.top].ravel()]))
    push = np.zeros(blocks.K.shape[0])
    push[blocks.dofs[blocks.top]] = [drag, 0, -DOWN]
    blocks.values = push[blocks.held]
    made = blocks.rows()
    ours = blocks.solve(made, mu)
    groups = {"slave": blocks.slave, "master": blocks.master, "top": np.flatnonzero(blocks.top)}
    groups["bottom"] = np.flatnonzero(blocks.points[:, 2] == 0)
    friction = {"coulomb": mu} if mu else "none"
    case = {
        "materials": {"soft": {"young": YOUNG, "poisson": POISSON}},
        "fix": [{"on": "bottom"}, {"on": "top", "value": [drag, 0, -DOWN]}],
        "contact": [{"name": "joint", "on": "slave", "against": "master", "slave": "on", "friction": friction}],
    }
    result = stiction.Case(case, mesh=(blocks.points, {"hex8": blocks.cells}, groups)).solve()
    scale = np.abs(result.displacement).max()
    assert np.allclose(ours.u[blocks.dofs], result.displacement, atol=1e-7 * scale)
    joint = result.contact["joint"]
    total = (made.unity_sum[:, None] * np.einsum("ki,kic->kc", ours.forces, np.stack([made.normals, *made.tangents.transpose(1, 0, 2)], axis=1))).sum(axis=0)
    assert np.allclose(total, joint.forces.sum(axis=0), atol=1e-6 * np.abs(total).max())
    assert sorted(made.nodes) == sorted(joint.nodes[joint.state >= 0])


def facing(points, faces, up):
    """Faces counter-clockwise seen from where `up` points."""
    a, b, c = np.moveaxis(points[faces[:, :3]], 1, 0)
    wrong = np.cross(b - a, c - a)[:, 2] * up < 0
    turned = faces.copy()
    turned[wrong] = faces[wrong][:, ::-1]
    return turned


@pytest.mark.parametrize("kind", [skfem.MeshHex, skfem.MeshTet])
def test_faces_in_order_need_no_cells(kind):
    blocks = Blocks(kind, gap=0.02)
    expected = blocks.rows()
    slave, master = facing(blocks.points, blocks.slave, -1), facing(blocks.points, blocks.master, 1)
    got = stiction.mortar(blocks.points, slave, master, dofs=blocks.dofs, held=blocks.held)
    for one, other in zip(got, expected, strict=True):
        difference = abs(one - other)
        assert difference.max() < 1e-13
    assert np.allclose(got.gap, 0.02)
    with pytest.raises(stiction.InputError, match="look the same way") as caught:
        stiction.mortar(blocks.points, slave[:, ::-1], master)
    assert caught.value.place == "slave" and "cells" in caught.value.remedy


def grid(count, z, up, kind):
    """A unit square of `count` squares a side as faces of `kind` nodes, seen from where `up` points."""
    line = np.linspace(0, 1, 2 * count + 1)
    x, y = np.meshgrid(line, line, indexing="ij")
    points = np.stack([x.ravel(), y.ravel(), np.full(x.size, z)], axis=1)
    number = np.arange(x.size).reshape(x.shape)
    i, j = (2 * a.ravel() for a in np.meshgrid(np.arange(count), np.arange(count), indexing="ij"))
    if kind in (4, 8):
        places = [(0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1)]
        lists = [places]
    else:
        lists = [
            [(0, 0), (2, 0), (2, 2), (1, 0), (2, 1), (1, 1)],
            [(0, 0), (2, 2), (0, 2), (1, 1), (1, 2), (0, 1)],
        ]
    faces = np.concatenate([np.stack([number[i + a, j + b] for a, b in places[:kind]], axis=1) for places in lists])
    if up < 0:  # corners the other way round, middles behind them
        corners = kind if kind <= 4 else kind // 2
        order = [0, *range(corners - 1, 0, -1)]
        faces = faces[:, order + ([] if kind == corners else [corners + k for k in range(corners - 1, -1, -1)])]
    return points, faces


@pytest.mark.parametrize("slave", [3, 4, 6, 8])
@pytest.mark.parametrize("master", [3, 4, 6, 8])
def test_linear_motions_that_both_follow_are_no_jump(slave, master):
    (below, lower), (above, upper) = grid(2, 0.0, 1, master), grid(3, 0.0, -1, slave)
    points = np.concatenate([below, above])
    rows = stiction.mortar(points, upper + len(below), lower)
    assert (rows.area * rows.unity_sum).sum() == pytest.approx(1.0, rel=1e-12) and (rows.area > 0).all()
    assert np.allclose(rows.normals, [0, 0, -1])
    u = points @ np.random.default_rng(5).normal(size=(3, 3)) + [1.0, -2.0, 0.5]
    assert np.abs(rows.B @ u.ravel()).max() < 1e-12
    # A translation of the upper body alone is a jump of so much: the force on both is the same.
    u = np.where(np.arange(len(points))[:, None] >= len(below), [0.1, 0.2, -0.3], 0.0)
    jump = (rows.B @ u.ravel()).reshape(-1, 3)
    along = np.stack([rows.normals, rows.tangents[:, 0], rows.tangents[:, 1]], axis=1) @ [0.1, 0.2, -0.3]
    assert np.allclose(jump, along * rows.unity_sum[:, None])


def test_mixed_faces_and_other_numberings():
    (below, lower), (above, upper) = grid(2, 0.0, 1, 4), grid(3, 0.05, -1, 3)
    points = np.concatenate([below, above])
    upper = upper + len(below)
    expected = stiction.mortar(points, upper, lower)
    got = stiction.mortar(points, [upper[:5], upper[5:].astype(np.int32)], lower.tolist())
    assert abs(got.B - expected.B).max() < 1e-14 and np.array_equal(got.nodes, expected.nodes)
    dofs = np.random.default_rng(2).permutation(3 * len(points) + 7)[: 3 * len(points)].reshape(-1, 3)
    moved = stiction.mortar(points, upper, lower, dofs=dofs, unknowns=3 * len(points) + 7)
    assert moved.B.shape[1] == 3 * len(points) + 7
    assert abs(moved.B[:, dofs.ravel()] - expected.B).max() == 0.0


def test_held_nodes_leave_their_part_to_their_neighbours():
    (below, lower), (above, upper) = grid(2, 0.0, 1, 4), grid(4, 0.0, -1, 4)
    points = np.concatenate([below, above])
    upper = upper + len(below)
    edge = len(below) + np.flatnonzero((above[:, 0] == 0) & np.isin(len(below) + np.arange(len(above)), upper))
    mask = np.zeros(3 * len(points), dtype=bool)
    mask[(3 * edge[:, None] + np.arange(3)).ravel()] = True
    rows = stiction.mortar(points, upper, lower, held=mask)
    assert not np.isin(edge, rows.nodes).any()
    assert (rows.area * rows.unity_sum).sum() == pytest.approx(1.0, rel=1e-9)
    assert rows.unity_sum.max() > 1.1
    by_numbers = stiction.mortar(points, upper, lower, held=np.flatnonzero(mask))
    assert abs(rows.B - by_numbers.B).max() == 0.0


SQUARE = np.array([[0, 0], [1, 0], [1, 1], [0, 1.0]])
POINTS = np.concatenate([np.insert(SQUARE, 2, 0.1, axis=1), np.insert(SQUARE, 2, 0.0, axis=1)])


@pytest.mark.parametrize(
    ("change", "place", "text"),
    [
        ({"points": POINTS[:, :2]}, "mesh", r"\(8, 2\)"),
        ({"points": np.where(POINTS == 1, np.nan, POINTS)}, "points", "finite"),
        ({"slave": []}, "slave", "float64"),
        ({"slave": np.zeros((0, 4), int)}, "slave", "no faces"),
        ({"slave": [[0, 3, 2, 1, 1]]}, "slave", r"\(1, 5\)"),
        ({"slave": [[0.0, 3, 2, 1]]}, "slave", "float64"),
        ({"slave": [0, 3, 2, 1]}, "slave", r"\(4,\)"),
        ({"slave": [[0, 3, 2, 1], [3, 2, 1, 0]]}, "slave", r"corners \[0, 1, 2, 3\] is given twice"),
        ({"slave": [[0, 3, 2, 8]]}, "slave", "no node 8 among 8"),
        ({"master": [[4, 5, 6, -1]]}, "master", "no node -1"),
        ({"slave": [[0, 1, 2, 3]]}, "slave", "look the same way"),
        ({"points": POINTS * [1, 1, 50]}, "search", "5.000e0 apart"),
        ({"search": -1.0}, "search", "-1"),
        ({"search": np.nan}, "search", "nan"),
        ({"search": 0.01}, "search", "1.000e-1 apart"),
        ({"dofs": [[0, 1, 2]]}, "dofs", "of 1 nodes, and there are 8 points"),
        ({"dofs": np.arange(24).reshape(8, 3) + 0.5}, "dofs", "float64"),
        ({"dofs": np.arange(24).reshape(8, 3), "unknowns": 20}, "dofs", "20 unknowns"),
        ({"held": [24]}, "held", "no unknown 24 among 24"),
        ({"held": np.arange(12)}, "slave", "are held"),
        ({"cells": [[0, 1, 2, 3]]}, "cells, element 1", "flat|volume"),
        ({"cells": [[4, 5, 6, 0]]}, "slave", "faces of none"),
    ],
)
def test_surfaces_that_cannot_be_used_are_named(change, place, text):
    given = dict(points=POINTS, slave=[[0, 3, 2, 1]], master=[[4, 5, 6, 7]]) | change
    with pytest.raises(stiction.InputError, match=text) as caught:
        stiction.mortar(given.pop("points"), given.pop("slave"), given.pop("master"), **given)
    assert caught.value.place == place and caught.value.remedy
