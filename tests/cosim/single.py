"""Systems of one FMU."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from stickslip import cosim


def one(
    path: Path, parameters: Mapping[str, object] | None = None, u: str = "", **how: object
) -> cosim.System:
    """Return a system of the component ``a``; its input u leads to the variable ``u``."""
    system = cosim.System()
    system.add("a", path, parameters, **how)
    if u:
        system.expose("u", f"a.{u}")
    return system
