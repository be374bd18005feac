"""Which connections of a system there can be, and what they do to numbers."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stickslip.cosim.errors import ConnectionFault, ParameterError
from stickslip.cosim.fmu.names import component_of
from stickslip.cosim.fmu.units import Unit
from stickslip.cosim.system.scaling import (
    Link,
    Transform,
    ValueMap,
)

if TYPE_CHECKING:
    from stickslip.cosim.system.system import System


def pairs(system: System, source: str, target: str) -> list[tuple[str, str]]:
    """Return the connections element by element where both ends are arrays of one shape.

    Raises
    ------
    ConnectionFault
    """
    try:
        ends = [system.variable(name) for name in (source, target)]
    except ConnectionFault as fault:
        raise ConnectionFault(f"cannot connect {source} to {target}: {fault}") from None
    if not ends[0].dimensions or not ends[1].dimensions:
        return [(source, target)]
    if ends[0].dimensions != ends[1].dimensions:
        raise ConnectionFault(
            f"cannot connect {source} to {target}: their dimensions are"
            f" {ends[0].dimensions} and {ends[1].dimensions}"
        )
    names = (
        [f"{component_of(name)}.{element.name}" for element in end.elements()]
        for name, end in zip((source, target), ends, strict=True)
    )
    return list(zip(*names, strict=True))


def check_end(system: System, name: str, causality: str, purpose: str) -> None:
    """Check that a variable is one that can be connected, of this causality.

    Raises
    ------
    ConnectionFault
    """
    try:
        variable = system.variable(name)
    except ConnectionFault as fault:
        raise ConnectionFault(f"{purpose}: {fault}") from None
    if variable.causality != causality or not variable.is_signal:
        shape = "array" if variable.dimensions else variable.causality
        hint = f"; name its elements: {name}[...]" if variable.dimensions else ""
        raise ConnectionFault(
            f"{purpose}: {name} is a {variable.type} {shape},"
            f" expected an {causality} that is a number or Boolean{hint}"
        )


def transform(system: System, source: str, unit: Unit | None, target: str, link: Link) -> Transform:
    """Return what is done to a number on its way from ``source``, in a unit, to ``target``.

    Raises
    ------
    ConnectionFault
        When one unit cannot be converted to the other.
    """
    wanted = system.unit_of(target)
    if isinstance(link.scaling, ValueMap) or not (unit and wanted and link.convert):
        return link.scaling
    converted = unit.to(wanted)
    if converted is None:
        hint = "; scale it by a Link with convert=False" if unit.measures_as(wanted) else ""
        raise ConnectionFault(
            f"cannot connect {source} to {target}: {source} is in {unit}, {target} in {wanted};"
            f" one cannot be converted to the other{hint}"
        )
    return converted.then(link.scaling)


def _check_kinds(system: System, like: str, target: str, link: Link, purpose: str) -> None:
    start, end = system.variable(like), system.variable(target)
    if isinstance(link.scaling, ValueMap):
        if not (start.is_mapped and end.is_mapped):
            raise ConnectionFault(
                f"{purpose}: {like} is a {start.kind}, {target} a {end.kind}; values are mapped"
                " between integers, Booleans and enumerations"
            )
        for _, value in link.scaling.pairs:
            try:
                end.checked(value, target)
            except ParameterError as fault:
                raise ConnectionFault(f"{purpose}: {fault}") from None
    elif start.kind != end.kind:
        raise ConnectionFault(
            f"{purpose}: {like} is a {start.kind}, {target} a {end.kind}; only equal types"
            " connect, others with pairs of values (ValueMap)"
        )


def check_feed(
    system: System, source: str, like: str, unit: Unit | None, target: str, link: Link
) -> None:
    """Check that ``target`` can be fed by ``source``, which is a variable like ``like``.

    Raises
    ------
    ConnectionFault
    """
    purpose = f"cannot connect {source} to {target}"
    check_end(system, target, "input", purpose)
    _check_kinds(system, like, target, link, purpose)
    transform(system, source, unit, target, link)
    if feeder := system.sources().get(target):
        raise ConnectionFault(f"{purpose}: {target} is fed by {feeder} already")
