"""Rows of the jump at nodes, for those who assemble elsewhere."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _stiction
from ._arrays import Reals, Whole, numbers, reals, sparse
from ._errors import InputError
from ._mesh import of_arrays, places

__all__ = ["MortarRows", "Rows", "mortar", "rows"]


class Rows(NamedTuple):
    """The jump at contact points and its axes."""

    B: Any
    """``scipy.sparse.csr_array``, ``(3 k, unknowns)``: normal, first and second tangent of each point."""
    normals: Reals
    """``(k, 3)``, of length one."""
    tangents: Reals
    """``(k, 2, 3)``: the axes of the tangential forces and slips."""


def rows(
    nodes: npt.ArrayLike,
    normals: npt.ArrayLike,
    unknowns: int,
    *,
    against: npt.ArrayLike | None = None,
    dofs: npt.ArrayLike | None = None,
) -> Rows:
    """Rows of `B` for nodes that meet a rigid obstacle, or the nodes of another body one by one; needs SciPy.

    Parameters
    ----------
    nodes : array of int, (k,)
        One contact point each.
    normals : array, (k, 3), or (3,) for all
        From the body into its counterpart: (0, 0, -1) above a floor. Any length.
    unknowns : int
        Columns of `B`: the number of rows of `K`.
    against : array of int, (k,), optional
        Nodes of the counterpart, each opposite to its own; without them it is rigid and at rest.
    dofs : array of int, (nodes, 3), optional
        The unknown of each node along x, y, z; default ``3 * node + direction``.

    Examples
    --------
    >>> import stiction
    >>> stiction.rows([1], [0, 0, -1], 6).B.toarray()
    array([[ 0.,  0.,  0.,  0.,  0., -1.],
           [ 0.,  0.,  0.,  1.,  0.,  0.],
           [ 0.,  0.,  0.,  0., -1.,  0.]])
    """
    from scipy.sparse import csr_array

    table = _unknowns_of_nodes(dofs, unknowns)
    own = numbers(nodes, len(table), "nodes", "node")
    axes = reals(normals, "normals")
    if axes.shape not in ((3,), (len(own), 3)):
        raise InputError("normals", f"their shape is {axes.shape}", f"give ({len(own)}, 3), or one for all")
    normal = np.broadcast_to(axes, (len(own), 3))
    length = np.linalg.norm(normal, axis=1)
    bad = np.flatnonzero(~(np.isfinite(length) & (length > 0)))
    if len(bad):
        raise InputError("normals", f"that of point {bad[0]} has the length {length[bad[0]]:g}", "give directions")
    normal = normal / length[:, None]
    # Across the normal, along the coordinate axis that is farthest from it.
    axis = np.eye(3)[np.abs(normal).argmin(axis=1)]
    first = axis - np.sum(axis * normal, axis=1)[:, None] * normal
    first /= np.linalg.norm(first, axis=1)[:, None]
    second = np.cross(normal, first)
    frame = np.stack([normal, first, second], axis=1)
    sides = [(own, frame)]
    if against is not None:
        other = numbers(against, len(table), "against", "node")
        if len(other) != len(own):
            raise InputError("against", f"it has {len(other)} nodes, and `nodes` {len(own)}", "give one for each")
        if np.any(same := other == own):
            raise InputError("against", f"node {own[same.argmax()]} is against itself", "give nodes of the other body")
        sides.append((other, -frame))
    at = np.arange(3 * len(own)).reshape(-1, 3, 1)
    parts = [(values, np.broadcast_to(at, values.shape), table[places][:, None, :] + 0 * at) for places, values in sides]
    values, row, column = (np.concatenate([part[i].ravel() for part in parts]) for i in range(3))
    jump = csr_array((values, (row, column)), shape=(3 * len(own), unknowns))
    jump.eliminate_zeros()
    return Rows(jump, normal, np.stack([first, second], axis=1))


def _unknowns_of_nodes(dofs: npt.ArrayLike | None, unknowns: int) -> npt.NDArray[Any]:
    table = np.arange(unknowns - unknowns % 3).reshape(-1, 3) if dofs is None else np.asarray(dofs)
    if table.ndim != 2 or table.shape[1] != 3 or table.dtype.kind not in "iu":
        what = f"it has type {table.dtype} and shape {table.shape}"
        raise InputError("dofs", what, "give the unknowns of each node along x, y, z: (nodes, 3)")
    if table.size and not 0 <= table.min() <= table.max() < unknowns:
        raise InputError("dofs", f"they go from {table.min()} to {table.max()}", f"there are {unknowns} unknowns")
    return table


class MortarRows(NamedTuple):
    """Contact of two surfaces at ``m`` nodes of the slave; other nodes leave their part to these."""

    B: Any
    """``scipy.sparse.csr_array``, ``(3 m, unknowns)``: normal, first and second tangent of each point."""
    gap: Reals
    """``(m,)``, length: along the normal, negative where the surfaces overlap."""
    area: Reals
    """``(m,)``, length squared: normal forces over it are pressures."""
    nodes: Whole
    """``(m,)``: the slave node of each point."""
    normals: Reals
    """``(m, 3)``, of length one: from the slave into the master."""
    tangents: Reals
    """``(m, 2, 3)``: the axes of the tangential forces and slips; zero where a held node cannot move."""
    unity_sum: Reals
    """``(m,)``: forces times this add up to the whole force between the bodies. One, but next to nodes that were left out
    and on quadratic faces."""


def mortar(
    points: npt.ArrayLike,
    slave: Any,
    master: Any,
    *,
    cells: Any = None,
    dofs: npt.ArrayLike | None = None,
    unknowns: int | None = None,
    held: npt.ArrayLike | None = None,
    search: float | None = None,
) -> MortarRows:
    """Rows of `B` between two surfaces whose meshes need not match; needs SciPy.

    Dual mortar multipliers, integrated over the overlaps of the faces: what a :class:`Case` takes between two bodies. Constant
    pressures and linear displacements pass through exactly.

    Parameters
    ----------
    points : array, (nodes, 3)
        Coordinates.
    slave, master : array of int, (k, 3), (k, 4), (k, 6) or (k, 8), or a list of such
        Nodes of the faces of each surface: corners counter-clockwise seen from outside, then the middles of the edges, that
        behind the first corner first. The slave carries the points; take the surface with the smaller faces.
    cells : optional
        Nodes of the cells as of :class:`Case`, in the order of VTK (of hexahedra of scikit-fem ``m.t[HEX_MAPPING[:8]].T``).
        Corners of faces may turn either way then, and the nodes in the middle of edges are found.
    dofs : array of int, (nodes, 3), optional
        The unknown of each node along x, y, z; default ``3 * node + direction``.
    unknowns : int, optional
        Columns of `B`; default three a node, or as many as `dofs` name.
    held : array of int or bool, optional
        Unknowns whose displacement is prescribed, as of :class:`Problem`: their nodes leave what they cannot carry to their
        neighbours.
    search : float, optional
        Length: the surfaces meet where they are no farther apart, or overlap no deeper. Default a quarter of the diagonal of the
        smaller one.

    Raises
    ------
    InputError
        If the surfaces do not meet, look the same way, share a face, or faces cannot be used.

    Examples
    --------
    A square of two triangles above one of a single quadrilateral, 0.1 apart:

    >>> import numpy as np, stiction
    >>> square = np.array([[0, 0], [1, 0], [1, 1], [0, 1.0]])
    >>> points = np.concatenate([np.insert(square, 2, z, axis=1) for z in (0.1, 0.0)])
    >>> found = stiction.mortar(points, [[0, 2, 1], [0, 3, 2]], [[4, 5, 6, 7]])
    >>> found.gap.round(12), found.area.round(12)
    (array([0.1, 0.1, 0.1, 0.1]), array([0.33333333, 0.16666667, 0.33333333, 0.16666667]))
    """
    at = places(points)
    if not np.isfinite(at).all():
        raise InputError("points", "they are not all finite", "give finite numbers")
    surfaces = _faces(slave, len(at), "slave"), _faces(master, len(at), "master")
    mesh = None
    if cells is not None:
        corners = [[_corners(block) for block in surface] for surface in surfaces]
        named = {name: {"faces": np.concatenate(own)} for name, own in zip(("slave", "master"), corners, strict=True)}
        mesh = of_arrays(at, cells, named, {})
        surfaces = [], []
    if unknowns is None:
        unknowns = 3 * len(at) if dofs is None else int(np.max(np.asarray(dofs), initial=-1)) + 1
    table = _unknowns_of_nodes(dofs, unknowns)
    if len(table) != len(at):
        raise InputError("dofs", f"they are of {len(table)} nodes, and there are {len(at)} points", "give those of all nodes")
    fixed = np.zeros(unknowns, dtype=bool)
    fixed[numbers([] if held is None else held, unknowns, "held")] = True
    if search is not None and not 0 < search < np.inf:
        raise InputError("search", f"it is {search}", "give a positive length")
    found = _stiction.mortar(at, surfaces, mesh, np.flatnonzero(fixed[table.ravel()]), search)
    m = len(found["gap"])
    jump = sparse(found["B"])[np.arange(3 * m).reshape(3, m).T.ravel()].tocoo()
    jump = type(jump)((jump.data, (jump.row, table.ravel()[jump.col])), shape=(3 * m, unknowns)).tocsr()
    axes = found["axes"].reshape(m, 3, 3)
    return MortarRows(jump, found["gap"], found["area"], found["nodes"], axes[:, 0], axes[:, 1:], found["unity_sum"])


def _faces(faces: Any, nodes: int, name: str) -> list[Whole]:
    """Blocks of faces of one width each."""
    blocks = []
    ragged = isinstance(faces, (list, tuple)) and len(faces) > 0 and np.ndim(faces[0]) == 2
    for block in faces if ragged else [faces]:
        array = np.asarray(block)
        if array.ndim != 2 or array.shape[1] not in (3, 4, 6, 8) or array.dtype.kind not in "iu":
            what = f"its faces have type {array.dtype} and shape {array.shape}"
            raise InputError(name, what, "give the nodes of each face: (k, 3), (k, 4), (k, 6) or (k, 8)")
        if len(array) and not 0 <= array.min() <= array.max() < nodes:
            bad = array.min() if array.min() < 0 else array.max()
            raise InputError(name, f"there is no node {bad} among {nodes}", "count from zero")
        blocks.append(np.require(array, np.int64, ["C", "A"]))
    if not sum(map(len, blocks)):
        raise InputError(name, "it has no faces", "give some")
    corners = np.sort(np.concatenate([_corners(block) for block in blocks]), axis=1)
    once, count = np.unique(corners, axis=0, return_counts=True)
    if len(once) < len(corners):
        twice = once[count.argmax()]
        raise InputError(name, f"the face with the corners {twice[twice >= 0].tolist()} is given twice", "give it once")
    return blocks


def _corners(block: Whole) -> Whole:
    """Four a face, -1 behind those of a triangle."""
    corners = block[:, :3] if block.shape[1] in (3, 6) else block[:, :4]
    return np.pad(corners, ((0, 0), (0, 4 - corners.shape[1])), constant_values=-1)
