"""From modelDescription.xml to a Description. Takes whatever is there; complaining is for rules."""

from __future__ import annotations

from collections.abc import Iterator

from stickslip.fmucheck.description.model import (
    FLOATS,
    INITIALS,
    Attributes,
    Description,
    Dimension,
    Interface,
    TypeDefinition,
    Unit,
    Unknown,
    Variable,
    whole,
)
from stickslip.fmucheck.document import Element

_INTERFACES = ("ModelExchange", "CoSimulation", "ScheduledExecution")
_PARAMETERS = ("parameter", "calculatedParameter", "structuralParameter")
# The lists of FMI 2.0 under the names that FMI 3.0 gives their members.
_GROUPS = {
    "Outputs": "Output",
    "Derivatives": "ContinuousStateDerivative",
    "InitialUnknowns": "InitialUnknown",
}


def read_description(root: Element, version: int) -> Description:
    """Read a description of FMI 2.0 or FMI 3.0."""
    types = [_type(each, version) for each in _inside(root, "TypeDefinitions")]
    by_name = {each.name: each for each in types}
    variables = [
        _variable(each, index, version, by_name)
        for index, each in enumerate(_inside(root, "ModelVariables"), 1)
    ]
    experiment = root.find("DefaultExperiment")
    description = Description(
        version=version,
        root=_attributes(root),
        interfaces=[_interface(each) for each in _elements(root) if each.tag in _INTERFACES],
        units=[_unit(each) for each in _inside(root, "UnitDefinitions")],
        types=types,
        categories=[each.get("name", "") for each in _inside(root, "LogCategories")],
        experiment=None if experiment is None else _attributes(experiment),
        variables=variables,
    )
    description.unknowns = list(_unknowns(root, description))
    return description


def _elements(parent: Element) -> list[Element]:
    """Return the children that are elements; comments and entities are not."""
    return [child for child in parent if isinstance(child.tag, str)]


def _inside(root: Element, tag: str) -> list[Element]:
    found = root.find(tag)
    return [] if found is None else _elements(found)


def _attributes(element: Element) -> Attributes:
    return {str(key): str(value) for key, value in element.attrib.items()}


def _line(element: Element) -> int:
    return element.sourceline or 0


def _interface(element: Element) -> Interface:
    sources = tuple(file.get("name", "") for file in element.iterfind("SourceFiles/File"))
    return Interface(str(element.tag), _line(element), _attributes(element), sources)


def _unit(element: Element) -> Unit:
    base = element.find("BaseUnit")
    return Unit(
        name=element.get("name", ""),
        line=_line(element),
        base=None if base is None else _attributes(base),
        display=tuple(_attributes(each) for each in element.iterfind("DisplayUnit")),
    )


def _type(element: Element, version: int) -> TypeDefinition:
    inner = element
    if version == 2:
        inner = next(iter(_elements(element)), element)
    return TypeDefinition(
        name=element.get("name", ""),
        kind=str(inner.tag).removesuffix("Type"),
        line=_line(element),
        given=_attributes(inner),
        items=tuple((i.get("name", ""), i.get("value", "")) for i in inner.iterfind("Item")),
    )


def _variable(
    element: Element, index: int, version: int, types: dict[str, TypeDefinition]
) -> Variable:
    given, kind = _attributes(element), str(element.tag)
    if version == 2:
        inner = next((e for e in _elements(element) if e.tag != "Annotations"), element)
        given, kind = given | _attributes(inner), str(inner.tag)
    causality = given.get("causality", "local")
    variability = given.get("variability") or _variability(causality, kind, version)
    allowed = INITIALS.get((causality, variability), ())
    clocks = given.get("clocks")
    return Variable(
        index=index,
        line=_line(element),
        name=given.get("name", ""),
        reference=whole(given.get("valueReference")),
        kind=kind,
        causality=causality,
        variability=variability,
        initial=given.get("initial") or (allowed[0] if allowed else None),
        given=given,
        start=_start(element, given, kind, version),
        derivative=whole(given.get("derivative")),
        previous=whole(given.get("previous")),
        clocks=None if clocks is None else tuple(whole(c) or 0 for c in clocks.split()),
        dimensions=tuple(
            Dimension(whole(d.get("start")), whole(d.get("valueReference")))
            for d in element.iterfind("Dimension")
        ),
        aliases=tuple(_attributes(alias) for alias in element.iterfind("Alias")),
        type=types.get(given.get("declaredType", "")),
    )


def _variability(causality: str, kind: str, version: int) -> str:
    """Return the default: FMI 2.0.5, 2.2.7; FMI 3.0.2, 2.4.7.4."""
    if version == 2:
        return "continuous"
    if causality in _PARAMETERS:
        return "fixed"
    return "continuous" if kind in FLOATS else "discrete"


def _start(element: Element, given: Attributes, kind: str, version: int) -> tuple[str, ...] | None:
    if version == 3 and kind in ("String", "Binary"):
        return tuple(each.get("value", "") for each in element.iterfind("Start")) or None
    text = given.get("start")
    if text is None or version == 2:
        return None if text is None else (text,)
    return tuple(text.split())


def _unknowns(root: Element, description: Description) -> Iterator[Unknown]:
    for child in _inside(root, "ModelStructure"):
        if description.version == 3:
            yield _unknown(child, str(child.tag), "valueReference", description)
        else:
            group = _GROUPS.get(str(child.tag), str(child.tag))
            for entry in _elements(child):
                yield _unknown(entry, group, "index", description)


def _unknown(element: Element, group: str, key: str, description: Description) -> Unknown:
    def variable(text: str) -> Variable | None:
        place = whole(text)
        return None if place is None else description.by_key.get(place)

    depends, kinds = element.get("dependencies"), element.get("dependenciesKind")
    return Unknown(
        group=group,
        line=_line(element),
        key=element.get(key, ""),
        variable=variable(element.get(key, "")),
        dependencies=None if depends is None else tuple((d, variable(d)) for d in depends.split()),
        kinds=None if kinds is None else tuple(kinds.split()),
    )
