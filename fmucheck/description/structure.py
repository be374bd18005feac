"""Rules about derivatives, ModelStructure and dependencies."""

from collections.abc import Iterator

from stickslip.fmi.description.variables import FLOATS
from stickslip.fmucheck.description.model import Description, Unknown, Variable, listed, repeated
from stickslip.fmucheck.rules import Claims, error, note, warning

_ORDERS = 20  # of derivatives


@error("2.2.7", "2.4.7.5", "refer to the state it is the derivative of")
def bad_derivative(description: Description) -> Claims:
    """The attribute derivative refers to nothing, in a circle, or to no real that is continuous."""
    for v in description.variables:
        if "derivative" not in v.given:
            continue
        state = description.variable(v.derivative)
        what = f"derivative={v.given['derivative']}"
        if state is None:
            yield v.place, f"{what} is not a variable"
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
        at = description.variable(at.derivative) if at else None
        if at is v:
            return True
    return False


@error("2.2.8", "2.4.8", "add the attribute derivative")
def derivative_without_state(description: Description) -> Claims:
    """A listed state derivative has no attribute derivative, so that its state is unknown."""
    for unknown in description.group("ContinuousStateDerivative"):
        if "derivative" not in unknown.variable.given:
            yield unknown.place, f"{unknown.variable.name} has no attribute derivative"


@error("2.2.7", "2.4.7.4", "make it local or output")
def illegal_state(description: Description) -> Claims:
    """A state or state derivative is neither local nor output, or not continuous."""
    for v in dict.fromkeys([*description.states, *description.derivatives]):
        if v.causality not in ("local", "output"):
            yield v.place, f"is a state or its derivative, with causality {v.causality}"
        elif v.variability != "continuous":
            yield v.place, f"is a state or its derivative, with variability {v.variability}"


@error("2.2.8", "2.4.8", "list one derivative for each state")
def state_twice(description: Description) -> Claims:
    """Two listed derivatives belong to the same state."""
    seen = set()
    for state in description.states:
        if state.index in seen:
            yield state.place, "two listed derivatives belong to it"
        seen.add(state.index)


@warning("2.2.8", "2.4.8", "list it under the derivatives")
def unlisted_derivative(description: Description) -> Claims:
    """A local derivative is not listed in ModelStructure, though the FMU offers Model Exchange."""
    if not description.interface("ModelExchange"):
        return
    known = {v.index for v in description.derivatives}
    for v in description.variables:
        if "derivative" in v.given and v.causality == "local" and v.index not in known:
            yield v.place, "is the derivative of a variable, but is not listed"


@warning("2.2.7", "2.4.7.5", "remove the attribute")
def reinit_of_no_state(description: Description) -> Claims:
    """The attribute reinit is set for a variable that is not a continuous state."""
    states = {v.index for v in description.states}
    for v in description.variables:
        if v.given.get("reinit") in ("true", "1") and v.index not in states:
            yield v.place, "reinit is true, but the variable is not a continuous state"


@note("2.2.1", None, "leave numberOfEventIndicators out")
def indicators_without_model_exchange(description: Description) -> Claims:
    """Event indicators are declared without Model Exchange."""
    count = description.root.get("numberOfEventIndicators", "0").strip()
    if count not in ("", "0") and not description.interface("ModelExchange"):
        yield "modelDescription.xml", f"numberOfEventIndicators={count}, for Co-Simulation alone"


@error("2.2.8", "2.4.8", "refer to a variable that exists")
def unknown_in_structure(description: Description) -> Claims:
    """ModelStructure lists a variable that does not exist."""
    kind = "index" if description.version == 2 else "value reference"
    for place, key in description.dangling:
        yield place, f"no variable has {kind} {key}"


@error("2.2.8", "2.4.8", "list it once")
def listed_twice(description: Description) -> Claims:
    """ModelStructure lists a variable twice in one list."""
    entries = [(u.group, u.variable) for u in description.unknowns]
    for entry, count in repeated(entries):
        yield description.unknowns[entries.index(entry)].place, f"is listed {count} times"


@error("2.2.8", "2.4.8", "list exactly the outputs")
def outputs_incomplete(description: Description) -> Claims:
    """The listed outputs are not exactly the variables with causality output."""
    wanted = [v for v in description.variables if v.causality == "output"]
    yield from _differences(description, "Output", wanted)


def _differences(description: Description, group: str, wanted: list[Variable]) -> Claims:
    given = {u.variable.index: u.variable for u in description.group(group)}
    expected = {v.index for v in wanted}
    missing = [v.name for v in wanted if v.index not in given]
    extra = [v.name for v in given.values() if v.index not in expected]
    if missing:
        yield f"ModelStructure, {group}", f"{listed(missing)} must be listed"
    if extra:
        yield f"ModelStructure, {group}", f"{listed(extra)} must not be listed"


@error("2.2.8", "2.4.8", "list exactly what the standard asks for")
def initial_unknowns(description: Description) -> Claims:
    """The initial unknowns are not those that the standard asks for."""
    computed = ("approx", "calculated")
    dynamic = {v.index for v in [*description.states, *description.derivatives]}
    given = {u.variable.index for u in description.group("InitialUnknown")}

    def is_due(v: Variable) -> bool:
        if v.clocks is not None or v.kind == "Clock":
            return v.index in given  # clocked variables may be listed or not
        if v.causality == "output" or v.index in dynamic:
            return v.initial in computed
        return v.causality == "calculatedParameter"

    wanted = [v for v in description.variables if is_due(v)]
    yield from _differences(description, "InitialUnknown", wanted)


@error(None, "2.4.8", "refer to a continuous Float64 or Float32")
def bad_event_indicator(description: Description) -> Claims:
    """An event indicator is not a continuous floating-point variable, or a parameter or input."""
    for unknown in description.group("EventIndicator"):
        v = unknown.variable
        if v.kind not in FLOATS or v.variability != "continuous":
            yield unknown.place, f"{v.name} is {v.kind}, {v.variability}"
        elif v.causality not in ("local", "output"):
            yield unknown.place, f"{v.name} has causality {v.causality}; expected local or output"


@error(None, "2.4.8", "give it clocks, previous and discrete")
def bad_clocked_state(description: Description) -> Claims:
    """A clocked state has no clock, no previous value, or is not discrete."""
    for unknown in description.group("ClockedState"):
        v = unknown.variable
        clocked = v.clocks is not None and v.previous is not None and v.kind != "Clock"
        if not clocked or v.variability != "discrete":
            what = f"{v.name}: clocks {v.clocks}, previous {v.previous}, {v.variability}"
            yield unknown.place, what


@error("2.2.8", "2.4.8", "refer to a variable that exists", "unknowns")
def unknown_dependency(unknown: Unknown) -> Iterator[str]:
    """A dependency refers to a variable that does not exist."""
    for key, variable in unknown.dependencies or ():
        if variable is None:
            yield f"depends on {key}, which does not exist"


@error("2.2.8", "2.4.8", "list it once", "unknowns")
def repeated_dependency(unknown: Unknown) -> Iterator[str]:
    """A dependency is listed twice."""
    keys = [key for key, _ in unknown.dependencies or ()]
    if len(set(keys)) < len(keys):
        yield "lists a dependency twice"


@error("2.2.8", "2.4.8", "give one kind for each dependency", "unknowns")
def kinds_do_not_match(unknown: Unknown) -> Iterator[str]:
    """The dependenciesKind are not as many as the dependencies, or stand alone."""
    if unknown.kinds is None:
        return
    if unknown.dependencies is None:
        yield "dependenciesKind without dependencies"
    elif len(unknown.kinds) != len(unknown.dependencies):
        yield f"{len(unknown.kinds)} kinds for {len(unknown.dependencies)} dependencies"


@error("2.2.8", "2.4.8", "write dependent", "unknowns")
def illegal_kind(unknown: Unknown) -> Iterator[str]:
    """A kind is not allowed here: of a variable that is not real, or of an initial unknown."""
    for kind in unknown.kinds or ():
        if kind == "dependent":
            continue
        if unknown.variable.kind not in FLOATS:
            yield f"kind {kind} of a variable that is {unknown.variable.kind}"
        elif unknown.group == "InitialUnknown" and kind != "constant":
            yield f"kind {kind}; of initial unknowns only dependent or constant"


@warning("2.2.8", "2.4.8", "list only what counts as known")
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


@note("2.2.8", "2.4.8", "list them, an empty list for none")
def dependencies_not_given(description: Description) -> Claims:
    """Outputs or derivatives without dependencies count as depending on everything."""
    groups = ("Output", "ContinuousStateDerivative")
    bare = [u for u in description.unknowns if u.group in groups and u.dependencies is None]
    inputs = any(v.causality == "input" for v in description.variables)
    if bare and inputs:
        names = listed(u.variable.name for u in bare)
        yield "ModelStructure", f"no dependencies of {names}"
