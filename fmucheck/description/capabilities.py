"""Rules about capability flags that contradict each other."""

from __future__ import annotations

from stickslip.fmucheck.description.model import Description
from stickslip.fmucheck.description.values import boolean, number
from stickslip.fmucheck.finding import Severity
from stickslip.fmucheck.rules import Claims, rule


@rule(Severity.ERROR, fmi2="3.3.1", fmi3="2.4.2", advice="declare both, or neither")
def serialise_without_state(description: Description) -> Claims:
    """The state can be serialised, but not got and set."""
    for interface in description.interfaces:
        if interface.flag("canSerializeFMUState") and not interface.flag("canGetAndSetFMUState"):
            yield interface.place, "canSerializeFMUState without canGetAndSetFMUState"


@rule(Severity.ERROR, fmi2=None, fmi3="4.3", advice="declare providesIntermediateUpdate too")
def early_return_without_update(description: Description) -> Claims:
    """It can return early after an intermediate update, but has no intermediate update."""
    for interface in description.interfaces:
        if interface.flag("canReturnEarlyAfterIntermediateUpdate") and not interface.flag(
            "providesIntermediateUpdate"
        ):
            yield interface.place, "canReturnEarlyAfterIntermediateUpdate alone"


@rule(Severity.WARNING, fmi2=None, fmi3="4.3", advice="declare hasEventMode")
def clocks_without_event_mode(description: Description) -> Claims:
    """There are clocks, but Co-Simulation has no event mode to tick them in."""
    interface = description.interface("CoSimulation")
    clocks = [v for v in description.variables if v.kind == "Clock"]
    if clocks and interface and not interface.flag("hasEventMode"):
        yield interface.place, f"no hasEventMode, but {len(clocks)} clocks"


@rule(Severity.WARNING, fmi2=None, fmi3="4.3", advice="mark the variables, or drop the capability")
def intermediate_update_without_variables(description: Description) -> Claims:
    """Intermediate update is provided, but no variable can be accessed in it; or the reverse."""
    interface = description.interface("CoSimulation")
    marked = [v for v in description.variables if boolean(v.given.get("intermediateUpdate"))]
    if interface and marked and not interface.flag("providesIntermediateUpdate"):
        yield marked[0].place, "intermediateUpdate, but providesIntermediateUpdate is false"


@rule(Severity.WARNING, fmi2="4.3.1", fmi3="4.3", advice="declare the order it really reaches")
def absurd_derivative_order(description: Description) -> Claims:
    """The declared order of output derivatives is beyond what anything computes."""
    for interface in description.interfaces:
        order = number(interface.given.get("maxOutputDerivativeOrder"), "UInt32")
        if order is not None and order > 10:
            yield interface.place, f"maxOutputDerivativeOrder {order}"


@rule(Severity.NOTE, fmi2="4.3.1", fmi3="2.4.2", advice="tell the receiver which tool it needs")
def needs_a_tool(description: Description) -> Claims:
    """The FMU only talks to a tool that must be installed."""
    for interface in description.interfaces:
        if interface.flag("needsExecutionTool"):
            yield interface.place, "needsExecutionTool"
