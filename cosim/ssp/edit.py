"""Changes an SSP description: components, connections across nested systems, connectors."""

from itertools import takewhile

from stickslip.cosim.errors import SspError
from stickslip.cosim.fmu.fmu import Fmu
from stickslip.cosim.ssp.connectors import Connector, add_transformation
from stickslip.cosim.ssp.graph import Edge, End, Graph
from stickslip.cosim.ssp.markup import (
    FMU,
    Path,
    add,
    add_connector,
    add_units,
    component,
    discard,
    group,
)
from stickslip.cosim.ssp.structure import Node
from stickslip.cosim.system.scaling import IDENTITY, PLAIN, Link
from stickslip.fmi.description.units import Unit
from stickslip.fmi.description.variables import Variable

_TEXTS = {"String", "Binary"}


class Editor:
    """A description, or ``document``, being changed; the tree and the graph change together."""

    def __init__(self, graph: Graph, version: str) -> None:
        self.graph, self.document = graph, graph.nodes[()].document
        self._version = version
        self.has_arrays = self.has_clocks = version != "1.0"

    def add(self, path: Path, fmu: Fmu, source: str) -> None:
        """Add a component, and the systems around it that do not exist."""
        parent = self._system(path[:-1])
        elements = group(parent.body, "ssd:Elements")
        element = add(elements, "ssd:Component", name=path[-1], type=FMU, source=source)
        node = Node(path, self.document, element, element, self.document, {}, fmu=fmu.path)
        self._enter(parent, node)
        self.graph.fmus = {**self.graph.fmus, path: fmu}
        for variable in fmu.variables.values():
            is_array = variable.dimensions and self.has_arrays and variable.type not in _TEXTS
            exists = variable.type != "Clock" or self.has_clocks
            if variable.causality == "output" and exists and (variable.is_signal or is_array):
                self._declare((path, variable.name))
        add_units(self.document.root, "ssd:Units", fmu.units.values())

    def replace(self, path: Path, source: str) -> None:
        """Give a component another FMU."""
        self._own(self.graph.nodes[path]).element.set("source", source)

    def remove(self, path: Path) -> None:
        """Remove a component with its connections."""
        node = self._own(self.graph.nodes[path])
        for edge in list(self.graph.edges.values()):
            if path in (edge.source[0], edge.target[0]):
                self.disconnect(edge.target)
        discard(node.element)
        del self.graph.nodes[path]
        del self.graph.nodes[path[:-1]].children[path[-1]]

    def disconnect(self, target: End) -> None:
        """Remove the connection that leads to an end; of a whole array, that of each element."""
        if target not in self.graph.edges:  # removed with another element of its array
            return
        element = self.graph.edges[target].element
        for edge in [e for e in self.graph.edges.values() if e.element is element]:
            self.graph.drop(edge)
        discard(element)

    def connect(self, source: End, target: End, link: Link = PLAIN) -> None:
        """Connect two ends, through connectors of the systems between them."""
        both = zip(source[0][:-1], target[0][:-1], strict=False)
        common = tuple(name for name, _ in takewhile(lambda pair: pair[0] == pair[1], both))
        self._join(common, self._lift(source, common), self._sink(target, common), link)

    def expose(self, name: str, kind: str, end: End, unit: Unit | None) -> None:
        """Make a connector of the outermost system for what is at ``end``."""
        top = self.graph.nodes[()]
        if name not in top.connectors:
            self._declare(((), name), kind, end, unit)

    def conceal(self, name: str) -> None:
        """Remove a connector of the outermost system with its connections."""
        for edge in list(self.graph.edges.values()):
            if ((), name) in (edge.source, edge.target):
                self.disconnect(edge.target)
        top = self.graph.nodes[()]
        top.connectors.pop(name)
        for connector in group(top.body, "ssd:Connectors"):
            if connector.get("name") == name:
                discard(connector)

    def _lift(self, source: End, common: Path) -> End:
        """Lead a signal out of systems until it reaches one inside ``common``."""
        path = source[0][:-1]
        while len(path) > len(common):
            known = [e.target for e in self.graph.onward[source] if e.target[0] == path]
            if known and self.graph.edges[known[0]].scaling == IDENTITY:
                source = known[0]
            else:
                outside = self._new_connector(path, "output", source)
                self._join(path, source, outside, PLAIN)
                source = outside
            path = path[:-1]
        return source

    def _sink(self, target: End, common: Path) -> End:
        """Make connectors for a signal to enter the systems around ``target`` by."""
        path = target[0][:-1]
        while len(path) > len(common):
            outside = self._new_connector(path, "input", target)
            self._join(path, outside, target, PLAIN)
            target, path = outside, path[:-1]
        return target

    def _new_connector(self, path: Path, kind: str, like: End) -> End:
        name = f"{like[0][-1]}_{like[1]}"  # FMPy reads a dot as a path
        while self.graph.connector((path, name)):
            name += "_"
        self._declare((path, name), kind, like)
        return path, name

    def _join(self, system: Path, source: End, target: End, link: Link) -> None:
        node = self._own(self.graph.nodes[system])
        attributes = {}
        for which, end in (("start", source), ("end", target)):
            path, name = end
            if path != system:
                attributes[f"{which}Element"] = path[-1]
                self._declare(end)
            array = self._array(end)
            attributes[f"{which}Connector"] = array or name
            if array:
                attributes[f"{which}Indices"] = name[len(array) + 1 : -1].replace(",", " ")
        if not link.convert:
            attributes["suppressUnitConversion"] = "true"
        element = add(group(node.body, "ssd:Connections"), "ssd:Connection", **attributes)
        if link.scaling != IDENTITY:
            ends = (self._variable(self._behind(end)) for end in (source, target))
            add_transformation(element, link.scaling, *ends)
        self.graph.put(Edge(source, target, link.scaling, link.convert, element))

    def _array(self, end: End) -> str | None:
        """Return the name of the connector that is an array and has an end as its element."""
        connector = self.graph.connector(end)
        return connector.name if connector and connector.name != end[1] else None

    def _behind(self, end: End) -> End:
        """Return an end at a component that an end of a system leads to."""
        while end[0] not in self.graph.fmus:
            edge = self.graph.edges.get(end)
            end = edge.source if edge else self.graph.onward[end][0].target
        return end

    def _variable(self, end: End) -> Variable:
        if (variable := self.graph.variable(end)) is None:
            raise SspError(f"{component(end[0])} has no variable {end[1]!r}")
        return variable

    def _declare(
        self, end: End, kind: str = "", like: End | None = None, unit: Unit | None = None
    ) -> None:
        path, name = end
        node = self.graph.nodes[path]
        if self.graph.connector(end):
            return
        leaf = self._behind(like or end)
        variable = self._variable(leaf)
        if variable.type == "Clock" and not self.has_clocks:
            raise SspError(
                f"{component(path)}.{name} is a clock, which SSP 1.0 has not; write SSP 2.0"
            )
        if variable.array and self.has_arrays and not like:
            name, variable = variable.array, self._variable((path, variable.array))
        unit = unit or self.graph.inner_unit(leaf)
        kind = kind or variable.causality
        self._own(node)
        add_connector(self.document.root, node.body, name, kind, variable, self._version, unit)
        if unit:
            add_units(self.document.root, "ssd:Units", [unit])
        there = unit if unit and unit.exponents else None
        node.connectors[name] = Connector(name, kind, there, dimensions=variable.dimensions)

    def _system(self, path: Path) -> Node:
        if path not in self.graph.nodes:
            parent = self._system(path[:-1])
            body = add(group(parent.body, "ssd:Elements"), "ssd:System", name=path[-1])
            self._enter(parent, Node(path, self.document, body, body, self.document, {}))
        return self._own(self.graph.nodes[path])

    def _enter(self, parent: Node, node: Node) -> None:
        parent.children[node.path[-1]] = node
        self.graph.nodes[node.path] = node

    def _own(self, node: Node) -> Node:
        if node.body_document is not self.document:
            raise SspError(
                f"system {component(node.path)!r} lies in a file of its own inside the package and"
                " cannot be changed from outside"
            )
        return node
