"""Names of the form ``component.variable``."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from itertools import islice

_MOST = 5000  # names that are compared with one that is not known


def component_of(name: str) -> str:
    """Return ``component`` of ``component.variable``."""
    return name.partition(".")[0]


def variable_of(name: str) -> str:
    """Return ``variable`` of ``component.variable``; it may hold dots itself."""
    return name.partition(".")[2]


def check_name(name: str) -> str | None:
    """Return why something of a system cannot be called so, None where it can.

    Names head the columns of tables: the ones that spreadsheets take for formulas are not given.
    """
    if not name or "." in name:
        return "it is empty or has a dot"
    if not name.isprintable():
        return "it has control characters"
    if name[0] in "=+-@":
        return f"it begins with {name[0]!r}, which spreadsheets take for a formula"
    return None


def shown(name: str, most: int = 80) -> str:
    """Return a stranger's name for a message: quoted, without control characters, cut short."""
    return repr(name if len(name) <= most else f"{name[:most]}...")


def printable(text: str, most: int = 200) -> str:
    """Return a stranger's text for a message: in one line, what is no letter or sign escaped."""
    line = "".join(c if c.isprintable() else repr(c)[1:-1] for c in text[:most])
    return line if len(text) <= most else f"{line}..."


def suggestion(name: str, names: Iterable[str]) -> str:
    """Return the end of an error message: what ``name`` may have meant, or what there is."""
    known = [printable(each, 80) for each in islice(names, _MOST)]
    name = name[:80]
    if near := difflib.get_close_matches(name, known, n=3, cutoff=0.5):
        return f"; did you mean {' or '.join(map(repr, near))}?"
    shown = ", ".join(known[:12]) + (", ..." if len(known) > 12 else "")
    return f"; there is {shown}" if known else "; there is none"
