"""What a container shows of its system, and its modelDescription.xml and documentation.

Source: FMI 2.0.4 section 2.2, FMI 3.0.2 section 2.4.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import Literal
from xml.etree import ElementTree as ET

from stickslip.cosim.display import html_table
from stickslip.cosim.errors import ConnectionFault, CosimError, ParameterError
from stickslip.cosim.system.system import System
from stickslip.fmi.description.model import DefaultExperiment
from stickslip.fmi.description.units import BASE_UNITS, Unit
from stickslip.fmi.description.variables import Value, Variable
from stickslip.fmi.description.writing import child, document, naming
from stickslip.fmi.messages import escaped, suggestion

Role = Literal["TIME", "INPUT", "OUTPUT", "PARAMETER", "TUNABLE"]

# FMI 2.0 has one integer for both of these; the 64-bit enumerations of FMI 3.0 are left out.
TYPES = {"Real": "REAL", "Float64": "REAL", "Integer": "INTEGER", "Int32": "INTEGER"}
TYPES["Boolean"] = "BOOLEAN"


@dataclass(frozen=True)
class ContainerVariable:
    """A variable whose value reference is its place; ``source`` is what it stands for."""

    name: str
    role: Role
    type: str
    source: str = ""
    unit: Unit | None = None
    start: Value | None = None
    minimum: float | None = None
    maximum: float | None = None
    nominal: float | None = None
    description: str = ""


def shown_variables(
    system: System, outputs: Sequence[str] | None, parameters: Sequence[str] | None
) -> list[ContainerVariable]:
    """Return what a container shows, time first: what the names or patterns say, or all."""
    second = Unit("s", (0, 0, 1, 0, 0, 0, 0, 0))
    time = ContainerVariable("time", "TIME", "REAL", unit=second, description="Simulation time")
    inputs = [_input(system, name) for name in system.inputs]
    return [time, *inputs, *_outputs(system, outputs), *_parameters(system, parameters)]


def _input(system: System, name: str) -> ContainerVariable:
    target = system.inputs[name][0]
    variable = system.variable(target)
    start = system.parameters.get(target, variable.start)
    unit, start = system.unit_of(name), 0.0 if start is None else start
    described = variable.description
    if not variable.is_plain:
        what = "which a container does not show; leave it out"
        raise ConnectionFault(f"input {name} is a {variable.type}, {what}")
    return ContainerVariable(name, "INPUT", "REAL", name, unit, start, description=described)


def _outputs(system: System, patterns: Sequence[str] | None) -> list[ContainerVariable]:
    every = _variables(system, lambda v: v.causality == "output" and v.is_plain)
    if hidden := [name for name, source in system.outputs.items() if source not in every]:
        what = "is an array or of a type that a container does not show"
        raise ConnectionFault(f"output {hidden[0]} {what}")
    names = dict(system.outputs) if patterns is None else {}
    if not names:
        names = {name: name for name in _matching(every, patterns, ConnectionFault)}
    return [_shown(system, name, "OUTPUT", every[source], source) for name, source in names.items()]


def _parameters(system: System, patterns: Sequence[str] | None) -> list[ContainerVariable]:
    def is_settable(v: Variable) -> bool:
        scalar = v.type in TYPES and not v.dimensions and v.start is not None
        return v.causality == "parameter" and scalar

    every = _variables(system, is_settable)
    chosen = {name: every[name] for name in _matching(every, patterns, ParameterError)}
    return [
        _shown(system, name, "TUNABLE" if v.variability == "tunable" else "PARAMETER", v, name)
        for name, v in chosen.items()
    ]


def _variables(system: System, wanted: Callable[[Variable], bool]) -> dict[str, Variable]:
    return {
        f"{component}.{variable.name}": variable
        for component, fmu in system.components.items()
        for variable in fmu.variables.values()
        if wanted(variable)
    }


def _shown(system: System, name: str, role: Role, v: Variable, source: str) -> ContainerVariable:
    start = None if role == "OUTPUT" else system.parameters.get(source, v.start)
    limits = (v.minimum, v.maximum, v.nominal)
    unit = system.unit_of(source)
    return ContainerVariable(name, role, TYPES[v.type], source, unit, start, *limits, v.description)


def _matching(
    every: dict[str, Variable], patterns: Sequence[str] | None, error: type[CosimError]
) -> list[str]:
    chosen: dict[str, None] = dict.fromkeys(every if patterns is None else ())
    for pattern in patterns or ():
        found = [name for name in every if name == pattern or fnmatchcase(name, pattern)]
        if not found:
            near = suggestion(pattern, every)
            raise error(f"{pattern!r} matches nothing that a container can expose{near}")
        chosen |= dict.fromkeys(found)
    return list(chosen)


_TAGS = {
    2: {"REAL": "Real", "INTEGER": "Integer", "BOOLEAN": "Boolean"},
    3: {"REAL": "Float64", "INTEGER": "Int32", "BOOLEAN": "Boolean"},
}
_CAUSALITY = {"TIME": "independent", "INPUT": "input", "OUTPUT": "output"}
_CAUSALITY |= dict.fromkeys(("PARAMETER", "TUNABLE"), "parameter")
_VARIABILITY = {"PARAMETER": "fixed", "TUNABLE": "tunable"}
_INITIAL = {"PARAMETER": "exact", "TUNABLE": "exact", "OUTPUT": "calculated"}


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
    """Return the XML; the experiment's step is that of the components."""
    head = {
        "fmiVersion": f"{version}.0",
        "modelName": name,
        "guid" if version == 2 else "instantiationToken": token,
        "description": "A system of coupled FMUs, stepped by the kernel of stickslip",
        "version": "1.0",
        "author": "The authors of its components",
        "license": "That of each component: documentation/licenses/license.txt",
        "generationTool": "stickslip",
        "variableNamingConvention": naming(v.name for v in shown),
    }
    root = ET.Element("fmiModelDescription", head)
    state = "state" if version == 2 else "State"
    flags = {f"canGetAndSetFMU{state}": restores_state, f"canSerializeFMU{state}": serializes}
    flags["canHandleVariableCommunicationStepSize"] = varies_step
    internal = experiment.step if version == 3 and not varies_step else None
    child(root, "CoSimulation", modelIdentifier=identifier, **flags, fixedInternalStepSize=internal)
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
        components=html_table(("component", "model", "standard", "token"), components),
        connections=html_table(("from", "to"), connections),
        delay=", each delayed by one step" if jacobi else "",
    )


def licences(system: System) -> str:
    """Return the licence that each component declares."""
    lines = ["The FMUs in resources/ stay under their own licences:", ""]
    for name, fmu in system.fmus("a container").items():
        lines.append(f"{name} ({fmu.name}): {fmu.description.licence or 'not stated'}")
    return "\n".join([*lines, ""])
