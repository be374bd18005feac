"""modelDescription.xml of FMI 3.0."""

from __future__ import annotations

from stickslip.models.export import xml
from stickslip.models.export.description import Model
from stickslip.models.export.fmi2 import causality, has_start, initial

_TAGS = {"real": "Float64", "integer": "Int32", "boolean": "Boolean"}


def model_description(model: Model, token: str) -> str:
    """Return the XML. ``token`` is what the binary checks.

    Source
    ------
    FMI 3.0.2, section 2.4.
    """
    root = xml.root(model, "3.0", instantiationToken=token)
    capabilities: dict[str, object] = {
        "modelIdentifier": model.name,
        "canGetAndSetFMUState": True,
        "canSerializeFMUState": True,
        "providesDirectionalDerivatives": model.is_continuous,
        "providesAdjointDerivatives": model.is_continuous,
    }
    if model.has_model_exchange:
        xml.child(root, "ModelExchange", **capabilities, needsCompletedIntegratorStep=False)
    xml.child(root, "CoSimulation", **capabilities, canHandleVariableCommunicationStepSize=True)
    xml.add_units(root, model)
    xml.add_log_categories(root)
    xml.add_default_experiment(root, model)
    variables = xml.child(root, "ModelVariables")
    place = {v.name: k for k, v in enumerate(model.variables)}
    for reference, v in enumerate(model.variables):
        xml.child(
            variables,
            _TAGS[v.type],
            name=v.name,
            valueReference=reference,
            description=v.description,
            causality=causality(v),
            variability=v.variability,
            initial=initial(v),
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
    for tag, unknowns in (("Output", outputs), ("ContinuousStateDerivative", derivatives)):
        for v in unknowns:
            depends = xml.dependencies(v, known, place)
            xml.child(structure, tag, valueReference=place[v.name], **depends)
    for v in (*outputs, *derivatives):
        if initial(v) == "calculated":
            depends = xml.initial_dependencies(v, model, place)
            xml.child(structure, "InitialUnknown", valueReference=place[v.name], **depends)
    return xml.document(root)
