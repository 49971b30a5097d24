"""Exceptions of the package."""

from __future__ import annotations

from typing import Any

__all__ = ["InputError", "NotCertified", "TooLarge"]


class InputError(ValueError):
    """The problem cannot be posed: what is wrong, where, and the remedy.

    Attributes
    ----------
    place : str
        The argument, the key of a case or the line of a file; may be empty.
    what : str
        What is wrong.
    remedy : str
        What to do about it; may be empty.
    excerpt : str
        Lines of a case with the place marked; may be empty.
    """

    def __init__(self, place: str, what: str, remedy: str = "", excerpt: str = "") -> None:
        super().__init__(place, what, remedy, excerpt)
        self.place = place
        self.what = what
        self.remedy = remedy
        self.excerpt = excerpt

    def __str__(self) -> str:
        text = f"{self.place}: {self.what}" if self.place else self.what
        text += f"; {self.remedy}" if self.remedy else ""
        return f"{text}\n{self.excerpt}" if self.excerpt else text


class TooLarge(InputError, MemoryError):
    """The matrices do not fit the memory; an :class:`InputError` and a :class:`MemoryError`."""


class NotCertified(RuntimeError):
    """The iteration ended short of its tolerance.

    Attributes
    ----------
    result :
        As far as it came, with the certificate that says so; ``None`` if it was stopped before its first iteration.
    """

    def __init__(self, message: str, result: Any = None) -> None:
        super().__init__(message, result)
        self.result = result

    def __str__(self) -> str:
        return str(self.args[0])
