"""Contact problems given as matrices."""

from __future__ import annotations

import difflib
import functools
import inspect
import time
import warnings
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from . import _stiction
from ._arrays import Reals, Whole, compressed, counted, numbers, per_point, reals, sparse, threads_of, vector
from ._errors import InputError, NotCertified
from ._results import Certificate, Progress, Solution, certificate, outward

__all__ = ["Problem"]

Laws = tuple[npt.NDArray[np.uint8], Reals, Reals, Reals]


class Problem:
    """Elastic bodies in contact with dry friction, as matrices.

    Find displacements ``u`` and forces ``lambda`` of the bodies on their counterparts with::

        K u = f - B.T lambda                                   equilibrium
        N u <= gap,  lambda_n >= 0,  lambda_n (gap - N u) = 0  contact: compression is positive
        |lambda_t| <= bound                                    bound = mu lambda_n (Coulomb)
        s = T u - slip_reference;  s != 0  =>  lambda_t = bound s / |s|

    ``N`` and ``T`` are the normal and tangential rows of ``B``. Friction points along the slip because ``lambda`` acts
    on the counterpart. Any consistent units will do: N, mm and MPa, say.

    Parameters
    ----------
    K : sparse or dense matrix, (n, n)
        Stiffness, symmetric, both triangles. CSR and CSC are read as they are (indices of 32 or 64 bits); COO and dense
        matrices are converted. What is kept is a copy of the lower triangle.
        Positive definite on what is not `held`; with `coordinates` bodies may float.
    B : sparse or dense matrix, (3 m, n)
        Jump at ``m`` contact points. By default three rows a point: normal, first and second tangent.
    f : array, (n,)
        Load, force.
    gap : array, (m,), or a number
        Initial distance along the normal, length; negative where the bodies overlap. That of a point all of whose unknowns are
        `held` must not be: nothing could part it.
    mu : array, (m,), or a number
        Coefficient of friction; 0 is no friction.
    tresca : array, (m,), or a number, optional
        Given friction instead of `mu`: the largest tangential force of a point. Points where it is NaN follow `mu`.
    limit : array, (m,), or a number, optional
        Coulomb friction up to this force: ``min(mu lambda_n, limit)``.
    across : array, (m,), or a number, optional
        Friction along the second tangent over that along the first, from 0 to 1.
    bonded : array of bool, (m,), optional
        Points that are tied in all directions.
    cohesion : array, (m,), or a number, optional
        Shear strength of a point where the surfaces touch, force: ``|lambda_t| <= cohesion + mu lambda_n``; not with `limit` or
        `across`.
    tension : array, (m,), or a number, optional
        Its tensile strength, force, at most ``cohesion / mu``: ``lambda_n >= -tension``.
    rows : {"point", "block"}
        Order of the rows of `B`: ``n, t1, t2`` point by point, or all normal rows, then all first, then all second ones.
    slip_reference : array, (m, 2), or Solution, optional
        ``T u`` from which slip is measured: that of the last load step.
    held : array of int or bool, optional
        Unknowns whose displacement is prescribed: their numbers in any order, or a mask ``(n,)``. They are eliminated here.
    values : array, (len(held),), or a number
        Their displacements, length.
    coordinates : array, (nodes, 3), optional
        Of the nodes, length. Allows multigrid, which is faster from some ten thousand unknowns on, and bodies that only
        contact holds. The certificate then has the balance of forces as well.
    dofs : array of int, (nodes, 3), optional
        The unknown of each node along x, y, z; default ``3 * node + direction``. Other orders cost a copy of `K` here.

    Raises
    ------
    InputError
        If sizes do not fit or values cannot be used; place, what and remedy are attributes.

    Examples
    --------
    A node on three springs of 1000 N/mm, pressed on the floor below by 10 N and pulled along it by 4 N:

    >>> import numpy as np, stiction
    >>> K = 1e3 * np.eye(3)
    >>> B = [[0, 0, -1], [1, 0, 0], [0, 1, 0]]                  # -u_z, u_x, u_y
    >>> solution = stiction.Problem(K, B, [4, 0, -10], gap=0, mu=0.3).solve()
    >>> solution.forces.round(6)
    array([[10.,  3.,  0.]])
    >>> solution.u.round(6)
    array([0.001, 0.   , 0.   ])
    """

    def __init__(
        self,
        K: Any,
        B: Any,
        f: npt.ArrayLike,
        gap: npt.ArrayLike,
        mu: npt.ArrayLike = 0.0,
        *,
        tresca: npt.ArrayLike | None = None,
        limit: npt.ArrayLike | None = None,
        across: npt.ArrayLike | None = None,
        bonded: npt.ArrayLike | None = None,
        cohesion: npt.ArrayLike | None = None,
        tension: npt.ArrayLike | None = None,
        rows: str = "point",
        slip_reference: npt.ArrayLike | Solution | None = None,
        held: npt.ArrayLike | None = None,
        values: npt.ArrayLike = 0.0,
        coordinates: npt.ArrayLike | None = None,
        dofs: npt.ArrayLike | None = None,
    ) -> None:
        stiffness = compressed(K, None, "K", True)
        n = stiffness[0]
        if rows not in ("point", "block"):
            raise InputError("rows", f"{rows!r} is no order of the rows of B", 'give "point" or "block"')
        jump = compressed(B, n, "B")
        if jump[0] % 3:
            raise InputError("B", f"it has {jump[0]} rows, no multiple of three", "give n, t1, t2 for each point")
        self._points: int = jump[0] // 3
        self._unknowns: int = n
        load = vector(f, n, "f", " (one an unknown)")
        self._gap = per_point(gap, self._points, "gap")
        self._reference = self._slip_reference(slip_reference)
        given = reals(values, "values")
        if held is None and given.any():
            raise InputError("values", "they belong to `held` unknowns", "give `held` as well")
        held = numbers([] if held is None else held, n, "held")
        given = np.full(len(held), float(given)) if given.ndim == 0 else vector(given, len(held), "values")
        order = np.argsort(held, kind="stable")
        if np.any(np.diff(held[order]) == 0):
            raise InputError("held", "an unknown is named twice", "name each once")
        self._held, self._values, self._given_order = held[order], given[order], np.argsort(order)
        self._free = np.setdiff1d(np.arange(n), held, assume_unique=True)
        self._order, nodes = None, None
        if dofs is not None and coordinates is None:
            raise InputError("dofs", "they belong to coordinates", "give `coordinates` as well")
        if coordinates is not None:
            places, of, direction, self._order = _nodes(coordinates, dofs, n)
            nodes = (places, of, direction)
            if self._order is not None:
                stiffness, jump, load = self._reordered(K, B, load)
        laws, ratio = self._laws(mu, tresca, limit, across, bonded, cohesion, tension)
        self._own = _stiction.Problem(
            stiffness,
            jump,
            load,
            self._gap,
            laws,
            block=rows == "block",
            across=ratio,
            slip_reference=np.ascontiguousarray(self._reference.T).ravel(),
            held=self._inner(self._held)[0],
            values=self._inner(self._held, self._values)[1],
            nodes=nodes,
        )

    @property
    def points(self) -> int:
        """Number of contact points ``m``."""
        return self._points

    @property
    def unknowns(self) -> int:
        """Number of unknowns ``n``, prescribed ones included."""
        return self._unknowns

    def __repr__(self) -> str:
        held = f", {len(self._held)} of them held" if len(self._held) else ""
        return f"<Problem of {self._unknowns} unknowns{held}, {self._points} contact points>"

    def solve(
        self,
        *,
        tolerance: float = 1e-8,
        max_iterations: int = 200,
        method: str = "auto",
        start: npt.ArrayLike | Solution | None = None,
        threads: int | None = None,
        memory_limit: int | None = None,
        check: bool = True,
        progress: Callable[[Progress], object] | None = None,
    ) -> Solution:
        """Solve, and certify the answer.

        The factor or the multigrid hierarchy is kept for further solves, also of problems made by :meth:`with_friction` and
        :meth:`with_load`.

        Parameters
        ----------
        tolerance : float
            What each measure of the certificate is held against; useful from 1e-3 to about 1e-12.
        max_iterations : int
            Newton steps, or a fifth of the multigrid cycles.
        method : {"auto", "dense", "solves", "multigrid"}
            ``auto`` takes the faster by prediction, within memory, and tries another where one fails. ``dense`` and
            ``solves`` factorise `K`; ``multigrid`` needs `coordinates`.
        start : Solution, or forces (m, 3), or displacements (n,)
            Where to begin: forces for a factor, displacements for multigrid. A :class:`Solution` serves both.
        threads : int, optional
            Default one a core. The result does not depend on it.
        memory_limit : int, optional
            Bytes for the factor or the hierarchy; default nine tenths of what is free.
        check : bool
            Whether an answer whose certificate does not pass raises; otherwise it is returned.
        progress : callable, optional
            Called with a :class:`Progress` at each phase and iteration, in the thread that called. ``False`` stops the
            solve; an exception ends it and comes through.

        Raises
        ------
        NotCertified
            If the certificate does not pass; the answer is its ``result``.
        InputError
            If an argument cannot be used or `K` is not positive definite; :class:`TooLarge` if memory does not suffice.
        KeyboardInterrupt
            Signals are heard while the solver works, without the GIL.

        Warns
        -----
        UserWarning
            If no contact point touches: normals may be the wrong way round.
        """
        forces, displacements = self._start(start, method)
        begin = time.perf_counter()
        found = self._own.solve(
            tolerance=float(tolerance),
            max_iterations=counted("max_iterations", max_iterations),
            method=method,
            memory_limit=None if memory_limit is None else counted("memory_limit", memory_limit),
            forces=forces,
            u=displacements,
            threads=threads_of(threads),
            hear=None if progress is None else lambda *event: progress(Progress(*event)) is not False,
        )
        seconds = time.perf_counter() - begin
        u, matrices, why = self._outer(found.pop("u")), found.pop("matrices"), found.pop("why")
        solution = Solution(
            **{**found, "certificate": certificate(found["certificate"])},
            u=u,
            jump=found["slip"] + self._reference,
            reactions=self._reactions(u, found["forces"]),
            seconds=seconds,
            _linear=(matrices, *self._own_unknowns()),
        )
        if check and not solution.solved:
            raise NotCertified(f"{why or _why(solution.status)}: {solution.certificate!r}", solution)
        if solution.solved and self._points and not (solution.state.any() or solution.forces.any()):
            warnings.warn(_ALL_OPEN.format(self._points), stacklevel=2)
        return solution

    def check(
        self, u: npt.ArrayLike, forces: npt.ArrayLike, *, tolerance: float = 1e-8, threads: int | None = None
    ) -> Certificate:
        """Judge displacements and contact forces, wherever they come from.

        Parameters
        ----------
        u : array, (n,)
            Displacements, prescribed ones included.
        forces : array, (m, 3)
            Force of the body on its counterpart at each point: normal (compression positive), then both tangents.
        tolerance : float
            What each measure is held against.
        """
        u = vector(u, self._unknowns, "u", " (one an unknown)")
        forces = self._by_point(forces, 3, "forces")
        off = np.abs(u[self._held] - self._values)
        if len(off) and off.max() > tolerance * np.abs(u).max():
            worst = int(off.argmax())
            what = f"u[{self._held[worst]}] is {u[self._held[worst]]:g} where {self._values[worst]:g} is prescribed"
            raise InputError("u", what, "judge it by a problem with the same `values`")
        return certificate(self._own.check(self._free_part(u), forces, float(tolerance), threads_of(threads)))

    def constraints(self, solution: Solution) -> Any:
        """What contact ties in a state: rows ``C`` with ``C v = 0`` for small motions ``v`` about it; needs SciPy.

        Points in contact are tied along the normal, sticking ones along both tangents as well; sliding ones keep their
        friction. :meth:`Solution.tangent` eliminates them.

        Returns
        -------
        scipy.sparse.csr_array, (c, n)
            All normal rows first, then the first and the second tangential ones. Columns of `held` are empty: there ``v`` is
            zero.
        """
        return sparse(self._own.tied(solution.state)) @ outward(*self._own_unknowns()).T

    def _own_unknowns(self) -> tuple[Whole, int]:
        """Those of the compiled module, which are not held, among all, and how many these are."""
        mask = np.ones(self._unknowns, dtype=bool)
        mask[self._inner_of(self._held)] = False
        return np.flatnonzero(mask) if self._order is None else self._order[mask], self._unknowns

    def with_friction(
        self,
        mu: npt.ArrayLike = 0.0,
        *,
        tresca: npt.ArrayLike | None = None,
        limit: npt.ArrayLike | None = None,
        across: npt.ArrayLike | None = None,
        bonded: npt.ArrayLike | None = None,
        cohesion: npt.ArrayLike | None = None,
        tension: npt.ArrayLike | None = None,
    ) -> Problem:
        """The same problem with other friction; arguments as of :class:`Problem`. Matrices and factor are shared."""
        return self._varied(laws=self._laws(mu, tresca, limit, across, bonded, cohesion, tension))

    def with_load(
        self,
        f: npt.ArrayLike | None = None,
        *,
        gap: npt.ArrayLike | None = None,
        slip_reference: npt.ArrayLike | Solution | None = None,
    ) -> Problem:
        """The same problem with other load, gap or slip reference; what is not given stays.

        A next load step is ``problem.with_load(f, slip_reference=solution)``. Matrices and factor are shared.
        """
        return self._varied(
            load=None if f is None else vector(f, self._unknowns, "f", " (one an unknown)"),
            gap=None if gap is None else per_point(gap, self._points, "gap"),
            reference=None if slip_reference is None else self._slip_reference(slip_reference),
        )

    def _varied(
        self,
        laws: tuple[Laws, Reals | None] | None = None,
        load: Reals | None = None,
        gap: Reals | None = None,
        reference: Reals | None = None,
    ) -> Problem:
        other = Problem.__new__(Problem)
        other.__dict__.update(self.__dict__)
        other._gap = self._gap if gap is None else gap
        other._reference = self._reference if reference is None else reference
        if load is not None and self._order is not None:
            load = load[self._order]
        held = self._inner(self._held)[0]
        other._own = self._own.varied(
            friction=None if laws is None else laws[0],
            across=None if laws is None else laws[1],
            f=load,
            gap=other._gap,
            slip_reference=np.ascontiguousarray(other._reference.T).ravel(),
            free=np.setdiff1d(np.arange(self._unknowns), held, assume_unique=True),
            held=held,
        )
        return other

    def _laws(
        self,
        mu: npt.ArrayLike,
        tresca: npt.ArrayLike | None,
        limit: npt.ArrayLike | None,
        across: npt.ArrayLike | None,
        bonded: npt.ArrayLike | None,
        cohesion: npt.ArrayLike | None,
        tension: npt.ArrayLike | None,
    ) -> tuple[Laws, Reals | None]:
        m = self._points
        value = per_point(mu, m, "mu")
        if tension is not None and cohesion is None:
            raise InputError("tension", "it belongs to cohesion", "give `cohesion` as well")
        if cohesion is not None and (limit is not None or across is not None):
            other = "limit" if limit is not None else "across"
            raise InputError("cohesion", f"it does not go with `{other}`", "give one of the two")
        for name, numbers in (("mu", value), ("limit", limit), ("cohesion", cohesion), ("tension", tension)):
            all_points = per_point(0.0 if numbers is None else numbers, m, name)
            bad = np.flatnonzero(~(all_points >= 0))
            if len(bad):
                what = f"it is {all_points[bad[0]]:g} at point {bad[0]}"
                raise InputError(name, what, "friction is at least zero")
        code = np.where(value > 0, 1, 0).astype(np.uint8)
        limits = np.zeros(m)
        if limit is not None:
            limits = per_point(limit, m, "limit")
            code[code == 1] = 3
        tensions = per_point(0.0 if tension is None else tension, m, "tension")
        if cohesion is not None:
            limits = per_point(cohesion, m, "cohesion")
            code[:] = 5
        if tresca is not None:
            bound = per_point(tresca, m, "tresca")
            given = ~np.isnan(bound)
            code[given] = 2
            value = np.where(given, bound, value)
        if bonded is not None:
            mask = np.asarray(bonded)
            if mask.shape != (m,) or mask.dtype != np.bool_:
                what = f"it has type {mask.dtype} and shape {mask.shape}"
                raise InputError("bonded", what, f"give a mask of {m} points")
            code[mask] = 4
        return (code, value, limits, tensions), None if across is None else per_point(across, m, "across")

    def _slip_reference(self, given: npt.ArrayLike | Solution | None) -> Reals:
        if given is None:
            return np.zeros((self._points, 2))
        return self._by_point(given.jump if isinstance(given, Solution) else given, 2, "slip_reference")

    def _by_point(self, data: npt.ArrayLike, components: int, name: str) -> Reals:
        array = reals(data, name)
        if array.shape != (self._points, components):
            what = f"its shape is {array.shape} where {(self._points, components)} is needed"
            raise InputError(name, what, f"give {components} numbers for each of the {self._points} points")
        return array

    def _start(self, start: npt.ArrayLike | Solution | None, method: str) -> tuple[Reals | None, Reals | None]:
        if start is None:
            return None, None
        if isinstance(start, Solution):
            forces = self._by_point(start.forces, 3, "start")
            u = self._free_part(vector(start.u, self._unknowns, "start"))
            return (None if method == "multigrid" else forces), (None if method in ("dense", "solves") else u)
        array = reals(start, "start")
        if array.ndim == 2:
            return self._by_point(array, 3, "start"), None
        return None, self._free_part(vector(array, self._unknowns, "start"))

    def _reactions(self, u: Reals, forces: Reals) -> Reals:
        if not len(self._held):
            return np.zeros(0)
        inner = self._own.reactions(self._free_part(u), forces)
        # The compiled module has them by ascending inner number.
        by_number = np.empty(self._unknowns)
        by_number[np.sort(self._inner(self._held)[0])] = inner
        return by_number[self._inner_of(self._held)][self._given_order]

    def _inner_of(self, places: Whole) -> Whole:
        if self._order is None:
            return places
        inverse = np.empty_like(self._order)
        inverse[self._order] = np.arange(len(self._order))
        return inverse[places]

    def _inner(self, places: Whole, values: Reals | None = None) -> tuple[Whole, Reals]:
        """Places in the order of the compiled module, ascending, with their values."""
        inner = self._inner_of(places)
        order = np.argsort(inner)
        return np.ascontiguousarray(inner[order]), np.zeros(0) if values is None else np.ascontiguousarray(values[order])

    def _free_part(self, u: Reals) -> Reals:
        inner = u if self._order is None else u[self._order]
        free = np.ones(self._unknowns, dtype=bool)
        free[self._inner_of(self._held)] = False
        return np.ascontiguousarray(inner[free])

    def _outer(self, free: Reals) -> Reals:
        inner = np.empty(self._unknowns)
        mask = np.ones(self._unknowns, dtype=bool)
        mask[self._inner_of(self._held)] = False
        inner[mask] = free
        u = inner
        if self._order is not None:
            u = np.empty(self._unknowns)
            u[self._order] = inner
        u[self._held] = self._values
        return u

    def _reordered(self, K: Any, B: Any, load: Reals) -> tuple[Any, Any, Reals]:
        """Matrices and load with the unknowns node by node."""
        order = self._order
        sparse = [matrix.tocsr() if hasattr(matrix, "tocsr") else matrix for matrix in (K, B)]
        if any(isinstance(matrix, tuple) for matrix in sparse):
            raise InputError("dofs", "the order of the unknowns is not node by node", "give K and B as scipy matrices")
        stiffness, jump = (matrix if hasattr(matrix, "tocsr") else reals(matrix, "") for matrix in sparse)
        stiffness = compressed(stiffness[order][:, order], None, "K", True)
        return stiffness, compressed(jump[:, order], self._unknowns, "B"), load[order]


def _nodes(coordinates: npt.ArrayLike, dofs: npt.ArrayLike | None, n: int) -> tuple[Any, Any, Any, Whole | None]:
    """Coordinates, the node and the direction of each unknown, and the order node by node where it is another."""
    places = reals(coordinates, "coordinates")
    if places.ndim != 2 or places.shape[1] != 3:
        raise InputError("coordinates", f"their shape is {places.shape}", "give x, y, z of each node: (nodes, 3)")
    if not np.isfinite(places).all():
        raise InputError("coordinates", "they are not all finite", "give finite numbers")
    nodes = len(places)
    if 3 * nodes != n:
        what = f"{nodes} nodes have {3 * nodes} unknowns, and K has {n}"
        raise InputError("coordinates", what, "give all nodes, prescribed ones as `held`")
    of, direction = np.divmod(np.arange(n), 3)
    order: Whole | None = None
    if dofs is not None:
        table = np.asarray(dofs)
        if table.shape != (nodes, 3) or table.dtype.kind not in "iu":
            what = f"it has type {table.dtype} and shape {table.shape}"
            raise InputError("dofs", what, f"give the unknowns of each node: ({nodes}, 3)")
        order = table.astype(np.int64).ravel()
        if not np.array_equal(np.sort(order), np.arange(n)):
            raise InputError("dofs", "they do not name each unknown once", "give each unknown one node and direction")
        order = None if np.array_equal(order, np.arange(n)) else order
    return places, of.astype(np.int64), direction.astype(np.uint8), order


_ALL_OPEN = (
    "none of {} contact points touches its counterpart; if the bodies should touch, see whether the normals point from the "
    "body into its counterpart, and whether the gaps are right"
)

#: What others call the arguments of :class:`Problem`.
_OTHER_NAMES = {
    "mu": ("friction", "coulomb", "coefficient", "friction_coefficient", "f_c"),
    "tresca": ("bound", "slip_bound", "given_friction"),
    "f": ("load", "loads", "force", "forces", "rhs", "b", "F"),
    "K": ("k", "stiffness", "A"),
    "B": ("jump", "contact", "jacobian"),
    "gap": ("gaps", "g", "distance"),
    "held": ("fixed", "dirichlet", "prescribed", "bc", "clamped", "supports"),
    "values": ("displacements", "prescribed_values"),
    "coordinates": ("nodes", "points", "coords", "x"),
    "bonded": ("tied",),
    "slip_reference": ("start", "previous"),
}


def _hinting(function: Callable[..., None]) -> Callable[..., None]:
    """The same with the argument that was meant where a name is unknown."""
    known = list(inspect.signature(function).parameters)[1:]

    @functools.wraps(function)
    def called(self: Any, *args: Any, **named: Any) -> None:
        for name in named:
            if name not in known:
                meant = [ours for ours, theirs in _OTHER_NAMES.items() if name in theirs]
                meant = meant or difflib.get_close_matches(name, known, 1)
                hint = f"; did you mean `{meant[0]}`?" if meant else f"; there are {', '.join(known)}"
                raise TypeError(f"Problem has no argument `{name}`{hint}")
        function(self, *args, **named)

    return called


if not TYPE_CHECKING:
    Problem.__init__ = _hinting(Problem.__init__)


def _why(status: str) -> str:
    return {
        "max_iterations": "the limit of iterations was reached",
        "stalled": "no method gains on the residual any more",
        "no_equilibrium": "no contact forces balance the loads on a body that floats",
        "interrupted": "the solve was stopped",
    }.get(status, "the certificate does not pass")
