"""Units and declared types."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from stickslip.fmi.description.attributes import (
    DescriptionFault,
    Remarks,
    finite,
    name_of,
    whole,
)
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


def read_units(root: Any, remarks: Remarks) -> dict[str, Unit]:
    """Return the units by name; without its definition, a unit is compared by its name."""
    found = (remarks.attempt(_unit, each) for each in root.iterfind("UnitDefinitions/Unit"))
    return {unit.name: unit for unit in found if unit}


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


def read_types(root: Any, version: int, remarks: Remarks) -> dict[str, TypeDefinition]:
    """Return the declared types by name."""
    elements = root.iterfind(f"TypeDefinitions/{'*' if version == 3 else 'SimpleType'}")
    types = (remarks.attempt(_type, each, version, remarks) for each in elements)
    return {each.name: each for each in types if each}


def _type(element: Any, version: int, remarks: Remarks) -> TypeDefinition:
    name = name_of(element)
    if version == 2:
        if not len(element):
            raise DescriptionFault(element, "a SimpleType is empty")
        element = element[0]
    items = (remarks.attempt(_item, item) for item in element.iterfind("Item"))
    return TypeDefinition(name, dict(element.attrib), tuple(filter(None, items)))


def _item(element: Any) -> tuple[str, int]:
    number = whole(element.get("value", ""), "value of an Item", element)
    return element.get("name", ""), number
