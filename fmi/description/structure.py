"""References from one part of a description to another.

FMI 2.0 refers to variables by their place in the list, FMI 3.0 by their value references.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from stickslip.fmi.description.attributes import DescriptionFault, whole
from stickslip.fmi.description.model import Unknown
from stickslip.fmi.messages import shown

Places = Mapping[str, str]
"""Index or value reference, in digits -> name of the variable."""

_KINDS = {
    2: {"Outputs": "outputs", "Derivatives": "derivatives", "InitialUnknowns": "initial"},
    3: {
        "Output": "outputs",
        "ContinuousStateDerivative": "derivatives",
        "EventIndicator": "indicators",
        "ClockedState": "clocked",
        "InitialUnknown": "initial",
    },
}


def read_unknowns(root: Any, version: int, places: Places) -> dict[str, list[Unknown]]:
    """Return the entries of ModelStructure by kind."""
    kinds = _KINDS[version]
    found: dict[str, list[Unknown]] = {kind: [] for kind in kinds.values()}
    for element in root.iterfind("ModelStructure/*"):
        if kind := kinds.get(element.tag):
            if version == 3:
                found[kind].append(_unknown(element, "valueReference", places))
            else:
                found[kind] += [_unknown(entry, "index", places) for entry in element]
    return found


def _unknown(element: Any, key: str, places: Places) -> Unknown:
    known = element.get("dependencies")
    depends = None
    if known is not None:
        depends = tuple(_name(word, "dependencies", element, places) for word in known.split())
    return Unknown(_name(element.get(key, ""), key, element, places), depends)


def read_derivatives(elements: Iterable[tuple[Any, str]], places: Places) -> dict[str, str]:
    """Return name -> name of what it is the derivative of.

    Parameters
    ----------
    elements : with the attribute ``derivative`` where they have one, and the variable's name
    """
    states: dict[str, str] = {}
    lines: dict[str, Any] = {}
    for element, name in elements:
        if (text := element.get("derivative")) is not None:
            states[name] = _name(text, "derivative", element, places)
            lines[name] = element
    sound: set[str] = set()
    for name in states:
        chain = [name]
        while (following := states.get(chain[-1])) and following not in sound:
            if following in chain:
                raise DescriptionFault(lines[name], f"{shown(name)} is a derivative of itself")
            chain.append(following)
        sound.update(chain)
    return states


def _name(text: str, what: str, element: Any, places: Places) -> str:
    if (name := places.get(text)) is not None:
        return name
    place = whole(text, what, element)  # it may be spelled with blanks or a sign
    if (name := places.get(str(place))) is None:
        raise DescriptionFault(
            element, f"{what} of {element.tag} is {place}, which is no variable; export it again"
        )
    return name
