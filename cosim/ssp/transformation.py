"""Transformations of SSP: a straight line for numbers, pairs for other values."""

from __future__ import annotations

from typing import Any

from stickslip.cosim.errors import SspError
from stickslip.cosim.ssp.compose import add
from stickslip.cosim.ssp.connectors import Items
from stickslip.cosim.ssp.markup import attribute, integer, local, number, place
from stickslip.cosim.ssp.names import NAMESPACES, tag
from stickslip.cosim.system.scaling import IDENTITY, Scaling, Transform, ValueMap
from stickslip.fmi.description.variables import FAMILY, Variable, converts
from stickslip.fmi.messages import suggestion

_WORDS = {"true": 1, "1": 1, "false": 0, "0": 0}
_FITS = {
    "Linear": {"number", "integer"},
    "BooleanMapping": {"Boolean"},
    "IntegerMapping": {"integer", "enumeration"},
    "EnumerationMapping": {"enumeration"},
}


def transform_of(element: Any, start: Items, end: Items) -> Transform:
    """Return what a connection or mapping entry does to a value, nothing where it says nothing.

    Parameters
    ----------
    start, end : items of the enumerations at its ends

    Raises
    ------
    SspError
        When a pair names no value of its type, or two pairs are for one value.
    """
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
    """Check that the ends of a connection have types that fit together and its transformation.

    Parameters
    ----------
    ends : of source and target the name, for messages, and the type of SSP or FMI, None where
        nothing is known
    """
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
    """Write what a connection does to a value.

    Raises
    ------
    SspError
        When SSP cannot express it.
    """
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
