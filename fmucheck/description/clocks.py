"""Rules about clocks and clocked variables (FMI 3.0)."""

from __future__ import annotations

from stickslip.fmucheck.description.model import Description, Variable
from stickslip.fmucheck.description.values import number
from stickslip.fmucheck.finding import Severity
from stickslip.fmucheck.rules import Claims, rule

_PERIODIC = ("constant", "fixed", "tunable")
_TIMES = ("intervalDecimal", "shiftDecimal", "resolution", "intervalCounter", "shiftCounter")


def _clocks(description: Description) -> list[Variable]:
    return [v for v in description.variables if v.kind == "Clock"]


@rule(Severity.ERROR, fmi2=None, fmi3="2.4.7.4", advice="make it input, output or local")
def clock_causality(description: Description) -> Claims:
    """A clock is neither input nor output nor local, or is an output that is not triggered."""
    for v in _clocks(description):
        if v.causality not in ("input", "output", "local"):
            yield v.place, f"causality {v.causality}"
        elif v.causality != "input" and v.get("intervalVariability") != "triggered":
            kind = v.get("intervalVariability")
            yield v.place, f"is {v.causality}, but {kind}; expected intervalVariability triggered"


@rule(
    Severity.ERROR,
    fmi2=None,
    fmi3="2.4.4",
    advice="give a period above 0 and a shift of at least 0",
)
def clock_interval(description: Description) -> Claims:
    """A clock's period is missing, not above 0, or given to a clock that is not periodic."""
    for v in _clocks(description):
        kind = v.get("intervalVariability")
        interval, shift = number(v.get("intervalDecimal")), number(v.get("shiftDecimal"))
        if kind not in _PERIODIC:
            if given := [name for name in _TIMES if v.get(name) is not None]:
                yield v.place, f"{given[0]}, but intervalVariability {kind}"
        elif interval is None and kind == "constant":
            yield v.place, "is constant, but has no intervalDecimal"
        elif (interval is not None and interval <= 0) or (shift is not None and shift < 0):
            yield v.place, f"intervalDecimal {interval}, shiftDecimal {shift or 0}"


@rule(
    Severity.ERROR, fmi2=None, fmi3="2.4.4", advice="give supportsFraction, resolution and counters"
)
def clock_fraction(description: Description) -> Claims:
    """Counters of a clock come without supportsFraction or without a resolution."""
    for v in _clocks(description):
        counters = [n for n in ("intervalCounter", "shiftCounter") if v.get(n) is not None]
        if counters and v.get("supportsFraction") not in ("true", "1"):
            yield v.place, f"{counters[0]} without supportsFraction"
        elif counters and number(v.get("resolution"), "UInt64") in (None, 0):
            yield v.place, f"{counters[0]} without a resolution"


@rule(Severity.ERROR, fmi2=None, fmi3="2.4.4", advice="give a priority")
def clock_priority(description: Description) -> Claims:
    """An input clock of Scheduled Execution has no priority."""
    if description.interface("ScheduledExecution"):
        for v in _clocks(description):
            if v.causality == "input" and v.get("priority") is None:
                yield v.place, "has no priority"


@rule(Severity.ERROR, fmi2=None, fmi3="2.4.7.4", advice="refer to clocks, and make it discrete")
def bad_clocks(description: Description) -> Claims:
    """A clocked variable refers to something that is no clock, or is continuous or fixed."""
    for v in description.variables:
        for reference in v.clocks or ():
            clock = description.by_key.get(reference)
            if clock is None or clock.kind != "Clock":
                yield v.place, f"clocks={reference}, which is no clock"
        if v.clocks is not None and v.variability not in ("discrete", "tunable"):
            yield v.place, f"is clocked, with variability {v.variability}"


@rule(Severity.ERROR, fmi2=None, fmi3="2.4.7.4", advice="refer to a discrete variable of its type")
def bad_previous(description: Description) -> Claims:
    """The attribute previous breaks one of the constraints on it."""
    users: dict[int, Variable] = {}
    for v in description.variables:
        if v.previous is None:
            continue
        other = description.by_key.get(v.previous)
        if other is None or other is v:
            what = "itself" if other else "nothing that exists"
            yield v.place, f"previous={v.previous} is {what}"
        elif other.kind != v.kind or other.variability != "discrete" or other.causality == "input":
            yield (
                v.place,
                f"previous is {other.name}: {other.kind}, {other.variability}, {other.causality}",
            )
        if v.clocks is None or v.variability != "discrete":
            yield v.place, "has previous, but is not clocked and discrete"
        if users.setdefault(v.previous, v) is not v:
            yield v.place, f"has the same previous as {users[v.previous].name}"
