"""modelDescription.xml of a container.

Source: FMI 2.0.4 section 2.2, FMI 3.0.2 section 2.4.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from xml.etree import ElementTree as ET

from stickslip.cosim.container.variables import Shown
from stickslip.fmi.description.model import DefaultExperiment
from stickslip.fmi.description.units import BASE_UNITS

_TAGS = {
    2: {"REAL": "Real", "INTEGER": "Integer", "BOOLEAN": "Boolean"},
    3: {"REAL": "Float64", "INTEGER": "Int32", "BOOLEAN": "Boolean"},
}
_CAUSALITY = {
    "TIME": "independent",
    "INPUT": "input",
    "OUTPUT": "output",
    "PARAMETER": "parameter",
    "TUNABLE": "parameter",
}
_VARIABILITY = {"PARAMETER": "fixed", "TUNABLE": "tunable"}
_INITIAL = {"PARAMETER": "exact", "TUNABLE": "exact", "OUTPUT": "calculated"}
_NAME = r"[A-Za-z_]\w*(\[\d+(,\d+)*\])?"
_STRUCTURED = re.compile(rf"{_NAME}(\.{_NAME})*", re.ASCII)


def model_description(
    version: int,
    name: str,
    identifier: str,
    token: str,
    shown: Sequence[Shown],
    experiment: DefaultExperiment,
    *,
    restores_state: bool,
    serializes: bool,
) -> str:
    """Return the XML.

    Parameters
    ----------
    version : of FMI, 2 or 3
    experiment : times; its step is that of the components
    """
    structured = all(_STRUCTURED.fullmatch(v.name) for v in shown)
    head = {
        "fmiVersion": f"{version}.0",
        "modelName": name,
        "guid" if version == 2 else "instantiationToken": token,
        "description": "A system of coupled FMUs, stepped by the kernel of stickslip",
        "version": "1.0",
        "author": "The authors of its components",
        "license": "That of each component: documentation/licenses/license.txt",
        "generationTool": "stickslip",
        "variableNamingConvention": "structured" if structured else "flat",
    }
    root = ET.Element("fmiModelDescription", head)
    state = "state" if version == 2 else "State"
    flags = {f"canGetAndSetFMU{state}": restores_state, f"canSerializeFMU{state}": serializes}
    if version == 3:
        flags_3 = {"fixedInternalStepSize": experiment.step}
        _child(root, "CoSimulation", modelIdentifier=identifier, **flags, **flags_3)
    else:
        _child(root, "CoSimulation", modelIdentifier=identifier, **flags)
    # Old releases of the FMI Library want a start value for time, which FMI 2.0 forbids; but there
    # it may be left out.
    listed = {place: v for place, v in enumerate(shown) if version == 3 or v.role != "TIME"}
    _add_units(root, listed.values())
    categories = _child(root, "LogCategories")
    _child(categories, "Category", name="logStatusError", description="Calls that failed, and why")
    _child(
        root,
        "DefaultExperiment",
        startTime=experiment.start,
        stopTime=experiment.stop,
        stepSize=experiment.step,
    )
    _add_variables(root, version, listed)
    _add_structure(root, version, listed)
    ET.indent(root)
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{ET.tostring(root, encoding="unicode")}\n'


def _child(parent: ET.Element, tag: str, **attributes: object) -> ET.Element:
    texts = {key: _text(value) for key, value in attributes.items() if value is not None}
    return ET.SubElement(parent, tag, texts)


def _text(value: object) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


def _add_units(root: ET.Element, shown: Iterable[Shown]) -> None:
    units = {v.unit.name: v.unit for v in shown if v.unit}
    definitions = _child(root, "UnitDefinitions") if units else root
    for unit in units.values():
        element = _child(definitions, "Unit", name=unit.name)
        if unit.exponents is not None:
            exponents = dict(zip(BASE_UNITS, unit.exponents, strict=True))
            numbers = {"factor": unit.factor, "offset": unit.offset}
            _child(element, "BaseUnit", **{k: n for k, n in exponents.items() if n}, **numbers)


def _add_variables(root: ET.Element, version: int, listed: Mapping[int, Shown]) -> None:
    variables = _child(root, "ModelVariables")
    for reference, v in listed.items():
        usual = "continuous" if v.type == "REAL" else "discrete"
        common = {
            "name": v.name,
            "valueReference": reference,
            "description": v.description or None,
            "causality": _CAUSALITY[v.role],
            "variability": _VARIABILITY.get(v.role, usual),
            "initial": _INITIAL.get(v.role),
        }
        convert = {"REAL": float, "INTEGER": int, "BOOLEAN": bool}[v.type]
        typed = {"start": None if v.start is None else convert(v.start)}
        if v.type != "BOOLEAN":
            typed |= {"min": _as(convert, v.minimum), "max": _as(convert, v.maximum)}
        if v.type == "REAL":
            typed |= {"unit": v.unit.name if v.unit else None, "nominal": v.nominal or None}
            typed |= {"relativeQuantity": True if v.unit and v.unit.relative else None}
        if version == 2:
            _child(_child(variables, "ScalarVariable", **common), _TAGS[2][v.type], **typed)
        else:
            _child(variables, _TAGS[3][v.type], **common, **typed)


def _as(convert: type, value: float | None) -> object:
    return None if value is None else convert(value)


def _add_structure(root: ET.Element, version: int, listed: Mapping[int, Shown]) -> None:
    """Append the outputs: those of the last step, which depend on no input of the present time."""
    structure = _child(root, "ModelStructure")
    places = [place for place, v in listed.items() if v.role == "OUTPUT"]
    if version == 3:
        for tag in ("Output", "InitialUnknown"):
            for place in places:
                depends = "" if tag == "Output" else None
                _child(structure, tag, valueReference=place, dependencies=depends)
    elif places:
        indices = [i for i, v in enumerate(listed.values(), 1) if v.role == "OUTPUT"]
        for tag in ("Outputs", "InitialUnknowns"):
            group = _child(structure, tag)
            for index in indices:
                depends = "" if tag == "Outputs" else None
                _child(group, "Unknown", index=index, dependencies=depends)
