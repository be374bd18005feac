"""What a connection makes of the number at its one end, and which connections are possible."""

from __future__ import annotations

from dataclasses import dataclass

from stickslip.cosim.component import component_of
from stickslip.cosim.errors import ConnectionFault
from stickslip.fmi.description.units import Unit
from stickslip.fmi.description.variables import Variable, converts


@dataclass(frozen=True)
class Scaling:
    """y = factor * x + offset, in the unit of y."""

    factor: float = 1.0
    offset: float = 0.0

    def __call__(self, x: float) -> float:
        """Return y."""
        return x if self == IDENTITY else self.factor * x + self.offset

    def then(self, following: Scaling) -> Scaling:
        """Return what does this one, then ``following``."""
        if IDENTITY in (self, following):
            return following if self == IDENTITY else self
        factor = following.factor * self.factor
        return Scaling(factor, following(self.offset))

    def inverse(self, y: float) -> float:
        """Return the x that leads to y; the factor must not be 0."""
        return y if self == IDENTITY else (y - self.offset) / self.factor


IDENTITY = Scaling()


def conversion(unit: Unit, other: Unit) -> Scaling | None:
    """Return the conversion of a number in one unit to another unit, None when there is none.

    There is none where the units measure different quantities, or one does not say what it
    measures, and between a difference and an absolute value where an offset would matter.
    """
    if unit.same_as(other):
        return IDENTITY
    if not unit.measures_as(other):
        return None
    factor, offset = unit.factor / other.factor, (unit.offset - other.offset) / other.factor
    mine, theirs = unit.like(other).relative, other.like(unit).relative
    if mine and theirs:
        return Scaling(factor)
    return None if bool(mine) != bool(theirs) and offset else Scaling(factor, offset)


@dataclass(frozen=True)
class Link:
    """How a connection treats the number that it carries.

    Where ``convert``, it is first converted to the unit of the target. Then ``scaling`` is applied.
    """

    scaling: Scaling = IDENTITY
    convert: bool = True


PLAIN = Link()


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
            what = f"expected an {causality} that is a number or Boolean{hint}"
            raise ConnectionFault(f"{purpose}: {self.name} is a {variable.type} {shape}, {what}")


def pairs(source: End, target: End) -> list[tuple[str, str]]:
    """Return the connections element by element where both ends are arrays of one shape."""
    shapes = source.variable.dimensions, target.variable.dimensions
    if not all(shapes):
        return [(source.name, target.name)]
    if shapes[0] != shapes[1]:
        what = f"their dimensions are {shapes[0]} and {shapes[1]}"
        raise ConnectionFault(f"cannot connect {source.name} to {target.name}: {what}")
    names = (
        [f"{component_of(end.name)}.{element.name}" for element in end.variable.elements()]
        for end in (source, target)
    )
    return list(zip(*names, strict=True))


def transform(source: End, target: End, link: Link) -> Scaling:
    """Return the scaling of a number from one end to the other."""
    unit, wanted = source.unit, target.unit
    if not (unit and wanted and link.convert):
        return link.scaling
    scaling = conversion(unit, wanted)
    if scaling is None:
        vague = [one for one in (unit, wanted) if one.exponents is None]
        hint = f", as nothing defines {vague[0]} by base units" if vague else ""
        if vague or unit.measures_as(wanted):
            hint += "; scale it by a Link with convert=False"
        what = f"{source.name} is in {unit}, {target.name} in {wanted}"
        advice = f"one cannot be converted to the other{hint}"
        raise ConnectionFault(f"cannot connect {source.name} to {target.name}: {what}; {advice}")
    return scaling.then(link.scaling)


def check_connection(source: End, target: End, link: Link) -> None:
    """Check that an output or exposed input can be connected to an input."""
    purpose = f"cannot connect {source.name} to {target.name}"
    target.check("input", purpose)
    start, end = source.variable, target.variable
    types = f"{source.name} is a {start.type}, {target.name} a {end.type}"
    if not converts(start.family, end.family):
        advice = "put a component between"
        raise ConnectionFault(f"{purpose}: {types}, which loses a part of the value; {advice}")
    transform(source, target, link)
