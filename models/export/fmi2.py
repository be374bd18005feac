"""modelDescription.xml of FMI 2.0."""

from __future__ import annotations

from stickslip.models.export import xml
from stickslip.models.export.description import Model, Variable
from stickslip.models.export.sources import c_files, compiled

_TAGS = {"real": "Real", "integer": "Integer", "boolean": "Boolean"}
_INITIAL = {
    "state": "exact",
    "parameter": "exact",
    "derivative": "calculated",
    "output": "calculated",
    "memory": "calculated",
}


def causality(v: Variable) -> str:
    """Return the causality of a variable, the same in FMI 2.0 and FMI 3.0."""
    if v.role in ("input", "parameter"):
        return v.role
    if v.role == "time":
        return "independent"
    return "output" if v.is_output else "local"


def has_start(v: Variable) -> bool:
    """Tell whether a variable carries a start value: inputs and what is initially exact."""
    return v.role == "input" or _INITIAL.get(v.role) == "exact"


def initial(v: Variable) -> str | None:
    """Return the attribute ``initial``; inputs and time have none."""
    return _INITIAL.get(v.role)


def model_description(model: Model, token: str) -> str:
    """Return the XML. ``token`` is what the binary checks.

    Source
    ------
    FMI 2.0.4, section 2.2.
    """
    root = xml.root(model, "2.0", guid=token)
    capabilities: dict[str, object] = {
        "modelIdentifier": model.name,
        "canNotUseMemoryManagementFunctions": True,
        "canGetAndSetFMUstate": True,
        "canSerializeFMUstate": True,
        "providesDirectionalDerivative": model.is_continuous,
    }
    if model.has_model_exchange:
        root.set("numberOfEventIndicators", "0")
        xml.child(root, "ModelExchange", **capabilities, completedIntegratorStepNotNeeded=True)
    xml.child(root, "CoSimulation", **capabilities, canHandleVariableCommunicationStepSize=True)
    for interface in root:
        listed = xml.child(interface, "SourceFiles")
        for path in compiled(c_files(model, 2)):
            xml.child(listed, "File", name=path)
    xml.add_units(root, model)
    xml.add_log_categories(root)
    xml.add_default_experiment(root, model)
    variables = xml.child(root, "ModelVariables")
    # Here a variable is named by its place in ModelVariables, from 1.
    place = {v.name: k for k, (_, v) in enumerate(_listed(model), 1)}
    for reference, v in _listed(model):
        scalar = xml.child(
            variables,
            "ScalarVariable",
            name=v.name,
            valueReference=reference,
            description=v.description,
            causality=causality(v),
            variability=v.variability,
            initial=initial(v),
        )
        xml.child(
            scalar,
            _TAGS[v.type],
            unit=v.unit,
            displayUnit=v.display,
            **xml.limits(v),
            nominal=v.nominal,
            derivative=place[v.of] if v.of else None,
            start=xml.start_text(v) if has_start(v) else None,
        )
    structure = xml.child(root, "ModelStructure")
    known = xml.knowns(model)
    outputs = [v for v in model.variables if v.is_output]
    derivatives = [v for v in model.variables if v.role == "derivative"]
    initial_unknowns = [v for v in outputs if initial(v) == "calculated"] + derivatives
    for tag, unknowns in (
        ("Outputs", outputs),
        ("Derivatives", derivatives),
        ("InitialUnknowns", sorted(initial_unknowns, key=lambda v: place[v.name])),
    ):
        if unknowns:
            section = xml.child(structure, tag)
        for v in unknowns:
            depends = (
                xml.initial_dependencies(v, model, place)
                if tag == "InitialUnknowns"
                else xml.dependencies(v, known, place)
            )
            xml.child(section, "Unknown", index=place[v.name], **depends)
    return xml.document(root)


def _listed(model: Model) -> list[tuple[int, Variable]]:
    """Return value reference and variable, all but time, which FMI 2.0 does not ask for.

    Importers built on FMILibrary complain that it has no start value, which it must not have.
    """
    return [(k, v) for k, v in enumerate(model.variables) if v.role != "time"]
