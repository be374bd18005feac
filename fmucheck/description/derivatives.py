"""Rules about derivatives and states."""

from __future__ import annotations

from stickslip.fmucheck.description.model import Description, Variable
from stickslip.fmucheck.description.values import FLOATS
from stickslip.fmucheck.finding import Severity
from stickslip.fmucheck.rules import Claims, rule

_ORDERS = 20  # of derivatives


@rule(
    Severity.ERROR,
    fmi2="2.2.7",
    fmi3="2.4.7.5",
    advice="refer to the state it is the derivative of",
)
def bad_derivative(description: Description) -> Claims:
    """The attribute derivative refers to nothing, in a circle, or to no real that is continuous."""
    for v in description.variables:
        if "derivative" not in v.given:
            continue
        state = None if v.derivative is None else description.by_key.get(v.derivative)
        what = f"derivative={v.given['derivative']}"
        if state is None:
            yield v.place, f"{what} is no variable"
        elif state is v:
            yield v.place, f"{what} is the variable itself"
        elif state.kind not in FLOATS or state.variability != "continuous":
            yield v.place, f"{what} is {state.name}, which is {state.kind}, {state.variability}"
        elif v.kind not in FLOATS:
            yield v.place, f"is {v.kind}, and the derivative of {state.name}"
        elif _is_circular(v, description):
            yield v.place, f"{what}, and so on in a circle"


def _is_circular(v: Variable, description: Description) -> bool:
    """Tell whether a variable is its own derivative of an order that occurs."""
    at: Variable | None = v
    for _ in range(_ORDERS):
        at = None if at is None or at.derivative is None else description.by_key.get(at.derivative)
        if at is v:
            return True
    return False


@rule(Severity.ERROR, fmi2="2.2.8", fmi3="2.4.8", advice="add the attribute derivative")
def derivative_without_state(description: Description) -> Claims:
    """A listed state derivative has no attribute derivative, so that its state is unknown."""
    for unknown in description.group("ContinuousStateDerivative"):
        if unknown.variable and "derivative" not in unknown.variable.given:
            yield unknown.place, f"{unknown.variable.name} has no attribute derivative"


@rule(Severity.ERROR, fmi2="2.2.7", fmi3="2.4.7.4", advice="make it local or output")
def illegal_state(description: Description) -> Claims:
    """A state or state derivative is neither local nor output, or not continuous."""
    for v in dict.fromkeys([*description.states, *description.derivatives]):
        if v.causality not in ("local", "output"):
            yield v.place, f"is a state or its derivative, with causality {v.causality}"
        elif v.variability != "continuous":
            yield v.place, f"is a state or its derivative, with variability {v.variability}"


@rule(Severity.ERROR, fmi2="2.2.8", fmi3="2.4.8", advice="list one derivative for each state")
def state_twice(description: Description) -> Claims:
    """Two listed derivatives belong to the same state."""
    seen = set()
    for state in description.states:
        if state.index in seen:
            yield state.place, "two listed derivatives belong to it"
        seen.add(state.index)


@rule(Severity.WARNING, fmi2="2.2.8", fmi3="2.4.8", advice="list it under the derivatives")
def unlisted_derivative(description: Description) -> Claims:
    """A local derivative is not listed in ModelStructure, though the FMU offers Model Exchange."""
    if not description.interface("ModelExchange"):
        return
    known = {v.index for v in description.derivatives}
    for v in description.variables:
        if "derivative" in v.given and v.causality == "local" and v.index not in known:
            yield v.place, "is the derivative of a variable, but is not listed"


@rule(Severity.WARNING, fmi2="2.2.7", fmi3="2.4.7.5", advice="remove the attribute")
def reinit_of_no_state(description: Description) -> Claims:
    """The attribute reinit stands at a variable that is no continuous state."""
    states = {v.index for v in description.states}
    for v in description.variables:
        if v.given.get("reinit") in ("true", "1") and v.index not in states:
            yield v.place, "reinit is true, but it is no continuous state"


@rule(Severity.NOTE, fmi2="2.2.1", fmi3=None, advice="leave numberOfEventIndicators out")
def indicators_without_model_exchange(description: Description) -> Claims:
    """Event indicators are counted, though there is no Model Exchange."""
    count = description.root.get("numberOfEventIndicators", "0").strip()
    if count not in ("", "0") and not description.interface("ModelExchange"):
        yield "modelDescription.xml", f"numberOfEventIndicators={count}, for Co-Simulation alone"
