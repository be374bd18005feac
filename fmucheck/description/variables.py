"""Rules about variables: names, causality, start values, ranges and dimensions."""

import math
import re
from collections import defaultdict
from collections.abc import Iterator

from stickslip.fmi.description.attributes import flag
from stickslip.fmi.description.variables import FLOATS, INITIALS
from stickslip.fmucheck.description.model import (
    RANGES,
    Description,
    Number,
    Variable,
    is_number,
    listed,
    number,
    repeated,
)
from stickslip.fmucheck.rules import Claims, error, warning

# The grammar of structured names (FMI 2.0.5, 2.2.9; FMI 3.0.2, 2.4.7.5.1), token by token.
_INDICES = r"(\[\d+(,\d+)*\])?"
_QUOTED = r"'([A-Za-z0-9_!#$%&()*+,\-./:;<>=?@\[\]^{}|~ ]|\\['\"?\\abfnrtv])+'"
_PART = rf"([A-Za-z_][A-Za-z0-9_]*|{_QUOTED}){_INDICES}"
_IDENTIFIER = rf"{_PART}(\.{_PART})*"
_STRUCTURED = re.compile(rf"{_IDENTIFIER}|der\({_IDENTIFIER}(,\d+)?\)")


@error("2.2.7", "2.4.7", "give each variable a name of its own")
def duplicate_name(description: Description) -> Claims:
    """Two variables, or a variable and an alias, have the same name."""
    names = [v.name for v in description.variables]
    names += [a.get("name", "") for v in description.variables for a in v.aliases]
    for name, count in repeated(names):
        yield f"variable {name}", f"{count} variables have this name"


@error("2.2.7", "2.4.7", "name it", "variables")
def empty_name(v: Variable) -> Iterator[str]:
    """A variable has no name."""
    if not v.name:
        yield f"variable number {v.index} has no name"


@error(None, "2.4.7", "give each variable a reference of its own")
def duplicate_reference(description: Description) -> Claims:
    """Two variables have the same value reference."""
    first: dict[int, Variable] = {}
    for v in description.variables:
        if v.reference is not None and first.setdefault(v.reference, v) is not v:
            yield v.place, f"has the value reference {v.reference} of {first[v.reference].place}"


@error("2.2.9", "2.4.7", "name it by the grammar, or declare flat")
def bad_structured_name(description: Description) -> Claims:
    """A name does not follow the convention 'structured' that the FMU declares."""
    if description.root.get("variableNamingConvention") != "structured":
        return
    for v in description.variables:
        for name in (v.name, *(alias.get("name", "") for alias in v.aliases)):
            if not _STRUCTURED.fullmatch(name):
                yield v.place, f"'{name}' is not a structured name"


def _alias_sets(description: Description) -> list[list[Variable]]:
    """Return the sets of variables of FMI 2.0 that share one value."""
    sets = defaultdict(list)
    for v in description.variables:
        kind = "Integer" if v.kind == "Enumeration" else v.kind
        sets[kind, v.reference].append(v)
    return [variables for variables in sets.values() if len(variables) > 1]


@error("2.2.7", None, "give the start value to one of them")
def alias_starts(description: Description) -> Claims:
    """Variables that share a value give more than one start value, or constants differing ones."""
    for variables in _alias_sets(description):
        starts = [v for v in variables if v.start is not None]
        constant = all(v.variability == "constant" for v in starts)
        if len(starts) > 1 and not (constant and len({v.start for v in starts}) == 1):
            yield starts[1].place, f"{listed(v.name for v in starts)} share a value and a start"


@error("2.2.7", None, "give all of them the same unit")
def alias_units(description: Description) -> Claims:
    """Variables that share a value have different units."""
    for variables in _alias_sets(description):
        units = {v.get("unit") for v in variables}
        if len(units) > 1:
            names = listed(f"{v.name} [{v.get('unit') or 'no unit'}]" for v in variables)
            yield variables[1].place, f"{names} share a value"


@error("2.2.7", None, "give one of them its own value reference")
def alias_inputs(description: Description) -> Claims:
    """Several variables that can be set share a value, or a constant shares one that varies."""
    for variables in _alias_sets(description):
        settable = [v for v in variables if v.causality in ("input", "parameter", "independent")]
        if len(settable) > 1:
            yield settable[1].place, f"{listed(v.name for v in settable)} share a value"
        if len({v.variability == "constant" for v in variables}) > 1:
            names = listed(f"{v.name} ({v.variability})" for v in variables)
            yield variables[1].place, f"{names} share a value"


@error("2.2.7", "2.4.7.4", "see the table in the standard", "variables")
def illegal_variability(v: Variable) -> Iterator[str]:
    """The combination of causality and variability is not allowed."""
    combination = v.causality, v.variability
    unknown = v.causality == "structuralParameter" and v.version == 2
    if combination not in INITIALS or unknown:
        default = "" if "variability" in v.given else " (the default)"
        yield f"causality {v.causality} with variability {v.variability}{default}"


@error("2.2.7", "2.4.7.5", "leave it out to get the default", "variables")
def illegal_initial(v: Variable) -> Iterator[str]:
    """The attribute initial is not allowed with this causality and variability."""
    given = v.given.get("initial")
    allowed = INITIALS.get((v.causality, v.variability))
    if v.causality == "input" and v.version == 3:
        allowed = ("exact",)
    if given and allowed is not None and given not in allowed:
        expected = " or ".join(allowed) or "none"
        combination = f"{v.causality}, {v.variability}"
        yield f"initial={given} for a variable that is {combination}; expected {expected}"


@error("2.2.7", "2.4.7.4", "make it discrete", "variables")
def continuous_but_not_real(v: Variable) -> Iterator[str]:
    """A variable that is not a floating-point number is continuous."""
    if v.variability == "continuous" and v.kind not in FLOATS:
        default = "" if "variability" in v.given else ", which is the default"
        yield f"is {v.kind} with variability continuous{default}"


def _needs_start(v: Variable) -> str | None:
    """Return why a variable must have a start value."""
    if v.kind == "Clock":
        return None
    if v.causality in ("input", "parameter", "structuralParameter"):
        return v.causality
    if v.variability == "constant":
        return "constant"
    return f"initial={v.initial}" if v.initial in ("exact", "approx") else None


@error("2.2.7", "2.4.7.5", "give it a start value", "variables")
def missing_start(v: Variable) -> Iterator[str]:
    """A start value is missing that the variable must have."""
    if v.start is None and (why := _needs_start(v)):
        yield f"no start value, but {why}"


@error("2.2.7", "2.4.7.5", "remove it, or write initial=approx", "variables")
def superfluous_start(v: Variable) -> Iterator[str]:
    """A start value is given that the variable must not have."""
    if v.start is None or v.kind == "Clock":
        return
    if v.causality == "independent":
        yield "is independent and has a start value"
    elif v.initial == "calculated" and not _needs_start(v):
        default = "" if "initial" in v.given else " (the default)"
        yield f"initial=calculated{default}, and has a start value"


@error("2.2.7", "2.4.7.4", "declare one, such as time in s")
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


@warning("2.2.7", "2.4.7.4", "remove the attribute", "variables")
def multiple_set_of_no_input(v: Variable) -> Iterator[str]:
    """A variable that is not an input has the flag canHandleMultipleSetPerTimeInstant."""
    if "canHandleMultipleSetPerTimeInstant" in v.given and v.causality != "input":
        yield f"canHandleMultipleSetPerTimeInstant, but causality {v.causality}"


@error(None, "2.4.7.4", "remove the attribute", "variables")
def illegal_intermediate_update(v: Variable) -> Iterator[str]:
    """A parameter or a clock claims to be accessible during intermediate update."""
    closed = v.causality == "parameter" or v.kind == "Clock"
    if closed and flag(v.given, "intermediateUpdate"):
        yield "intermediateUpdate is true"


@error("2.2.7", "2.4.7", "choose a start inside, or widen the range", "variables")
def start_outside_range(v: Variable) -> Iterator[str]:
    """A start value lies outside [min, max], or is not an item of its enumeration."""
    low, high = v.number("min"), v.number("max")
    items = v.items
    for start in v.start_numbers:
        if (low is not None and start < low) or (high is not None and start > high):
            ends = ["" if end is None else end for end in (low, high)]
            yield f"start {start} is outside [{ends[0]} .. {ends[1]}]"
        elif v.kind == "Enumeration" and items and start not in items:
            yield f"start {start} is not an item of {v.given.get('declaredType')}"


def _bounds(description: Description) -> Iterator[tuple[str, Number | None, Number | None]]:
    for each in description.types:
        if is_number(each.kind):
            low, high = (number(each.given.get(key), each.kind) for key in ("min", "max"))
            yield each.place, low, high
    for v in description.variables:
        if "min" in v.given or "max" in v.given:
            yield v.place, v.number("min"), v.number("max")


@error("2.2.3", "2.4.4", "swap or correct them")
def min_above_max(description: Description) -> Claims:
    """The smallest allowed value is above the largest, or one of them is NaN."""
    for place, low, high in _bounds(description):
        if low is not None and high is not None and low > high:
            yield place, f"min {low} is above max {high}"
        if any(isinstance(n, float) and math.isnan(n) for n in (low, high)):
            yield place, f"min {low}, max {high}"


@error("2.2.3", "2.4.4", "give the variable's usual size, above 0")
def bad_nominal(description: Description) -> Claims:
    """A nominal value is 0, negative or not finite, so that tolerances made of it fail."""
    everything = [(t.place, t.kind, t.given) for t in description.types]
    everything += [(v.place, v.kind, v.given) for v in description.variables]
    for place, kind, given in everything:
        nominal = number(given.get("nominal")) if kind in FLOATS else None
        if nominal is not None and not (nominal > 0.0 and math.isfinite(nominal)):
            yield place, f"nominal {nominal}"


@warning("2.2.7", "2.4.7", "give a finite value", "variables")
def start_not_finite(v: Variable) -> Iterator[str]:
    """A start value is infinite or not a number."""
    if any(isinstance(n, float) and not math.isfinite(n) for n in v.start_numbers):
        yield f"start {' '.join(v.start or ())}"


@error("2.2.7", "2.4.7", "write a value that the type can hold", "variables")
def start_not_of_type(v: Variable) -> Iterator[str]:
    """A start value is nothing that its type can hold."""
    for text in v.start or () if is_number(v.kind) else ():
        value = number(text, v.kind)
        if value is None:
            yield f"start '{text}' is not a valid {v.kind}"
        elif v.kind in RANGES and not RANGES[v.kind][0] <= value <= RANGES[v.kind][1]:
            yield f"start {text} does not fit into {v.kind}"


@error(None, "2.4.7.5", "give one value, or one for each element")
def start_count(description: Description) -> Claims:
    """An array has neither one start value nor one for each element; or a scalar has several."""
    for v in description.variables:
        if v.start is None or v.kind == "Clock":
            continue
        expected = description.size(v)
        if expected is not None and len(v.start) not in (1, expected):
            yield v.place, f"{len(v.start)} start values for {expected} elements"


_MOST = 10**8  # elements


@error(None, "2.4.7.2", "give either start or valueReference")
def bad_dimension(description: Description) -> Claims:
    """A dimension has no length, two lengths, length 0, or makes an array too large for memory."""
    for v in description.variables:
        for fixed, reference in v.dimensions:
            if (fixed is None) == (reference is None):
                yield v.place, "a Dimension needs either start or valueReference"
            elif description.length(fixed, reference) == 0:
                yield v.place, "a dimension has length 0"
        if (elements := description.size(v)) is not None and elements > _MOST:
            yield v.place, f"the array has {elements} elements"


@error(None, "2.4.7.2", "refer to a structural parameter of UInt64")
def bad_dimension_reference(description: Description) -> Claims:
    """A dimension refers to something other than a constant or structural parameter of UInt64."""
    for v in description.variables:
        for _, reference in v.dimensions:
            if reference is None:
                continue
            source = description.variable(reference)
            if source is None:
                yield v.place, f"a Dimension refers to {reference}, which does not exist"
            elif source.kind != "UInt64" or not (
                source.causality == "structuralParameter" or source.variability == "constant"
            ):
                what = f"{source.kind}, {source.causality}, {source.variability}"
                yield v.place, f"a Dimension refers to {source.name}, which is {what}"


@error(None, "2.4.7.4", "make it a scalar", "variables")
def structural_array(v: Variable) -> Iterator[str]:
    """A structural parameter or a clock is an array."""
    if v.dimensions and (v.causality == "structuralParameter" or v.kind == "Clock"):
        yield "has dimensions"
