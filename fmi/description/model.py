"""What is read of a description: clocks, what an FMU learns, and the structure of the model.

FMI 2.0 refers to variables by their place in the list, FMI 3.0 by their value references.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from stickslip.fmi.description.attributes import DescriptionFault, Remarks, finite, whole
from stickslip.fmi.description.units import Unit
from stickslip.fmi.description.variables import Variable
from stickslip.fmi.messages import shown

# When an FMU is asked for the interval, by ``intervalVariability``; places in ``enum Asked``.
# Clocks of other kinds are triggered by the importer.
_TRIGGERED = "triggered"
_NEVER, _ONCE = 0, 1
_ASKED = {**dict.fromkeys(("constant", "fixed", "tunable"), _NEVER), "calculated": _ONCE}
_ASKED |= {"changing": 2, "countdown": 3}


@dataclass(frozen=True)
class Clock:
    """An input clock; interval and shift are in s."""

    name: str
    reference: int
    asked: int | None  # when the FMU is asked for the interval, None where it ticks not by time
    interval: float = 0.0
    shift: float = 0.0


def read_clocks(elements: Sequence[Any], remarks: Remarks) -> tuple[Clock, ...]:
    """Return the input clocks among the elements of variables, whose clocks should be some."""
    clocks = [element for element in elements if element.tag == "Clock"]
    references = {element.get("valueReference") for element in clocks}
    for element in elements:
        for word in element.get("clocks", "").split():
            if word not in references:
                remarks.add(element, f"clocks has {word!r:.40}, which is no clock")
    return tuple(_clock(element) for element in clocks if element.get("causality") == "input")


def _clock(element: Any) -> Clock:
    kind = element.get("intervalVariability", _TRIGGERED)
    if kind not in (*_ASKED, _TRIGGERED):
        expected = ", ".join((*_ASKED, _TRIGGERED))
        raise DescriptionFault(element, f"intervalVariability is {kind!r:.40}, expected {expected}")
    asked = _ASKED.get(kind)
    interval = _seconds(element, "interval")
    if asked == _NEVER and not interval:
        asked = _ONCE
    reference = whole(element.get("valueReference"), "valueReference", element)
    return Clock(element.get("name"), reference, asked, interval, _seconds(element, "shift"))


def _seconds(element: Any, what: str) -> float:
    """Return a time given as a decimal number or by counter and resolution; 0 where it is not."""
    if decimal := element.get(f"{what}Decimal"):
        seconds = finite(decimal, f"{what}Decimal", element)
    else:
        counter = whole(element.get(f"{what}Counter", "0"), f"{what}Counter", element)
        resolution = whole(element.get("resolution", "1"), "resolution", element)
        if resolution < 1:
            raise DescriptionFault(element, f"resolution is {resolution}, expected at least 1")
        seconds = counter / resolution
    if seconds < 0:
        raise DescriptionFault(element, f"{what} of a clock is {seconds} s, expected none below 0")
    return seconds


ANNOTATION = "stickslip"
"""Name of the tool in FMI 2.0, type of the annotation in FMI 3.0."""
_PLACES = (
    f"VendorAnnotations/Tool[@name='{ANNOTATION}']/Learned/State",
    f"Annotations/Annotation[@type='{ANNOTATION}']/Learned/State",
)


@dataclass(frozen=True)
class LearnedVariables:
    """What an FMU learns in a run: an annotation of ours, which any tool may write.

        <VendorAnnotations><Tool name="stickslip">               in FMI 2.0
        <Annotations><Annotation type="stickslip">               in FMI 3.0
            <Learned model="lffc"><State parameter="w_0" variable="w"/>

    ``parameter`` takes over the value that ``variable`` has at the end of another run. Both are
    scalars or elements of arrays; an array's name alone in the annotation means all elements.
    """

    model: str = ""  # that learns; empty where the FMU learns nothing
    variables: Mapping[str, str] = field(default_factory=dict)


def read_learned(root: Any, variables: Mapping[str, Variable]) -> LearnedVariables:
    """Return what the annotation of a description says."""
    model, found = "", dict[str, str]()
    for element in (each for place in _PLACES for each in root.iterfind(place)):
        model = element.getparent().get("model", "")
        ends = [element.get(end, "") for end in ("parameter", "variable")]
        parameters, learned = (_elements(end, variables) for end in ends)
        if not parameters or len(parameters) != len(learned):
            what = " and ".join(map(shown, ends))
            raise DescriptionFault(element, f"{what} are not variables of the same size")
        found |= dict(zip(parameters, learned, strict=True))
    return LearnedVariables(model, found)


def _elements(name: str, variables: Mapping[str, Variable]) -> list[str]:
    """Return a scalar, or the elements of an array, which in FMI 2.0 are scalars."""
    if name in variables:
        return [each.name for each in variables[name].elements()]
    return [each for each in variables if each.partition("[")[0] == name]


@dataclass(frozen=True)
class DefaultExperiment:
    """What an FMU or SSP proposes: times in s, tolerance of solvers; None for what it does not."""

    start: float | None = None
    stop: float | None = None
    step: float | None = None
    tolerance: float | None = None


@dataclass(frozen=True)
class Unknown:
    """An entry of ModelStructure; its dependencies are None where the FMU does not say."""

    name: str
    dependencies: tuple[str, ...] | None


@dataclass(frozen=True)
class Description:
    """A description.

    ``interfaces`` has the attributes of CoSimulation, ModelExchange and ScheduledExecution,
    ``derivatives`` the name of the state for each derivative of one, None where it is not said.
    """

    standard: int  # 1, 2 or 3; what is FMI 1.0 is given in the form of FMI 2.0
    name: str
    tool: str  # which wrote it, "" if it does not say
    token: str  # the GUID of FMI 2.0, the instantiation token of FMI 3.0
    licence: str  # what the FMU says of it
    interfaces: Mapping[str, Mapping[str, str]]
    experiment: DefaultExperiment
    units: Mapping[str, Unit]
    variables: Mapping[str, Variable]  # by name, in the order of the file
    aliases: Mapping[str, str]  # other name -> name, in FMI 3.0
    outputs: tuple[Unknown, ...]
    derivatives: Mapping[str, str | None]
    derivative_of: Mapping[str, str]  # name -> name of what it is the derivative of, state or not
    n_states: int  # continuous ones
    n_indicators: int  # of events
    clocks: tuple[Clock, ...]  # the input clocks
    learned: LearnedVariables  # what it learns in a run
    remarks: tuple[str, ...]  # what is wrong in it and no run needs, in lines


Places = Mapping[str, str]
"""Index or value reference, in digits -> name of the variable."""
_KINDS = {
    2: {"Outputs": "outputs", "Derivatives": "derivatives", "InitialUnknowns": "initial"},
    3: {"Output": "outputs", "ContinuousStateDerivative": "derivatives", "ClockedState": "clocked"},
}
_KINDS[3] |= {"EventIndicator": "indicators", "InitialUnknown": "initial"}


def read_unknowns(
    root: Any, version: int, places: Places, remarks: Remarks
) -> dict[str, list[Unknown]]:
    """Return the entries of ModelStructure by kind; DescriptionFault if a solver lacks one."""
    kinds = _KINDS[version]
    found: dict[str, list[Unknown]] = {kind: [] for kind in kinds.values()}
    solved = {"derivatives", "indicators"} if root.find("ModelExchange") is not None else set()
    for element in root.iterfind("ModelStructure/*"):
        if not (kind := kinds.get(element.tag)):
            continue
        key, entries = ("valueReference", [element]) if version == 3 else ("index", element)
        for entry in entries:
            given = (entry, key, places, remarks)
            unknown = _unknown(*given) if kind in solved else remarks.attempt(_unknown, *given)
            found[kind] += [unknown] if unknown else []
    return found


def _unknown(element: Any, key: str, places: Places, remarks: Remarks) -> Unknown:
    name = _name(element.get(key, ""), key, element, places)
    return Unknown(name, remarks.attempt(_dependencies, element, places))


def _dependencies(element: Any, places: Places) -> tuple[str, ...] | None:
    if (known := element.get("dependencies")) is None:
        return None
    return tuple(_name(word, "dependencies", element, places) for word in known.split())


def read_derivatives(
    elements: Iterable[tuple[Any, str]], places: Places, remarks: Remarks
) -> dict[str, str]:
    """Return name -> name of what it is the derivative of, from elements with their names."""
    states: dict[str, str] = {}
    for element, name in elements:
        if (text := element.get("derivative")) is None:
            continue
        state = remarks.attempt(_name, text, "derivative", element, places)
        following = state
        while following and following != name:
            following = states.get(following)
        if following:
            remarks.add(element, f"{shown(name)} is a derivative of itself; this is ignored")
        elif state:
            states[name] = state
    return states


def _name(text: str, what: str, element: Any, places: Places) -> str:
    if (name := places.get(text)) is not None:
        return name
    place = whole(text, what, element)  # it may be spelled with blanks or a sign
    if (name := places.get(str(place))) is None:
        raise DescriptionFault(element, f"{what} of {element.tag} is {place}, which is no variable")
    return name
