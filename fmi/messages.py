"""Untrusted names and texts in messages: quoted, escaped, cut short, and what they may mean."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from itertools import islice

_MOST = 5000  # names that are compared with one that is not known


def shown(name: str, most: int = 80) -> str:
    """Return a name for a message: quoted, without control characters, cut short."""
    return repr(name if len(name) <= most else f"{name[:most]}...")


def printable(text: str, most: int = 200) -> str:
    """Return a text for a message: in one line, with control characters escaped."""
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
