"""Elastic contact with dry friction in 3D, with a certificate for every answer."""

from . import discrete
from ._case import Case, Facts, Result, Step, Surface
from ._errors import InputError, NotCertified, TooLarge
from ._problem import Problem
from ._results import Certificate, Progress, Solution
from ._stiction import __version__

__all__ = [
    "Case",
    "Certificate",
    "Facts",
    "InputError",
    "NotCertified",
    "Problem",
    "Progress",
    "Result",
    "Solution",
    "Step",
    "Surface",
    "TooLarge",
    "__version__",
    "discrete",
]
