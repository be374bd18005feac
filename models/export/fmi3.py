"""modelDescription.xml of FMI 3.0."""

from __future__ import annotations

from models.export import xml
from models.export.description import Model
from models.export.fmi2 import causality, has_start, initial

_TAGS = {"real": "Float64", "integer": "Int32", "boolean": "Boolean"}


def model_description(model: Model, token: str) -> str:
    """Return the XML. ``token`` is what the binary checks.

    Source
    ------
    FMI 3.0.2, section 2.4.
    """
    root = xml.root(model, "3.0", instantiationToken=token)
    xml.child(
        root,
        "CoSimulation",
        modelIdentifier=model.name,
        canGetAndSetFMUState=True,
        canSerializeFMUState=True,
        canHandleVariableCommunicationStepSize=True,
    )
    xml.add_units(root, model)
    xml.add_log_categories(root)
    xml.add_default_experiment(root, model)
    variables = xml.child(root, "ModelVariables")
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
            **xml.limits(v),
            nominal=v.nominal,
            start=xml.start_text(v) if has_start(v) else None,
        )
    place = {v.name: k for k, v in enumerate(model.variables)}
    structure = xml.child(root, "ModelStructure")
    outputs = [v for v in model.variables if v.is_output]
    for v in outputs:
        depends = " ".join(str(place[name]) for name in v.feedthrough)
        xml.child(structure, "Output", valueReference=place[v.name], dependencies=depends)
    for v in outputs:
        if initial(v) == "calculated":
            xml.child(structure, "InitialUnknown", valueReference=place[v.name])
    return xml.document(root)
