"""Cases: meshes, materials, loads and contact by the keys of the case file."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _stiction
from ._arrays import Reals, sparse, threads_of
from ._errors import InputError, NotCertified
from ._mesh import KINDS, given
from ._results import Certificate, Progress, Tangent, certificate, tangent

__all__ = ["Case", "Facts", "Result", "Step", "Surface"]


@dataclass(frozen=True, repr=False, eq=False)
class Surface:
    """Fields over the nodes of one side of a contact, in global axes. Nodes without a contact point have the state -1."""

    name: str
    """Of the contact."""
    nodes: npt.NDArray[np.int64]
    """Numbers of its nodes, shape ``(k,)``."""
    points: Reals
    """Their coordinates, ``(k, 3)``."""
    faces: list[list[int]]
    """Places in ``nodes``: corners, then the middles of edges."""
    pressure: Reals
    """``(k,)``, force over area, positive in compression; NaN where nothing is known."""
    shear: Reals
    """``(k, 3)``, force over area of the body on its counterpart."""
    slip: Reals
    """``(k, 3)``, length: since the last load step."""
    slid: Reals
    """``(k, 3)``, length: since the start."""
    gap: Reals
    """``(k,)``, length: what is left of it."""
    state: npt.NDArray[np.int32]
    """``(k,)``: 0 open, 1 stick, 2 slip, -1 no contact point."""
    forces: Reals
    """``(k, 3)``: force of the body on its counterpart at each node."""
    master: Surface | None = None
    """The other side, where it is a surface of a body."""

    def __repr__(self) -> str:
        counts = [int((self.state == state).sum()) for state in (0, 1, 2)]
        states = ", ".join(f"{count} {name}" for count, name in zip(counts, ("open", "stick", "slip"), strict=True))
        force = ", ".join(f"{component:.5g}" for component in self.forces.sum(axis=0))
        return f"<Surface {self.name!r}: {states}; force ({force})>"


@dataclass(frozen=True, repr=False, eq=False)
class Step:
    """The state at the end of a load step."""

    t: float
    """Time at its end."""
    displacement: Reals
    """``(nodes, 3)``, length."""
    reaction: Reals
    """``(nodes, 3)``: force of the supports on the body."""
    stress: npt.NDArray[np.float32]
    """``(cells, 6)``: mean xx, yy, zz, xy, yz, xz of each cell."""
    von_mises: npt.NDArray[np.float32]
    """``(cells,)``."""
    cell_error: npt.NDArray[np.float32]
    """``(cells,)``: estimated error of the stress of each cell, relative to the norm of the stress of the whole body."""
    contact: dict[str, Surface]
    """The contact surfaces by name."""

    def __repr__(self) -> str:
        return f"<Step to t = {self.t:g}: {list(self.contact.values())}>"


@dataclass(frozen=True, repr=False, eq=False)
class Facts:
    """What was understood of a case, before it is solved; ``print`` shows all of it."""

    text: str
    """Mesh, materials, supports, loads, contacts with areas and gaps."""
    unknowns: int
    """Unknown displacements."""
    points: int
    """Contact points."""
    nodes: int
    """Nodes of the mesh."""
    cells: int
    """Its cells."""
    volume: float
    """Their volume."""
    load: Reals
    """Resultant of all loads, ``(3,)``."""
    contacts: dict[str, dict[str, Any]]
    """For each contact its points, area, least and largest gap, and points that start inside the counterpart."""
    warnings: list[str]
    """What is probably not what was meant."""
    notes: list[str]
    """What a person should know and did not ask."""

    def __str__(self) -> str:
        return self.text

    def __repr__(self) -> str:
        return f"<Facts: {self.nodes} nodes, {self.cells} cells, {self.unknowns} unknowns, {self.points} contact points>"


@dataclass(frozen=True, repr=False, eq=False)
class Result:
    """The answer of a case; with load steps at the end of the last one."""

    status: str
    """``solved``; otherwise ``max_iterations``, ``stalled``, ``no_equilibrium``, ``passes_through``, ``uncertified`` or
    ``interrupted``."""
    points: Reals
    """Coordinates of the nodes, ``(nodes, 3)``: those given, without nodes of no cell."""
    cells: list[tuple[str, npt.NDArray[np.int64]]]
    """Kind and nodes of the cells, block by block."""
    displacement: Reals
    """``(nodes, 3)``, length."""
    reaction: Reals
    """``(nodes, 3)``: force of the supports on the body, springs included."""
    stress: npt.NDArray[np.float32]
    """``(cells, 6)``: mean xx, yy, zz, xy, yz, xz of each cell."""
    von_mises: npt.NDArray[np.float32]
    """``(cells,)``."""
    cell_error: npt.NDArray[np.float32]
    """``(cells,)``: estimated error of the stress of each cell, relative to the norm of the stress of the whole body."""
    contact: dict[str, Surface]
    """The contact surfaces by name."""
    steps: list[Step]
    """One for each load step that was solved by this call."""
    certificate: Certificate
    """How far this is from a solution."""
    summary: dict[str, Any]
    """What ``summary.json`` holds."""
    files: list[str]
    """Names of the files that were written."""
    seconds: float
    """Wall time."""
    _matrices: _stiction.Matrices | None = None

    @property
    def solved(self) -> bool:
        """Whether the certificate passes."""
        return self.status == "solved"

    @property
    def error(self) -> float | None:
        """Estimated discretisation error: of the stresses in the mean, in the energy norm, relative to their norm."""
        error: float | None = self.summary.get("discretisation_error")
        return error

    @property
    def accuracy(self) -> dict[str, Any] | None:
        """Of a case with ``accuracy`` what its meshes have reached: ``reached``, ``goals``, ``levels`` and ``values`` with their
        error bars, as in ``summary.json``; otherwise None."""
        accuracy: dict[str, Any] | None = self.summary.get("accuracy")
        return accuracy

    def __repr__(self) -> str:
        judged = repr(self.certificate)[1:-1].replace("Certificate", "certificate")
        steps = f"{len(self.steps)} load steps, " if self.steps else ""
        return f"<Result {self.status}: {steps}{len(self.points)} nodes, {list(self.contact.values())}; {judged}>"

    def tangent(self) -> Tangent:
        """Stiffness and motions of the bodies in this state of contact; needs SciPy and a solve with ``matrices=True``.

        ``(free @ x).reshape(-1, 3)`` are displacements of the nodes along x, y, z. See :class:`Tangent`, and :meth:`mass` for the
        mass matrix.
        """
        own = self._linear()
        return tangent(own, sparse(own.directions()))

    def mass(self) -> Any:
        """The consistent mass matrix of all nodes, from the densities of the materials; needs SciPy and a solve with
        ``matrices=True``.

        Returns
        -------
        scipy.sparse.csr_array, (3 nodes, 3 nodes)
            Mass; displacement ``c`` of node ``i`` is number ``3 i + c``. In mm, N, MPa a density of steel is 7.85e-9 (tonnes
            per mm³), and frequencies come out in 1/s.

        Raises
        ------
        InputError
            If no material has a density.
        """
        from scipy.sparse import csr_array, eye_array, kron

        return csr_array(kron(sparse(self._linear().mass()), eye_array(3), format="csr"))

    def _linear(self) -> _stiction.Matrices:
        if self._matrices is None:
            raise InputError("matrices", "they were not kept", "solve the case with `matrices=True`")
        return self._matrices

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_matrices": None}

    def to_meshio(self) -> Any:
        """As a ``meshio.Mesh`` with all fields; needs meshio."""
        import meshio

        ends = np.cumsum([len(nodes) for _, nodes in self.cells])[:-1]
        return meshio.Mesh(
            self.points,
            [(KINDS[kind][1], nodes) for kind, nodes in self.cells],
            point_data=self._point_data(),
            cell_data={name: np.split(data, ends) for name, data in self._cell_data().items()},
        )

    def to_pyvista(self) -> Any:
        """As a ``pyvista.UnstructuredGrid`` with all fields; needs pyvista."""
        import pyvista

        rows = [np.insert(nodes, 0, nodes.shape[1], axis=1).ravel() for _, nodes in self.cells]
        types = np.concatenate([np.full(len(nodes), KINDS[kind][2], dtype=np.uint8) for kind, nodes in self.cells])
        grid = pyvista.UnstructuredGrid(np.concatenate(rows), types, self.points)
        for name, data in self._point_data().items():
            grid.point_data[name] = data
        for name, data in self._cell_data().items():
            grid.cell_data[name] = data
        return grid

    def _point_data(self) -> dict[str, Any]:
        data: dict[str, Any] = {"displacement": self.displacement, "reaction": self.reaction}
        for name, surface in self.contact.items():
            for field in ("pressure", "gap"):
                all_nodes = np.full(len(self.points), np.nan)
                all_nodes[surface.nodes] = getattr(surface, field)
                data[f"{field} {name}"] = all_nodes
        return data

    def _cell_data(self) -> dict[str, Any]:
        return {"stress": self.stress, "von_mises": self.von_mises, "error": self.cell_error}


class Case:
    """A case by the keys of the case file (``docs/case-file.md``), with a mesh from a file or from memory.

    Parameters
    ----------
    case : dict, str or path
        A dict with the keys of a case file, the text of one (TOML), or its path.
    mesh : optional
        A mesh in place of the case's own: a path, a ``meshio.Mesh``, a ``pyvista.UnstructuredGrid``, or
        ``(points, cells, groups, arrays)``, of which the last two may be left out: coordinates ``(nodes, 3)``; nodes of the
        cells, an array or ``{kind: array}`` with the kinds tet4, hex8, tet10, hex20, wedge6, wedge15 in VTK's order; groups by
        name, as numbers of nodes ``(k,)``, corners of faces ``(k, 3)`` or ``(k, 4)``, or ``{"cells": .., "faces": .., "nodes": ..}``; arrays by name, a number for
        each node or for each cell. A pyvista grid gives groups by its arrays of integers, as a ``.vtu`` file does. Arrays of floating-point
        numbers are those of the mesh that a case may name: ``{"temperature": {"array": "T"}}``.
    overrides : dict, optional
        Values by dotted keys: ``{"contact.0.friction.coulomb": 0.2}``.

    Raises
    ------
    InputError
        If a key is unknown, missing or out of range; place and excerpt show the line, of a dict as TOML.

    Examples
    --------
    >>> import stiction
    >>> case = stiction.Case({
    ...     "units": "mm, N, MPa",
    ...     "mesh": {"block": {"size": [60, 40, 20], "cells": [6, 4, 2], "element": "hex8"}},
    ...     "materials": {"steel": {"young": 210e3, "poisson": 0.3}},
    ...     "fix": [{"on": "z-max", "value": [1e-3, 0, -2e-3]}],
    ...     "contact": [{"name": "sole", "on": "z-min", "friction": {"coulomb": 0.3},
    ...                  "against": {"plane": {"point": [0, 0, 0], "normal": [0, 0, 1]}}}],
    ... })
    >>> case.facts()
    <Facts: 105 nodes, 48 cells, 210 unknowns, 35 contact points>
    >>> result = case.solve()
    >>> result.solved, result.contact["sole"].pressure.shape
    (True, (35,))
    >>> result.displacement.shape
    (105, 3)
    """

    def __init__(
        self,
        case: Mapping[str, Any] | str | os.PathLike[str],
        *,
        mesh: Any = None,
        overrides: Mapping[str, Any] | None = None,
    ) -> None:
        text: str | None = None
        path: str | None = None
        name = "case"
        keys = [(key, value_text(value)) for key, value in (overrides or {}).items()]
        is_file = isinstance(mesh, (str, os.PathLike))
        file = os.path.abspath(mesh) if is_file else "(given)"
        if isinstance(case, Mapping):
            table = dict(case)
            if mesh is not None:
                own = dict(table.get("mesh") or {})
                if not is_file and "scale" in own:
                    raise InputError("mesh.scale", "it is for a mesh file", "scale the points of the mesh")
                table["mesh"] = {**own, "file": file}
            text = toml(table)
        else:
            if mesh is not None:
                keys.append(("mesh.file", value_text(file)))
            if isinstance(case, os.PathLike) or "\n" not in case and "=" not in case:
                path = os.fspath(case)
            else:
                text = case
        self._own = _stiction.Case(text, path, name, keys, None if mesh is None or is_file else given(mesh))

    @property
    def title(self) -> str:
        """Heading of the case."""
        return self._own.title

    def __repr__(self) -> str:
        return f"<Case {self.title!r}>"

    def facts(self, *, threads: int | None = None) -> Facts:
        """Pose the case and say what was understood of it: areas, gaps, free motions, notes."""
        found = self._own.facts(threads_of(threads))
        return Facts(**{**found, "load": np.asarray(found["load"])})

    def solve(
        self,
        *,
        folder: str | os.PathLike[str] | None = None,
        resume: bool = False,
        report: bool = True,
        matrices: bool = False,
        threads: int | None = None,
        check: bool = True,
        progress: Callable[[Progress], object] | None = None,
    ) -> Result:
        """Solve the case: all its load steps, and with ``accuracy`` on ever finer meshes until that is reached or cannot be.

        Whether it was is in ``accuracy`` of the result, whose mesh is the last one.

        Parameters
        ----------
        folder : path, optional
            Where to write what the command writes: VTU files, summary, pictures, what ``stiction check`` needs.
        resume : bool
            Go on after the last finished load step, or mesh of a case with ``accuracy``, that the folder holds of this case.
        report : bool
            Whether ``report.html`` is among the files.
        matrices : bool
            Whether the result keeps the stiffness, for :meth:`Result.tangent` and :meth:`Result.mass`.
        threads, check, progress :
            As of :meth:`stiction.Problem.solve`; `progress` also has the load step and its time.

        Raises
        ------
        NotCertified
            If the answer is none: see ``status`` of its ``result``.
        InputError
            If the case cannot be posed or the folder not be written.
        """
        begin = time.perf_counter()
        last = [0, 0.0]

        def hear(*event: Any) -> bool:
            *known, step, t = event
            if step:
                last[:] = [step, t]
            return progress is None or progress(Progress(*known, *last)) is not False

        found = self._own.solve(
            folder=None if folder is None else os.fspath(folder),
            resume=resume,
            report=report,
            matrices=matrices,
            threads=threads_of(threads),
            hear=None if progress is None else hear,
        )
        why = found.pop("why")
        steps = [Step(**{**_fields(step), "t": step["t"]}) for step in found["steps"]]
        result = Result(
            status=found["status"],
            points=found["points"],
            cells=[(kind, nodes.reshape(-1, KINDS[kind][0])) for kind, nodes in found["cells"]],
            certificate=certificate(found["certificate"]),
            summary=json.loads(found["summary"]),
            files=found["files"],
            steps=steps,
            seconds=time.perf_counter() - begin,
            _matrices=found["matrices"],
            **_fields(found),
        )
        if check and not result.solved:
            raise NotCertified(why or f"{result.status}: {result.certificate!r}", result)
        return result


def _fields(found: dict[str, Any]) -> dict[str, Any]:
    contact: dict[str, Surface] = {}
    masters = {own["name"]: own for own in found["surfaces"] if own["master"]}
    for own in found["surfaces"]:
        if not own["master"]:
            other = masters.get(own["name"])
            master = None if other is None else Surface(**{**other, "master": None})
            contact[own["name"]] = Surface(**{**own, "master": master})
    return {name: found[name] for name in ("displacement", "reaction", "stress", "von_mises", "cell_error")} | {"contact": contact}


def toml(table: Mapping[str, Any]) -> str:
    """A case file of a dict: one line a key, so that messages show it."""
    plain, tables = [], []
    for key, value in table.items():
        if value is None:
            continue
        if isinstance(value, Mapping):
            tables += [f"\n[{key_text(key)}]", *_lines(value)]
        elif isinstance(value, (list, tuple)) and value and all(isinstance(item, Mapping) for item in value):
            for item in value:
                tables += [f"\n[[{key_text(key)}]]", *_lines(item)]
        else:
            plain.append(f"{key_text(key)} = {value_text(value)}")
    return "\n".join(plain + tables) + "\n"


def _lines(table: Mapping[str, Any]) -> list[str]:
    return [f"{key_text(key)} = {value_text(value)}" for key, value in table.items() if value is not None]


def key_text(key: Any) -> str:
    text = str(key)
    bare = text and all(c.isascii() and (c.isalnum() or c in "-_") for c in text)
    return text if bare else json.dumps(text)


def value_text(value: Any) -> str:
    """A value of TOML."""
    if isinstance(value, np.ndarray) or isinstance(value, np.generic):
        value = value.tolist()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (str, os.PathLike)):
        return json.dumps(os.fspath(value), ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, (int, float)):
        return repr(value)
    if isinstance(value, Mapping):
        return "{ " + ", ".join(_lines(value)) + " }" if value else "{}"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(value_text(item) for item in value) + "]"
    raise InputError("case", f"{value!r} is a {type(value).__name__}", "give text, numbers, truth values, lists or dicts")
