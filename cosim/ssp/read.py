"""Reads an SSP 1.0 package as a system."""

from __future__ import annotations

import os
from collections import defaultdict
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

from lxml import etree

from cosim.archive import unpack
from cosim.errors import CosimError, SspError
from cosim.experiment import DefaultExperiment
from cosim.ssp.names import ANNOTATION, NAMESPACES, OSP, SCHEMAS, STRUCTURE, tag
from cosim.system import System
from cosim.units import BASE_UNITS, Unit

_FMU_TYPES = (None, "application/x-fmu-sharedlibrary")


def read_ssp(path: str | os.PathLike[str]) -> tuple[System, DefaultExperiment]:
    """Read a system and the times it proposes.

    Connectors through which the system gives outputs to the outside are passed over: every output
    of a component can be recorded.

    Raises
    ------
    SspError
        When the file is no SSP 1.0 package, or holds what is not supported: nested systems, signal
        dictionaries, parameter mappings, transformations of signals.
    """
    package = Path(path).absolute()
    folder = unpack(package, "ssps", SspError)
    if not (folder / STRUCTURE).is_file():
        raise SspError(f"{package}: {STRUCTURE} is missing; this is no system structure package")
    try:
        root = _parse(folder / STRUCTURE, "SystemStructureDescription.xsd")
        _refuse(root)
        system = _read_system(folder, _find(root, "ssd:System"))
        return system, _read_experiment(root)
    except CosimError as fault:
        raise SspError(f"{package}: {fault}") from fault


def _parse(file: Path, schema: str) -> Any:
    try:
        root = etree.parse(file, etree.XMLParser(resolve_entities=False, no_network=True)).getroot()
    except (etree.XMLSyntaxError, OSError) as fault:
        raise SspError(f"{file.name}: {fault}") from fault
    version = root.get("version", "")
    if not version.startswith("1."):
        raise SspError(f"{file.name}: version is {version!r}, expected '1.0'")
    checker = etree.XMLSchema(file=str(SCHEMAS / schema))
    if not checker.validate(root):
        error = checker.error_log[0]
        raise SspError(f"{file.name}, line {error.line}: {error.message}")
    return root


def _refuse(root: Any) -> None:
    for name in (
        "ssd:SignalDictionaryReference",
        "ssd:ParameterMapping",
        "ssd:Elements/ssd:System",
    ):
        for element in root.iterfind(f".//{name}", NAMESPACES):
            raise SspError(f"{STRUCTURE}, line {element.sourceline}: {name} is not supported")
    for connection in root.iterfind(".//ssd:Connection", NAMESPACES):
        if len(connection):
            kind = etree.QName(connection[0]).localname
            raise SspError(f"{STRUCTURE}, line {connection.sourceline}: {kind} is not supported")


def _read_system(folder: Path, top: Any) -> System:
    system = System(top.get("name"))
    for component in top.iterfind("ssd:Elements/ssd:Component", NAMESPACES):
        if component.get("type") not in _FMU_TYPES:
            raise SspError(
                f"component {component.get('name')!r} is no FMU; only FMUs are supported"
            )
        system.add(component.get("name"), _inside(folder, component.get("source")))
        _read_parameters(folder, component, system, f"{component.get('name')}.")
    _read_parameters(folder, top, system, "")
    _read_connections(top, system)
    return system


def _read_connections(top: Any, system: System) -> None:
    targets: dict[str, list[str]] = defaultdict(list)
    kinds = {c.get("name"): c.get("kind") for c in top.iterfind("ssd:Connectors/*", NAMESPACES)}
    for connection in top.iterfind("ssd:Connections/ssd:Connection", NAMESPACES):
        ends = [
            (connection.get(f"{end}Element"), connection.get(f"{end}Connector"))
            for end in ("start", "end")
        ]
        names = [f"{element}.{name}" for element, name in ends if element]
        outside = [name for element, name in ends if not element]
        if not outside:
            if system.variable(names[0]).causality == "input":
                names.reverse()  # start and end say nothing about the direction
            system.connect(names[0], names[1])
        elif names and kinds.get(outside[0]) == "input":
            targets[outside[0]].append(names[0])
        elif outside[0] not in kinds:
            raise SspError(f"the system has no connector {outside[0]!r}")
    for name, inputs in targets.items():
        system.expose(name, *inputs)


def _read_parameters(folder: Path, element: Any, system: System, owner: str) -> None:
    for binding in element.iterfind("ssd:ParameterBindings/ssd:ParameterBinding", NAMESPACES):
        source = binding.get("source")
        if source:
            root = _parse(_inside(folder, source), "SystemStructureParameterValues.xsd")
        else:
            root = _find(binding, "ssd:ParameterValues/ssv:ParameterSet")
        units = {unit.name: unit for unit in map(_read_unit, root.iter(tag("ssc:Unit")))}
        for parameter in root.iterfind("ssv:Parameters/ssv:Parameter", NAMESPACES):
            name = owner + binding.get("prefix", "") + parameter.get("name")
            value = parameter[0]
            if value.tag == tag("ssv:Enumeration"):
                raise SspError(f"parameter {name!r}: enumerations by name are not supported")
            unit = value.get("unit")
            if unit:
                _check_unit(system, name, units.get(unit, Unit(unit)))
            system.set(name, value.get("value"))


def _check_unit(system: System, name: str, unit: Unit) -> None:
    wanted = system.unit_of(name)
    if wanted and not unit.same_as(wanted):
        raise SspError(
            f"parameter {name!r} is given in {unit.name!r}, the FMU has {wanted.name!r};"
            " units are not converted"
        )


def _read_unit(element: Any) -> Unit:
    base = _find(element, "ssc:BaseUnit")
    exponents = tuple(int(base.get(name, "0")) for name in BASE_UNITS)
    factor, offset = float(base.get("factor", "1")), float(base.get("offset", "0"))
    return Unit(element.get("name"), exponents, factor, offset)


def _read_experiment(root: Any) -> DefaultExperiment:
    element = root.find("ssd:DefaultExperiment", NAMESPACES)
    if element is None:
        return DefaultExperiment()
    step = element.find(
        f"ssd:Annotations/ssc:Annotation[@type='{ANNOTATION}']"
        f"/{{{OSP}}}Algorithm/{{{OSP}}}FixedStepAlgorithm",
        NAMESPACES,
    )
    times = (
        element.get("startTime"),
        element.get("stopTime"),
        None if step is None else step.get("baseStepSize"),
    )
    try:
        return DefaultExperiment(*(None if text is None else float(text) for text in times))
    except ValueError as fault:
        raise SspError(f"{STRUCTURE}: DefaultExperiment: {fault}") from fault


def _inside(folder: Path, source: str) -> Path:
    """Return the file a relative URI names, which must lie in the package."""
    uri = urlsplit(source)
    file = (folder / unquote(uri.path)).resolve()
    if uri.scheme or uri.netloc or not file.is_relative_to(folder.resolve()):
        raise SspError(f"source {source!r} lies outside the package; only its own files are read")
    if not file.is_file():
        raise SspError(f"source {source!r} is missing from the package")
    return file


def _find(element: Any, path: str) -> Any:
    found = element.find(path, NAMESPACES)
    if found is None:
        raise SspError(f"{STRUCTURE}, line {element.sourceline}: {path} is missing")
    return found
