"""Writes a system as an SSP 1.0 package."""

from __future__ import annotations

import io
import os
import re
import zipfile
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from lxml import etree

import toolchain
from cosim.errors import SspError
from cosim.experiment import DefaultExperiment
from cosim.fmu import Fmu
from cosim.names import component_of, variable_of
from cosim.ssp.names import ANNOTATION, NAMESPACES, OSP, STRUCTURE, tag
from cosim.system import System
from cosim.units import BASE_UNITS, Unit
from cosim.variables import Value

_TIMESTAMP = (1980, 1, 1, 0, 0, 0)  # the same system gives the same bytes
_PARAMETER_TYPES = {bool: "Boolean", int: "Integer", float: "Real", str: "String"}


def write_ssp(
    system: System,
    path: str | os.PathLike[str],
    experiment: DefaultExperiment | None = None,
) -> Path:
    """Write a system with its FMUs, start values, units and times; return the path.

    Connectors are written for all outputs and for the inputs that are fed: a tool that wants a
    source for each connector finds one.

    Raises
    ------
    SspError
        When an FMU is no longer where it was read from.
    OSError
        When the file cannot be written.
    """
    resources = {
        name: re.sub(r"[^\w-]", "_", f"{i}_{name}", flags=re.ASCII)
        for i, name in enumerate(system.components)
    }
    members = {STRUCTURE: _structure(system, resources, experiment or DefaultExperiment())}
    for name, fmu in system.components.items():
        values = _values_of(system, name)
        if values:
            members[f"resources/{resources[name]}.ssv"] = _parameters(fmu, name, values)
        try:
            members[f"resources/{resources[name]}.fmu"] = fmu.path.read_bytes()
        except OSError as fault:
            raise SspError(f"{path}: cannot pack {fmu.path}: {fault.strerror}") from fault
    return toolchain.write_whole(Path(path), _zip(members))


def _structure(system: System, resources: dict[str, str], experiment: DefaultExperiment) -> bytes:
    root = _root("ssd:SystemStructureDescription", system.name)
    top = _add(root, "ssd:System", name=system.name)
    if system.inputs:
        connectors = _add(top, "ssd:Connectors")
        for name, targets in system.inputs.items():
            _add_connector(connectors, name, "input", system.unit_of(targets[0]))
    elements = _add(top, "ssd:Elements")
    for name, file in resources.items():
        _add_component(elements, system, name, file)
    _add_connections(top, system)
    _add_units(root, "ssd:Units", (unit for f in system.components.values() for unit in _units(f)))
    _add_experiment(root, experiment)
    return _text(root)


def _add_component(elements: Any, system: System, name: str, file: str) -> None:
    component = _add(
        elements,
        "ssd:Component",
        name=name,
        type="application/x-fmu-sharedlibrary",
        source=f"resources/{file}.fmu",
    )
    fed = system.sources()
    connectors = _add(component, "ssd:Connectors")
    for variable in system.components[name].variables.values():
        full = f"{name}.{variable.name}"
        if full in fed or (variable.causality == "output" and variable.is_signal):
            _add_connector(connectors, variable.name, variable.causality, system.unit_of(full))
    if not len(connectors):
        component.remove(connectors)
    if _values_of(system, name):
        bindings = _add(component, "ssd:ParameterBindings")
        _add(bindings, "ssd:ParameterBinding", source=f"resources/{file}.ssv")


def _add_connections(top: Any, system: System) -> None:
    sources = system.sources()
    connections = _add(top, "ssd:Connections") if sources else None
    for target, source in sources.items():
        ends = {"endElement": component_of(target), "endConnector": variable_of(target)}
        if source in system.inputs:
            _add(connections, "ssd:Connection", startConnector=source, **ends)
        else:
            start = {"startElement": component_of(source), "startConnector": variable_of(source)}
            _add(connections, "ssd:Connection", **start, **ends)


def _add_connector(connectors: Any, name: str, kind: str, unit: Unit | None) -> None:
    connector = _add(connectors, "ssd:Connector", name=name, kind=kind)
    _add(connector, "ssc:Real", **({"unit": unit.name} if unit and unit.exponents else {}))


def _add_experiment(root: Any, experiment: DefaultExperiment) -> None:
    times = {"startTime": experiment.start, "stopTime": experiment.stop}
    given = {name: repr(float(time)) for name, time in times.items() if time is not None}
    element = _add(root, "ssd:DefaultExperiment", **given)
    if experiment.step is not None:
        annotations = _add(element, "ssd:Annotations")
        annotation = _add(annotations, "ssc:Annotation", type=ANNOTATION)
        algorithm = etree.SubElement(annotation, f"{{{OSP}}}Algorithm")
        fixed = etree.SubElement(algorithm, f"{{{OSP}}}FixedStepAlgorithm")
        fixed.set("baseStepSize", repr(float(experiment.step)))


def _parameters(fmu: Fmu, name: str, values: dict[str, Value]) -> bytes:
    root = _root("ssv:ParameterSet", name)
    units = []
    parameters = _add(root, "ssv:Parameters")
    for variable, value in values.items():
        parameter = _add(parameters, "ssv:Parameter", name=variable)
        text = str(value).lower() if isinstance(value, bool) else str(value)
        element = _add(parameter, f"ssv:{_PARAMETER_TYPES[type(value)]}", value=text)
        unit = fmu.unit(fmu.variables[variable])
        if isinstance(value, float) and unit and unit.exponents:
            element.set("unit", unit.name)
            units.append(unit)
    _add_units(root, "ssv:Units", units)
    return _text(root)


def _add_units(root: Any, name: str, units: Iterable[Unit]) -> None:
    distinct = {unit.name: unit for unit in units}
    group = _add(root, name) if distinct else None
    for unit in distinct.values():
        base = _add(_add(group, "ssc:Unit", name=unit.name), "ssc:BaseUnit")
        for base_unit, exponent in zip(BASE_UNITS, unit.exponents or (), strict=True):
            if exponent:
                base.set(base_unit, str(exponent))
        if unit.factor != 1.0:
            base.set("factor", repr(unit.factor))
        if unit.offset != 0.0:
            base.set("offset", repr(unit.offset))


def _units(fmu: Fmu) -> list[Unit]:
    return [unit for unit in fmu.units.values() if unit.exponents]


def _values_of(system: System, component: str) -> dict[str, Value]:
    return {
        variable_of(name): value
        for name, value in system.parameters.items()
        if component_of(name) == component
    }


def _root(name: str, title: str) -> Any:
    prefix = name.partition(":")[0]
    # libcosim takes a namespace declared on osp:Algorithm itself for an algorithm
    nsmap = {key: NAMESPACES[key] for key in (prefix, "ssc")} | {"osp": OSP}
    return etree.Element(tag(name), {"version": "1.0", "name": title}, nsmap=nsmap)


def _add(parent: Any, name: str, /, **attributes: str) -> Any:
    return etree.SubElement(parent, tag(name), attributes)


def _text(root: Any) -> bytes:
    text: bytes = etree.tostring(root, xml_declaration=True, encoding="UTF-8", pretty_print=True)
    return text


def _zip(members: dict[str, bytes]) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for name, content in members.items():
            member = zipfile.ZipInfo(name, _TIMESTAMP)
            member.compress_type = zipfile.ZIP_DEFLATED
            member.create_system = 3
            member.external_attr = 0o644 << 16
            archive.writestr(member, content)
    return buffer.getvalue()
