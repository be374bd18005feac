"""Rules about dependencies and their kinds."""

from __future__ import annotations

from stickslip.fmucheck.description.model import Description, Unknown, Variable
from stickslip.fmucheck.description.values import FLOATS, listed
from stickslip.fmucheck.finding import Severity
from stickslip.fmucheck.rules import Claims, rule


@rule(Severity.ERROR, fmi2="2.2.8", fmi3="2.4.8", advice="refer to a variable that exists")
def unknown_dependency(description: Description) -> Claims:
    """A dependency refers to a variable that does not exist."""
    for unknown in description.unknowns:
        for key, variable in unknown.dependencies or ():
            if variable is None:
                yield unknown.place, f"depends on {key}, which does not exist"


@rule(Severity.ERROR, fmi2="2.2.8", fmi3="2.4.8", advice="list it once")
def repeated_dependency(description: Description) -> Claims:
    """A dependency is listed twice."""
    for unknown in description.unknowns:
        keys = [key for key, _ in unknown.dependencies or ()]
        if len(set(keys)) < len(keys):
            yield unknown.place, "lists a dependency twice"


@rule(Severity.ERROR, fmi2="2.2.8", fmi3="2.4.8", advice="give one kind for each dependency")
def kinds_do_not_match(description: Description) -> Claims:
    """The dependenciesKind are not as many as the dependencies, or stand alone."""
    for unknown in description.unknowns:
        if unknown.kinds is None:
            continue
        if unknown.dependencies is None:
            yield unknown.place, "dependenciesKind without dependencies"
        elif len(unknown.kinds) != len(unknown.dependencies):
            count = f"{len(unknown.kinds)} kinds for {len(unknown.dependencies)} dependencies"
            yield unknown.place, count


@rule(Severity.ERROR, fmi2="2.2.8", fmi3="2.4.8", advice="write dependent")
def illegal_kind(description: Description) -> Claims:
    """A kind is not allowed here: of a variable that is not real, or of an initial unknown."""
    for unknown in description.unknowns:
        for kind in unknown.kinds or ():
            if kind == "dependent":
                continue
            if unknown.variable and unknown.variable.kind not in FLOATS:
                yield unknown.place, f"kind {kind} of a variable that is {unknown.variable.kind}"
            elif unknown.group == "InitialUnknown" and kind != "constant":
                yield unknown.place, f"kind {kind}; of initial unknowns only dependent or constant"


@rule(Severity.WARNING, fmi2="2.2.8", fmi3="2.4.8", advice="list only what counts as known")
def dependency_on_no_known(description: Description) -> Claims:
    """A dependency refers to a variable that is computed, which does not count as known."""
    states = {v.index for v in description.states}
    for unknown in description.unknowns:
        given = (v for _, v in unknown.dependencies or () if v)
        wrong = [v.name for v in given if not _is_known(v, unknown, states)]
        if wrong:
            yield unknown.place, f"depends on {listed(wrong)}, which the FMU computes"


def _is_known(v: Variable, unknown: Unknown, states: set[int]) -> bool:
    if v.causality in ("input", "independent", "parameter", "structuralParameter"):
        return True
    if v.index in states or v.initial == "exact":
        return True
    return unknown.group != "InitialUnknown" and v.variability == "discrete"


@rule(Severity.NOTE, fmi2="2.2.8", fmi3="2.4.8", advice="list them, an empty list for none")
def dependencies_not_given(description: Description) -> Claims:
    """Outputs or derivatives without dependencies count as depending on everything."""
    groups = ("Output", "ContinuousStateDerivative")
    bare = [u for u in description.unknowns if u.group in groups and u.dependencies is None]
    inputs = any(v.causality == "input" for v in description.variables)
    if bare and inputs:
        names = listed(u.variable.name for u in bare if u.variable)
        yield "ModelStructure", f"no dependencies of {names}"
