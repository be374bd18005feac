"""Rules about start, min, max and nominal."""

from __future__ import annotations

import math
from collections.abc import Iterator

from stickslip.fmucheck.description.arrays import size
from stickslip.fmucheck.description.model import Description, Variable
from stickslip.fmucheck.description.units import items_of
from stickslip.fmucheck.description.values import FLOATS, RANGES, Number, is_number, number
from stickslip.fmucheck.finding import Severity
from stickslip.fmucheck.rules import Claims, rule


@rule(
    Severity.ERROR, fmi2="2.2.7", fmi3="2.4.7", advice="choose a start inside, or widen the range"
)
def start_outside_range(description: Description) -> Claims:
    """A start value lies outside [min, max], or is no item of its enumeration."""
    for v in description.variables:
        low, high = v.number("min"), v.number("max")
        items = items_of(v)
        for start in v.start_numbers:
            if (low is not None and start < low) or (high is not None and start > high):
                yield v.place, f"start {start} is outside {_range(low, high)}"
            elif v.kind == "Enumeration" and items and start not in items:
                yield v.place, f"start {start} is no item of {v.given.get('declaredType')}"


def _range(low: Number | None, high: Number | None) -> str:
    return f"[{'' if low is None else low} .. {'' if high is None else high}]"


def _bounds(description: Description) -> Iterator[tuple[str, Number | None, Number | None]]:
    for each in description.types:
        if is_number(each.kind):
            low, high = (number(each.given.get(key), each.kind) for key in ("min", "max"))
            yield each.place, low, high
    for v in description.variables:
        if "min" in v.given or "max" in v.given:
            yield v.place, v.number("min"), v.number("max")


@rule(Severity.ERROR, fmi2="2.2.3", fmi3="2.4.4", advice="swap or correct them")
def min_above_max(description: Description) -> Claims:
    """The smallest allowed value is above the largest, or one of them is no number."""
    for place, low, high in _bounds(description):
        if low is not None and high is not None and low > high:
            yield place, f"min {low} is above max {high}"
        if any(isinstance(n, float) and math.isnan(n) for n in (low, high)):
            yield place, f"min {low}, max {high}"


@rule(Severity.ERROR, fmi2="2.2.3", fmi3="2.4.4", advice="give the variable's usual size, above 0")
def bad_nominal(description: Description) -> Claims:
    """A nominal value is 0, negative or not finite, so that tolerances made of it fail."""
    everything = [(t.place, t.kind, t.given) for t in description.types]
    everything += [(v.place, v.kind, v.given) for v in description.variables]
    for place, kind, given in everything:
        nominal = number(given.get("nominal")) if kind in FLOATS else None
        if nominal is not None and not (nominal > 0.0 and math.isfinite(nominal)):
            yield place, f"nominal {nominal}"


@rule(Severity.WARNING, fmi2="2.2.7", fmi3="2.4.7", advice="give a finite value")
def start_not_finite(description: Description) -> Claims:
    """A start value is infinite or not a number."""
    for v in description.variables:
        if any(isinstance(n, float) and not math.isfinite(n) for n in v.start_numbers):
            yield v.place, f"start {' '.join(v.start or ())}"


@rule(Severity.ERROR, fmi2="2.2.7", fmi3="2.4.7", advice="write a value that the type can hold")
def start_not_of_type(description: Description) -> Claims:
    """A start value is nothing that its type can hold."""
    for v in description.variables:
        for text in v.start or () if is_number(v.kind) else ():
            value = number(text, v.kind)
            if value is None:
                yield v.place, f"start '{text}' is no {v.kind}"
            elif v.kind in RANGES and not RANGES[v.kind][0] <= value <= RANGES[v.kind][1]:
                yield v.place, f"start {text} does not fit into {v.kind}"


@rule(Severity.ERROR, fmi2=None, fmi3="2.4.7.5", advice="give one value, or one for each element")
def start_count(description: Description) -> Claims:
    """An array has neither one start value nor one for each element; or a scalar has several."""
    for v in description.variables:
        expected = size(v, description)
        count = _starts(v)
        if count is not None and expected is not None and count not in (1, expected):
            yield v.place, f"{count} start values for {expected} elements"


def _starts(v: Variable) -> int | None:
    return None if v.start is None or v.kind == "Clock" else len(v.start)
