"""Rigid obstacles of simple shapes: gaps and normals at points, for :func:`stiction.rows`."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ._arrays import Reals, reals
from ._errors import InputError
from ._mesh import places

__all__ = ["Cylinder", "Meeting", "Plane", "Sphere"]


class Meeting(NamedTuple):
    """Where points are to an obstacle."""

    gap: Reals
    """``(k,)``, length: the distance from its surface, negative inside the obstacle."""
    normals: Reals
    """``(k, 3)``, of length one: from each point towards the obstacle, as :func:`stiction.rows` takes them."""


class Plane:
    """A half space.

    Parameters
    ----------
    point : array, (3,)
        On its surface.
    normal : array, (3,)
        From the obstacle to the body: (0, 0, 1) of a floor. Any length.

    Examples
    --------
    >>> import stiction
    >>> stiction.Plane([0, 0, 0], [0, 0, 2]).meet([[1, 2, 3]])
    Meeting(gap=array([3.]), normals=array([[-0., -0., -1.]]))
    """

    def __init__(self, point: npt.ArrayLike, normal: npt.ArrayLike) -> None:
        self._point, self._normal = _triple(point, "point"), _direction(normal, "normal")

    def meet(self, points: npt.ArrayLike) -> Meeting:
        """Gap and normal of each of `points`, ``(k, 3)``."""
        at = _finite(points)
        return Meeting((at - self._point) @ self._normal, np.tile(-self._normal, (len(at), 1)))


class Sphere:
    """A ball, or with ``inside=True`` what is around a hollow one.

    Parameters
    ----------
    center : array, (3,)
    radius : float
        Positive.
    inside : bool
        Whether the body is inside.

    Examples
    --------
    >>> import stiction
    >>> stiction.Sphere([0, 0, 0], 2.0).meet([[0, 0, 2.5]]).gap
    array([0.5])
    >>> stiction.Sphere([0, 0, 0], 2.0, inside=True).meet([[0, 0, 1.5]]).normals
    array([[0., 0., 1.]])
    """

    def __init__(self, center: npt.ArrayLike, radius: float, *, inside: bool = False) -> None:
        self._center, self._radius, self._inside = _triple(center, "center"), _positive(radius), inside

    def meet(self, points: npt.ArrayLike) -> Meeting:
        """Gap and normal of each of `points`, ``(k, 3)``, none of which is the centre."""
        return _round(_finite(points) - self._center, self._radius, self._inside, "the centre")


class Cylinder:
    """A round bar without ends, or with ``inside=True`` what is around a bore.

    Parameters
    ----------
    point, axis : array, (3,)
        A point of its axis, and the direction of that, of any length.
    radius : float
        Positive.
    inside : bool
        Whether the body is inside.

    Examples
    --------
    >>> import stiction
    >>> stiction.Cylinder([0, 0, 0], [0, 0, 1], 1.0).meet([[0, 3, 7]]).gap
    array([2.])
    """

    def __init__(self, point: npt.ArrayLike, axis: npt.ArrayLike, radius: float, *, inside: bool = False) -> None:
        self._point, self._axis = _triple(point, "point"), _direction(axis, "axis")
        self._radius, self._inside = _positive(radius), inside

    def meet(self, points: npt.ArrayLike) -> Meeting:
        """Gap and normal of each of `points`, ``(k, 3)``, none of which is on the axis."""
        arm = _finite(points) - self._point
        return _round(arm - np.outer(arm @ self._axis, self._axis), self._radius, self._inside, "the axis")


def _round(arm: Reals, radius: float, inside: bool, middle: str) -> Meeting:
    distance = np.linalg.norm(arm, axis=1)
    bad = np.flatnonzero(distance == 0)
    if len(bad):
        raise InputError("points", f"point {bad[0]} lies on {middle}, where every direction is normal", "leave it out")
    outward = arm / distance[:, None]
    return Meeting(radius - distance, outward) if inside else Meeting(distance - radius, -outward)


def _finite(points: npt.ArrayLike) -> Reals:
    at = places(points)
    if not np.isfinite(at).all():
        raise InputError("points", "they are not all finite", "give finite numbers")
    return at


def _triple(values: npt.ArrayLike, name: str) -> Reals:
    array = reals(values, name)
    if array.shape != (3,) or not np.isfinite(array).all():
        raise InputError(name, f"it is {array}", "give three finite numbers")
    return array


def _direction(values: npt.ArrayLike, name: str) -> Reals:
    array = _triple(values, name)
    length = float(np.linalg.norm(array))
    if length == 0:
        raise InputError(name, "it is zero", "give a direction")
    unit: Reals = array / length
    return unit


def _positive(radius: float) -> float:
    if not 0 < radius < np.inf:
        raise InputError("radius", f"it is {radius}", "give a positive length")
    return float(radius)
