"""Connections across the borders of nested systems and through signal dictionaries."""

from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import product
from math import prod
from typing import Any

from stickslip.cosim.errors import SspError
from stickslip.cosim.fmu.fmu import Fmu
from stickslip.cosim.ssp.connectors import Connector, Items, check_types, scaling_of
from stickslip.cosim.ssp.markup import NAMESPACES, Path, attribute, component, place, truth
from stickslip.cosim.ssp.structure import Node
from stickslip.cosim.system.scaling import IDENTITY, PLAIN, Link, Scaling, conversion
from stickslip.fmi.description.units import Unit
from stickslip.fmi.description.variables import FAMILY, Variable, converts, parse_element
from stickslip.fmi.messages import suggestion

End = tuple[Path, str]
"""Path of an element and name of its connector; a dictionary ends its path with a blank name.

An element of an array is called ``name[i,j]``, counted from 1.
"""

_GIVES = {"output", "calculatedParameter", "local", "constant"}
_TAKES = {"input", "parameter", "structuralParameter"}
Shape = tuple[int, ...]
MOST_ELEMENTS = 1_000_000
_PARAMETERS = {"parameter", "structuralParameter", "calculatedParameter", "constant"}


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
    lengths : path -> structural parameters of a component other than their start values
    edges : target -> the one connection that leads there
    onward : source -> the connections that lead away from there
    """

    def __init__(self, top: Node, fmus: Mapping[Path, Fmu]) -> None:
        self.nodes = {node.path: node for node in top.walk()}
        self.fmus = fmus
        self.lengths: dict[Path, Mapping[str, int]] = {}
        self.edges: dict[End, Edge] = {}
        self.onward: dict[End, list[Edge]] = defaultdict(list)
        for node in top.walk():
            for element in node.body.iterfind("ssd:Connections/ssd:Connection", NAMESPACES):
                self._join(node, element)

    def put(self, edge: Edge) -> None:
        """Add a connection to an end that is not connected and does not lead back to it."""
        if other := self.edges.get(edge.target):
            what = f"is already connected, in {place(other.element)}; leave one of them"
            raise SspError(f"{place(edge.element)}: {label(edge.target)} {what}")
        if edge.target in (edge.source, *(before.source for before in self.way_to(edge.source))):
            raise SspError(f"{place(edge.element)}: the connection leads back to itself")
        self.edges[edge.target] = edge
        self.onward[edge.source].append(edge)

    def drop(self, edge: Edge) -> None:
        """Remove a connection."""
        del self.edges[edge.target]
        self.onward[edge.source].remove(edge)

    def way_to(self, target: End) -> list[Edge]:
        """Return the connections that lead to an end, the one farthest from it first."""
        way: list[Edge] = []
        while edge := self.edges.get(target):
            way.append(edge)
            target = edge.source
        return way[::-1]

    def ways_from(self, source: End) -> Iterator[list[Edge]]:
        """Yield each way from an end to a component's variable."""
        for edge in self.onward[source]:
            if edge.target[0] in self.fmus:
                yield [edge]
            for rest in self.ways_from(edge.target):
                yield [edge, *rest]

    def is_component(self, end: End) -> bool:
        """Whether an end is a variable of an FMU."""
        return end[0] in self.fmus

    def unit(self, end: End) -> Unit | None:
        """Return the unit of the connector at an end, else that of its variable."""
        connector = self.connector(end)
        return (connector and connector.unit) or self.inner_unit(end)

    def connector(self, end: End) -> Connector | None:
        """Return the connector at an end, of an element that of its array; None without one."""
        path, name = end
        known: Mapping[str, Connector] = (
            self.nodes[path[:-2]].dictionaries[path[-2]]
            if path and not path[-1]
            else self.nodes[path].connectors
        )
        element = parse_element(name)
        return known.get(name) or (known.get(element[0]) if element else None)

    def variable(self, end: End) -> Variable | None:
        """Return the FMU's variable at an end, None at other ends."""
        fmu = self.fmus.get(end[0])
        return fmu.find(end[1], self.lengths.get(end[0])) if fmu else None

    def type(self, end: End) -> str | None:
        """Return the type at an end, of SSP or FMI; None where it is not declared."""
        variable, connector = self.variable(end), self.connector(end)
        known = variable or connector
        return known.type if known else None

    def items(self, end: End) -> Items:
        """Return the items of the enumeration at an end."""
        variable, connector = self.variable(end), self.connector(end)
        return (connector and connector.items) or dict(variable.items if variable else ())

    def inner_unit(self, end: End) -> Unit | None:
        """Return the unit of an FMU's variable, None at other ends."""
        variable = self.variable(end)
        return self.fmus[end[0]].unit(variable) if variable else None

    def scaling(self, way: list[Edge], unit: Unit | None) -> Scaling:
        """Return the scaling of a number in ``unit`` on a way, up to the FMU at its end."""
        total: Scaling = IDENTITY
        last = self.inner_unit(way[-1].target)
        unit = unit and unit.like(last)
        for edge in way:
            there = self.unit(edge.target)
            there = there and there.like(unit or last)
            if edge.convert:
                total = total.then(_converted(unit, there, edge))
            total = total.then(edge.scaling)
            unit = there or (unit if edge.convert and edge.scaling == IDENTITY else None)
        return total.then(_converted(unit, last, way[-1]))

    def link(self, way: list[Edge]) -> Link:
        """Return a way from an FMU or from a connector of the whole as a single connection."""
        source, target = way[0].source, way[-1].target
        inner, start = self.inner_unit(source), self.unit(source)
        start = start and start.like(inner)
        total = _converted(inner, start, way[0]).then(self.scaling(way, start))
        scaled = [i for i, edge in enumerate(way) if edge.scaling != IDENTITY]
        if all(edge.convert for edge in way) and len(scaled) <= 1:
            wanted = self.inner_unit(target)
            after = [self.unit(edge.target) for edge in way[scaled[0] :]] if scaled else []
            if all(not unit or (wanted and unit.same_as(wanted)) for unit in after):
                return Link(way[scaled[0]].scaling) if scaled else PLAIN
        return Link(total, convert=False)

    def _join(self, node: Node, element: Any) -> None:
        start, end = (self._end(node, element, which) for which in ("start", "end"))
        self._check_declared(start, element)
        self._check_declared(end, element)
        gives, takes = self._role(start, node.path), self._role(end, node.path)
        if gives == takes and gives != "either":
            raise SspError(f"{_connection(element)}: both ends {gives} a signal")
        if gives == "take" or takes == "give":  # the standard leaves the direction to the ends
            start, end = end, start
        check_types(element, [(label(e), self.type(e)) for e in (start, end)])
        convert = not truth(element, "suppressUnitConversion")
        scaling = scaling_of(element)
        self.put(Edge(start, end, scaling, convert, element))

    def _end(self, node: Node, element: Any, which: str) -> End:
        name = attribute(element, f"{which}Connector")
        inner = element.get(f"{which}Element")
        indices = element.get(f"{which}Indices", "").split()
        at = f"[{','.join(indices)}]" if indices else ""
        if "0" in indices:
            raise SspError(f"{place(element)}: {which}Indices count from 1, got 0")
        if not inner:
            self._expect(name, node.connectors, f"the system has no connector {name!r}", element)
            return node.path, name + at
        self._expect(inner, node.children, f"there is no component {inner!r}", element)
        child = node.children[inner]
        if child.dictionary is not None:
            path = self._dictionary(child, element)
            entries = self.nodes[path[:-2]].dictionaries[path[-2]]
            self._expect(name, entries, f"the dictionary has no entry {name!r}", element)
            return path, name + at
        known = [*child.connectors, *(self.fmus[child.path].variables if child.fmu else ())]
        if self.variable((child.path, name)) is None:
            self._expect(name, known, f"{component(child.path)} has no connector {name!r}", element)
        return child.path, name + at

    def _check_declared(self, end: End, element: Any) -> None:
        variable, connector = self.variable(end), self.connector(end)
        if variable is None or connector is None:
            return
        roles = {connector.kind, variable.causality}
        declared, is_ = FAMILY.get(connector.type or ""), variable.family
        differ = declared and not (
            (connector.kind not in _GIVES and converts(declared, is_))
            or (connector.kind not in _TAKES and converts(is_, declared))
        )
        if roles == {"input", "output"} or differ:
            what = f"{label(end)} is declared as {connector.kind} {connector.type or ''}"
            advice = f"its FMU has {variable.causality} {variable.type}; correct the connector"
            raise SspError(f"{place(element)}: {what}, {advice}")

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
        path = end[0]
        if path and not path[-1]:
            return "either"
        connector, variable = self.connector(end), self.variable(end)
        kind = connector.kind if connector else "unspecified"
        if kind == "unspecified" and variable:
            kind = variable.causality
        if kind not in _GIVES | _TAKES:
            return "either"
        gives = kind in _GIVES
        return "give" if gives != (path == system) else "take"


def _converted(unit: Unit | None, other: Unit | None, edge: Edge) -> Scaling:
    if unit is None or other is None:
        return IDENTITY
    scaling = conversion(unit, other)
    if scaling is None:
        unknown = [u.name for u in (unit, other) if u.exponents is None]
        undefined = [f"; no file defines what {name!r} is" for name in unknown]
        what = f"to {label(edge.target)}: {unit} cannot be converted to {other}{''.join(undefined)}"
        raise SspError(f"{place(edge.element)}: cannot connect {label(edge.source)} {what}")
    return scaling


def _connection(element: Any) -> str:
    """Return the beginning of an error message about a connection."""
    start, end = (
        ".".join(filter(None, (element.get(f"{which}Element"), element.get(f"{which}Connector"))))
        for which in ("start", "end")
    )
    return f"{place(element)}: cannot connect {start} to {end}"


def label(end: End) -> str:
    """Return an end as messages name it."""
    return f"{component(end[0])}.{end[1]}" if end[0] else end[1]


def expand(graph: Graph) -> None:
    """Replace each connection of whole arrays (SSP 2.0) by connections of their elements."""
    shapes = []
    for edge in graph.edges.values():
        variable, connector = graph.variable(edge.target), graph.connector(edge.target)
        kind = variable.causality if variable else connector and connector.kind
        if kind not in _PARAMETERS:
            shapes.append((edge, _shape_at(graph, edge)))
    for edge, shape in shapes:
        if not shape:
            continue
        if prod(shape) > MOST_ELEMENTS:
            what = f"to {label(edge.target)}: {prod(shape)} elements, at most {MOST_ELEMENTS} are"
            raise SspError(f"{place(edge.element)}: cannot connect {label(edge.source)} {what}")
        graph.drop(edge)
        for place_ in product(*(range(1, n + 1) for n in shape)):
            text = f"[{','.join(map(str, place_))}]"
            source, target = ((path, name + text) for path, name in (edge.source, edge.target))
            graph.put(replace(edge, source=source, target=target))


def _shape_at(graph: Graph, edge: Edge) -> Shape:
    source, target = (_shape(graph, end, edge, ()) for end in (edge.source, edge.target))
    if source != target:
        what = f"to {label(edge.target)}: their dimensions are {source} and {target}"
        raise SspError(f"{place(edge.element)}: cannot connect {label(edge.source)} {what}")
    return source


def _shape(graph: Graph, end: End, edge: Edge, seen: tuple[End, ...]) -> Shape:
    variable, connector = graph.variable(end), graph.connector(end)
    element = connector is not None and connector.name != end[1]
    declared = connector.dimensions if connector and not element else ()
    if variable:
        wanted = [n for n in declared if n is not None]
        if wanted and declared != variable.dimensions:
            raise SspError(
                f"{place(edge.element)}: the connector {label(end)} has the dimensions {declared},"
                f" its FMU's variable {variable.dimensions}; correct the connector"
            )
        return variable.dimensions
    if element and connector:
        lengths = connector.dimensions
        _, indices = parse_element(end[1]) or ("", ())
        fit = [n is None or i <= n for i, n in zip(indices, lengths, strict=False)]
        if len(indices) != len(lengths) or not all(fit):
            what = f"{label(end)} is not an element of an array of the dimensions {lengths}"
            raise SspError(f"{place(edge.element)}: {what}")
    if None not in declared:
        return tuple(n for n in declared if n is not None)
    before = [graph.edges[end].source] if end in graph.edges else []
    for other in (*before, *(e.target for e in graph.onward[end])):
        if other not in seen:
            return _shape(graph, other, edge, (*seen, end))
    raise SspError(f"{place(edge.element)}: the length of the array {label(end)} is not declared")
