"""Reads an SSP 1.0 or 2.0 package as a system without nesting, and its parameter bindings."""

from __future__ import annotations

import os
from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

from stickslip.cosim.component import component_of, variable_of
from stickslip.cosim.errors import CosimError, SspError
from stickslip.cosim.fmu.fmu import Fmu
from stickslip.cosim.ssp.connectors import Definitions, Items, scaling_of
from stickslip.cosim.ssp.graph import End, Graph, expand, label
from stickslip.cosim.ssp.markup import (
    ANNOTATION,
    NAMESPACES,
    OSP,
    Path,
    attribute,
    check,
    component,
    find,
    inside,
    local,
    number,
    parse,
    place,
    tag,
    truth,
)
from stickslip.cosim.ssp.structure import Node, Package, read_structure
from stickslip.cosim.system.scaling import IDENTITY, Link, Scaling, conversion
from stickslip.cosim.system.system import Origin, System
from stickslip.fmi.archive import unpack
from stickslip.fmi.description.model import DefaultExperiment
from stickslip.fmi.description.units import Unit
from stickslip.fmi.description.variables import FAMILY, Value
from stickslip.fmi.messages import suggestion


def read_ssp(
    path: str | os.PathLike[str], variant: str | None = None
) -> tuple[System, DefaultExperiment]:
    """Read a system and the times it proposes.

    Components of nested systems are called ``outer/inner``, so that their variables are
    ``outer/inner.variable``. The system remembers the package: written again, it keeps all that is
    not read of it.

    Parameters
    ----------
    path : the ``.ssp`` file
    variant : name of one of ``variants(path)``, or of its file; the default one if left out

    Raises
    ------
    SspError : when the file is not an SSP package, or a component is not an FMU
    """
    package = Package.open(path, variant)
    try:
        return read_package(package)[:2]
    except CosimError as fault:
        raise SspError(f"{package.path}: {fault}") from fault


def read_package(package: Origin) -> tuple[System, DefaultExperiment, Graph]:
    """Read a system, its default experiment and the graph that it was flattened from."""
    top = read_structure(package.folder / package.structure, package.folder)
    system = System(top.body.get("name") or "system")
    fmus: dict[Path, Fmu] = {}
    for node in top.walk():
        if node.fmu is not None:
            with _blaming(node.element):
                system.add(component(node.path), node.fmu)
            fmus[node.path] = system.fmus("an SSP")[component(node.path)]
    graph = Graph(top, fmus)
    parameters = sorted(  # those ahead that say how long arrays are
        read_parameters(graph).items(),
        key=lambda item: (
            variable_of(item[0]) not in system.components[component_of(item[0])].structural
        ),
    )
    for name, (value, element) in parameters:
        with _blaming(element):
            system.set(name, value)
    graph.lengths = {path: system.lengths(component(path)) for path in fmus}
    expand(graph)
    _connect(system, graph)
    _show_outputs(system, graph)
    system.origin = package
    return system, read_experiment(top.document.root), graph


def read_experiment(root: Any) -> DefaultExperiment:
    """Return the times that a SystemStructureDescription proposes."""
    element = root.find("ssd:DefaultExperiment", NAMESPACES)
    if element is None:
        return DefaultExperiment()
    algorithm = f"ssd:Annotations/ssc:Annotation[@type='{ANNOTATION}']/{{{OSP}}}Algorithm"
    step = element.find(f"{algorithm}/{{{OSP}}}FixedStepAlgorithm", NAMESPACES)
    start, stop = _time(element, "startTime"), _time(element, "stopTime")
    times = DefaultExperiment(start, stop, None if step is None else _time(step, "baseStepSize"))
    if times.stop is not None and times.stop <= (times.start or 0.0):
        what = f"expected a time after startTime = {times.start or 0.0} s"
        raise SspError(f"{place(element)}: stopTime is {times.stop} s, {what}")
    if times.step is not None and times.step <= 0:
        raise SspError(f"{place(step)}: baseStepSize is {times.step} s, expected a positive one")
    return times


def _connect(system: System, graph: Graph) -> None:
    exposed: dict[str, dict[str, Link]] = defaultdict(dict)
    for target in [end for end in graph.edges if graph.is_component(end)]:
        way = graph.way_to(target)
        source, name = way[0].source, label(target)
        kind = system.variable(name).causality
        if kind != "input":
            if graph.is_component(source):
                ends = f"{label(source)} to {name}"
                raise SspError(f"{place(way[-1].element)}: cannot connect {ends}: it is a {kind}")
            continue  # a parameter that a binding sets through a connector
        link = graph.link(way)
        with _blaming(way[-1].element):
            if graph.is_component(source):
                system.connect(label(source), name, link)
            elif source[0] == ():
                exposed[source[1]][name] = link
    for name, links in exposed.items():
        with _blaming(graph.onward[(), name][0].element):
            unit, first = graph.unit(((), name)), system.unit_of(next(iter(links)))
            other = unit if unit and not (first and unit.same_as(first)) else None
            system.expose(name, *links, unit=other, links=links)


def _show_outputs(system: System, graph: Graph) -> None:
    for path, name in [end for end in graph.edges if end[0] == ()]:
        way, connector = graph.way_to((path, name)), graph.connector((path, name))
        if connector and connector.kind == "output" and graph.is_component(way[0].source):
            with _blaming(way[-1].element):
                system.expose_output(name, label(way[0].source))


def _time(element: Any, name: str) -> float | None:
    return None if element.get(name) is None else number(element, name, 0.0)


@contextmanager
def _blaming(element: Any) -> Iterator[None]:
    """Add file and line of an element to errors."""
    try:
        yield
    except CosimError as fault:
        raise SspError(f"{place(element)}: {fault}") from fault


_SET, _MAPPING = "application/x-ssp-parameter-set", "application/x-ssp-parameter-mapping"
Raw = float | str | tuple[float, ...]
"""A number, the numbers of an array, or any other value as text."""


@dataclass(frozen=True)
class ParameterValue:
    """A parameter as a file gives it, with what happens to it on the way.

    The value of an enumeration is the name of an item among ``items``, which are None for other
    types.
    """

    value: Raw
    unit: Unit | None
    element: Any
    convert: bool = True
    scaling: Scaling = IDENTITY
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
            what = f"no enumeration with an item {self.value!r} is defined{near}"
            raise SspError(f"{place(self.element)}: {what}")
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
        unit = definitions.unit(element.get("unit"))
        return ParameterValue(_numbers(text, element), unit, parameter)
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
        what = f"there is no parameter {source!r}{suggestion(source, given)}"
        raise SspError(f"{place(entry)}: {what}")
    convert = not truth(entry, "suppressUnitConversion")
    return replace(given[source], convert=convert, scaling=scaling_of(entry), element=entry)


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


def _scaled(value: Raw, scaling: Scaling, element: Any) -> Raw:
    if scaling == IDENTITY:
        return value
    if isinstance(value, str):
        value = _numbers(value, element)
    return tuple(map(scaling, value)) if isinstance(value, tuple) else scaling(value)
