"""Connectors, entries of signal dictionaries and transformations of SSP."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from stickslip.cosim.errors import SspError
from stickslip.cosim.ssp.markup import (
    NAMESPACES,
    add,
    attribute,
    find,
    integer,
    local,
    number,
    place,
    tag,
)
from stickslip.cosim.system.scaling import IDENTITY, Scaling, Transform, ValueMap
from stickslip.fmi.description.units import BASE_UNITS, Unit
from stickslip.fmi.description.variables import FAMILY, Variable, converts
from stickslip.fmi.messages import suggestion

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
        return cls(
            units,
            {attribute(e, "name"): _items(e) for e in root.iter(tag("ssc:Enumeration")) if len(e)},
        )

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


_WORDS = {"true": 1, "1": 1, "false": 0, "0": 0}
_FITS = {
    "Linear": {"number", "integer"},
    "BooleanMapping": {"Boolean"},
    "IntegerMapping": {"integer", "enumeration"},
    "EnumerationMapping": {"enumeration"},
}


def transform_of(element: Any, start: Items, end: Items) -> Transform:
    """Return what an element does to a value; the ends have these items of enumerations."""
    found = _transformation(element)
    if found is None:
        return IDENTITY
    kind = _kind(found)
    if kind == "Linear":
        return Scaling(number(found, "factor", 1.0), number(found, "offset", 0.0))
    pairs: dict[int, int] = {}
    for entry in found.iterfind("ssc:MapEntry", NAMESPACES):
        x, y = (
            _value(kind, attribute(entry, which), entry, items)
            for which, items in (("source", start), ("target", end))
        )
        if pairs.setdefault(x, y) != y:
            raise SspError(
                f"{place(entry)}: {local(found)} maps {entry.get('source')!r} twice; leave one"
                " MapEntry for each source"
            )
    return ValueMap.of(pairs)


def check_types(element: Any, ends: list[tuple[str, str | None]]) -> None:
    """Check that the ends of a connection, each with name and type or None, fit together."""
    found = _transformation(element)
    wanted = _FITS[_kind(found)] if found is not None else ()
    families = [FAMILY.get(kind or "") for _, kind in ends]
    for (name, kind), family, comes_out in zip(ends, families, (False, True), strict=True):
        fits = (converts(w, family) if comes_out else converts(family, w) for w in wanted if family)
        if family and wanted and not any(fits):
            raise SspError(
                f"{place(found)}: {local(found)} is for {' and '.join(sorted(wanted))} values,"
                f" {name} is of the type {kind}"
            )
    start, end = families
    mapped = found is not None and _kind(found) != "Linear"
    if start and end and not mapped and not converts(start, end):
        both = " to ".join(f"{name} ({kind})" for name, kind in ends)
        raise SspError(
            f"{place(element)}: cannot connect {both}: only types that lose nothing connect: a"
            " Boolean to integers and numbers, an integer to numbers and enumerations and back"
        )


def add_transformation(
    element: Any, transform: Transform, source: Variable, target: Variable
) -> None:
    """Write what a connection does to a value."""
    if isinstance(transform, Scaling):
        line = {"factor": repr(transform.factor), "offset": repr(transform.offset)}
        add(element, "ssc:LinearTransformation", **line)
        return
    families = {FAMILY.get(source.type), FAMILY.get(target.type)}
    names = [{str(n): item for item, n in variable.items} for variable in (source, target)]
    pairs = [tuple(map(str, pair)) for pair in transform.pairs]
    kind = "Integer"
    if families == {"Boolean"}:
        kind, names = "Boolean", [{"1": "true", "0": "false"}] * 2
    elif not families <= {"integer", "enumeration"}:
        raise SspError(
            f"SSP has no pairs of {source.type} and {target.type} values; put a component between"
        )
    elif families == {"enumeration"} and all(x in names[0] and y in names[1] for x, y in pairs):
        kind = "Enumeration"
    mapping = add(element, f"ssc:{kind}MappingTransformation")
    for x, y in pairs:
        if kind != "Integer":
            x, y = names[0][x], names[1][y]
        add(mapping, "ssc:MapEntry", source=x, target=y)


def pairs_of_names(element: Any) -> dict[str, str]:
    """Return the pairs of item names that a mapping entry holds."""
    entries = element.iterfind("ssc:EnumerationMappingTransformation/ssc:MapEntry", NAMESPACES)
    return {attribute(entry, "source"): attribute(entry, "target") for entry in entries}


def _transformation(element: Any) -> Any:
    names = (tag(f"ssc:{kind}Transformation") for kind in _FITS)
    return next(element.iterchildren(*names), None)


def _kind(transformation: Any) -> str:
    return local(transformation).removesuffix("Transformation")


def _value(kind: str, text: str, entry: Any, items: Items) -> int:
    if kind == "IntegerMapping":
        return integer(text, entry)
    known = _WORDS if kind == "BooleanMapping" else items
    if text in known:
        return known[text]
    if known:
        raise SspError(
            f"{place(entry)}: {text!r} is not a value of its type{suggestion(text, known)}"
        )
    raise SspError(
        f"{place(entry)}: the items of the enumeration with {text!r} are defined neither in"
        " ssd:Enumerations nor in the FMU"
    )
