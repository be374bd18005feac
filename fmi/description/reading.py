"""A whole description from its XML; one of FMI 1.0 is read in the form of FMI 2.0.

Source: FMI 1.0 for Model Exchange, section 3; FMI 1.0 for Co-Simulation, sections 2.2 and 3.2;
FMI 2.0, section 2.2.
"""

import codecs
import re
from collections.abc import Sequence
from types import MappingProxyType
from typing import Any

from stickslip.fmi.description.attributes import (
    DescriptionFault,
    Remarks,
    name_of,
    read_types,
    read_units,
    real,
    whole,
    whole_of,
)
from stickslip.fmi.description.elements import (
    MAX_REFERENCE,
    Lengths,
    name_apart,
    read_variable,
    typed_element,
)
from stickslip.fmi.description.model import (
    DefaultExperiment,
    Description,
    read_clocks,
    read_derivatives,
    read_learned,
    read_unknowns,
)
from stickslip.fmi.description.variables import MAX_ELEMENTS
from stickslip.fmi.messages import shown


def upgrade(root: Any) -> None:
    """Turn a description of FMI 1.0 into FMI 2.0; DescriptionFault where it cannot be run."""
    given = {"modelIdentifier": root.get("modelIdentifier", "")}
    implementation = root.find("Implementation/*")  # there is none in Model Exchange
    if implementation is not None:
        capabilities = implementation.find("Capabilities")
        given |= {} if capabilities is None else capabilities.attrib
        given["needsExecutionTool"] = str(implementation.tag == "CoSimulation_Tool").lower()
    tag = "ModelExchange" if implementation is None else "CoSimulation"
    root.append(root.makeelement(tag, given))
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
        what = f"{causality} {shown(name_of(variable))} is a negated alias, which is not supported"
        raise DescriptionFault(variable, f"{what}; export the model again for FMI 2.0 or 3.0")
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


_INTERFACES = ("CoSimulation", "ModelExchange", "ScheduledExecution")


def read_description(root: Any) -> Description:
    """Return what a description says."""
    standard = _version(root)
    version = max(2, standard)
    if standard == 1:
        upgrade(root)
    remarks = Remarks()
    encoding = root.getroottree().docinfo.encoding or "UTF-8"
    if codecs.lookup(encoding).name not in ("utf-8", "ascii"):
        remarks.add(root, f"the text is in {encoding}, expected UTF-8")
    units, types = read_units(root, remarks), read_types(root, version, remarks)
    found = _elements(root, version, remarks)
    elements = [element for _, element, _ in found]
    lengths = _lengths(elements) if version == 3 else {}
    given = version, types, lengths, remarks
    variables = [read_variable(each, inner, *given) for _, each, inner in found]
    aliases = _aliases(elements, remarks) if version == 3 else {}
    if (total := sum(v.size for v in variables)) > MAX_ELEMENTS:
        what = f"all arrays together have {total} elements, expected at most {MAX_ELEMENTS}"
        raise DescriptionFault(elements[0].getparent(), what)
    places: dict[str, str] = {}
    for (place, element, _), variable in zip(found, variables, strict=True):
        name = places.setdefault(str(place if version == 2 else variable.reference), variable.name)
        if name != variable.name:
            what = f"{shown(variable.name)} has the valueReference of {shown(name)}"
            remarks.add(element, f"{what}; in FMI 3.0 each variable has its own")
    unknowns = read_unknowns(root, version, places, remarks)
    typed = ((inner, v.name) for (_, _, inner), v in zip(found, variables, strict=True))
    states = read_derivatives(typed, places, remarks)
    by_name = {v.name: v for v in variables}
    rates = [u.name for u in unknowns["derivatives"]]
    interfaces = {tag: dict(e.attrib) for tag in _INTERFACES if (e := root.find(tag)) is not None}
    return Description(
        standard=standard,
        name=root.get("modelName", ""),
        tool=root.get("generationTool", ""),
        token=root.get("guid" if version == 2 else "instantiationToken", ""),
        licence=root.get("license", ""),
        interfaces=interfaces,
        experiment=_experiment(root.find("DefaultExperiment"), remarks),
        units=units,
        variables=MappingProxyType(by_name),
        aliases=aliases,
        outputs=tuple(unknowns["outputs"]),
        derivatives={rate: states.get(rate) for rate in rates},
        derivative_of=states,
        n_states=_count(root, "numberOfContinuousStates")
        if standard == 1
        else sum(by_name[rate].size for rate in rates),
        n_indicators=_count(root, "numberOfEventIndicators")
        if version == 2
        else sum(by_name[u.name].size for u in unknowns["indicators"]),
        clocks=read_clocks(elements, remarks) if version == 3 else (),
        learned=read_learned(root, by_name),
        remarks=remarks.lines,
    )


def _version(root: Any) -> int:
    version = root.get("fmiVersion")
    if root.tag != "fmiModelDescription":
        what = f"the root element is {shown(str(root.tag))}, expected fmiModelDescription"
        raise DescriptionFault(root, what)
    if version is None or not re.fullmatch(r"[12]\.0(\.[0-9]+)?|3\.[0-9]+(\.[0-9]+)?", version):
        stated = "missing" if version is None else shown(version)
        what = f"fmiVersion is {stated}, expected '1.0', '2.0' or '3.0'"
        raise DescriptionFault(root, f"{what}; export the model again for one of these")
    return int(version[0])


def _elements(root: Any, version: int, remarks: Remarks) -> list[tuple[int, Any, Any]]:
    """Return the variables: place in the list, element, and the one that has the type."""
    listed = root.find("ModelVariables")
    if listed is None:
        remarks.add(root, "ModelVariables is missing; there are no variables")
        return []
    taken: set[str] = set()
    found = []
    for place, element in enumerate(listed, 1):
        typed = remarks.attempt(typed_element, element, version)
        if typed is not None and remarks.attempt(name_apart, element, taken, remarks) is not None:
            found.append((place, element, typed))
    return found


def _lengths(elements: Sequence[Any]) -> Lengths:
    """Return what dimensions of arrays can refer to."""
    found: dict[int, tuple[str, int]] = {}
    for element in elements:
        source = element.get("causality") == "structuralParameter"
        if (source or element.get("variability") == "constant") and "Int" in element.tag:
            start = element.get("start", "")
            if len(start.split()) == 1:  # neither absent nor an array
                reference = whole_of(element, "valueReference", 0, MAX_REFERENCE)
                found[reference] = name_of(element), whole(start, "start", element)
    return found


def _aliases(elements: Sequence[Any], remarks: Remarks) -> dict[str, str]:
    found: dict[str, str] = {}
    names = {element.get("name") for element in elements}
    for element in elements:
        for alias in element.iterfind("Alias"):
            if (name := remarks.attempt(name_of, alias)) in names or name in found:
                remarks.add(alias, f"a second variable {shown(name or '')}; this alias is ignored")
            elif name:
                found[name] = element.get("name")
    return found


def _count(root: Any, attribute: str) -> int:
    """Return a number that only a solver needs."""
    if root.get(attribute) is None or root.find("ModelExchange") is None:
        return 0
    return whole_of(root, attribute, 0, MAX_ELEMENTS)


def _experiment(element: Any, remarks: Remarks) -> DefaultExperiment:
    if element is None:
        return DefaultExperiment()

    def number(name: str) -> float | None:
        text: str | None = element.get(name)
        return None if text is None else remarks.attempt(real, text, name, element)

    tolerance = number("tolerance")
    if tolerance is not None and not 0 < tolerance < 1:
        tolerance = None  # no tolerance, as other importers see it
    return DefaultExperiment(number("startTime"), number("stopTime"), number("stepSize"), tolerance)
