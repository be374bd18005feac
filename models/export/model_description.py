"""modelDescription.xml of FMI 2.0 and FMI 3.0."""

from xml.etree import ElementTree as ET

from stickslip.fmi.description.model import ANNOTATION
from stickslip.fmi.description.writing import child, document, naming, text
from stickslip.models.export.description import Model, Variable
from stickslip.models.export.sources import START, FmiVersion, c_files, compiled
from stickslip.models.export.units import DISPLAY, base_unit

_TAGS = {
    2: {"real": "Real", "integer": "Integer", "boolean": "Boolean"},
    3: {"real": "Float64", "integer": "Int32", "boolean": "Boolean"},
}
_INITIAL = {
    **dict.fromkeys(("state", "parameter"), "exact"),
    **dict.fromkeys(("mode", "derivative", "indicator", "output", "memory"), "calculated"),
}
_CAUSALITY = {"input": "input", "parameter": "parameter", "time": "independent"}
_LOG_CATEGORIES = {
    "logStatusError": "Calls that failed, and why",
    "logStatusDiscard": "Points at which the equations cannot be evaluated",
    "logEvents": "Phases of the life cycle",
    "logAll": "All of these",
}


def model_description(model: Model, token: str, fmi: FmiVersion) -> str:
    """Return the XML; the binary checks the token. Source: FMI 2.0.4, 2.2; FMI 3.0.2, 2.4."""
    root = ET.Element(
        "fmiModelDescription",
        {
            "fmiVersion": f"{fmi}.0",
            "modelName": model.name,
            "description": f"{model.title}. {model.description}",
            "author": "The stickslip authors",
            "copyright": "(c) 2026 The stickslip authors",
            "license": "MIT",
            "generationTool": "stickslip",
            "variableNamingConvention": naming(v.name for v in model.variables),
            **({"version": model.version} if model.version else {}),
            ("guid" if fmi == 2 else "instantiationToken"): token,
        },
    )
    _add_interfaces(root, model, fmi)
    definitions = child(root, "UnitDefinitions")
    for unit in sorted({v.unit for v in model.variables if v.unit}):
        definition, base = child(definitions, "Unit", name=unit), base_unit(unit)
        if base is not None:
            child(definition, "BaseUnit", **base)
        for name, factor in DISPLAY.get(unit, {}).items():
            child(definition, "DisplayUnit", name=name, factor=factor)
    categories = child(root, "LogCategories")
    for name, description in _LOG_CATEGORIES.items():
        child(categories, "Category", name=name, description=description)
    span = {"startTime": 0.0, "stopTime": float(model.stop)}
    tolerance = 1e-6 if model.is_continuous else None
    child(root, "DefaultExperiment", **span, tolerance=tolerance, stepSize=model.step)
    if fmi == 2:
        _add_learned(root, model, "VendorAnnotations", "Tool", name=ANNOTATION)
    # FMI 2.0 does not ask for time, of which importers built on FMILibrary complain that it has no
    # start value, which it must not have. There a variable is named by its place, from 1.
    listed = [(k, v) for k, v in enumerate(model.variables) if fmi == 3 or v.role != "time"]
    place = {v.name: k for k, (_, v) in enumerate(listed, 3 - fmi)}
    variables = child(root, "ModelVariables")
    for reference, v in listed:
        own: dict[str, object] = {
            "name": v.name,
            "valueReference": reference,
            "description": v.description,
            "causality": _CAUSALITY.get(v.role, "output" if v.is_output else "local"),
            "variability": v.variability,
            "initial": _INITIAL.get(v.role),
        }
        typed: dict[str, object] = {
            "unit": v.unit,
            "displayUnit": v.display,
            "min": _typed(v, v.minimum),
            "max": _typed(v, v.maximum),
            "nominal": v.nominal,
            "derivative": place[v.of] if v.of else None,
            "start": _start(v),
        }
        if fmi == 2:
            child(child(variables, "ScalarVariable", **own), _TAGS[2][v.type], **typed)
        else:
            child(variables, _TAGS[3][v.type], **own, **typed)
    _add_structure(root, model, place, fmi)
    if fmi == 3:
        _add_learned(root, model, "Annotations", "Annotation", type=ANNOTATION)
    return document(root)


def _add_learned(root: ET.Element, model: Model, place: str, tag: str, **named: str) -> None:
    """Note which parameters take over what a run has learned."""
    if model.ports is not None and model.ports.learned:
        annotation = child(child(root, place), tag, **named)
        learned = child(annotation, "Learned", model=model.folder.name)
        for parameter, variable in model.ports.learned.items():
            child(learned, "State", parameter=parameter, variable=variable)


def _add_interfaces(root: ET.Element, model: Model, fmi: FmiVersion) -> None:
    smooth = model.is_continuous and not model.is_switched
    capabilities: dict[str, object] = {"modelIdentifier": model.name}
    if fmi == 2:
        capabilities["canNotUseMemoryManagementFunctions"] = True
        capabilities |= {"canGetAndSetFMUstate": True, "canSerializeFMUstate": True}
        capabilities |= {"providesDirectionalDerivative": smooth}
        integrated = {"completedIntegratorStepNotNeeded": True}
    else:
        capabilities |= {"canGetAndSetFMUState": True, "canSerializeFMUState": True}
        capabilities |= {"providesDirectionalDerivatives": smooth}
        capabilities |= {"providesAdjointDerivatives": smooth}
        integrated = {"needsCompletedIntegratorStep": False}
    if model.has_model_exchange:
        if fmi == 2:
            indicators = sum(v.role == "indicator" for v in model.variables)
            root.set("numberOfEventIndicators", str(indicators))
        child(root, "ModelExchange", **capabilities, **integrated)
    child(root, "CoSimulation", **capabilities, canHandleVariableCommunicationStepSize=True)
    names = compiled([*c_files(model, 2), START]) if fmi == 2 else []
    for interface in root if names else ():
        listed = child(interface, "SourceFiles")
        for path in names:
            child(listed, "File", name=path)


def _typed(v: Variable, value: float | None) -> object:
    """Return a number in the variable's own type."""
    return value if value is None else int(value) if v.type == "integer" else float(value)


def _start(v: Variable) -> str | None:
    """Return the start value of inputs and of what is initially exact, in its own type."""
    if v.role != "input" and _INITIAL.get(v.role) != "exact":
        return None
    if v.type == "boolean":
        return text(v.start != 0.0)
    return text(v.start if v.type == "real" else int(v.start))


def _add_structure(root: ET.Element, model: Model, place: dict[str, int], fmi: FmiVersion) -> None:
    structure = child(root, "ModelStructure")
    # Outputs depend on inputs and on what a solver integrates.
    knowns = {v.name for v in model.variables if v.role == "input"}
    knowns |= {v.of for v in model.variables if v.of}
    outputs = [v for v in model.variables if v.is_output]
    derivatives = [v for v in model.variables if v.role == "derivative"]
    unknowns = [v for v in (*outputs, *derivatives) if _INITIAL[v.role] == "calculated"]
    if fmi == 2:
        unknowns.sort(key=lambda v: place[v.name])
    for plural, tag, members in (
        ("Outputs", "Output", outputs),
        ("Derivatives", "ContinuousStateDerivative", derivatives),
        ("InitialUnknowns", "InitialUnknown", unknowns),
    ):
        section = child(structure, plural) if fmi == 2 and members else structure
        for v in members:
            if tag == "InitialUnknown":
                listed = _initial_dependencies(v, model, place)
            else:  # a state is its own output
                depends = {v.name: "constant"} if v.role == "state" else v.depends
                listed = {place[name]: kind for name, kind in depends.items() if name in knowns}
            named = {"index" if fmi == 2 else "valueReference": place[v.name]}
            dependencies = " ".join(map(str, sorted(listed)))
            kinds = " ".join(listed[k] for k in sorted(listed))
            entry = "Unknown" if fmi == 2 else tag
            child(section, entry, **named, dependencies=dependencies, dependenciesKind=kinds)
    for v in model.variables if fmi == 3 else ():
        if v.role == "indicator":  # depends on all
            child(structure, "EventIndicator", valueReference=place[v.name])


def _initial_dependencies(v: Variable, model: Model, place: dict[str, int]) -> dict[int, str]:
    """Return what a value depends on before the first step or sample, parameters included."""
    later = v.held and not model.is_continuous
    at_once = () if model.sampled or later else v.depends
    return {place[name]: "dependent" for name in {*at_once, *(() if later else v.uses)}}
