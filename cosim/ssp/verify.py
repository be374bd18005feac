"""Reads a changed package back before it is handed out."""

from __future__ import annotations

import math

from stickslip.cosim.errors import CosimError, SspError
from stickslip.cosim.fmu.names import component_of
from stickslip.cosim.ssp.members import Members
from stickslip.cosim.ssp.package import Package
from stickslip.cosim.ssp.read import read_package
from stickslip.cosim.system.scaling import Scaling, Transform
from stickslip.cosim.system.system import System
from stickslip.fmi.description.variables import Value
from stickslip.fmi.process import temporary_folder


def verify(members: Members, structure: str, system: System) -> None:
    """Check that the members of a package say what a system is.

    Raises
    ------
    SspError
        When they do not, and where; for example when a binding still names a component that was
        removed.
    """
    with temporary_folder() as folder:
        for member, data in members.items():
            file = folder / member
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_bytes(data)
        try:
            again = read_package(Package(folder / structure, folder, structure))[0]
        except CosimError as fault:
            raise SspError(f"the changed package would be broken: {fault}") from fault
    for part in ("connections", "inputs", "outputs"):
        if (found := getattr(again, part)) != getattr(system, part):
            raise SspError(f"the changed package would have the {part} {found}")
    for target, source in system.sources().items():
        wanted, found = system.scaling(source, target), again.scaling(source, target)
        if not _same(wanted, found):
            raise SspError(f"the changed package would scale {target} by {found}, not {wanted}")
    for parameter, value in system.parameters.items():
        if (found := _value(again, parameter)) != value:
            raise SspError(f"the changed package would give {parameter} = {found!r}, not {value!r}")


def _same(wanted: Transform, found: Transform) -> bool:
    if not (isinstance(wanted, Scaling) and isinstance(found, Scaling)):
        return wanted == found
    return math.isclose(wanted.factor, found.factor, rel_tol=1e-12) and math.isclose(
        wanted.offset, found.offset, rel_tol=1e-12, abs_tol=1e-300
    )


def _value(system: System, name: str) -> Value | None:
    """Return a start value; of an element it may be that in its array."""
    variable = system.variable(name)
    whole = system.parameters.get(f"{component_of(name)}.{variable.array}")
    inside = whole[variable.element] if isinstance(whole, tuple) else None
    return system.parameters.get(name, inside)
