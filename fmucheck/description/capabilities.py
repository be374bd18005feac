"""Rules about the default experiment, capability flags and clocks."""

import math
from collections.abc import Iterator

from stickslip.fmi.description.attributes import flag
from stickslip.fmucheck.description.model import Description, Interface, Variable, number
from stickslip.fmucheck.rules import Claims, error, note, warning

_PLACE = "DefaultExperiment"


@error("2.2.5", "2.4.6", "stop after the start")
def stop_before_start(description: Description) -> Claims:
    """The stopTime is before startTime."""
    start = description.proposed("startTime") or 0.0
    stop = description.proposed("stopTime")
    if stop is not None and stop < start:
        yield _PLACE, f"stopTime {stop} is before startTime {start}"


@error("2.2.5", "2.4.6", "write a finite time")
def time_not_finite(description: Description) -> Claims:
    """A time is infinite or not a number, on which importers run for ever."""
    for name in ("startTime", "stopTime"):
        value = description.proposed(name)
        if value is not None and not math.isfinite(value):
            yield _PLACE, f"{name} {value}"


@error("2.2.5", "2.4.6", "write a step above 0")
def bad_step_size(description: Description) -> Claims:
    """A step size is 0, negative or not finite."""
    steps = [(_PLACE, "stepSize", description.proposed("stepSize"))]
    for interface in description.interfaces:
        fixed = number(interface.given.get("fixedInternalStepSize"))
        steps.append((interface.place, "fixedInternalStepSize", fixed))
    for place, name, step in steps:
        if step is not None and not (step > 0.0 and math.isfinite(step)):
            yield place, f"{name} {step}"


@warning("2.2.5", "2.4.6", "make the step smaller")
def step_beyond_stop(description: Description) -> Claims:
    """One step is longer than the whole experiment."""
    start = description.proposed("startTime") or 0.0
    stop, step = (description.proposed(name) for name in ("stopTime", "stepSize"))
    if stop is not None and step is not None and start < stop < start + step:
        yield _PLACE, f"stepSize {step} for {start} to {stop}"


@error("2.2.5", "2.4.6", "write a relative tolerance such as 1e-6")
def bad_tolerance(description: Description) -> Claims:
    """The tolerance is 0, negative or not finite."""
    tolerance = description.proposed("tolerance")
    if tolerance is not None and not (tolerance > 0.0 and math.isfinite(tolerance)):
        yield _PLACE, f"tolerance {tolerance}"


@note("2.2.5", "2.4.6", "propose stopTime and stepSize")
def no_default_experiment(description: Description) -> Claims:
    """No experiment is proposed, so that users have to guess how long to simulate."""
    if description.experiment is None:
        yield "modelDescription.xml", f"there is no {_PLACE}"


@error("3.3.1", "2.4.2", "declare both, or neither", "interfaces")
def serialise_without_state(interface: Interface) -> Iterator[str]:
    """The state can be serialised, but not got and set."""
    if interface.flag("canSerializeFMUState") and not interface.flag("canGetAndSetFMUState"):
        yield "canSerializeFMUState without canGetAndSetFMUState"


@error(None, "4.3", "declare providesIntermediateUpdate too", "interfaces")
def early_return_without_update(interface: Interface) -> Iterator[str]:
    """It can return early after an intermediate update, but has no intermediate update."""
    if interface.flag("canReturnEarlyAfterIntermediateUpdate") and not interface.flag(
        "providesIntermediateUpdate"
    ):
        yield "canReturnEarlyAfterIntermediateUpdate alone"


@warning(None, "4.3", "declare hasEventMode")
def clocks_without_event_mode(description: Description) -> Claims:
    """There are clocks, but Co-Simulation has no event mode to tick them in."""
    interface, clocks = description.interface("CoSimulation"), description.clocks
    if clocks and interface and not interface.flag("hasEventMode"):
        yield interface.place, f"no hasEventMode, but {len(clocks)} clocks"


@warning(None, "4.3", "mark the variables, or drop the capability")
def intermediate_update_without_variables(description: Description) -> Claims:
    """Intermediate update is provided, but no variable can be accessed in it; or the reverse."""
    interface = description.interface("CoSimulation")
    marked = [v for v in description.variables if flag(v.given, "intermediateUpdate")]
    if interface and marked and not interface.flag("providesIntermediateUpdate"):
        yield marked[0].place, "intermediateUpdate, but providesIntermediateUpdate is false"


@warning("4.3.1", "4.3", "declare the order it really reaches", "interfaces")
def absurd_derivative_order(interface: Interface) -> Iterator[str]:
    """The declared order of output derivatives is beyond what anything computes."""
    order = number(interface.given.get("maxOutputDerivativeOrder"), "UInt32")
    if order is not None and order > 10:
        yield f"maxOutputDerivativeOrder {order}"


@note("4.3.1", "2.4.2", "tell the receiver which tool it needs", "interfaces")
def needs_a_tool(interface: Interface) -> Iterator[str]:
    """The FMU only talks to a tool that must be installed."""
    if interface.flag("needsExecutionTool"):
        yield "needsExecutionTool"


_PERIODIC = ("constant", "fixed", "tunable")
_TIMES = ("intervalDecimal", "shiftDecimal", "resolution", "intervalCounter", "shiftCounter")


@error(None, "2.4.7.4", "make it input, output or local", "clocks")
def clock_causality(v: Variable) -> Iterator[str]:
    """A clock is neither input nor output nor local, or is an output that is not triggered."""
    if v.causality not in ("input", "output", "local"):
        yield f"causality {v.causality}"
    elif v.causality != "input" and v.get("intervalVariability") != "triggered":
        kind = v.get("intervalVariability")
        yield f"is {v.causality}, but {kind}; expected intervalVariability triggered"


@error(None, "2.4.4", "give a period above 0 and a shift of at least 0", "clocks")
def clock_interval(v: Variable) -> Iterator[str]:
    """A clock's period is missing, not above 0, or given to a clock that is not periodic."""
    kind = v.get("intervalVariability")
    interval, shift = number(v.get("intervalDecimal")), number(v.get("shiftDecimal"))
    if kind not in _PERIODIC:
        if given := [name for name in _TIMES if v.get(name) is not None]:
            yield f"{given[0]}, but intervalVariability {kind}"
    elif interval is None and kind == "constant":
        yield "is constant, but has no intervalDecimal"
    elif (interval is not None and interval <= 0) or (shift is not None and shift < 0):
        yield f"intervalDecimal {interval}, shiftDecimal {shift or 0}"


@error(None, "2.4.4", "give supportsFraction, resolution and counters", "clocks")
def clock_fraction(v: Variable) -> Iterator[str]:
    """Counters of a clock come without supportsFraction or without a resolution."""
    counters = [n for n in ("intervalCounter", "shiftCounter") if v.get(n) is not None]
    if counters and v.get("supportsFraction") not in ("true", "1"):
        yield f"{counters[0]} without supportsFraction"
    elif counters and number(v.get("resolution"), "UInt64") in (None, 0):
        yield f"{counters[0]} without a resolution"


@error(None, "2.4.4", "give a priority")
def clock_priority(description: Description) -> Claims:
    """An input clock of Scheduled Execution has no priority."""
    if description.interface("ScheduledExecution"):
        for v in description.clocks:
            if v.causality == "input" and v.get("priority") is None:
                yield v.place, "has no priority"


@error(None, "2.4.7.4", "refer to clocks, and make it discrete")
def bad_clocks(description: Description) -> Claims:
    """A clocked variable refers to something that is not a clock, or is continuous or fixed."""
    for v in description.variables:
        for reference in v.clocks or ():
            clock = description.variable(reference)
            if clock is None or clock.kind != "Clock":
                yield v.place, f"clocks={reference}, which is not a clock"
        if v.clocks is not None and v.variability not in ("discrete", "tunable"):
            yield v.place, f"is clocked, with variability {v.variability}"


@error(None, "2.4.7.4", "refer to a discrete variable of its type")
def bad_previous(description: Description) -> Claims:
    """The attribute previous breaks one of the constraints on it."""
    users: dict[int, Variable] = {}
    for v in description.variables:
        if v.previous is None:
            continue
        other = description.variable(v.previous)
        if other is None or other is v:
            what = "itself" if other else "nothing that exists"
            yield v.place, f"previous={v.previous} is {what}"
        elif other.kind != v.kind or other.variability != "discrete" or other.causality == "input":
            what = f"{other.kind}, {other.variability}, {other.causality}"
            yield v.place, f"previous is {other.name}: {what}"
        if v.clocks is None or v.variability != "discrete":
            yield v.place, "has previous, but is not clocked and discrete"
        if users.setdefault(v.previous, v) is not v:
            yield v.place, f"has the same previous as {users[v.previous].name}"
