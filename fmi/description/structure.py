"""References from one part of a description to another.

FMI 2.0 refers to variables by their place in the list, FMI 3.0 by their value references.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from stickslip.fmi.description.attributes import DescriptionFault, Remarks, whole
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


def read_unknowns(
    root: Any, version: int, places: Places, remarks: Remarks
) -> dict[str, list[Unknown]]:
    """Return the entries of ModelStructure by kind.

    Raises
    ------
    DescriptionFault
        When a state or an event indicator, which a solver has to count, is no variable.
    """
    kinds = _KINDS[version]
    found: dict[str, list[Unknown]] = {kind: [] for kind in kinds.values()}
    solved = {"derivatives", "indicators"} if root.find("ModelExchange") is not None else set()
    for element in root.iterfind("ModelStructure/*"):
        if not (kind := kinds.get(element.tag)):
            continue
        key, entries = ("valueReference", [element]) if version == 3 else ("index", element)
        for entry in entries:
            given = (entry, key, places, remarks)
            unknown = _unknown(*given) if kind in solved else remarks.attempt(_unknown, *given)
            found[kind] += [unknown] if unknown else []
    return found


def _unknown(element: Any, key: str, places: Places, remarks: Remarks) -> Unknown:
    name = _name(element.get(key, ""), key, element, places)
    return Unknown(name, remarks.attempt(_dependencies, element, places))


def _dependencies(element: Any, places: Places) -> tuple[str, ...] | None:
    if (known := element.get("dependencies")) is None:
        return None
    return tuple(_name(word, "dependencies", element, places) for word in known.split())


def read_derivatives(
    elements: Iterable[tuple[Any, str]], places: Places, remarks: Remarks
) -> dict[str, str]:
    """Return name -> name of what it is the derivative of.

    Parameters
    ----------
    elements : with the attribute ``derivative`` where they have one, and the variable's name
    """
    states: dict[str, str] = {}
    for element, name in elements:
        if (text := element.get("derivative")) is None:
            continue
        state = remarks.attempt(_name, text, "derivative", element, places)
        following = state
        while following and following != name:
            following = states.get(following)
        if following:
            remarks.add(element, f"{shown(name)} is a derivative of itself; this is ignored")
        elif state:
            states[name] = state
    return states


def _name(text: str, what: str, element: Any, places: Places) -> str:
    if (name := places.get(text)) is not None:
        return name
    place = whole(text, what, element)  # it may be spelled with blanks or a sign
    if (name := places.get(str(place))) is None:
        raise DescriptionFault(element, f"{what} of {element.tag} is {place}, which is no variable")
    return name
