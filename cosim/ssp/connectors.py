"""Connectors, entries of signal dictionaries and transformations of SSP."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from stickslip.cosim.errors import SspError
from stickslip.cosim.ssp.markup import (
    NAMESPACES,
    attribute,
    find,
    integer,
    local,
    number,
    place,
    tag,
)
from stickslip.cosim.system.scaling import IDENTITY, Scaling
from stickslip.fmi.description.units import BASE_UNITS, Unit
from stickslip.fmi.description.variables import FAMILY, converts

Items = Mapping[str, int]  # names of the values of an enumeration


@dataclass(frozen=True)
class Definitions:
    """The units and enumerations that a file defines, by name."""

    units: Mapping[str, Unit]
    enumerations: Mapping[str, Items]

    @classmethod
    def of(cls, root: Any) -> Definitions:
        """Read all definitions below an element."""
        units: dict[str, Unit] = {}
        for element in root.iter(tag("ssc:Unit")):
            unit = _read_unit(element)
            if units.setdefault(unit.name, unit) != unit:
                raise SspError(f"{place(element)}: unit {unit.name!r} has two definitions")
        found = (e for e in root.iter(tag("ssc:Enumeration")) if len(e))
        return cls(units, {attribute(e, "name"): _items(e) for e in found})

    def within(self, outer: Definitions) -> Definitions:
        """Return these definitions, completed by those of another file."""
        units = {**outer.units, **self.units}
        return Definitions(units, {**outer.enumerations, **self.enumerations})

    def unit(self, name: str | None) -> Unit | None:
        """Return a unit; one that is not defined can only equal itself."""
        return self.units.get(name, Unit(name)) if name else None


@dataclass(frozen=True)
class Connector:
    """A place where a signal enters or leaves an element, or an entry of a dictionary.

    What the file does not declare is None, also in ``dimensions``.
    """

    name: str
    kind: str
    unit: Unit | None = None
    type: str | None = None
    items: Items = field(default_factory=dict)
    dimensions: tuple[int | None, ...] = ()


def read_connectors(element: Any, definitions: Definitions) -> dict[str, Connector]:
    """Return the connectors of an element by name."""
    found = element.iterfind("ssd:Connectors/ssd:Connector", NAMESPACES)
    return _read("connectors", found, definitions)


def read_entries(root: Any, definitions: Definitions) -> dict[str, Connector]:
    """Return the entries of an ssb:SignalDictionary by name."""
    return _read("entries", root.iterfind("ssb:DictionaryEntry", NAMESPACES), definitions)


def _read(what: str, elements: Any, definitions: Definitions) -> dict[str, Connector]:
    result: dict[str, Connector] = {}
    for element in elements:
        name = attribute(element, "name")
        if name in result:
            raise SspError(f"{place(element)}: there are two {what} {name!r}; rename one")
        kind = attribute(element, "kind") if what == "connectors" else "inout"
        lengths = (d.get("size") for d in element.iterfind("ssc:Dimension", NAMESPACES))
        dimensions = tuple(None if n is None else integer(n, element) for n in lengths)
        typed = next((c for c in element.iterchildren(tag("ssc:*")) if local(c) in FAMILY), None)
        attributes = {} if typed is None else typed.attrib
        unit = definitions.unit(attributes.get("unit"))
        items = definitions.enumerations.get(attributes.get("name", ""), {})
        type_name = None if typed is None else local(typed)
        result[name] = Connector(name, kind, unit, type_name, items, dimensions)
    return result


def _items(enumeration: Any) -> Items:
    items = enumeration.iterfind("ssc:Item", NAMESPACES)
    return {attribute(item, "name"): integer(attribute(item, "value"), item) for item in items}


def _read_unit(element: Any) -> Unit:
    base = find(element, "ssc:BaseUnit")
    exponents = tuple(int(number(base, name, 0)) for name in BASE_UNITS)
    factor, offset = number(base, "factor", 1.0), number(base, "offset", 0.0)
    if factor == 0:
        raise SspError(f"{place(base)}: the factor of a unit cannot be 0")
    return Unit(attribute(element, "name"), exponents, factor, offset)


def scaling_of(element: Any) -> Scaling:
    """Return what an element does to a value."""
    found = next((c for c in element if str(c.tag).endswith("Transformation")), None)
    if found is None:
        return IDENTITY
    if found.tag != tag("ssc:LinearTransformation"):
        advice = "map the values in a component between"
        raise SspError(f"{place(found)}: a {local(found)} is not supported; {advice}")
    return Scaling(number(found, "factor", 1.0), number(found, "offset", 0.0))


def check_types(element: Any, ends: list[tuple[str, str | None]]) -> None:
    """Check that the ends of a connection, each with name and type or None, fit together."""
    start, end = (FAMILY.get(kind or "") for _, kind in ends)
    if end and scaling_of(element) != IDENTITY and end not in ("number", "integer", "enumeration"):
        what = f"for integer and number values, {ends[1][0]} is of the type {ends[1][1]}"
        raise SspError(f"{place(element)}: LinearTransformation is {what}")
    if start and end and not converts(start, end):
        both = " to ".join(f"{name} ({kind})" for name, kind in ends)
        raise SspError(
            f"{place(element)}: cannot connect {both}: only types that lose nothing connect: a"
            " Boolean to integers and numbers, an integer to numbers and enumerations and back"
        )
