"""Transformations of SSP: a straight line for numbers, a list of pairs for other values."""

from __future__ import annotations

from typing import Any

from cosim.errors import SspError
from cosim.scaling import IDENTITY, Scaling
from cosim.ssp.markup import attribute, local, number, place
from cosim.ssp.names import NAMESPACES, tag

_MAPS = [tag(f"ssc:{name}MappingTransformation") for name in ("Boolean", "Integer", "Enumeration")]


def scaling_of(element: Any) -> Scaling:
    """Return the line that a connection or a mapping entry holds, y = x where there is none.

    Raises
    ------
    SspError
        When it holds a list of pairs: signals are numbers on their way.
    """
    for mapping in element.iterchildren(*_MAPS):
        raise SspError(f"{place(mapping)}: {local(mapping)} of a signal is not supported")
    line = element.find("ssc:LinearTransformation", NAMESPACES)
    if line is None:
        return IDENTITY
    return Scaling(number(line, "factor", 1.0), number(line, "offset", 0.0))


def pairs_of(element: Any) -> dict[str, str] | None:
    """Return the list of pairs source -> target that a mapping entry holds, None without one."""
    for mapping in element.iterchildren(*_MAPS):
        entries = mapping.iterfind("ssc:MapEntry", NAMESPACES)
        return {attribute(entry, "source"): attribute(entry, "target") for entry in entries}
    return None
