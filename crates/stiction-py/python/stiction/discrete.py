"""Discrete contact problems with Coulomb friction, given as matrices (those of the collection FCLib).

``m`` points of ``d`` components (3, or 2 in the plane), point by point: the normal one first, then the tangential ones::

    u = W r + q                       velocities of the points by their impulses
    0 <= u_n  perp  r_n >= 0,   |r_t| <= mu r_n,   u_t != 0  =>  r_t = -mu r_n u_t / |u_t|

or with the velocities ``v`` of the bodies as unknowns::

    M v = H r + f,   u = H.T v + w

``r`` acts on the body, so that friction points against the slip velocity. Any consistent units will do.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from . import _stiction
from ._arrays import Reals, compressed, counted, per_point, reals, threads_of, vector
from ._errors import InputError, NotCertified
from ._results import Certificate

__all__ = ["Problem", "Progress", "Solution", "matched", "read", "solve"]


class Progress(NamedTuple):
    """Handed to ``progress`` at each iteration."""

    iteration: int
    """Its number: proximal steps, or rounds of the other methods."""
    residual: float
    """The largest of the measures."""
    newton_steps: int
    """So far."""


@dataclass(frozen=True, repr=False, eq=False)
class Solution:
    """Impulses and velocities with their measures."""

    status: str
    """``solved``; otherwise ``max_iterations``, ``stalled``, ``rounding``, ``inaccurate`` or ``interrupted``."""
    r: Reals
    """Impulses on the body, shape ``(m, d)``."""
    u: Reals
    """Velocities of the points, shape ``(m, d)``."""
    v: Reals
    """Velocities of the bodies, shape ``(n,)``; empty for a problem in ``W``."""
    l: Reals  # noqa: E741
    """Impulses of bilateral constraints."""
    certificate: Certificate
    """Each measure beside the tolerance."""
    counts: dict[str, int]
    """What it cost: iterations, newton_steps, sweeps, gradients, alternations."""
    history: Reals
    """One row an iteration: number, largest measure, parameter of the method, Newton steps."""
    seconds: float
    """Wall time."""

    @property
    def solved(self) -> bool:
        """Whether all measures are at most the tolerance."""
        return self.certificate.passed

    def __repr__(self) -> str:
        certificate = repr(self.certificate)[1:-1].replace("Certificate", "certificate")
        return f"<Solution {self.status} after {self.counts['iterations']} iterations, {len(self.r)} points; {certificate}>"


class Problem:
    """A discrete problem, from matrices or from a file; see :func:`solve` for the arguments.

    Keep one to solve it again from other starts or by other methods.
    """

    def __init__(
        self,
        *,
        W: Any = None,
        q: npt.ArrayLike | None = None,
        M: Any = None,
        H: Any = None,
        f: npt.ArrayLike | None = None,
        w: npt.ArrayLike | None = None,
        mu: npt.ArrayLike,
        dimension: int = 3,
    ) -> None:
        if dimension not in (2, 3):
            raise InputError("dimension", f"it is {dimension}", "points have 2 or 3 components")
        local, bodies = {"W": W, "q": q}, {"M": M, "H": H, "f": f}
        missing = [
            [name for name, value in form.items() if value is None] for form in (local, bodies)
        ]
        if len(missing[0]) < len(local) and (len(missing[1]) < len(bodies) or w is not None):
            raise InputError("W", "matrices of both forms are given", "give W and q, or M, H, f and w")
        if all(missing):
            names = " and ".join(missing[0] if len(missing[0]) < len(local) else missing[1])
            raise InputError(names, "missing", "give W and q, or M, H, f and w")
        if not missing[0]:
            offset = reals(q, "q")
            size = offset.size
            self._own = _stiction.Discrete.local(
                compressed(W, size, "W"), vector(offset, size, "q"), _coefficients(mu, size, dimension), dimension, None
            )
            return
        load = reals(f, "f")
        matrix = compressed(H, None, "H")
        size = matrix[1]
        self._own = _stiction.Discrete.global_(
            compressed(M, load.size, "M"),
            matrix,
            vector(load, load.size, "f"),
            np.zeros(size) if w is None else vector(w, size, "w"),
            _coefficients(mu, size, dimension),
            dimension,
            None,
        )

    @property
    def points(self) -> int:
        """Number of points ``m``."""
        return self._own.points

    @property
    def dimension(self) -> int:
        """Components of a point, 2 or 3."""
        return self._own.dimension

    @property
    def data(self) -> dict[str, Any]:
        """Arrays and matrices by FCLib's names; matrices as SciPy's ``csr_array``. What a file calls a solution beside them."""
        from scipy.sparse import csr_array

        def made(value: Any) -> Any:
            if not isinstance(value, tuple):
                return value
            rows, columns, start, column, data = value
            return csr_array((data, column, start), shape=(rows, columns))

        return {name: made(value) for name, value in self._own.data().items()}

    def __repr__(self) -> str:
        return f"<discrete Problem of {self.points} points with {self.dimension} components>"

    def solve(
        self,
        *,
        tolerance: float = 1e-8,
        max_iterations: int = 1000,
        method: str = "auto",
        form: str = "auto",
        start: npt.ArrayLike | Solution | None = None,
        threads: int | None = None,
        check: bool = True,
        progress: Callable[[Progress], object] | None = None,
    ) -> Solution:
        """As :func:`solve`."""
        given = start.r if isinstance(start, Solution) else start
        begin = time.perf_counter()
        found = self._own.solve(
            tolerance=float(tolerance),
            max_iterations=counted("max_iterations", max_iterations),
            method=method,
            form=form,
            start=None if given is None else reals(given, "start").ravel(),
            threads=threads_of(threads),
            hear=None if progress is None else lambda *event: progress(Progress(*event)) is not False,
        )
        measures = dict(found.pop("measures")) | {"equilibrium": found.pop("equilibrium")}
        judged = Certificate(measures, max(measures.values()), found.pop("tolerance"), found.pop("passed"))
        solution = Solution(**found, certificate=judged, seconds=time.perf_counter() - begin)
        if check and not solution.solved:
            raise NotCertified(f"{solution.status}: {judged!r}", solution)
        return solution


def solve(
    *,
    W: Any = None,
    q: npt.ArrayLike | None = None,
    M: Any = None,
    H: Any = None,
    f: npt.ArrayLike | None = None,
    w: npt.ArrayLike | None = None,
    mu: npt.ArrayLike,
    dimension: int = 3,
    tolerance: float = 1e-8,
    max_iterations: int = 1000,
    method: str = "auto",
    form: str = "auto",
    start: npt.ArrayLike | Solution | None = None,
    threads: int | None = None,
    check: bool = True,
    progress: Callable[[Progress], object] | None = None,
) -> Solution:
    """Solve a discrete problem, given by `W` and `q`, or by `M`, `H`, `f` and `w`.

    Parameters
    ----------
    W : sparse or dense matrix, (d m, d m)
        Velocity per impulse; may be singular and not quite symmetric.
    q : array, (d m,)
        Relative velocity without contact.
    M : sparse or dense matrix, (n, n)
        Mass or stiffness, regular.
    H : sparse or dense matrix, (n, d m)
        Directions of the impulses.
    f : array, (n,)
        Impulses from outside.
    w : array, (d m,), optional
        Velocity of the points beside that of the bodies; default zero.
    mu : array, (m,), or a number
        Coefficient of friction, at least zero.
    dimension : {3, 2}
        Components ``d`` of a point.
    tolerance : float
        What each measure is held against; useful from 1e-3 to about 1e-12.
    max_iterations : int
        Proximal steps; methods without them take up to ten rounds of ten steps for each.
    method : {"auto", "newton", "gauss-seidel", "gradient", "admm"}
    form : {"auto", "condensed", "sparse"}
        Whether the velocities of bodies are eliminated.
    start : Solution, or array (m, d), optional
        Impulses to begin with, those of the last time step, say.
    threads, check, progress :
        As of :meth:`stiction.Problem.solve`.

    Raises
    ------
    InputError
        If the problem cannot be posed.
    NotCertified
        If a measure exceeds the tolerance; the answer is its ``result``.

    Examples
    --------
    A block of mass one falls on a table with velocity 2 and slides along it with velocity 3:

    >>> import numpy as np
    >>> from stiction import discrete
    >>> solution = discrete.solve(W=np.eye(3), q=[-2, 3, 0], mu=0.5)
    >>> solution.r.round(6) + 0.0
    array([[ 2., -1.,  0.]])
    >>> solution.u.round(6) + 0.0
    array([[0., 2., 0.]])
    """
    problem = Problem(W=W, q=q, M=M, H=H, f=f, w=w, mu=mu, dimension=dimension)
    return problem.solve(
        tolerance=tolerance,
        max_iterations=max_iterations,
        method=method,
        form=form,
        start=start,
        threads=threads,
        check=check,
        progress=progress,
    )


def matched(r: npt.ArrayLike, before: npt.ArrayLike, now: npt.ArrayLike) -> Reals:
    """Impulses of the last time step as a start of the next, whose contacts may be others.

    Parameters
    ----------
    r : array, (m, d)
        Impulses of the last step.
    before : array, (m,)
        A name of each of its contacts: whole numbers or texts, each once.
    now : array, (k,)
        The names of the contacts of the next step, each once.

    Returns
    -------
    array, (k, d)
        The impulses of contacts that both steps have, zero for new ones.

    Raises
    ------
    InputError
        If `before` has not one name for each row of `r`, or a name occurs twice.

    Examples
    --------
    >>> from stiction import discrete
    >>> discrete.matched([[2.0, 1.0], [3.0, 0.0]], [7, 9], [9, 4])
    array([[3., 0.],
           [0., 0.]])
    """
    old = reals(r, "r")
    names, wanted = np.asarray(before), np.asarray(now)
    if old.ndim != 2 or names.shape != old.shape[:1]:
        what = f"its shape is {names.shape} where r has the shape {old.shape}"
        raise InputError("before", what, "give the name of the contact of each row of r")
    for name, given in (("before", names), ("now", wanted)):
        if len(np.unique(given)) < given.size or given.ndim != 1:
            raise InputError(name, "a contact is named twice", "give a list of names, each once")
    start = np.zeros((len(wanted), old.shape[1]))
    _, here, there = np.intersect1d(wanted, names, return_indices=True)
    start[here] = old[there]
    return start


def read(path: str | os.PathLike[str]) -> Problem:
    """Read a problem: a file of FCLib (``.hdf5``), a NumPy file (``.npz``) or a folder of Matrix Market files.

    A solve without a start begins with the best of the guesses in the file.
    """
    problem = Problem.__new__(Problem)
    problem._own = _stiction.Discrete.read(os.fspath(path))
    return problem


def _coefficients(mu: npt.ArrayLike, size: int, dimension: int) -> Reals:
    if size % dimension:
        what = f"{size} velocities are no multiple of {dimension}"
        raise InputError("dimension", what, "give all components of each point")
    return per_point(mu, size // dimension, "mu")
