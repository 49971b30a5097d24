"""A small assembly of trilinear hexahedra, written for the tests alone."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp


def block(cells, size, young=1.0, poisson=0.0):
    """Nodes (nodes, 3) and stiffness (CSR, three unknowns a node) of a box of hexahedra."""
    axes = [np.linspace(0.0, length, count + 1) for count, length in zip(cells, size, strict=True)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    numbers = np.arange(len(points)).reshape([count + 1 for count in cells])
    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
    at = [numbers[i : i + cells[0], j : j + cells[1], k : k + cells[2]].ravel() for i, j, k in corners]
    hexes = np.stack(at, axis=1)
    own = _element(np.asarray(size) / np.asarray(cells), young, poisson, np.asarray(corners))
    dofs = (3 * hexes[:, :, None] + np.arange(3)).reshape(len(hexes), 24)
    rows = np.repeat(dofs, 24, axis=1).ravel()
    columns = np.tile(dofs, (1, 24)).ravel()
    matrix = sp.coo_array((np.tile(own.ravel(), len(hexes)), (rows, columns)), shape=(3 * len(points),) * 2)
    matrix = matrix.tocsr()
    return points, (0.5 * (matrix + matrix.T)).tocsr()  # symmetric to the last bit


def _element(lengths, young, poisson, corners):
    shear, lame = young / (2 + 2 * poisson), young * poisson / ((1 + poisson) * (1 - 2 * poisson))
    elasticity = np.diag([2 * shear] * 3 + [shear] * 3)
    elasticity[:3, :3] += lame
    stiffness = np.zeros((24, 24))
    gauss = 0.5 + np.array([-0.5, 0.5]) / np.sqrt(3.0)
    for x in np.stack(np.meshgrid(gauss, gauss, gauss), axis=-1).reshape(-1, 3):
        factor = np.where(corners == 1, x, 1 - x)
        sign = np.where(corners == 1, 1.0, -1.0)
        strain = np.zeros((6, 24))
        for c in range(3):
            other = [a for a in range(3) if a != c]
            slope = sign[:, c] * factor[:, other[0]] * factor[:, other[1]] / lengths[c]
            strain[c, c::3] = slope
            pairs = [(3, (0, 1)), (4, (1, 2)), (5, (2, 0))]
            for row, pair in pairs:
                if c in pair:
                    strain[row, (pair[0] + pair[1] - c) :: 3] += slope
        stiffness += strain.T @ elasticity @ strain * np.prod(lengths) / 8
    return stiffness


def floor_rows(points, unknowns, on):
    """Rows n, t1, t2 of the nodes `on` above a floor z = 0: -u_z, u_x, u_y. Gaps beside."""
    rows = 3 * np.arange(len(on))
    places = np.concatenate([rows, rows + 1, rows + 2])
    columns = np.concatenate([3 * on + 2, 3 * on, 3 * on + 1])
    values = np.concatenate([-np.ones(len(on)), np.ones(2 * len(on))])
    return sp.csr_array((values, (places, columns)), shape=(3 * len(on), unknowns)), points[on, 2].copy()


def column(cells, size=(1.0, 1.0, 1.0), young=2000.0, poisson=0.0, lift=0.0):
    """A box above a floor: points, K, B, gap, unknowns of the top."""
    points, stiffness = block(cells, size, young, poisson)
    bottom, top = np.flatnonzero(points[:, 2] == 0), np.flatnonzero(points[:, 2] == size[2])
    jump, gap = floor_rows(points, stiffness.shape[0], bottom)
    return points, stiffness, jump, gap + lift, (3 * top[:, None] + np.arange(3)).ravel()
