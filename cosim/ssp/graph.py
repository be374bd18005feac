"""Who feeds whom across the borders of nested systems and through signal dictionaries."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from cosim.errors import SspError
from cosim.fmu import Fmu
from cosim.names import suggestion
from cosim.scaling import IDENTITY, PLAIN, Link, Scaling
from cosim.ssp.markup import attribute, place, truth
from cosim.ssp.names import NAMESPACES, Path, component
from cosim.ssp.structure import Node
from cosim.ssp.transformation import scaling_of
from cosim.units import Unit

End = tuple[Path, str]
"""Path of an element and name of its connector; a dictionary ends its path with a blank name."""

_GIVES = {"output", "calculatedParameter", "local", "constant"}
_TAKES = {"input", "parameter", "structuralParameter"}


@dataclass(frozen=True)
class Edge:
    """A connection, turned so that the signal runs from source to target."""

    source: End
    target: End
    scaling: Scaling
    convert: bool
    element: Any


class Graph:
    """The connections of all nested systems.

    Attributes
    ----------
    nodes : path -> element, the outermost system at ()
    fmus : path -> FMU of each component
    edges : target -> the one connection that leads there
    onward : source -> the connections that lead away from there

    Raises
    ------
    SspError
        When a connection has an end that does not exist, joins two ends that both give or both
        take, or leads to an end that is fed already.
    """

    def __init__(self, top: Node, fmus: Mapping[Path, Fmu]) -> None:
        self.nodes = {node.path: node for node in top.walk()}
        self.fmus = fmus
        self.edges: dict[End, Edge] = {}
        self.onward: dict[End, list[Edge]] = defaultdict(list)
        for node in top.walk():
            for element in node.body.iterfind("ssd:Connections/ssd:Connection", NAMESPACES):
                self._join(node, element)

    def way_to(self, target: End) -> list[Edge]:
        """Return the connections that lead to an end, the one farthest from it first."""
        way: list[Edge] = []
        while edge := self.edges.get(target):
            if edge in way:
                raise SspError(f"{place(edge.element)}: the connection leads back to itself")
            way.append(edge)
            target = edge.source
        return way[::-1]

    def ways_from(self, source: End, seen: tuple[End, ...] = ()) -> Iterator[list[Edge]]:
        """Yield each way from an end to a component's variable."""
        if source in seen:
            raise SspError(f"{component(source[0])}: {source[1]} leads back to itself")
        for edge in self.onward[source]:
            if edge.target[0] in self.fmus:
                yield [edge]
            for rest in self.ways_from(edge.target, (*seen, source)):
                yield [edge, *rest]

    def is_component(self, end: End) -> bool:
        """Whether an end is a variable of an FMU."""
        return end[0] in self.fmus

    def unit(self, end: End) -> Unit | None:
        """Return the unit at an end; at a component what its connector says, else its FMU."""
        path, name = end
        if path and not path[-1]:
            return self.nodes[path[:-2]].dictionaries[path[-2]][name]
        connector = self.nodes[path].connectors.get(name)
        return (connector and connector.unit) or self.inner_unit(end)

    def inner_unit(self, end: End) -> Unit | None:
        """Return the unit of an FMU's variable, None at other ends."""
        fmu = self.fmus.get(end[0])
        variable = fmu and fmu.variables.get(end[1])
        return fmu.unit(variable) if fmu and variable else None

    def scaling(self, way: list[Edge], unit: Unit | None) -> Scaling:
        """Return what is done to a number in ``unit`` on a way, up to the FMU at its end."""
        total = IDENTITY
        for edge in way:
            there = self.unit(edge.target)
            if edge.convert:
                total = total.then(_converted(unit, there, edge))
            total = total.then(edge.scaling)
            unit = there or (unit if edge.convert and edge.scaling == IDENTITY else None)
        return total.then(_converted(unit, self.inner_unit(way[-1].target), way[-1]))

    def link(self, way: list[Edge]) -> Link:
        """Return a way from an FMU or from a connector of the whole as a single connection."""
        source, target = way[0].source, way[-1].target
        start = self.unit(source)
        total = _converted(self.inner_unit(source), start, way[0]).then(self.scaling(way, start))
        scaled = [i for i, edge in enumerate(way) if edge.scaling != IDENTITY]
        if all(edge.convert for edge in way) and len(scaled) <= 1:
            wanted = self.inner_unit(target)
            after = [self.unit(edge.target) for edge in way[scaled[0] :]] if scaled else []
            if all(not unit or (wanted and unit.same_as(wanted)) for unit in after):
                return Link(way[scaled[0]].scaling) if scaled else PLAIN
        usual = _converted(self.inner_unit(source) or start, self.inner_unit(target), way[-1])
        return PLAIN if total == usual else Link(total, convert=False)

    def _join(self, node: Node, element: Any) -> None:
        start, end = (self._end(node, element, which) for which in ("start", "end"))
        gives, takes = self._role(start, node.path), self._role(end, node.path)
        if gives == takes and gives != "either":
            raise SspError(f"{_connection(element)}: both ends {gives} a signal")
        if gives == "take" or takes == "give":  # start and end say nothing about the direction
            start, end = end, start
        if end in self.edges:
            other = place(self.edges[end].element)
            raise SspError(
                f"{place(element)}: {component(end[0])}.{end[1]} is fed already, by the connection"
                f" in {other}"
            )
        convert = not truth(element, "suppressUnitConversion")
        edge = Edge(start, end, scaling_of(element), convert, element)
        self.edges[end] = edge
        self.onward[start].append(edge)

    def _end(self, node: Node, element: Any, which: str) -> End:
        name = attribute(element, f"{which}Connector")
        inner = element.get(f"{which}Element")
        if element.get(f"{which}Indices"):
            raise SspError(f"{place(element)}: connections of single array elements are not read")
        if not inner:
            self._expect(name, node.connectors, f"the system has no connector {name!r}", element)
            return node.path, name
        self._expect(inner, node.children, f"there is no component {inner!r}", element)
        child = node.children[inner]
        if child.dictionary is not None:
            path = self._dictionary(child, element)
            entries = self.nodes[path[:-2]].dictionaries[path[-2]]
            self._expect(name, entries, f"the dictionary has no entry {name!r}", element)
            return path, name
        known = [*child.connectors, *(self.fmus[child.path].variables if child.fmu else ())]
        self._expect(name, known, f"{component(child.path)} has no connector {name!r}", element)
        return child.path, name

    def _dictionary(self, reference: Node, element: Any) -> Path:
        name = reference.dictionary or ""
        for n in range(len(reference.path) - 1, -1, -1):
            if name in self.nodes[reference.path[:n]].dictionaries:
                return (*reference.path[:n], name, "")
        raise SspError(f"{place(element)}: there is no signal dictionary {name!r}")

    def _expect(self, name: str, known: Any, message: str, element: Any) -> None:
        if name not in known:
            near = suggestion(name, dict.fromkeys(known))
            raise SspError(f"{_connection(element)}: {message}{near}")

    def _role(self, end: End, system: Path) -> str:
        path, name = end
        if path and not path[-1]:
            return "either"
        connector = self.nodes[path].connectors.get(name)
        kind = connector.kind if connector else "unspecified"
        if kind == "unspecified" and path in self.fmus:
            kind = self.fmus[path].variables[name].causality
        if kind not in _GIVES | _TAKES:
            return "either"
        gives = kind in _GIVES
        return "give" if gives != (path == system) else "take"


def _converted(unit: Unit | None, other: Unit | None, edge: Edge) -> Scaling:
    if unit is None or other is None:
        return IDENTITY
    scaling = unit.to(other)
    if scaling is None:
        raise SspError(
            f"{place(edge.element)}: cannot connect {_label(edge.source)} to {_label(edge.target)}:"
            f" {unit.name!r} cannot be converted to {other.name!r}"
        )
    return scaling


def _connection(element: Any) -> str:
    """Return the beginning of a complaint about a connection."""
    start, end = (
        ".".join(filter(None, (element.get(f"{which}Element"), element.get(f"{which}Connector"))))
        for which in ("start", "end")
    )
    return f"{place(element)}: cannot connect {start} to {end}"


def _label(end: End) -> str:
    return f"{component(end[0])}.{end[1]}" if end[0] else end[1]
