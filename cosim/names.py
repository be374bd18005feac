"""Names of the form ``component.variable``."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


def component_of(name: str) -> str:
    """Return ``component`` of ``component.variable``."""
    return name.partition(".")[0]


def variable_of(name: str) -> str:
    """Return ``variable`` of ``component.variable``; it may hold dots itself."""
    return name.partition(".")[2]


def suggestion(name: str, names: Iterable[str]) -> str:
    """Return the end of an error message: what ``name`` may have meant, or what there is."""
    known = list(names)
    if near := difflib.get_close_matches(name, known, n=3, cutoff=0.5):
        return f"; did you mean {' or '.join(map(repr, near))}?"
    shown = ", ".join(known[:12]) + (", ..." if len(known) > 12 else "")
    return f"; there is {shown}" if known else "; there is none"
