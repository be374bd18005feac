"""What the two modelDescription.xml have in common, on ElementTree."""

from __future__ import annotations

import re
from collections.abc import Mapping
from xml.etree import ElementTree as ET

from stickslip.models.export.description import Model, Variable
from stickslip.models.export.units import DISPLAY, base_unit

Attributes = dict[str, str]

# A path of identifiers with indices (FMI 2.0.4, section 2.2.9).
_NAME = r"[A-Za-z_]\w*(?:\[\d+(?:,\d+)*\])?"
_PATH = rf"{_NAME}(?:\.{_NAME})*"
_STRUCTURED = re.compile(rf"{_PATH}|der\({_PATH}\)", re.ASCII)

LOG_CATEGORIES = {
    "logStatusError": "Calls that failed, and why",
    "logStatusDiscard": "Points at which the equations cannot be evaluated",
    "logEvents": "Phases of the life cycle",
    "logAll": "All of these",
}


def child(parent: ET.Element, tag: str, **attributes: object) -> ET.Element:
    """Append an element; attributes that are None are left out."""
    return ET.SubElement(parent, tag, {k: text(v) for k, v in attributes.items() if v is not None})


def text(value: object) -> str:
    """Return a value as XML schema writes it; floats keep every bit."""
    if isinstance(value, bool):
        return str(value).lower()
    return repr(value) if isinstance(value, float) else str(value)


def start_text(v: Variable) -> str:
    """Return the start value in the variable's own type."""
    if v.type == "boolean":
        return text(v.start != 0.0)
    return text(v.start if v.type == "real" else int(v.start))


def limits(v: Variable) -> dict[str, object]:
    """Return ``min`` and ``max`` as attributes in the variable's own type."""
    convert = int if v.type == "integer" else float
    return {
        key: None if value is None else convert(value)
        for key, value in (("min", v.minimum), ("max", v.maximum))
    }


def root(model: Model, version: str, **attributes: str) -> ET.Element:
    """Return the root element with what describes the model."""
    return ET.Element(
        "fmiModelDescription",
        {
            "fmiVersion": version,
            "modelName": model.name,
            "description": f"{model.title}. {model.description}",
            "author": "The stickslip authors",
            "copyright": "(c) 2026 The stickslip authors",
            "license": "MIT",
            "generationTool": "stickslip",
            "variableNamingConvention": "structured" if _structured(model) else "flat",
            **({"version": model.version} if model.version else {}),
            **attributes,
        },
    )


def _structured(model: Model) -> bool:
    return all(_STRUCTURED.fullmatch(v.name) for v in model.variables)


def add_units(parent: ET.Element, model: Model) -> None:
    """Append the UnitDefinitions of the units that the model uses."""
    definitions = child(parent, "UnitDefinitions")
    for unit in sorted({v.unit for v in model.variables if v.unit}):
        definition, base = child(definitions, "Unit", name=unit), base_unit(unit)
        if base is not None:
            child(definition, "BaseUnit", **base)
        for name, factor in DISPLAY.get(unit, {}).items():
            child(definition, "DisplayUnit", name=name, factor=factor)


def add_log_categories(parent: ET.Element) -> None:
    """Append the categories that the adapter's messages carry."""
    categories = child(parent, "LogCategories")
    for name, description in LOG_CATEGORIES.items():
        child(categories, "Category", name=name, description=description)


def add_default_experiment(parent: ET.Element, model: Model) -> None:
    """Append the DefaultExperiment."""
    child(
        parent,
        "DefaultExperiment",
        startTime=0.0,
        stopTime=float(model.stop),
        tolerance=1e-6 if model.is_continuous else None,
        stepSize=model.step,
    )


def knowns(model: Model) -> set[str]:
    """Return what an output may be said to depend on: inputs, and what a solver integrates."""
    return {v.name for v in model.variables if v.role == "input"} | {
        v.of for v in model.variables if v.of
    }


def dependencies(v: Variable, known: set[str], place: Mapping[str, int]) -> dict[str, object]:
    """Return both attributes of an element of ModelStructure; a state is its own output."""
    depends = {v.name: "constant"} if v.role == "state" else v.depends
    listed = {place[name]: kind for name, kind in depends.items() if name in known}
    return {
        "dependencies": " ".join(str(k) for k in sorted(listed)),
        "dependenciesKind": " ".join(listed[k] for k in sorted(listed)),
    }


def initial_dependencies(v: Variable, model: Model, place: Mapping[str, int]) -> dict[str, object]:
    """Return both attributes of an element of InitialUnknowns, where parameters count as well.

    What is sampled answers its inputs from the first sample on, what belongs to a step after it.
    """
    later = v.held and not model.is_continuous
    at_once = () if model.sampled or later else v.depends
    listed = sorted(place[name] for name in {*at_once, *(() if later else v.uses)})
    return {
        "dependencies": " ".join(map(str, listed)),
        "dependenciesKind": " ".join("dependent" for _ in listed),
    }


def document(element: ET.Element) -> str:
    """Return the document as text, indented."""
    ET.indent(element)
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{ET.tostring(element, encoding="unicode")}\n'
