"""Attributes as values, units, declared types: a number that is none names element and line."""

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, TypeVar

from stickslip.fmi.description.units import BASE_UNITS, Unit
from stickslip.fmi.messages import shown

_T = TypeVar("_T")
_WHOLE = re.compile(r"\s*[-+]?[0-9]{1,20}\s*")
CONTROLS = re.compile(r"[\x00-\x1f\x7f-\x9f\u2028\u2029]")
MOST_REMARKS = 20
"""Lines of one description; a list of 100,000 variables can have one for each."""
WORDS = {"true": True, "1": True, "false": False, "0": False}


class DescriptionFault(ValueError):
    """A description, or a part of it, that is not taken; the message begins with the line."""

    def __init__(self, element: Any, what: str) -> None:
        super().__init__(f"line {element.sourceline}: {what}")
        self.element = element


class Remarks:
    """What is wrong in a description and no run needs: it is left out, and a line says so."""

    def __init__(self) -> None:
        self._lines: list[str] = []
        self._further = 0

    def add(self, element: Any, what: str) -> None:
        """Note what is wrong with an element, and what is done about it."""
        if len(self._lines) < MOST_REMARKS:
            self._lines.append(f"line {element.sourceline}: {what}")
        else:
            self._further += 1

    def attempt(self, read: Callable[..., _T], *arguments: Any) -> _T | None:
        """Return what a function reads; None, with a remark, where it refuses."""
        try:
            return read(*arguments)
        except DescriptionFault as fault:
            what = str(fault).partition(": ")[2].removesuffix("; export it again")
            self.add(fault.element, f"{what}; this is ignored")
            return None

    @property
    def lines(self) -> tuple[str, ...]:
        """The remarks, of many the first and how many more there are."""
        more = (f"{self._further} more",) if self._further else ()
        return (*self._lines, *more)


def name_of(element: Any) -> str:
    """Return an element's name, which it must have; without control characters."""
    name: str = element.get("name") or ""
    if not name or CONTROLS.search(name):
        what = f"is {shown(name)}: control characters are not taken" if name else "is missing"
        raise DescriptionFault(element, f"the name of a {element.tag} {what}; export it again")
    return name


def real(text: str, what: str, element: Any) -> float:
    """Return a number, which may be INF or NaN."""
    try:
        if "_" not in text:
            return float(text)
    except ValueError:
        pass
    raise DescriptionFault(element, f"{what} is {shown(text)}, expected a number")


def finite(text: str, what: str, element: Any) -> float:
    """Return a number that is neither INF nor NaN."""
    number = real(text, what, element)
    if not math.isfinite(number):
        raise DescriptionFault(element, f"{what} is {number}, expected a finite number")
    return number


def whole(text: str, what: str, element: Any) -> int:
    """Return an integer."""
    if not _WHOLE.fullmatch(text):
        raise DescriptionFault(element, f"{what} is {shown(text)}, expected an integer")
    return int(text)


def whole_of(element: Any, attribute: str, least: int, most: int) -> int:
    """Return an attribute that must exist, an integer within a range."""
    text = element.get(attribute)
    if text is None:
        raise DescriptionFault(element, f"{element.tag} has no {attribute}; export it again")
    number = whole(text, attribute, element)
    if not least <= number <= most:
        what = f"{attribute} is {number}, expected an integer from {least} to {most}"
        raise DescriptionFault(element, what)
    return number


def flag(attributes: Mapping[str, str], name: str) -> bool:
    """Return an attribute that is true or false, false where it is missing."""
    return WORDS.get(attributes.get(name, "false").strip(), False)


@dataclass(frozen=True)
class TypeDefinition:
    """A declared type: what a variable of it need not say itself."""

    name: str
    given: Mapping[str, str]  # attributes as text
    items: tuple[tuple[str, int], ...]  # (name, number), of an enumeration


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
