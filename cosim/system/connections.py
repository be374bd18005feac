"""Which connections are possible, and how they transform numbers."""

from __future__ import annotations

from dataclasses import dataclass

from stickslip.cosim.errors import ConnectionFault, ParameterError
from stickslip.cosim.fmu.names import component_of
from stickslip.cosim.fmu.values import converted
from stickslip.cosim.system.scaling import Link, Transform, ValueMap, conversion
from stickslip.fmi.description.units import Unit
from stickslip.fmi.description.variables import Variable, converts


@dataclass(frozen=True)
class End:
    """One end of a connection: a component's variable, or an exposed input that is like one."""

    name: str
    variable: Variable
    unit: Unit | None

    def check(self, causality: str, purpose: str) -> None:
        """Check that it can be connected and has this causality."""
        variable = self.variable
        if variable.causality != causality or not variable.is_signal:
            shape = "array" if variable.dimensions else variable.causality
            hint = f"; name its elements: {self.name}[...]" if variable.dimensions else ""
            raise ConnectionFault(
                f"{purpose}: {self.name} is a {variable.type} {shape},"
                f" expected an {causality} that is a number or Boolean{hint}"
            )


def pairs(source: End, target: End) -> list[tuple[str, str]]:
    """Return the connections element by element where both ends are arrays of one shape."""
    shapes = source.variable.dimensions, target.variable.dimensions
    if not all(shapes):
        return [(source.name, target.name)]
    if shapes[0] != shapes[1]:
        raise ConnectionFault(
            f"cannot connect {source.name} to {target.name}: their dimensions are"
            f" {shapes[0]} and {shapes[1]}"
        )
    names = (
        [f"{component_of(end.name)}.{element.name}" for element in end.variable.elements()]
        for end in (source, target)
    )
    return list(zip(*names, strict=True))


def transform(source: End, target: End, link: Link) -> Transform:
    """Return the transform of a number from one end to the other."""
    unit, wanted = source.unit, target.unit
    if isinstance(link.scaling, ValueMap) or not (unit and wanted and link.convert):
        return link.scaling
    scaling = conversion(unit, wanted)
    if scaling is None:
        hint = "; scale it by a Link with convert=False" if unit.measures_as(wanted) else ""
        raise ConnectionFault(
            f"cannot connect {source.name} to {target.name}: {source.name} is in {unit},"
            f" {target.name} in {wanted}; one cannot be converted to the other{hint}"
        )
    return scaling.then(link.scaling)


def check_connection(source: End, target: End, link: Link) -> None:
    """Check that an output or exposed input can be connected to an input."""
    purpose = f"cannot connect {source.name} to {target.name}"
    target.check("input", purpose)
    start, end = source.variable, target.variable
    types = f"{source.name} is a {start.type}, {target.name} a {end.type}"
    if isinstance(link.scaling, ValueMap):
        if start.family == end.family == "number":
            raise ConnectionFault(
                f"{purpose}: {types}; pairs of values need an integer, Boolean or enumeration"
            )
        for _, value in link.scaling.pairs:
            try:
                converted(end, value, target.name)
            except ParameterError as fault:
                raise ConnectionFault(f"{purpose}: {fault}") from None
    elif not converts(start.family, end.family):
        raise ConnectionFault(
            f"{purpose}: {types}, which loses a part of the value; give pairs of values (ValueMap);"
            " a number without a pair then loses what follows its decimal point"
        )
    transform(source, target, link)
