"""Rows of the jump at nodes, for those who assemble elsewhere."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ._arrays import Reals, numbers, reals
from ._errors import InputError

__all__ = ["Rows", "rows"]


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

    table = np.arange(unknowns - unknowns % 3).reshape(-1, 3) if dofs is None else np.asarray(dofs)
    if table.ndim != 2 or table.shape[1] != 3 or table.dtype.kind not in "iu":
        what = f"it has type {table.dtype} and shape {table.shape}"
        raise InputError("dofs", what, "give the unknowns of each node along x, y, z: (nodes, 3)")
    if table.size and not 0 <= table.min() <= table.max() < unknowns:
        raise InputError("dofs", f"they go from {table.min()} to {table.max()}", f"there are {unknowns} unknowns")
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
        sides.append((other, -frame))
    at = np.arange(3 * len(own)).reshape(-1, 3, 1)
    parts = [(values, np.broadcast_to(at, values.shape), table[places][:, None, :] + 0 * at) for places, values in sides]
    values, row, column = (np.concatenate([part[i].ravel() for part in parts]) for i in range(3))
    jump = csr_array((values, (row, column)), shape=(3 * len(own), unknowns))
    jump.eliminate_zeros()
    return Rows(jump, normal, np.stack([first, second], axis=1))
