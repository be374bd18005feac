"""Parameter bindings: values from .ssv files, by way of mappings from .ssm files."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

from cosim.archive import unpack
from cosim.errors import SspError
from cosim.names import suggestion
from cosim.scaling import IDENTITY, Scaling
from cosim.ssp.graph import End, Graph
from cosim.ssp.markup import attribute, check, find, inside, local, parse, place, truth
from cosim.ssp.names import NAMESPACES, component, tag
from cosim.ssp.structure import Node, read_units
from cosim.ssp.transformation import pairs_of, scaling_of
from cosim.units import Unit
from cosim.variables import Value

_SET, _MAPPING = "application/x-ssp-parameter-set", "application/x-ssp-parameter-mapping"
_NUMBERS = {"Real", "Float64", "Float32"}


@dataclass(frozen=True)
class Given:
    """A parameter as a file gives it.

    Attributes
    ----------
    value : a number or text
    unit : of the number, None where none is said
    element : for messages
    convert : whether the number is converted to the unit of what it is given to
    scaling : applied to it after that
    """

    value: float | str
    unit: Unit | None
    element: Any
    convert: bool = True
    scaling: Scaling = IDENTITY

    def at(self, unit: Unit | None) -> float | str:
        """Return the value for something that has this unit."""
        value: float | str = self.value
        if self.unit and unit and self.convert:
            converted = self.unit.to(unit)
            if converted is None:
                raise SspError(
                    f"{place(self.element)}: parameter {self.element.get('name')!r} is given in"
                    f" {self.unit.name!r}, which cannot be converted to {unit.name!r}"
                )
            value = _scaled(value, converted, self.element)
        return _scaled(value, self.scaling, self.element)


def read_parameters(graph: Graph) -> dict[str, tuple[Value, Any]]:
    """Return the start values by ``component.variable``, each with the element that gives it.

    Outer systems go before inner ones, later bindings before earlier ones.

    Raises
    ------
    SspError
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


def _read_binding(binding: Any, node: Node) -> dict[str, Given]:
    root = _content(binding, node, _SET, "ssv", "ssd:ParameterValues/ssv:ParameterSet")
    units = dict(node.document.units) | read_units(root)
    prefix = binding.get("prefix", "")
    given = {}
    for parameter in root.iterfind("ssv:Parameters/ssv:Parameter", NAMESPACES):
        given[prefix + attribute(parameter, "name")] = _read_value(parameter, units, root, node)
    mapping = binding.find("ssd:ParameterMapping", NAMESPACES)
    if mapping is None:
        return given
    root = _content(mapping, node, _MAPPING, "ssm", "ssm:ParameterMapping")
    return {
        attribute(entry, "target"): _mapped(entry, given)
        for entry in root.iterfind("ssm:MappingEntry", NAMESPACES)
    }


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


def _read_value(parameter: Any, units: dict[str, Unit], root: Any, node: Node) -> Given:
    element = next(parameter.iterchildren(tag("ssv:*")), None)
    if element is None:
        raise SspError(f"{place(parameter)}: parameter {parameter.get('name')!r} has no value")
    text, unit = attribute(element, "value"), element.get("unit")
    kind = local(element)
    if kind in _NUMBERS:
        given = units.get(unit, Unit(unit)) if unit else None
        return Given(_number(text, element), given, parameter)
    if kind == "Enumeration":
        text = _item(element, text, root, node)
    return Given(text, None, parameter)


def _number(text: str, element: Any) -> float:
    try:
        return float(text)
    except ValueError:
        raise SspError(
            f"{place(element)}: value is {text!r}, expected one number;"
            " parameters that are arrays are not supported"
        ) from None


def _item(element: Any, text: str, root: Any, node: Node) -> str:
    """Return the number of an item of an enumeration as text."""
    name = element.get("name")
    for source in (root, node.document.root):
        for enumeration in source.iter(tag("ssc:Enumeration")):
            if name is None or enumeration.get("name") == name:
                for item in enumeration.iterfind("ssc:Item", NAMESPACES):
                    if item.get("name") == text:
                        return attribute(item, "value")
    raise SspError(
        f"{place(element)}: no enumeration {name or ''} with an item {text!r} is defined"
    )


def _mapped(entry: Any, given: dict[str, Given]) -> Given:
    source = attribute(entry, "source")
    if source not in given:
        raise SspError(
            f"{place(entry)}: there is no parameter {source!r}{suggestion(source, given)}"
        )
    value = given[source]
    pairs = pairs_of(entry)
    if pairs is not None:
        if value.value not in pairs:
            raise SspError(f"{place(entry)}: no pair for the value {value.value!r}")
        return replace(value, value=pairs[str(value.value)], element=entry)
    convert = not truth(entry, "suppressUnitConversion")
    return replace(value, convert=convert, scaling=scaling_of(entry), element=entry)


def _resolve(graph: Graph, node: Node, name: str, given: Given) -> Iterator[tuple[End, Value]]:
    """Yield the variables of components that a parameter reaches, with its value there."""
    if node.fmu is not None:
        end = (node.path, name)
        yield end, given.at(graph.inner_unit(end))
        return
    first, _, rest = name.partition(".")
    if name in node.connectors:
        unit = node.connectors[name].unit
        for way in graph.ways_from((node.path, name)):
            scaling = graph.scaling(way, unit or given.unit)
            yield way[-1].target, _scaled(given.at(unit), scaling, given.element)
    elif first in node.children and rest:
        yield from _resolve(graph, node.children[first], rest, given)
    else:
        known = [*node.connectors, *(f"{child}." for child in node.children)]
        raise SspError(f"{place(given.element)}: no parameter {name!r}{suggestion(name, known)}")


def _scaled(value: float | str, scaling: Scaling, element: Any) -> float | str:
    if scaling == IDENTITY:
        return value
    return scaling(value if isinstance(value, float) else _number(value, element))
