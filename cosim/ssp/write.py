"""Writes a system as an SSP 1.0 or 2.0 package.

A system that was read from a package and has other start values or times only is written as that
package with these, so that geometry, annotations, other variants and files stay as they were.
"""

from __future__ import annotations

import os
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import replace
from itertools import takewhile
from pathlib import Path as File
from typing import Any, Literal, NamedTuple

from lxml import etree

from stickslip.cosim.component import component_of, variable_of
from stickslip.cosim.errors import CosimError, SspError
from stickslip.cosim.ssp.markup import (
    ANNOTATION,
    FMU,
    OSP,
    STRUCTURE,
    VERSIONS,
    Members,
    Path,
    add,
    add_connector,
    add_units,
    file_name,
    find,
    free_name,
    group,
    new_root,
    path_of,
    tag,
    text_of,
)
from stickslip.cosim.ssp.read import read_experiment, read_package
from stickslip.cosim.system.scaling import IDENTITY, PLAIN, Link
from stickslip.cosim.system.system import System
from stickslip.fmi.archive import zipped
from stickslip.fmi.description.model import DefaultExperiment
from stickslip.fmi.description.units import Unit
from stickslip.fmi.description.variables import FLOATS, Value, Variable
from stickslip.fmi.files import atomic_write

_TYPES = {bool: "Boolean", int: "Integer", float: "Real", str: "String"}
_TEXTS = {"String", "Binary"}
_PARTS = ("connections", "links", "inputs", "input_units", "outputs")


def write_ssp(
    system: System,
    path: str | os.PathLike[str],
    experiment: DefaultExperiment | None = None,
    *,
    start: float | None = None,
    stop: float | None = None,
    step: float | None = None,
    version: Literal["1.0", "2.0"] | None = None,
) -> File:
    """Write a system with its FMUs, start values, units and times; return the path.

    Connectors are written for all outputs and for the connected inputs, since some tools require a
    source for each connector. Components called ``outer/inner`` are written into nested systems.

    Parameters
    ----------
    system : to write
    path : of the ``.ssp`` file
    experiment : the times it proposes; of a system that was read, those of its package by default
    start, stop, step : of the experiment, s, in place of it
    version : of SSP; of a system that was read, that of its package by default, else 1.0

    Raises
    ------
    SspError : when an FMU is no longer where it was read from, or the version cannot express the
        system
    OSError : when the file cannot be written
    """
    if version not in {None, *VERSIONS}:
        raise SspError(f"version is {version!r}, expected '1.0' or '2.0'")
    if (suffix := File(path).suffix) != ".ssp":
        raise SspError(f"{path}: ends with {suffix!r}; write to a name that ends with '.ssp'")
    times = {"start": start, "stop": stop, "step": step}
    if given := {name: time for name, time in times.items() if time is not None}:
        experiment = replace(experiment or DefaultExperiment(), **given)
    try:
        members = _members(system, experiment, version)
    except CosimError as fault:
        raise SspError(f"{path}: {fault}") from fault
    except OSError as fault:
        raise SspError(f"{path}: cannot pack {fault.filename}: {fault.strerror}") from fault
    return atomic_write(File(path), zipped(members))


def _members(system: System, experiment: DefaultExperiment | None, version: str | None) -> Members:
    if (package := system.origin) is None:
        return _Structure(system, version or "1.0").members(experiment)
    before, times, graph = read_package(package)
    root, times = graph.nodes[()].document.root, experiment or times
    known = {name: fmu.path for name, fmu in before.fmus("an SSP").items()}
    same = {name: fmu.path for name, fmu in system.fmus("an SSP").items()} == known
    same = same and all(getattr(before, part) == getattr(system, part) for part in _PARTS)
    if not same or version not in (None, root.get("version")):
        return _Structure(system, version or root.get("version")).members(times)
    members = {
        file.relative_to(package.folder).as_posix(): file.read_bytes()
        for file in sorted(package.folder.rglob("*"))
        if file.is_file()
    }
    unchanged = etree.tostring(root)
    if values := _changed_values(before, system):
        _bind(find(root, "ssd:System"), system, values, members)
    _propose(root, experiment)
    if etree.tostring(root) != unchanged:
        members[package.structure] = text_of(root)
    return members


def _changed_values(before: System, system: System) -> dict[str, Value]:
    values = {n: v for n, v in system.parameters.items() if before.parameters.get(n) != v}
    for name in before.parameters.keys() - system.parameters.keys():
        start = system.variable(name).start
        if start is None:
            raise SspError(f"{name} has no start value in its FMU to go back to")
        values[name] = start
    return values


class End(NamedTuple):
    """A connector of a component or system, indices of its element, and the FMU's variable."""

    path: Path
    name: str
    indices: str = ""
    variable: str = ""


class _Structure:
    """The description of a system without a package."""

    def __init__(self, system: System, version: str) -> None:
        self._system, self._version = system, version
        self._root = new_root("ssd:SystemStructureDescription", system.name, version)
        self._bodies: dict[Path, Any] = {(): add(self._root, "ssd:System", name=system.name)}
        self._names: dict[tuple[Path, End], str] = {}  # of the way of a signal through a system
        self._connectors: set[tuple[Path, str]] = set()

    def members(self, experiment: DefaultExperiment | None) -> Members:
        """Return the files of the package."""
        system, members = self._system, {STRUCTURE: b""}
        values: dict[str, dict[str, Value]] = defaultdict(dict)
        for name, value in system.parameters.items():
            values[component_of(name)][name] = value
        for i, (name, fmu) in enumerate(system.fmus("an SSP").items()):
            source = free_name(f"resources/{file_name(i, name)}", ".fmu", members)
            members[source] = fmu.content()
            path = path_of(name)
            elements = group(self._body(path[:-1]), "ssd:Elements")
            named = {"name": path[-1], "type": FMU, "source": source}
            self._bodies[path] = add(elements, "ssd:Component", **named)
            for v in fmu.variables.values():
                arrays = bool(v.dimensions) and self._is_new and v.type not in _TEXTS
                exists = v.type != "Clock" or self._is_new
                if v.causality == "output" and exists and (v.is_signal or arrays):
                    self._end(f"{name}.{v.name}")
            add_units(self._root, "ssd:Units", fmu.units.values())
        for name, own in values.items():
            stem = file_name(list(system.components).index(name), name)
            _bind(self._bodies[path_of(name)], system, own, members, stem)
        for target, source in system.sources().items():
            link, total = system.links.get(target, PLAIN), system.scaling(source, target)
            # Other tools convert no units, so the conversion is written out.
            written = link if total == link.scaling else Link(total, convert=False)
            self._connect(self._source(source), self._end(target), written)
        for name, source in system.outputs.items():
            self._declare((), name, "output", source)
            self._connect(self._end(source), End((), name), PLAIN)
        _propose(self._root, experiment)
        members[STRUCTURE] = text_of(self._root)
        return members

    @property
    def _is_new(self) -> bool:
        """Whether the version has arrays and clocks."""
        return self._version != "1.0"

    def _body(self, path: Path) -> Any:
        if path not in self._bodies:
            elements = group(self._body(path[:-1]), "ssd:Elements")
            self._bodies[path] = add(elements, "ssd:System", name=path[-1])
        return self._bodies[path]

    def _source(self, name: str) -> End:
        if name not in self._system.inputs:
            return self._end(name)
        first, unit = self._system.inputs[name][0], self._system.unit_of(name)
        self._declare((), name, "input", first, unit)
        return End((), name)

    def _end(self, name: str) -> End:
        """Return a variable of a component as an end; it has a connector then."""
        path, variable, indices = path_of(component_of(name)), self._system.variable(name), ""
        own = variable.name
        if variable.array and self._is_new:
            own, indices = variable.array, own[len(variable.array) + 1 : -1].replace(",", " ")
        self._declare(path, own, variable.causality, f"{component_of(name)}.{own}")
        return End(path, own, indices, name)

    def _declare(
        self, path: Path, name: str, kind: str, like: str, unit: Unit | None = None
    ) -> None:
        """Make a connector, once, for a signal like a variable of a component."""
        if (path, name) in self._connectors:
            return
        self._connectors.add((path, name))
        variable = self._system.variable(like)
        if variable.type == "Clock" and not self._is_new:
            where = ".".join(("/".join(path), name))
            raise SspError(f"{where} is a clock, which SSP 1.0 has not; write SSP 2.0")
        unit, element = unit or self._system.unit_of(like), self._bodies[path]
        add_connector(self._root, element, name, kind, variable, self._version, unit)
        if unit:
            add_units(self._root, "ssd:Units", [unit])

    def _connect(self, source: End, target: End, link: Link) -> None:
        """Connect two ends, through connectors of the systems between them."""
        both = zip(source.path[:-1], target.path[:-1], strict=False)
        common = tuple(name for name, _ in takewhile(lambda pair: pair[0] == pair[1], both))
        start = self._led_out(source, common, "output")
        end = self._led_out(target, common, "input")
        self._line(common, start, end, link)

    def _led_out(self, end: End, common: Path, kind: str) -> End:
        """Return the connector of a system inside ``common`` that leads to an end in it."""
        path = end.path[:-1]
        while len(path) > len(common):
            name = self._names.get((path, end))
            outside = End(path, name or self._free(path, end), "", end.variable)
            if name is None:
                self._names[path, end] = outside.name
                self._declare(path, outside.name, kind, end.variable)
                ends = (end, outside) if kind == "output" else (outside, end)
                self._line(path, *ends, PLAIN)
            end, path = outside, path[:-1]
        return end

    def _free(self, path: Path, end: End) -> str:
        name = f"{end.path[-1]}_{end.name}"  # FMPy reads a dot as a path
        name += f"[{end.indices.replace(' ', ',')}]" if end.indices else ""
        while (path, name) in self._connectors:
            name += "_"
        return name

    def _line(self, system: Path, source: End, target: End, link: Link) -> None:
        attributes = {}
        for which, end in (("start", source), ("end", target)):
            if end.path != system:
                attributes[f"{which}Element"] = end.path[-1]
            attributes[f"{which}Connector"] = end.name
            if end.indices:
                attributes[f"{which}Indices"] = end.indices
        if not link.convert:
            attributes["suppressUnitConversion"] = "true"
        lines = group(self._bodies[system], "ssd:Connections")
        element = add(lines, "ssd:Connection", **attributes)
        if link.scaling != IDENTITY:
            line = {"factor": repr(link.scaling.factor), "offset": repr(link.scaling.offset)}
            add(element, "ssc:LinearTransformation", **line)


def _bind(
    element: Any, system: System, values: Mapping[str, Value], members: Members, stem: str = ""
) -> None:
    """Bind values to the component of a file's stem; else to the system, where they go first."""
    version = element.getroottree().getroot().get("version")
    # One name for all components: ecos applies the parameter set of a name to all that have it.
    root = new_root("ssv:ParameterSet", "parameters" if stem else "settings", version)
    parameters = group(root, "ssv:Parameters")
    values = values if version == "1.0" else _whole_arrays(values, system)
    for name, value in values.items():
        owner, variable = component_of(name), system.variable(name)
        prefix = "" if stem else ".".join(path_of(owner)) + "."
        parameter = add(parameters, "ssv:Parameter", name=prefix + variable_of(name))
        kind = _type_of(variable, value, version)
        if kind is None:
            what = f"SSP {version} has no values that are arrays or binary; write version='2.0'"
            raise SspError(f"{name}: {what}")
        written = add(parameter, f"ssv:{kind}", value=_text_of_value(value))
        for length in variable.dimensions:
            add(parameter, "ssc:Dimension", size=str(length))
        unit = system.components[owner].unit(variable)
        if kind in FLOATS and unit and unit.exponents:
            written.set("unit", unit.name)
            add_units(root, "ssv:Units", [unit])
    source = free_name(f"resources/{stem or 'settings'}", ".ssv", members)
    members[source] = text_of(root)
    add(group(element, "ssd:ParameterBindings"), "ssd:ParameterBinding", source=source)


def _text_of_value(value: Value) -> str:
    """Return a value as XML wants it, arrays row by row."""
    if isinstance(value, tuple):
        return " ".join(map(_text_of_value, value))
    if isinstance(value, bytes):
        return value.hex()
    return str(value).lower() if isinstance(value, bool) else str(value)


def _whole_arrays(values: Mapping[str, Value], system: System) -> dict[str, Value]:
    """Return values in which those of single elements have become those of their arrays."""
    result: dict[str, Value] = {}
    for name, value in values.items():
        variable = system.variable(name)
        if variable.array is None:
            result[name] = value
            continue
        array = f"{component_of(name)}.{variable.array}"
        before = result.get(array, system.parameters.get(array, system.variable(array).start))
        if not isinstance(before, tuple) or isinstance(value, tuple):
            raise SspError(f"{array}: its other elements have no start value; set it as a whole")
        i = variable.element
        result[array] = (*before[:i], value, *before[i + 1 :])
    return result


def _type_of(variable: Variable, value: Value, version: str) -> str | None:
    if version != "1.0" and variable.type != "Enumeration":
        return variable.type
    return _TYPES.get(type(value[0] if version != "1.0" and isinstance(value, tuple) else value))


def _propose(root: Any, experiment: DefaultExperiment | None) -> None:
    if experiment is None or experiment == read_experiment(root):
        return
    element = group(root, "ssd:DefaultExperiment")
    for name, time in (("startTime", experiment.start), ("stopTime", experiment.stop)):
        element.attrib.pop(name, None)
        if time is not None:
            element.set(name, repr(float(time)))
    annotations = group(element, "ssd:Annotations")
    for annotation in annotations.findall(f"{tag('ssc:Annotation')}[@type='{ANNOTATION}']"):
        annotations.remove(annotation)
    if experiment.step is not None:
        annotation = add(annotations, "ssc:Annotation", type=ANNOTATION)
        algorithm = etree.SubElement(annotation, f"{{{OSP}}}Algorithm")
        fixed = etree.SubElement(algorithm, f"{{{OSP}}}FixedStepAlgorithm")
        fixed.set("baseStepSize", repr(float(experiment.step)))
    elif not len(annotations):
        element.remove(annotations)
