"""Units and declared types."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from stickslip.fmi.description.attributes import DescriptionFault, finite, name_of, whole
from stickslip.fmi.description.units import BASE_UNITS, Unit


@dataclass(frozen=True)
class TypeDefinition:
    """A declared type: what a variable of it need not say itself.

    Attributes
    ----------
    given : attributes as text
    items : (name, number), of an enumeration
    """

    name: str
    given: Mapping[str, str]
    items: tuple[tuple[str, int], ...]


def read_units(root: Any) -> dict[str, Unit]:
    """Return the units by name."""
    return {unit.name: unit for unit in map(_unit, root.iterfind("UnitDefinitions/Unit"))}


def _unit(element: Any) -> Unit:
    name, base = name_of(element), element.find("BaseUnit")
    if base is None:
        return Unit(name)
    exponents = tuple(whole(base.get(unit, "0"), unit, base) for unit in BASE_UNITS)
    factor = finite(base.get("factor", "1"), "factor", base)
    if not factor:
        raise DescriptionFault(base, "factor is 0, expected another number")
    offset = finite(base.get("offset", "0"), "offset", base)
    return Unit(name, exponents, factor, offset, relative=False)


def read_types(root: Any, version: int) -> dict[str, TypeDefinition]:
    """Return the declared types by name."""
    types = (_type(*pair) for pair in _elements(root, version))
    return {each.name: each for each in types}


def _elements(root: Any, version: int) -> Iterator[tuple[Any, Any]]:
    """Yield the element that has the name and the one that has the rest."""
    if version == 3:
        yield from ((element, element) for element in root.iterfind("TypeDefinitions/*"))
    for element in root.iterfind("TypeDefinitions/SimpleType") if version == 2 else ():
        if not len(element):
            raise DescriptionFault(element, "a SimpleType is empty; export it again")
        yield element, element[0]


def _type(named: Any, element: Any) -> TypeDefinition:
    items = tuple(
        (item.get("name", ""), whole(item.get("value", ""), "value of an Item", item))
        for item in element.iterfind("Item")
    )
    return TypeDefinition(name_of(named), dict(element.attrib), items)
