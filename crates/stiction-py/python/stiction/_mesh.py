"""Meshes of others: meshio, pyvista, plain arrays."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ._arrays import reals
from ._errors import InputError

#: Name of each kind, its nodes, and what meshio and VTK call it.
KINDS = {
    "tet4": (4, "tetra", 10),
    "hex8": (8, "hexahedron", 12),
    "tet10": (10, "tetra10", 24),
    "hex20": (20, "hexahedron20", 25),
    "wedge6": (6, "wedge", 13),
    "wedge15": (15, "wedge15", 26),
}
OF_MESHIO = {meshio: kind for kind, (_, meshio, _) in KINDS.items()}
OF_VTK = {vtk: kind for kind, (_, _, vtk) in KINDS.items()}
#: Corners of faces by meshio's names and VTK's numbers; quadratic faces begin with them.
FACES = {"triangle": 3, "triangle6": 3, "quad": 4, "quad8": 4, "quad9": 4, 5: 3, 22: 3, 9: 4, 23: 4, 28: 4}
#: Points and lines: their groups are groups of nodes.
NODES = {"vertex", "line", "line3", 1, 3, 21}

Whole = np.ndarray[tuple[Any, ...], np.dtype[np.int64]]
Reals = npt.NDArray[np.float64]
#: Name and values of arrays on nodes; name, values of cells, values of faces of arrays on cells; corners of these faces; name of an array
#: that is not one number at each place, and what it is.
Numbers = tuple[list[tuple[str, Reals]], list[tuple[str, Reals, Reals]], Whole, list[tuple[str, str]]]
#: Coordinates; name and nodes of each block of cells; name, cells, corners of faces, nodes of each group; arrays.
Given = tuple[Reals, list[tuple[str, Whole]], list[tuple[str, Whole, Whole, Whole]], Numbers]


class Groups:
    """Groups as they are gathered."""

    def __init__(self) -> None:
        self.all: dict[str, tuple[list[Whole], list[Whole], list[Whole]]] = {}

    def add(self, name: str, kind: int, numbers: Any) -> None:
        parts = self.all.setdefault(str(name), ([], [], []))
        parts[kind].append(np.ascontiguousarray(numbers, dtype=np.int64))

    def cells(self, name: str, numbers: Any) -> None:
        self.add(name, 0, numbers)

    def faces(self, name: str, corners: Any) -> None:
        corners = np.asarray(corners, dtype=np.int64)
        self.add(name, 1, np.pad(corners, ((0, 0), (0, 4 - corners.shape[1])), constant_values=-1))

    def nodes(self, name: str, numbers: Any) -> None:
        self.add(name, 2, np.unique(np.asarray(numbers)))

    def list(self) -> list[tuple[str, Whole, Whole, Whole]]:
        empty, no_faces = np.zeros(0, dtype=np.int64), np.zeros((0, 4), dtype=np.int64)
        return [
            (
                name,
                np.concatenate([empty, *cells]),
                np.ascontiguousarray(np.concatenate([no_faces, *faces])),
                np.concatenate([empty, *nodes]),
            )
            for name, (cells, faces, nodes) in self.all.items()
        ]


class Arrays:
    """Arrays of floating-point numbers as they are gathered."""

    def __init__(self) -> None:
        self.of_nodes: list[tuple[str, Reals]] = []
        self.of_cells: list[tuple[str, Reals, Reals]] = []
        self.others: list[tuple[str, str]] = []
        self.corners: list[Whole] = []

    def fits(self, name: str, values: Any) -> bool:
        """Whether it is one floating-point number at each place; integers are groups and marks."""
        array = np.asarray(values)
        if array.dtype.kind != "f":
            return False
        if array.ndim != 1:
            self.others.append((str(name), f"it has {np.prod(array.shape[1:])} components"))
        return array.ndim == 1

    def nodes(self, name: str, values: Any) -> None:
        if self.fits(name, values):
            self.of_nodes.append((str(name), np.ascontiguousarray(values, dtype=np.float64)))

    def cells(self, name: str, values: list[Reals], on_faces: list[Reals]) -> None:
        """Values of all blocks of cells and of faces in their order."""
        parts = [np.concatenate([np.zeros(0), *part]).astype(np.float64) for part in (values, on_faces)]
        self.of_cells.append((str(name), parts[0], parts[1]))

    def faces(self, corners: Any) -> None:
        corners = np.asarray(corners, dtype=np.int64)
        self.corners.append(np.pad(corners, ((0, 0), (0, 4 - corners.shape[1])), constant_values=-1))

    def list(self) -> Numbers:
        corners = np.concatenate([np.zeros((0, 4), dtype=np.int64), *self.corners])
        return self.of_nodes, self.of_cells, np.ascontiguousarray(corners), self.others


def given(mesh: Any) -> Given:
    """Coordinates, cells, groups and arrays of whatever it is."""
    if isinstance(mesh, tuple):
        if len(mesh) not in (2, 3, 4):
            raise InputError("mesh", f"it is a tuple of {len(mesh)}", "give (points, cells, groups, arrays)")
        return of_arrays(*mesh, *({}, {})[len(mesh) - 2 :])
    if hasattr(mesh, "cell_sets") and hasattr(mesh, "cells"):
        return of_meshio(mesh)
    if hasattr(mesh, "celltypes") and hasattr(mesh, "cell_data"):
        return of_pyvista(mesh)
    raise InputError("mesh", f"a {type(mesh).__name__} is no mesh", "give a file, meshio, pyvista or (points, cells, groups, arrays)")


def places(points: Any) -> npt.NDArray[np.float64]:
    array = reals(points, "mesh")
    if array.ndim != 2 or array.shape[1] != 3:
        raise InputError("mesh", f"the points have the shape {array.shape}", "give x, y, z of each: (nodes, 3)")
    return array


def table(kind: str, nodes: Any) -> tuple[str, Whole]:
    array = np.asarray(nodes)
    if array.ndim != 2 or array.dtype.kind not in "iu" or array.shape[1] != KINDS[kind][0]:
        what = f"the cells {kind} have type {array.dtype} and shape {array.shape}"
        raise InputError("mesh", what, f"give {KINDS[kind][0]} nodes of each cell")
    return kind, np.require(array, np.int64, ["C", "A"])


def of_arrays(points: Any, cells: Any, groups: Any, arrays: Any) -> Given:
    blocks = []
    by_width = {width: kind for kind, (width, _, _) in KINDS.items()}
    named = isinstance(cells, list) and all(len(part) == 2 and isinstance(part[0], str) for part in cells)
    pairs = cells.items() if isinstance(cells, dict) else cells if named else [(None, cells)]
    for name, nodes in pairs:
        kind = by_width.get(np.shape(nodes)[-1]) if name is None else OF_MESHIO.get(name, name)
        if kind not in KINDS:
            raise InputError("mesh", f"{name or np.shape(nodes)} is no kind of cell", f"give {', '.join(KINDS)}")
        blocks.append(table(kind, nodes))
    gathered = Groups()
    for name, numbers in groups.items():
        parts = numbers if isinstance(numbers, dict) else {"faces" if np.ndim(numbers) == 2 else "nodes": numbers}
        for key, part in parts.items():
            array = np.asarray(part)
            array = np.flatnonzero(array) if array.dtype == np.bool_ else array
            fits = array.ndim == 2 and array.shape[-1] in (3, 4) if key == "faces" else array.ndim == 1
            if key not in ("cells", "faces", "nodes") or not fits or array.dtype.kind not in "iu":
                what = f"{key!r} has type {array.dtype} and shape {array.shape}"
                remedy = "give numbers of nodes, corners of faces (k, 3 or 4), or a dict of cells, faces and nodes"
                raise InputError(f"mesh, group {name!r}", what, remedy)
            {"cells": gathered.cells, "faces": gathered.faces, "nodes": gathered.nodes}[key](name, array)
    where, numbers = places(points), Arrays()
    counts = {len(where): "nodes", sum(len(nodes) for _, nodes in blocks): "cells"}
    for name, values in arrays.items():
        array = reals(values, f"mesh, array {name!r}")
        if array.ndim != 1 or len(array) not in counts:
            what, remedy = f"its shape is {array.shape}", f"give one number for each of {' or '.join(map(str, counts))}"
            raise InputError(f"mesh, array {name!r}", what, f"{remedy}: nodes or cells")
        if len(array) == len(where):
            numbers.nodes(name, array)
        else:
            numbers.cells(name, [array], [])
    return where, blocks, gathered.list(), numbers.list()


def of_meshio(mesh: Any) -> Given:
    """Sets of cells and points, and the physical groups of Gmsh."""
    blocks, gathered = [], Groups()
    first = []
    count = 0
    for block in mesh.cells:
        first.append(count)
        if block.type in OF_MESHIO:
            blocks.append(table(OF_MESHIO[block.type], block.data))
            count += len(block.data)
        elif block.type not in FACES and block.type not in NODES:
            raise InputError("mesh", f"cells of the type {block.type} cannot be used", f"give {', '.join(OF_MESHIO)}")

    def add(name: str, b: int, chosen: Any) -> None:
        block = mesh.cells[b]
        if block.type in OF_MESHIO:
            gathered.cells(name, first[b] + np.asarray(chosen))
        elif block.type in FACES:
            gathered.faces(name, block.data[chosen][:, : FACES[block.type]])
        else:
            gathered.nodes(name, block.data[chosen])

    for name, parts in mesh.cell_sets.items():
        if not name.startswith("gmsh:"):
            for b, chosen in enumerate(parts):
                if chosen is not None and len(chosen):
                    add(name, b, np.asarray(chosen, dtype=np.int64))
    tags = mesh.cell_data.get("gmsh:physical")
    for name, (tag, _) in mesh.field_data.items() if tags is not None else ():
        if name not in gathered.all:
            for b, of_block in enumerate(tags):
                chosen = np.flatnonzero(np.asarray(of_block) == tag)
                if len(chosen):
                    add(name, b, chosen)
    for name, chosen in mesh.point_sets.items():
        gathered.nodes(name, chosen)
    numbers = Arrays()
    of_faces = [b for b, block in enumerate(mesh.cells) if block.type in FACES]
    of_cells = [b for b, block in enumerate(mesh.cells) if block.type in OF_MESHIO]
    for b in of_faces:
        numbers.faces(mesh.cells[b].data[:, : FACES[mesh.cells[b].type]])
    for name, values in mesh.point_data.items():
        numbers.nodes(name, values)
    for name, parts in mesh.cell_data.items():
        if of_cells and numbers.fits(name, parts[of_cells[0]]):
            numbers.cells(name, [np.asarray(parts[b]) for b in of_cells], [np.asarray(parts[b]) for b in of_faces])
    return places(mesh.points), blocks, gathered.list(), numbers.list()


def of_pyvista(grid: Any) -> Given:
    """An array `part` gives `part-1` and so on, an array of zeros and ones a group with its name, as in `.vtu` files."""
    types = np.asarray(grid.celltypes)
    of_type = {int(kind): np.asarray(nodes) for kind, nodes in grid.cells_dict.items()}
    number = np.full(len(types), -1)
    blocks, gathered = [], Groups()
    count = 0
    for kind, nodes in of_type.items():
        if kind in OF_VTK:
            blocks.append(table(OF_VTK[kind], nodes))
            number[types == kind] = count + np.arange(len(nodes))
            count += len(nodes)
        elif kind not in FACES and kind not in NODES:
            raise InputError("mesh", f"cells of VTK's type {kind} cannot be used", "give tetrahedra, wedges and hexahedra")
    for key in grid.cell_data:
        array = np.asarray(grid.cell_data[key])
        if array.ndim != 1 or array.dtype.kind not in "iub":
            continue
        values = np.unique(array)
        if key == "part":
            chosen = [(f"part-{value}", array == value) for value in values]
        elif set(values.tolist()) <= {0, 1}:
            chosen = [(key, array != 0)]
        else:
            continue
        for name, mask in chosen:
            for kind, nodes in of_type.items():
                own = mask[types == kind]
                if kind in OF_VTK and own.any():
                    gathered.cells(name, number[mask & (types == kind)])
                elif kind in FACES and own.any():
                    gathered.faces(name, nodes[own][:, : FACES[kind]])
                elif own.any():
                    gathered.nodes(name, nodes[own])
    for key in grid.point_data:
        array = np.asarray(grid.point_data[key])
        if array.ndim == 1 and array.dtype.kind in "iub" and set(np.unique(array).tolist()) <= {0, 1}:
            gathered.nodes(key, np.flatnonzero(array))
    numbers = Arrays()
    of_faces = [kind for kind in of_type if kind in FACES]
    of_cells = [kind for kind in of_type if kind in OF_VTK]
    for kind in of_faces:
        numbers.faces(of_type[kind][:, : FACES[kind]])
    for key in grid.point_data:
        numbers.nodes(key, grid.point_data[key])
    for key in grid.cell_data:
        if numbers.fits(key, grid.cell_data[key]):
            of_kind = {kind: np.asarray(grid.cell_data[key])[types == kind] for kind in of_type}
            numbers.cells(key, [of_kind[kind] for kind in of_cells], [of_kind[kind] for kind in of_faces])
    return places(grid.points), blocks, gathered.list(), numbers.list()
