"""Elastic contact with dry friction in 3D, with a certificate for every answer."""

from . import discrete
from ._case import Case, Facts, Result, Step, Surface
from ._errors import InputError, NotCertified, TooLarge
from ._obstacles import Cylinder, Meeting, Plane, Sphere
from ._problem import Problem
from ._results import Certificate, Progress, Solution, Tangent
from ._rows import MortarRows, Rows, mortar, rows
from ._stiction import __version__

# Users see one module, in messages and in `help`.
for _public in (
    Case, Certificate, Cylinder, Facts, InputError, Meeting, MortarRows, NotCertified, Plane, Problem, Progress, Result, Rows, Solution,
    Sphere, Step, Surface, Tangent, TooLarge,
):  # fmt: skip
    _public.__module__ = __name__

__all__ = [
    "Case",
    "Certificate",
    "Cylinder",
    "Facts",
    "InputError",
    "Meeting",
    "MortarRows",
    "NotCertified",
    "Plane",
    "Problem",
    "Progress",
    "Result",
    "Rows",
    "Solution",
    "Sphere",
    "Step",
    "Surface",
    "Tangent",
    "TooLarge",
    "__version__",
    "discrete",
    "mortar",
    "rows",
]
