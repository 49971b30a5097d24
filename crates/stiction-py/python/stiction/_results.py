"""What a solve returns."""

from __future__ import annotations

import sys
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _stiction
from ._arrays import Reals, sparse
from ._errors import InputError

__all__ = ["Certificate", "Progress", "Solution", "Tangent"]


class Progress(NamedTuple):
    """What a solver is doing; handed to ``progress`` at each phase and iteration."""

    phase: str
    """``set-up``, ``ordering``, ``factorisation``, ``solving``, or the kind of iteration (``newton``,
    ``multigrid`` ..); of a case also ``step``, ``step halved``, ``step finished``, ``mesh`` (one is solved),
    ``uniqueness``, ``other starts``."""
    iteration: int
    """Number of the iteration, or of the mesh; 0 outside iterations."""
    residual: float
    """Relative residual; of a mesh its estimated error; not a number outside iterations."""
    open: int
    """Points that are open."""
    stick: int
    """Points that stick."""
    slip: int
    """Points that slip."""
    seconds: float
    """Since the start of the solve."""
    step: int = 0
    """Load step of a case, from 1."""
    t: float = 0.0
    """Time at its end."""


def size(measure: float) -> str:
    """Two digits. Where answer and data hold nothing to count an error in, the measure is the largest number there is."""
    return f"{measure:.2g}" if measure < sys.float_info.max else "beyond all bounds"


@dataclass(frozen=True, repr=False)
class Certificate:
    """How far an answer is from solving its problem, recomputed from the data by code that shares nothing with the solvers.

    All measures are dimensionless and do not change with the units.
    """

    measures: dict[str, float]
    """Each measure by its name: equilibrium, penetration, tension, cone, slip_direction, bipotential_gap,
    natural_residual; with supports also force_balance and moment_balance."""
    worst: float
    """The largest measure."""
    tolerance: float
    """What each of them is held against."""
    passed: bool
    """Whether ``worst <= tolerance``, and no part exceeds ``part_tolerance``."""
    parts: list[tuple[str, str, float]] = field(default_factory=list)
    """Each body and each pair by its own forces: ``("pair", name, residual)``."""
    part_tolerance: float = 1e-6
    """What each part is held against."""
    error_bound: float | None = None
    """For given friction: a bound of half the squared error in energy."""

    def __repr__(self) -> str:
        name = max(self.measures, key=lambda name: self.measures[name], default="nothing")
        verdict, sign = ("passed", "<=") if self.worst <= self.tolerance else ("not passed", ">")
        if sign == "<=" and not self.passed:
            kind, name, residual = max(self.parts, key=lambda part: part[2], default=("part", "", float("nan")))
            return f"<Certificate not passed: {kind} {name!r} {size(residual)} > {self.part_tolerance:g}>"
        return f"<Certificate {verdict}: {name} {size(self.worst)} {sign} {self.tolerance:g}>"

    def __str__(self) -> str:
        lines = [f"certificate {'passed' if self.passed else 'not passed'}, each measure against {self.tolerance:g}"]
        width = max(map(len, self.measures), default=0)
        for name, value in self.measures.items():
            number = f"{value:9.2e}" if value < sys.float_info.max else size(value)
            lines.append(f"  {name:<{width}}  {number}{'' if value <= self.tolerance else '  too large'}")
        for kind, name, residual in self.parts:
            if residual > self.part_tolerance:
                number = f"{residual:.2e}" if residual < sys.float_info.max else size(residual)
                lines.append(f"  {kind} {name!r} by its own forces: {number} > {self.part_tolerance:g}")
        return "\n".join(lines)


class Tangent(NamedTuple):
    """Small motions about a state of contact: points that stick are tied, those that slide are tied along the normal and move
    along their tangents without more friction, open ones are free. Prescribed displacements stay.

    A symmetric model, right as long as no point changes its state. That friction of sliding points follows the normal force
    is not in it.
    """

    K: Any
    """Stiffness of these motions, ``free.T @ K @ free``, symmetric: ``scipy.sparse.csr_array``, ``(k, k)``."""
    free: Any
    """The motions, one a column: ``scipy.sparse.csr_array``, ``(n, k)``. ``free @ x`` are displacements, ``free.T @ f`` a load,
    ``free.T @ M @ free`` the mass matrix that belongs to `K`."""


def tangent(own: _stiction.Matrices, seen: Any) -> Tangent:
    """By the motions of the unknowns that are not held; `seen` says what these are among all displacements."""
    motions = sparse(own.free())
    reduced = motions.T @ sparse(own.stiffness()) @ motions
    return Tangent((0.5 * (reduced + reduced.T)).tocsr(), (seen @ motions).tocsr())


def outward(places: npt.NDArray[np.int64], count: int) -> Any:
    """The places of some numbers among `count`, as a matrix of zeros and ones."""
    from scipy.sparse import csr_array

    return csr_array((np.ones(len(places)), (places, np.arange(len(places)))), shape=(count, len(places)))


@dataclass(frozen=True, repr=False, eq=False)
class Solution:
    """Displacements and contact forces with their certificate. ``m`` contact points, ``n`` unknowns."""

    status: str
    """``solved``; otherwise ``max_iterations``, ``stalled``, ``no_equilibrium`` or ``interrupted``."""
    u: Reals
    """Displacements, shape ``(n,)``, length; prescribed ones included."""
    forces: Reals
    """Force of the body on its counterpart, shape ``(m, 3)``: normal (compression positive), then along both tangents."""
    slip: Reals
    """``T u - slip_reference``, shape ``(m, 2)``, length; friction points along it."""
    gap: Reals
    """``gap - N u``, shape ``(m,)``, length; zero in contact."""
    state: npt.NDArray[np.uint8]
    """Shape ``(m,)``: 0 open, 1 stick, 2 slip."""
    jump: Reals
    """``T u``, shape ``(m, 2)``, length: the slip reference of a next load step."""
    reactions: Reals
    """Forces of the supports on the body, shape ``(len(held),)``: one for each unknown of ``held`` in the order given there;
    of a mask, by ascending unknown. Without ``held`` there are none."""
    certificate: Certificate
    """How far this is from a solution."""
    method: str
    """How it was found: ``dense``, ``solves`` or ``multigrid``."""
    counts: dict[str, int]
    """What it cost: newton_steps, restarts, fixed_point_steps, products, solves, cycles."""
    history: Reals
    """One row an iteration: number, relative residual, products, points open, that stick, that slip."""
    seconds: float
    """Wall time of the solve."""
    _linear: tuple[_stiction.Matrices, npt.NDArray[np.int64], int] | None = None

    @property
    def solved(self) -> bool:
        """Whether the certificate passes."""
        return self.status == "solved"

    def __repr__(self) -> str:
        counts = np.bincount(self.state, minlength=3)
        states = ", ".join(f"{count} {name}" for count, name in zip(counts, ("open", "stick", "slip"), strict=False))
        certificate = repr(self.certificate)[1:-1].replace("Certificate", "certificate")
        steps = max(self.counts.get("newton_steps", 0), self.counts.get("cycles", 0))
        return f"<Solution {self.status} after {steps} iterations ({self.method}): {states}; {certificate}>"

    def tangent(self) -> Tangent:
        """Stiffness and motions of the bodies in this state of contact, for modes and responses; needs SciPy.

        With a mass matrix ``M`` of all unknowns ``scipy.sparse.linalg.eigsh(K, k, M=free.T @ M @ free, sigma=0)`` gives squared
        angular frequencies of the joint as it is.

        Examples
        --------
        Of a node that is pressed on the floor and slides, the motion along the normal is tied:

        >>> import numpy as np, stiction
        >>> B = [[0, 0, -1], [1, 0, 0], [0, 1, 0]]
        >>> K, free = stiction.Problem(1e3 * np.eye(3), B, [4, 0, -10], gap=0, mu=0.3).solve().tangent()
        >>> K.toarray()
        array([[1000.,    0.],
               [   0., 1000.]])
        >>> free.toarray()
        array([[1., 0.],
               [0., 1.],
               [0., 0.]])
        """
        if self._linear is None:
            raise InputError("tangent", "a solution that was pickled has no matrices", "ask where it was solved")
        own, places, count = self._linear
        return tangent(own, outward(places, count))

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_linear": None}


def certificate(data: dict[str, Any]) -> Certificate:
    """From what the compiled module returns."""
    return Certificate(**{**data, "measures": dict(data["measures"])})
