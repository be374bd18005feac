"""Which call an FMU is in, written down where another process can read it."""

from __future__ import annotations

from ctypes import CDLL, addressof, c_void_p
from pathlib import Path

from stickslip.cosim.kernel.structures import Mark

_place: list[tuple[Mark, Path]] = []


def use(mark: Mark, kernel: Path) -> None:
    """Let all that is called in this process from now on be noted in ``mark``.

    Parameters
    ----------
    kernel : its library, built with marks
    """
    _place.append((mark, kernel))


def note(name: str, call: str) -> None:
    """Note a call that the kernel does not make, where notes are taken."""
    for mark, _ in _place:
        mark.begin(name, call)


def library() -> Path | None:
    """Return the library of the kernel that writes marks, None where no marks are used."""
    return _place[0][1] if _place else None


def attach(kernel: CDLL) -> None:
    """Tell a library of the kernel where to take its notes."""
    for mark, _ in _place:
        kernel.mark_in(c_void_p(addressof(mark)))
