"""Changes an SSP description: components, connections across nested systems, connectors."""

from __future__ import annotations

from cosim.errors import SspError
from cosim.fmu import Fmu
from cosim.scaling import IDENTITY, PLAIN, Link
from cosim.ssp.compose import add, add_connector, add_units, discard, group, type_of
from cosim.ssp.graph import Edge, End, Graph
from cosim.ssp.names import FMU, Path, component
from cosim.ssp.structure import Connector, Document, Node
from cosim.units import Unit


class Editor:
    """A description being changed; tree and graph stay in step.

    Attributes
    ----------
    graph : of the description
    document : of the outermost system
    changed : whether anything was
    """

    def __init__(self, graph: Graph, version: str) -> None:
        self.graph = graph
        self.document: Document = graph.nodes[()].document
        self.changed = False
        self._version = version

    def add(self, path: Path, fmu: Fmu, source: str) -> None:
        """Add a component, and the systems around it that do not exist."""
        parent = self._system(path[:-1])
        elements = group(parent.body, "ssd:Elements")
        element = add(elements, "ssd:Component", name=path[-1], type=FMU, source=source)
        node = Node(path, self.document, element, element, self.document, {}, fmu=fmu.path)
        self._enter(parent, node)
        fmus = dict(self.graph.fmus)
        fmus[path] = fmu
        self.graph.fmus = fmus
        for variable in fmu.variables.values():
            if variable.causality == "output" and variable.is_signal:
                self._declare((path, variable.name))
        add_units(self.document.root, "ssd:Units", fmu.units.values())

    def replace(self, path: Path, source: str) -> None:
        """Give a component another FMU."""
        self._own(self.graph.nodes[path]).element.set("source", source)
        self.changed = True

    def remove(self, path: Path) -> None:
        """Remove a component with its connections."""
        node = self._own(self.graph.nodes[path])
        for edge in list(self.graph.edges.values()):
            if path in (edge.source[0], edge.target[0]):
                self.disconnect(edge.target)
        discard(node.element)
        del self.graph.nodes[path]
        del self.graph.nodes[path[:-1]].children[path[-1]]
        self.changed = True

    def disconnect(self, target: End) -> None:
        """Remove the connection that leads to an end."""
        edge = self.graph.edges.pop(target)
        self.graph.onward[edge.source].remove(edge)
        discard(edge.element)
        self.changed = True

    def connect(self, source: End, target: End, link: Link = PLAIN) -> None:
        """Connect two ends, through connectors of the systems between them."""
        common = _common(source, target)
        outer = self._lift(source, common)
        inner = self._sink(target, common)
        self._join(common, outer, inner, link)

    def expose(self, name: str, kind: str, end: End, unit: Unit | None) -> None:
        """Make a connector of the outermost system for what is at ``end``."""
        top = self.graph.nodes[()]
        if name not in top.connectors:
            self._declare(((), name), kind, end, unit)

    def conceal(self, name: str) -> None:
        """Remove a connector of the outermost system with its connections."""
        end: End = ((), name)
        if end in self.graph.edges:
            self.disconnect(end)
        for edge in list(self.graph.onward[end]):
            self.disconnect(edge.target)
        top = self.graph.nodes[()]
        top.connectors.pop(name)
        for connector in group(top.body, "ssd:Connectors"):
            if connector.get("name") == name:
                discard(connector)
        self.changed = True

    def _lift(self, source: End, common: Path) -> End:
        """Lead a signal out of systems until it reaches one inside ``common``."""
        path = source[0][:-1] if source[0] else ()
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
        path = target[0][:-1] if target[0] else ()
        while len(path) > len(common):
            outside = self._new_connector(path, "input", target)
            self._join(path, outside, target, PLAIN)
            target = outside
            path = path[:-1]
        return target

    def _new_connector(self, path: Path, kind: str, like: End) -> End:
        name = f"{like[0][-1]}_{like[1]}"  # with a dot FMPy takes it for what is inside
        while name in self.graph.nodes[path].connectors:
            name += "_"
        self._declare((path, name), kind, like)
        return path, name

    def _join(self, system: Path, source: End, target: End, link: Link) -> None:
        node = self._own(self.graph.nodes[system])
        attributes = {}
        for which, (path, name) in (("start", source), ("end", target)):
            if path != system:
                attributes[f"{which}Element"] = path[-1]
                self._declare((path, name))
            attributes[f"{which}Connector"] = name
        if not link.convert:
            attributes["suppressUnitConversion"] = "true"
        element = add(group(node.body, "ssd:Connections"), "ssd:Connection", **attributes)
        if link.scaling != IDENTITY:
            line = {"factor": repr(link.scaling.factor), "offset": repr(link.scaling.offset)}
            add(element, "ssc:LinearTransformation", **line)
        edge = Edge(source, target, link.scaling, link.convert, element)
        self.graph.edges[target] = edge
        self.graph.onward[source].append(edge)
        self.changed = True

    def _declare(
        self, end: End, kind: str = "", like: End | None = None, unit: Unit | None = None
    ) -> None:
        """Make sure that an end has a connector."""
        path, name = end
        node = self.graph.nodes[path]
        if name in node.connectors:
            return
        leaf = like or end
        while leaf[0] not in self.graph.fmus:  # a connector of a system: look at what is behind
            edge = self.graph.edges.get(leaf)
            leaf = edge.source if edge else self.graph.onward[leaf][0].target
        variable = self.graph.fmus[leaf[0]].variables[leaf[1]]
        unit = unit or self.graph.inner_unit(leaf)
        kind = kind or variable.causality
        self._own(node)
        add_connector(node.body, name, kind, type_of(variable, self._version), unit)
        if unit:
            add_units(self.document.root, "ssd:Units", [unit])
        node.connectors[name] = Connector(name, kind, unit if unit and unit.exponents else None)
        self.changed = True

    def _system(self, path: Path) -> Node:
        if path not in self.graph.nodes:
            parent = self._system(path[:-1])
            body = add(group(parent.body, "ssd:Elements"), "ssd:System", name=path[-1])
            self._enter(parent, Node(path, self.document, body, body, self.document, {}))
        return self._own(self.graph.nodes[path])

    def _enter(self, parent: Node, node: Node) -> None:
        parent.children[node.path[-1]] = node
        self.graph.nodes[node.path] = node
        self.changed = True

    def _own(self, node: Node) -> Node:
        if node.body_document is not self.document:
            raise SspError(
                f"system {component(node.path)!r} lies in a file of its own inside the package and"
                " cannot be changed from outside"
            )
        return node


def _common(source: End, target: End) -> Path:
    """Return the innermost system that holds both ends; of the whole, its inside."""
    a, b = source[0][:-1], target[0][:-1]
    n = 0
    while n < min(len(a), len(b)) and a[n] == b[n]:
        n += 1
    return a[:n]
