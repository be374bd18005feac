"""modelDescription.xml and documentation of a container.

Source: FMI 2.0.4 section 2.2, FMI 3.0.2 section 2.4.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from xml.etree import ElementTree as ET

from stickslip.cosim.container.variables import ContainerVariable
from stickslip.cosim.system.system import System
from stickslip.fmi.description.model import DefaultExperiment
from stickslip.fmi.description.units import BASE_UNITS
from stickslip.fmi.description.writing import child, document
from stickslip.fmi.messages import escaped

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
    shown: Sequence[ContainerVariable],
    experiment: DefaultExperiment,
    *,
    varies_step: bool,
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
    flags["canHandleVariableCommunicationStepSize"] = varies_step
    internal = experiment.step if version == 3 and not varies_step else None
    child(
        root,
        "CoSimulation",
        modelIdentifier=identifier,
        **flags,
        fixedInternalStepSize=internal,
    )
    # Old releases of the FMI Library require a start value for time, which FMI 2.0 forbids; there
    # time may be left out.
    listed = {place: v for place, v in enumerate(shown) if version == 3 or v.role != "TIME"}
    _add_units(root, listed.values())
    categories = child(root, "LogCategories")
    child(categories, "Category", name="logStatusError", description="Calls that failed, and why")
    start, stop = experiment.start, experiment.stop
    times = {"startTime": start, "stopTime": stop, "stepSize": experiment.step}
    child(root, "DefaultExperiment", **times)
    variables = child(root, "ModelVariables")
    for reference, v in listed.items():
        _add_variable(variables, version, reference, v)
    # Outputs are those of the last step, which depend on no input of the present time.
    structure = child(root, "ModelStructure")
    places = enumerate(listed.items(), 1)
    outputs = [i if version == 2 else ref for i, (ref, v) in places if v.role == "OUTPUT"]
    for tag, depends in (("Output", ""), ("InitialUnknown", None)):
        group = child(structure, f"{tag}s") if version == 2 and outputs else structure
        for place in outputs:
            named = {"index" if version == 2 else "valueReference": place}
            child(group, "Unknown" if version == 2 else tag, **named, dependencies=depends)
    return document(root)


def _add_units(root: ET.Element, shown: Iterable[ContainerVariable]) -> None:
    units = {v.unit.name: v.unit for v in shown if v.unit}
    definitions = child(root, "UnitDefinitions") if units else root
    for unit in units.values():
        element = child(definitions, "Unit", name=unit.name)
        if unit.exponents is not None:
            exponents = dict(zip(BASE_UNITS, unit.exponents, strict=True))
            numbers = {"factor": unit.factor, "offset": unit.offset}
            child(element, "BaseUnit", **{k: n for k, n in exponents.items() if n}, **numbers)


def _add_variable(
    variables: ET.Element, version: int, reference: int, v: ContainerVariable
) -> None:
    convert = {"REAL": float, "INTEGER": int, "BOOLEAN": bool}[v.type]
    usual = "continuous" if v.type == "REAL" else "discrete"
    common = {
        "name": v.name,
        "valueReference": reference,
        "description": v.description or None,
        "causality": _CAUSALITY[v.role],
        "variability": _VARIABILITY.get(v.role, usual),
        "initial": _INITIAL.get(v.role),
    }
    limits = {} if v.type == "BOOLEAN" else {"min": v.minimum, "max": v.maximum}
    values = {"start": v.start, **limits}
    typed = {key: None if x is None else convert(x) for key, x in values.items()}
    if v.type == "REAL":
        typed |= {"unit": v.unit.name if v.unit else None, "nominal": v.nominal or None}
        typed |= {"relativeQuantity": True if v.unit and v.unit.relative else None}
    if version == 2:
        child(child(variables, "ScalarVariable", **common), _TAGS[2][v.type], **typed)
    else:
        child(variables, _TAGS[3][v.type], **common, **typed)


_PAGE = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<title>{title}</title>
<style>
body {{ font: 16px/1.5 sans-serif; max-width: 60em; margin: 2em auto; padding: 0 1em; }}
table {{ border-collapse: collapse; }}
td, th {{ border: 1px solid #ccc; padding: 0.2em 0.6em; text-align: left; }}
</style>
</head>
<body>
<h1>{title}</h1>
<p>A system of coupled FMUs in one. All components step by {step:g} s. {rest}</p>
<h2>Components, in the order in which they step</h2>
{components}
<h2>Connections{delay}</h2>
{connections}
<h2>Licence</h2>
<p>The components are unchanged in <code>resources/</code>, each under its own licence:
<a href="licenses/license.txt">licenses/license.txt</a>.</p>
</body>
</html>
"""


_SHORTENED = "In communication steps that are no multiples of it the last step is shorter."
_WHOLE = "Communication steps must be multiples of it."


def index(system: System, order: Sequence[str], step: float, *, jacobi: bool) -> str:
    """Return the page."""
    fmus = system.fmus("a container")
    components = [(n, fmus[n].name, f"FMI {fmus[n].version}.0", fmus[n].token) for n in order]
    connections = [(source, target) for target, source in system.sources().items()]
    return _PAGE.format(
        title=escaped(system.name),
        step=step,
        rest=_SHORTENED if all(c.varies_step for c in system.components.values()) else _WHOLE,
        components=_table(("component", "model", "standard", "token"), components),
        connections=_table(("from", "to"), connections),
        delay=", each delayed by one step" if jacobi else "",
    )


def licences(system: System) -> str:
    """Return the licence that each component declares."""
    lines = ["The FMUs in resources/ stay under their own licences:", ""]
    for name, fmu in system.fmus("a container").items():
        lines.append(f"{name} ({fmu.name}): {fmu.description.licence or 'not stated'}")
    return "\n".join([*lines, ""])


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [f"<tr>{''.join(f'<th>{escaped(cell)}</th>' for cell in head)}</tr>"]
    lines += [f"<tr>{''.join(f'<td>{escaped(cell)}</td>' for cell in row)}</tr>" for row in rows]
    return "<table>" + "\n".join(lines) + "</table>"
