"""Rules about dimensions and structural parameters."""

from __future__ import annotations

import math

from stickslip.fmucheck.description.model import Description, Dimension, Variable
from stickslip.fmucheck.finding import Severity
from stickslip.fmucheck.rules import Claims, rule

_MOST = 10**8  # elements


def length(dimension: Dimension, description: Description) -> int | None:
    """Return the initial length of a dimension, ``None`` when it cannot be told."""
    if dimension.start is not None:
        return dimension.start
    source = (
        description.by_key.get(dimension.reference) if dimension.reference is not None else None
    )
    starts = source.start_numbers if source else []
    return int(starts[0]) if starts else None


def size(variable: Variable, description: Description) -> int | None:
    """Return how many elements a variable has at first, 1 for a scalar."""
    lengths = [length(d, description) for d in variable.dimensions]
    known = [n for n in lengths if n is not None]
    return math.prod(known) if len(known) == len(lengths) else None


@rule(Severity.ERROR, fmi2=None, fmi3="2.4.7.2", advice="give either start or valueReference")
def bad_dimension(description: Description) -> Claims:
    """A dimension has no length, two, one of 0, or one that makes an array nobody could hold."""
    for v in description.variables:
        for d in v.dimensions:
            if (d.start is None) == (d.reference is None):
                yield v.place, "a Dimension needs either start or valueReference"
            elif length(d, description) == 0:
                yield v.place, "a dimension has length 0"
        if (elements := size(v, description)) is not None and elements > _MOST:
            yield v.place, f"the array has {elements} elements"


@rule(Severity.ERROR, fmi2=None, fmi3="2.4.7.2", advice="refer to a structural parameter of UInt64")
def bad_dimension_reference(description: Description) -> Claims:
    """A dimension refers to something other than a constant or structural parameter of UInt64."""
    for v in description.variables:
        for d in v.dimensions:
            if d.reference is None:
                continue
            source = description.by_key.get(d.reference)
            if source is None:
                yield v.place, f"a Dimension refers to {d.reference}, which does not exist"
            elif source.kind != "UInt64" or not (
                source.causality == "structuralParameter" or source.variability == "constant"
            ):
                what = f"{source.kind}, {source.causality}, {source.variability}"
                yield v.place, f"a Dimension refers to {source.name}, which is {what}"


@rule(Severity.ERROR, fmi2=None, fmi3="2.4.7.4", advice="make it a scalar")
def structural_array(description: Description) -> Claims:
    """A structural parameter or a clock is an array."""
    for v in description.variables:
        if v.dimensions and (v.causality == "structuralParameter" or v.kind == "Clock"):
            yield v.place, "has dimensions"
