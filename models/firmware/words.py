"""Names and literals of structured text."""

from __future__ import annotations

from collections.abc import Iterable

_RESERVED = """
    abs abstract and any array at bool by byte case char clk concat configuration constant
    cos date delete dint div do dt dword else elsif end exit exp expt extends false final
    find for from function if implements in insert int interface internal jmp ld left len
    limit ln log lreal lword max method mid min mod move mux n ne not of on or out pointer
    private program property protected public r read real reference replace resource ret
    retain return right s sel shl shr sin sint sqrt st step stn string struct super tan task
    then this time to tod true trunc type udint uint until usint var when while with word
    write xor
"""
SMALLEST = 2.0**-126
"""Compilers such as matiec take no literal that is not 0 and below what a REAL holds."""


def literal(value: float) -> str:
    """Return a real literal: it needs a point, also before an exponent."""
    mantissa, exponent, power = repr(float(value)).partition("e")
    return (mantissa if "." in mantissa else f"{mantissa}.0") + exponent.upper() + power


def is_reserved(name: str) -> bool:
    """Whether a name is a word of the language, in upper or lower case."""
    return name.lower() in _RESERVED.split()


def distinct(names: Iterable[str]) -> dict[str, str]:
    """Return names that differ by more than case and are not words of the language."""
    found: dict[str, str] = {}
    for name in names:
        new, taken = name, {other.lower() for other in found.values()}
        while new.lower() in taken or is_reserved(new):
            new += "_1" if new == name else "1"
        found[name] = new
    return found
