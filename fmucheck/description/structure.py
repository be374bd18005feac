"""Rules about ModelStructure: what must be listed."""

from __future__ import annotations

from collections import Counter

from stickslip.fmucheck.description.model import Description, Variable
from stickslip.fmucheck.description.values import FLOATS, listed
from stickslip.fmucheck.finding import Severity
from stickslip.fmucheck.rules import Claims, rule


@rule(Severity.ERROR, fmi2="2.2.8", fmi3="2.4.8", advice="refer to a variable that exists")
def unknown_in_structure(description: Description) -> Claims:
    """ModelStructure lists a variable that does not exist."""
    for unknown in description.unknowns:
        if unknown.variable is None:
            yield unknown.place, f"no variable has {_key(description)} {unknown.key}"


def _key(description: Description) -> str:
    return "index" if description.version == 2 else "value reference"


@rule(Severity.ERROR, fmi2="2.2.8", fmi3="2.4.8", advice="list it once")
def listed_twice(description: Description) -> Claims:
    """ModelStructure lists a variable twice in one list."""
    for (group, key), count in Counter((u.group, u.key) for u in description.unknowns).items():
        if count > 1:
            name = next(u.place for u in description.unknowns if (u.group, u.key) == (group, key))
            yield name, f"is listed {count} times"


@rule(Severity.ERROR, fmi2="2.2.8", fmi3="2.4.8", advice="list exactly the outputs")
def outputs_incomplete(description: Description) -> Claims:
    """The listed outputs are not exactly the variables with causality output."""
    wanted = [v for v in description.variables if v.causality == "output"]
    yield from _differences(description, "Output", wanted)


def _differences(description: Description, group: str, wanted: list[Variable]) -> Claims:
    given = {u.variable.index: u.variable for u in description.group(group) if u.variable}
    expected = {v.index for v in wanted}
    missing = [v.name for v in wanted if v.index not in given]
    extra = [v.name for v in given.values() if v.index not in expected]
    if missing:
        yield f"ModelStructure, {group}", f"{listed(missing)} must be listed"
    if extra:
        yield f"ModelStructure, {group}", f"{listed(extra)} must not be listed"


@rule(Severity.ERROR, fmi2="2.2.8", fmi3="2.4.8", advice="list exactly what the standard asks for")
def initial_unknowns(description: Description) -> Claims:
    """The initial unknowns are not those that the standard asks for."""
    computed = ("approx", "calculated")
    dynamic = {v.index for v in [*description.states, *description.derivatives]}
    given = {u.variable.index for u in description.group("InitialUnknown") if u.variable}

    def is_due(v: Variable) -> bool:
        if v.clocks is not None or v.kind == "Clock":
            return v.index in given  # clocked variables may be listed or not
        if v.causality == "output" or v.index in dynamic:
            return v.initial in computed
        return v.causality == "calculatedParameter"

    wanted = [v for v in description.variables if is_due(v)]
    yield from _differences(description, "InitialUnknown", wanted)


@rule(Severity.ERROR, fmi2=None, fmi3="2.4.8", advice="refer to a continuous Float64 or Float32")
def bad_event_indicator(description: Description) -> Claims:
    """An event indicator is no continuous floating-point variable, or a parameter or input."""
    for unknown in description.group("EventIndicator"):
        v = unknown.variable
        if v is None:
            continue
        if v.kind not in FLOATS or v.variability != "continuous":
            yield unknown.place, f"{v.name} is {v.kind}, {v.variability}"
        elif v.causality not in ("local", "output"):
            yield unknown.place, f"{v.name} has causality {v.causality}; expected local or output"


@rule(Severity.ERROR, fmi2=None, fmi3="2.4.8", advice="give it clocks, previous and discrete")
def bad_clocked_state(description: Description) -> Claims:
    """A clocked state has no clock, no previous value, or is not discrete."""
    for unknown in description.group("ClockedState"):
        v = unknown.variable
        if v is None:
            continue
        if (
            v.clocks is None
            or v.previous is None
            or v.variability != "discrete"
            or v.kind == "Clock"
        ):
            yield (
                unknown.place,
                f"{v.name}: clocks {v.clocks}, previous {v.previous}, {v.variability}",
            )
