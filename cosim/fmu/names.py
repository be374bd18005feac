"""Names of the form ``component.variable``."""

from __future__ import annotations


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
