"""From what users have to the arrays the compiled module takes."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ._errors import InputError

Reals = np.ndarray[tuple[Any, ...], np.dtype[np.float64]]
Whole = np.ndarray[tuple[Any, ...], np.dtype[np.int64]]
#: Rows, columns, indptr, indices, data.
Rows = tuple[int, int, npt.NDArray[Any], npt.NDArray[Any], Reals]


def reals(data: Any, name: str) -> Reals:
    """As contiguous float64; a copy only where it is something else."""
    try:
        array = np.asarray(data)
    except ValueError as error:
        raise InputError(name, f"it is no array ({error})", "give an array of numbers") from None
    if array.dtype.kind not in "fiub":
        raise InputError(name, f"its numbers are of type {array.dtype}", "give real numbers")
    # Not `ascontiguousarray`, which makes an array of a number.
    return np.require(array, np.float64, ["C", "A"])


def vector(data: Any, length: int, name: str, meaning: str = "") -> Reals:
    """An array of so many numbers."""
    array = reals(data, name)
    if array.shape != (length,):
        raise InputError(name, f"its shape is {array.shape} where ({length},) is needed{meaning}", "give one number each")
    return array


def per_point(data: Any, points: int, name: str) -> Reals:
    """A number for all points, or one each."""
    array = reals(data, name)
    return np.full(points, float(array)) if array.ndim == 0 else vector(array, points, name, " (one a point)")


def compressed(matrix: Any, columns: int | None, name: str, symmetric: bool = False) -> Rows:
    """A matrix by compressed rows: SciPy's, `(data, indices, indptr)`, or dense."""
    if hasattr(matrix, "B") and hasattr(matrix, "normals"):
        raise InputError(name, f"it is all of a {type(matrix).__name__}", "give its matrix: rows.B")
    if hasattr(matrix, "tocsr"):
        # The columns of a symmetric matrix are its rows.
        own: Any = matrix if symmetric and matrix.format == "csc" else matrix.tocsr()
        if not own.has_canonical_format:
            own = own.copy()
            own.sum_duplicates()
        shape, start, column, data = own.shape, own.indptr, own.indices, own.data
    elif isinstance(matrix, tuple):
        if len(matrix) != 3:
            raise InputError(name, f"it is a tuple of {len(matrix)}", "give (data, indices, indptr) by rows")
        data, column, start = (np.asarray(part) for part in matrix)
        shape = (len(start) - 1, len(start) - 1 if columns is None else columns)
    else:
        dense = reals(matrix, name)
        if dense.ndim != 2:
            raise InputError(name, f"it has {dense.ndim} dimensions", "give a matrix: scipy.sparse or a dense array")
        shape = dense.shape
        at, column = np.nonzero(dense)
        start = np.concatenate([[0], np.cumsum(np.bincount(at, minlength=shape[0]))])
        data = dense[at, column]
    if columns is not None and shape[1] != columns:
        raise InputError(name, f"it has {shape[1]} columns where {columns} are needed", "give one column an unknown")
    data = reals(data, name)
    return int(shape[0]), int(shape[1]), index(start, name), index(column, name), data


def sparse(rows: Rows) -> Any:
    """A ``scipy.sparse.csr_array``; needs SciPy."""
    from scipy.sparse import csr_array

    count, columns, start, column, data = rows
    return csr_array((data, column, start), shape=(count, columns))


def index(data: Any, name: str) -> npt.NDArray[Any]:
    """Indices of 32 or 64 bits as they are, others as 64."""
    array = np.asarray(data)
    if array.dtype.kind not in "iu":
        raise InputError(name, f"its indices are of type {array.dtype}", "give whole numbers")
    return np.require(array, array.dtype if array.dtype in (np.int32, np.int64) else np.int64, ["C", "A"])


def numbers(data: Any, count: int, name: str, what: str = "unknown") -> Whole:
    """Numbers of unknowns or nodes; a mask of all will do."""
    array = np.asarray(data)
    if array.dtype == np.bool_:
        if array.shape != (count,):
            raise InputError(name, f"the mask has the shape {array.shape} where ({count},) is needed", f"mask all {what}s")
        array = np.flatnonzero(array)
    if array.size == 0:
        return np.zeros(0, dtype=np.int64)
    if array.dtype.kind not in "iu" or array.ndim != 1:
        raise InputError(name, f"it has type {array.dtype} and shape {array.shape}", f"give a list of {what}s")
    array = array.astype(np.int64)
    low, high = array.min(), array.max()
    if low < 0 or high >= count:
        bad = low if low < 0 else high
        raise InputError(name, f"there is no {what} {bad} among {count}", "count from zero")
    return array


def counted(name: str, value: int) -> int:
    """A whole number from 1 to 2**53."""
    if not 1 <= value <= 2**53 or value != int(value):
        raise InputError(name, f"it is {value}", "give a whole number, one or larger")
    return int(value)


def threads_of(threads: int | None) -> int:
    """Zero for one a core."""
    if threads is None:
        return 0
    if not 1 <= threads <= 4096:
        raise InputError("threads", f"it is {threads}", "give a number from 1 to 4096, or None")
    return int(threads)
