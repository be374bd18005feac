"""Rules about causality, variability, initial, and which variables have a start value."""

from __future__ import annotations

from stickslip.fmucheck.description.model import INITIALS, Description, Variable
from stickslip.fmucheck.description.values import FLOATS
from stickslip.fmucheck.finding import Severity
from stickslip.fmucheck.rules import Claims, rule


@rule(Severity.ERROR, fmi2="2.2.7", fmi3="2.4.7.4", advice="see the table in the standard")
def illegal_variability(description: Description) -> Claims:
    """The combination of causality and variability is not allowed."""
    for v in description.variables:
        combination = v.causality, v.variability
        unknown = v.causality == "structuralParameter" and description.version == 2
        if combination not in INITIALS or unknown:
            default = "" if "variability" in v.given else " (the default)"
            yield v.place, f"causality {v.causality} with variability {v.variability}{default}"


@rule(Severity.ERROR, fmi2="2.2.7", fmi3="2.4.7.5", advice="leave it out to get the default")
def illegal_initial(description: Description) -> Claims:
    """The attribute initial is not allowed with this causality and variability."""
    for v in description.variables:
        given = v.given.get("initial")
        allowed = INITIALS.get((v.causality, v.variability))
        if v.causality == "input" and description.version == 3:
            allowed = ("exact",)
        if given and allowed is not None and given not in allowed:
            expected = " or ".join(allowed) or "none"
            combination = f"{v.causality}, {v.variability}"
            yield (
                v.place,
                f"initial={given} for a variable that is {combination}; expected {expected}",
            )


@rule(Severity.ERROR, fmi2="2.2.7", fmi3="2.4.7.4", advice="make it discrete")
def continuous_but_not_real(description: Description) -> Claims:
    """A variable that is no floating-point number is continuous."""
    for v in description.variables:
        if v.variability == "continuous" and v.kind not in FLOATS:
            default = "" if "variability" in v.given else ", which is the default"
            yield v.place, f"is {v.kind} with variability continuous{default}"


def _needs_start(v: Variable) -> str | None:
    """Return why a variable must have a start value."""
    if v.kind == "Clock":
        return None
    if v.causality in ("input", "parameter", "structuralParameter"):
        return v.causality
    if v.variability == "constant":
        return "constant"
    return f"initial={v.initial}" if v.initial in ("exact", "approx") else None


@rule(Severity.ERROR, fmi2="2.2.7", fmi3="2.4.7.5", advice="give it a start value")
def missing_start(description: Description) -> Claims:
    """A start value is missing that the variable must have."""
    for v in description.variables:
        if v.start is None and (why := _needs_start(v)):
            yield v.place, f"no start value, but {why}"


@rule(Severity.ERROR, fmi2="2.2.7", fmi3="2.4.7.5", advice="remove it, or write initial=approx")
def superfluous_start(description: Description) -> Claims:
    """A start value is given that the variable must not have."""
    for v in description.variables:
        if v.start is None or v.kind == "Clock":
            continue
        if v.causality == "independent":
            yield v.place, "is independent and has a start value"
        elif v.initial == "calculated" and not _needs_start(v):
            default = "" if "initial" in v.given else " (the default)"
            yield v.place, f"initial=calculated{default}, and has a start value"


@rule(Severity.ERROR, fmi2="2.2.7", fmi3="2.4.7.4", advice="declare one, such as time in s")
def independent_variable(description: Description) -> Claims:
    """There is not exactly one independent variable (FMI 3.0), or there are several (FMI 2.0)."""
    found = [v for v in description.variables if v.causality == "independent"]
    if len(found) > 1:
        yield found[1].place, f"{len(found)} variables are independent"
    if not found and description.version == 3:
        yield "ModelVariables", "no variable has causality independent"
    for v in found:
        if v.kind not in FLOATS:
            yield v.place, f"is independent, but {v.kind}; expected a floating-point number"


@rule(Severity.WARNING, fmi2="2.2.7", fmi3="2.4.7.4", advice="remove the attribute")
def multiple_set_of_no_input(description: Description) -> Claims:
    """The flag canHandleMultipleSetPerTimeInstant stands at a variable that is no input."""
    for v in description.variables:
        if "canHandleMultipleSetPerTimeInstant" in v.given and v.causality != "input":
            yield v.place, f"canHandleMultipleSetPerTimeInstant, but causality {v.causality}"


@rule(Severity.ERROR, fmi2=None, fmi3="2.4.7.4", advice="remove the attribute")
def illegal_intermediate_update(description: Description) -> Claims:
    """A parameter or a clock claims to be accessible during intermediate update."""
    for v in description.variables:
        if v.given.get("intermediateUpdate") in ("true", "1") and (
            v.causality == "parameter" or v.kind == "Clock"
        ):
            yield v.place, "intermediateUpdate is true"
