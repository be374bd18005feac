"""Parameter bindings: values from .ssv files, by way of mappings from .ssm files."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

from stickslip.cosim.errors import SspError
from stickslip.cosim.ssp.connectors import Definitions, Items
from stickslip.cosim.ssp.graph import End, Graph
from stickslip.cosim.ssp.markup import (
    attribute,
    check,
    find,
    inside,
    integer,
    local,
    parse,
    place,
    truth,
)
from stickslip.cosim.ssp.names import NAMESPACES, component, tag
from stickslip.cosim.ssp.structure import Node
from stickslip.cosim.ssp.transformation import pairs_of_names, transform_of
from stickslip.cosim.system.scaling import IDENTITY, Transform, ValueMap, conversion
from stickslip.fmi.archive import unpack
from stickslip.fmi.description.units import Unit
from stickslip.fmi.description.variables import FAMILY, Value
from stickslip.fmi.messages import suggestion

_SET, _MAPPING = "application/x-ssp-parameter-set", "application/x-ssp-parameter-mapping"
_WORDS = {"true": 1, "false": 0}

Raw = float | str | tuple[float, ...]
"""A number, the numbers of an array, or any other value as text."""


@dataclass(frozen=True)
class ParameterValue:
    """A parameter as a file gives it.

    Attributes
    ----------
    value : a number, numbers or text; of an enumeration the name of the item
    unit : of the number, None where it is not declared
    element : for messages
    convert : whether the number is converted to the unit of what it is given to
    scaling : applied to it after that
    items : of the enumeration, as the file defines it; None for other types
    """

    value: Raw
    unit: Unit | None
    element: Any
    convert: bool = True
    scaling: Transform = IDENTITY
    items: Items | None = None

    def at(self, unit: Unit | None, items: Items) -> Raw:
        """Return the value for something that has this unit or these items of an enumeration."""
        value = self.value if self.items is None else self._number({**self.items, **items})
        if self.unit and unit and self.convert:
            converted = conversion(self.unit, unit)
            if converted is None:
                name = self.element.get("name") or self.element.get("target")
                undefined = " and is not defined by its file" if not self.unit.exponents else ""
                raise SspError(
                    f"{place(self.element)}: parameter {name!r} is given in {self.unit.name!r},"
                    f" which cannot be converted to {unit.name!r}{undefined}; correct the unit, or"
                    " set suppressUnitConversion in a mapping"
                )
            value = _scaled(value, converted, self.element)
        return _scaled(value, self.scaling, self.element)

    def _number(self, items: Items) -> str:
        if self.value not in items:
            near = suggestion(str(self.value), items)
            raise SspError(
                f"{place(self.element)}: no enumeration with an item {self.value!r} is"
                f" defined{near}"
            )
        return str(items[str(self.value)])


def read_parameters(graph: Graph) -> dict[str, tuple[Value, Any]]:
    """Return the start values by ``component.variable``, each with the element that gives it.

    Outer systems go before inner ones, later bindings before earlier ones.
    """
    values: dict[str, tuple[Value, Any]] = {}
    for node in sorted(graph.nodes.values(), key=lambda node: -len(node.path)):
        for owner, body in _bindings_of(node):
            for binding in body.iterfind("ssd:ParameterBindings/ssd:ParameterBinding", NAMESPACES):
                for name, given in _read_binding(binding, owner).items():
                    for end, value in _resolve(graph, node, name, given):
                        values[f"{component(end[0])}.{end[1]}"] = (value, given.element)
    return values


def _bindings_of(node: Node) -> Iterator[tuple[Node, Any]]:
    """Yield the elements that hold bindings of a node; of a nested file, it and its component."""
    yield replace(node, document=node.body_document), node.body
    if node.element is not None and node.element is not node.body:
        yield node, node.element


def _read_binding(binding: Any, node: Node) -> dict[str, ParameterValue]:
    root = _content(binding, node, _SET, "ssv", "ssd:ParameterValues/ssv:ParameterSet")
    definitions = Definitions.of(root).within(node.document.definitions)
    prefix = binding.get("prefix", "")
    given: dict[str, ParameterValue] = {}
    for parameter in root.iterfind("ssv:Parameters/ssv:Parameter", NAMESPACES):
        name, value = prefix + attribute(parameter, "name"), _read_value(parameter, definitions)
        if name in given and (value.value, value.unit) != (given[name].value, given[name].unit):
            raise SspError(f"{place(parameter)}: {name!r} has two values in one set; keep one")
        given[name] = value
    mapping = binding.find("ssd:ParameterMapping", NAMESPACES)
    if mapping is None:
        return given
    root = _content(mapping, node, _MAPPING, "ssm", "ssm:ParameterMapping")
    mapped: dict[str, ParameterValue] = {}
    for entry in root.iterfind("ssm:MappingEntry", NAMESPACES):
        if entry.get("source") == "":  # the target keeps its value, as in OMSimulator
            continue
        if (target := attribute(entry, "target")) in mapped:
            raise SspError(f"{place(entry)}: target {target!r} has two sources; keep one")
        mapped[target] = _mapped(entry, given)
    return mapped


def _content(element: Any, node: Node, kind: str, part: str, path: str) -> Any:
    """Return what an element holds, or names as its source."""
    if element.get("type", kind) != kind:
        raise SspError(f"{place(element)}: {element.get('type')} is not supported")
    if element.get("source") is None:
        root = find(element, path)
        check(root, part)
        return root
    if element.get("sourceBase") != "component":
        return parse(node.document.locate(element), part)
    if node.fmu is None:
        raise SspError(f"{place(element)}: sourceBase 'component' needs a component")
    folder = unpack(node.fmu, "fmus", SspError)
    return parse(inside(folder, folder, element), part)


def _read_value(parameter: Any, definitions: Definitions) -> ParameterValue:
    element = next(parameter.iterchildren(tag("ssv:*")), None)
    if element is None:
        raise SspError(f"{place(parameter)}: parameter {parameter.get('name')!r} has no value")
    text, family = attribute(element, "value"), FAMILY.get(local(element))
    if family == "number":
        return ParameterValue(
            _numbers(text, element), definitions.unit(element.get("unit")), parameter
        )
    if family == "enumeration":
        return ParameterValue(text, None, parameter, items=_items(element.get("name"), definitions))
    return ParameterValue(text, None, parameter)


def _items(name: str | None, definitions: Definitions) -> Items:
    """Return the items of an enumeration, of all that are defined where it has no name."""
    if name is not None:
        return definitions.enumerations.get(name, {})
    return {item: n for items in definitions.enumerations.values() for item, n in items.items()}


def _numbers(text: str, element: Any) -> float | tuple[float, ...]:
    """Return the number that a text holds, or the numbers of an array row by row."""
    try:
        numbers = tuple(float(word) for word in text.split())
    except ValueError:
        numbers = ()
    if not numbers:
        raise SspError(f"{place(element)}: value is {text!r}, expected a number or several")
    return numbers if len(numbers) > 1 else numbers[0]


def _mapped(entry: Any, given: dict[str, ParameterValue]) -> ParameterValue:
    source = attribute(entry, "source")
    if source not in given:
        raise SspError(
            f"{place(entry)}: there is no parameter {source!r}{suggestion(source, given)}"
        )
    value = given[source]
    if pairs := pairs_of_names(entry):
        return replace(value, value=pairs.get(str(value.value), value.value), element=entry)
    convert = not truth(entry, "suppressUnitConversion")
    return replace(value, convert=convert, scaling=transform_of(entry, {}, {}), element=entry)


def _resolve(
    graph: Graph, node: Node, name: str, given: ParameterValue
) -> Iterator[tuple[End, Value]]:
    """Yield the variables of components that a parameter reaches, with its value there."""
    if node.fmu is not None:
        end = (node.path, name)
        yield end, given.at(graph.inner_unit(end), graph.items(end))
        return
    first, _, rest = name.partition(".")
    if name in node.connectors:
        unit = node.connectors[name].unit
        for way in graph.ways_from((node.path, name)):
            scaling = graph.scaling(way, unit or given.unit)
            items = graph.items((node.path, name)) or graph.items(way[-1].target)
            yield way[-1].target, _scaled(given.at(unit, items), scaling, given.element)
    elif first in node.children and rest:
        yield from _resolve(graph, node.children[first], rest, given)
    else:
        known = [*node.connectors, *(f"{child}." for child in node.children)]
        raise SspError(f"{place(given.element)}: no parameter {name!r}{suggestion(name, known)}")


def _scaled(value: Raw, scaling: Transform, element: Any) -> Raw:
    if scaling == IDENTITY:
        return value
    if isinstance(scaling, ValueMap):
        text = str(value).strip()
        return str(int(scaling(_WORDS[text] if text in _WORDS else integer(text, element))))
    if isinstance(value, str):
        value = _numbers(value, element)
    return tuple(map(scaling, value)) if isinstance(value, tuple) else scaling(value)
