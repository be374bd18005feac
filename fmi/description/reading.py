"""A whole description from its XML."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

from stickslip.fmi.description.attributes import DescriptionFault, name_of, real, whole, whole_of
from stickslip.fmi.description.clocks import read_clocks
from stickslip.fmi.description.elements import MAX_REFERENCE, Lengths, read_variable, typed_element
from stickslip.fmi.description.fmi1 import upgrade
from stickslip.fmi.description.learned import read_learned
from stickslip.fmi.description.model import DefaultExperiment, Description
from stickslip.fmi.description.structure import read_derivatives, read_unknowns
from stickslip.fmi.description.types import read_types, read_units
from stickslip.fmi.description.variables import MAX_ELEMENTS, Variable
from stickslip.fmi.messages import shown

_INTERFACES = ("CoSimulation", "ModelExchange", "ScheduledExecution")


def read_description(root: Any) -> Description:
    """Return what a description says."""
    standard = _version(root)
    version = max(2, standard)
    if standard == 1:
        upgrade(root)
    units, types = read_units(root), read_types(root, version)
    elements = _elements(root)
    lengths = _lengths(elements) if version == 3 else {}
    typed = [typed_element(each, version) for each in elements]
    variables = [
        read_variable(each, inner, version, types, lengths)
        for each, inner in zip(elements, typed, strict=True)
    ]
    aliases = _aliases(elements) if version == 3 else {}
    _check_distinct(variables, elements, aliases)
    for variable, element in zip(variables, elements, strict=True):
        _check_numbers(variable, element)
    _check_size(variables, elements)
    places = (
        {str(i): v.name for i, v in enumerate(variables, 1)}
        if version == 2
        else {str(v.reference): v.name for v in variables}
    )
    unknowns = read_unknowns(root, version, places)
    states = read_derivatives(
        ((inner, v.name) for inner, v in zip(typed, variables, strict=True)), places
    )
    by_name = {v.name: v for v in variables}
    rates = [u.name for u in unknowns["derivatives"]]
    return Description(
        standard=standard,
        name=root.get("modelName", ""),
        token=root.get("guid" if version == 2 else "instantiationToken", ""),
        licence=root.get("license", ""),
        interfaces={
            tag: dict(e.attrib) for tag in _INTERFACES if (e := root.find(tag)) is not None
        },
        experiment=_experiment(root.find("DefaultExperiment")),
        units=units,
        variables=MappingProxyType(by_name),
        aliases=aliases,
        outputs=tuple(unknowns["outputs"]),
        derivatives={rate: states.get(rate) for rate in rates},
        derivative_of=states,
        n_states=sum(by_name[rate].size for rate in rates),
        n_indicators=_indicators(root)
        if version == 2
        else sum(by_name[u.name].size for u in unknowns["indicators"]),
        clocks=read_clocks(elements) if version == 3 else (),
        outside=tuple(filter(_starts_outside, variables)),
        learned=read_learned(root, by_name),
    )


def _version(root: Any) -> int:
    version = root.get("fmiVersion")
    if root.tag != "fmiModelDescription":
        raise DescriptionFault(
            root, f"the root element is {shown(str(root.tag))}, expected fmiModelDescription"
        )
    if version is None or not re.fullmatch(r"[12]\.0|3\.[0-9]+(\.[0-9]+)?", version):
        stated = "missing" if version is None else shown(version)
        raise DescriptionFault(
            root,
            f"fmiVersion is {stated}, expected '1.0', '2.0' or '3.0'; export the model again for"
            " one of these",
        )
    return int(version[0])


def _elements(root: Any) -> list[Any]:
    found = root.find("ModelVariables")
    if found is None:
        raise DescriptionFault(root, "ModelVariables is missing; export it again")
    return list(found)


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


def _aliases(elements: Sequence[Any]) -> dict[str, str]:
    found: dict[str, str] = {}
    for element in elements:
        for alias in element.iterfind("Alias"):
            if (name := name_of(alias)) in found:
                raise DescriptionFault(alias, f"a second alias {shown(name)}; rename it")
            found[name] = element.get("name")
    return found


def _check_size(variables: Sequence[Variable], elements: Sequence[Any]) -> None:
    if (total := sum(v.size for v in variables)) > MAX_ELEMENTS:
        raise DescriptionFault(
            elements[0].getparent(),
            f"all arrays together have {total} elements, expected at most {MAX_ELEMENTS}",
        )


def _indicators(root: Any) -> int:
    if root.get("numberOfEventIndicators") is None:
        return 0
    return whole_of(root, "numberOfEventIndicators", 0, MAX_ELEMENTS)


def _experiment(element: Any) -> DefaultExperiment:
    if element is None:
        return DefaultExperiment()

    def number(name: str) -> float | None:
        text: str | None = element.get(name)
        return None if text is None else real(text, name, element)

    tolerance = number("tolerance")
    if tolerance is not None and not 0 < tolerance < 1:
        tolerance = None  # no tolerance, as other importers see it
    return DefaultExperiment(number("startTime"), number("stopTime"), number("stepSize"), tolerance)


def _check_distinct(
    variables: Sequence[Variable], elements: Sequence[Any], aliases: Mapping[str, str]
) -> None:
    """Check that names, and in FMI 3.0 value references, occur once."""
    names: set[str] = set(aliases)
    references: dict[int, str] = {}
    for variable, element in zip(variables, elements, strict=True):
        if variable.name in names:
            raise DescriptionFault(element, f"a second variable {shown(variable.name)}; rename it")
        names.add(variable.name)
        if element.tag == "ScalarVariable":  # FMI 2.0: those that share one are one quantity
            continue
        other = references.setdefault(variable.reference, variable.name)
        if other is not variable.name:
            raise DescriptionFault(
                element,
                f"valueReference {variable.reference} of {shown(variable.name)} is that of"
                f" {shown(other)} already; in FMI 3.0 each variable has its own",
            )


def _check_numbers(variable: Variable, element: Any) -> None:
    """Check that a range holds a value and that a nominal value is one."""
    low, high, nominal = variable.minimum, variable.maximum, variable.nominal
    for what, number in (("min", low), ("max", high)):
        if number is not None and number != number:
            raise DescriptionFault(
                element, f"{what} of {shown(variable.name)} is nan, expected a number"
            )
    if low is not None and high is not None and low > high:
        raise DescriptionFault(
            element,
            f"min of {shown(variable.name)} is {low}, above its max {high}, so that no value is"
            " left; export it again",
        )
    if nominal is not None and not 0 < nominal < float("inf"):
        raise DescriptionFault(
            element, f"nominal of {shown(variable.name)} is {nominal}, expected a positive number"
        )


def _starts_outside(variable: Variable) -> bool:
    """Tell whether a start value that the FMU itself gives is not in the variable's range."""
    start = variable.start
    if start is None or isinstance(start, (str, bytes, bool)):
        return False
    low = float("-inf") if variable.minimum is None else variable.minimum
    high = float("inf") if variable.maximum is None else variable.maximum
    values = start if isinstance(start, tuple) else (start,)
    return not all(low <= value <= high for value in values if not isinstance(value, (str, bytes)))
