from collections.abc import Callable
from typing import Any, final

import numpy as np
import numpy.typing as npt

__all__ = ["Case", "Discrete", "Matrices", "Problem", "__version__", "command", "mortar"]

_Reals = npt.NDArray[np.float64]
_Whole = npt.NDArray[np.int64]
_Rows = tuple[int, int, npt.NDArray[Any], npt.NDArray[Any], _Reals]
_Laws = tuple[npt.NDArray[np.uint8], _Reals, _Reals, _Reals]

_Numbers = tuple[list[tuple[str, _Reals]], list[tuple[str, _Reals, _Reals]], _Whole, list[tuple[str, str]]]
_Given = tuple[_Reals, list[tuple[str, _Whole]], list[tuple[str, _Whole, _Whole, _Whole]], _Numbers]

__version__: str

def command(arguments: list[str]) -> int: ...
def mortar(
    points: _Reals,
    surfaces: tuple[list[_Whole], list[_Whole]],
    mesh: _Given | None,
    held: _Whole,
    search: float | None,
) -> dict[str, Any]: ...

@final
class Case:
    def __new__(
        cls,
        text: str | None,
        path: str | None,
        name: str,
        overrides: list[tuple[str, str]],
        mesh: _Given | None,
    ) -> Case: ...
    @property
    def title(self) -> str: ...
    def facts(self, threads: int) -> dict[str, Any]: ...
    def solve(
        self,
        *,
        folder: str | None,
        resume: bool,
        report: bool,
        matrices: bool,
        threads: int,
        hear: Callable[..., bool] | None,
    ) -> dict[str, Any]: ...
@final
class Discrete:
    @staticmethod
    def local(
        W: _Rows, q: _Reals, mu: _Reals, dimension: int, bilateral: tuple[_Rows, _Rows, _Reals] | None
    ) -> Discrete: ...
    @staticmethod
    def global_(
        M: _Rows, H: _Rows, f: _Reals, w: _Reals, mu: _Reals, dimension: int, equalities: tuple[_Rows, _Reals] | None
    ) -> Discrete: ...
    @staticmethod
    def read(path: str) -> Discrete: ...
    @property
    def dimension(self) -> int: ...
    @property
    def points(self) -> int: ...
    def data(self) -> dict[str, Any]: ...
    def solve(
        self,
        *,
        tolerance: float,
        max_iterations: int,
        method: str,
        form: str,
        start: _Reals | None,
        threads: int,
        hear: Callable[..., bool] | None,
    ) -> dict[str, Any]: ...
@final
class Matrices:
    def stiffness(self) -> _Rows: ...
    def free(self) -> _Rows: ...
    def directions(self) -> _Rows: ...
    def mass(self) -> _Rows: ...
@final
class Problem:
    def __new__(
        cls,
        k: _Rows,
        b: _Rows,
        f: _Reals,
        gap: _Reals,
        friction: _Laws,
        *,
        block: bool,
        across: _Reals | None,
        slip_reference: _Reals,
        held: _Whole,
        values: _Reals,
        nodes: tuple[_Reals, _Whole, npt.NDArray[np.uint8]] | None,
    ) -> Problem: ...
    def varied(
        self,
        *,
        friction: _Laws | None,
        across: _Reals | None,
        f: _Reals | None,
        gap: _Reals,
        slip_reference: _Reals,
        free: _Whole,
        held: _Whole,
    ) -> Problem: ...
    def solve(
        self,
        *,
        tolerance: float,
        max_iterations: int,
        method: str,
        memory_limit: int | None,
        forces: _Reals | None,
        u: _Reals | None,
        threads: int,
        hear: Callable[..., bool] | None,
    ) -> dict[str, Any]: ...
    def check(self, u: _Reals, forces: _Reals, tolerance: float, threads: int) -> dict[str, Any]: ...
    def reactions(self, u: _Reals, forces: _Reals) -> _Reals: ...
    def tied(self, states: npt.NDArray[np.uint8]) -> _Rows: ...
