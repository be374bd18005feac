"""What comments say of a variable."""

from __future__ import annotations

from stickslip.models.export.description import Variable


def unit(v: Variable) -> str:
    """Return the unit, or the values of a Boolean."""
    return "0 or 1" if v.type == "boolean" else v.unit or "1"


def explained(v: Variable) -> str:
    """Return unit, range and description."""
    span = "" if v.minimum is None else f", {v.minimum:g} .. {v.maximum:g}"
    return f"[{unit(v)}{span}] {v.description}"
