"""Descriptions of FMI 1.0 Co-Simulation in the form of FMI 2.0.

Source: FMI 1.0 for Co-Simulation, sections 2.2 and 3.2; FMI 2.0, section 2.2.
"""

from __future__ import annotations

from typing import Any

from stickslip.fmi.description.attributes import DescriptionFault, name_of
from stickslip.fmi.messages import shown


def upgrade(root: Any) -> None:
    """Turn a description of FMI 1.0 into one of FMI 2.0, whose lines stay those of the file.

    Raises
    ------
    DescriptionFault
        When the FMU is for Model Exchange, or an input or output is a negated alias.
    """
    capabilities = root.find("Implementation/*/Capabilities")
    if capabilities is None:
        raise DescriptionFault(
            root,
            "fmiVersion is '1.0' and the interface Model Exchange, of FMI 1.0 only Co-Simulation"
            " is run; export the model again for FMI 2.0 or 3.0",
        )
    tool = root.find("Implementation/CoSimulation_Tool") is not None
    chosen = root.makeelement(
        "CoSimulation",
        {
            **capabilities.attrib,
            "modelIdentifier": root.get("modelIdentifier", ""),
            "needsExecutionTool": str(tool).lower(),
        },
    )
    root.append(chosen)
    for declared in root.iterfind("TypeDefinitions/Type"):
        declared.tag = "SimpleType"
        for typed in declared:
            typed.tag = typed.tag.removesuffix("Type")
            for number, item in enumerate(typed, 1):
                item.set("value", str(number))
    variables = root.find("ModelVariables")
    for variable in [] if variables is None else list(variables):
        _upgrade_variable(variable)
        if variable.get("alias") == "negatedAlias":
            variables.remove(variable)
    root.append(_structure(root))


def _upgrade_variable(variable: Any) -> None:
    causality = variable.get("causality", "internal")
    variability = variable.get("variability", "continuous")
    if causality in {"input", "output"} and variable.get("alias") == "negatedAlias":
        raise DescriptionFault(
            variable,
            f"{causality} {shown(name_of(variable))} is a negated alias, which is not supported;"
            " export the model again for FMI 2.0 or 3.0",
        )
    if causality in {"internal", "none"}:
        causality = "parameter" if variability == "parameter" else "local"
    if variability == "parameter":
        variability = "fixed" if causality == "parameter" else "discrete"
    if causality == "input" and variability == "constant":
        variability = "discrete"
    variable.set("causality", causality)
    variable.set("variability", variability)
    if len(variable) and variable[0].get("start") is not None and causality in {"local", "output"}:
        exact = variability == "constant" or variable[0].get("fixed", "true") in {"true", "1"}
        variable.set("initial", "exact" if exact else "approx")


def _structure(root: Any) -> Any:
    """Return the outputs with what they depend on."""
    variables = list(root.iterfind("ModelVariables/ScalarVariable"))
    places = {variable.get("name"): str(i) for i, variable in enumerate(variables, 1)}
    structure = root.makeelement("ModelStructure")
    outputs = root.makeelement("Outputs")
    structure.append(outputs)
    for i, variable in enumerate(variables, 1):
        if variable.get("causality") == "output":
            unknown = root.makeelement("Unknown", {"index": str(i)})
            direct = variable.find("DirectDependency")
            if direct is not None:
                known = (places.get(name.text or "", "0") for name in direct)
                unknown.set("dependencies", " ".join(known))
            outputs.append(unknown)
    return structure
