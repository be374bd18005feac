"""Rules about the values that come out."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

from stickslip.fmi.description.variables import FLOATS
from stickslip.fmucheck.description.model import Variable, is_number
from stickslip.fmucheck.rules import Claims, error, warning
from stickslip.fmucheck.running.bench import Bench
from stickslip.fmucheck.running.calls import CallFailed
from stickslip.fmucheck.running.instance import Values
from stickslip.fmucheck.running.run import STEPS, Run, finished, new_run, other, scale, start_of


def _samples(bench: Bench) -> Iterator[tuple[Run, list[Values]]]:
    """Yield a run and all observed values, after initialisation and after each step."""
    run = new_run(bench, watching=False)
    run.begin()
    yield run, run.instance.get(bench.observed)
    for _ in range(STEPS):
        run.go(1)
        yield run, run.instance.get(bench.observed)


def _first(bench: Bench, fault: Callable[[Variable, Values], str]) -> Claims:
    """Yield where each variable has a fault for the first time."""
    reported = set()
    for run, values in _samples(bench):
        for v, elements in zip(bench.observed, values, strict=True):
            if v.index not in reported and (why := fault(v, elements)):
                reported.add(v.index)
                yield v.place, f"{why} at t = {run.time}"


@error("2.1.7", "2.2.7", "find the division by 0 or missing start")
def value_not_finite(bench: Bench) -> Claims:
    """A value becomes infinite or not a number."""

    def fault(v: Variable, elements: Values) -> str:
        odd = v.kind in FLOATS and not all(map(math.isfinite, elements))
        return f"is {elements}" if odd else ""

    return _first(bench, fault)


@warning("2.2.7", "2.2.7", "widen the range, or keep within it")
def leaves_its_range(bench: Bench) -> Claims:
    """A value leaves the range [min, max] that is declared for it."""

    def fault(v: Variable, elements: Values) -> str:
        if not is_number(v.kind) or v.causality == "input":
            return ""
        low, high = v.number("min"), v.number("max")
        slack = 1e-9 * scale(v, max(abs(low or 0), abs(high or 0)))
        return f"is {elements}" if any(_outside(x, low, high, slack) for x in elements) else ""

    return _first(bench, fault)


def _outside(x: Any, low: float | None, high: float | None, slack: float) -> bool:
    return bool((low is not None and x < low - slack) or (high is not None and x > high + slack))


@error("2.2.7", "2.4.7.5", "use the same values in code and description")
def start_differs(bench: Bench) -> Claims:
    """A parameter, constant or input does not have the start value of the description."""
    run = new_run(bench, watching=False)
    run.begin()
    for v in bench.observed:
        fixed = v.causality in ("parameter", "input", "structuralParameter")
        if fixed or v.variability == "constant":
            expected, got = start_of(v), run.instance.get([v])[0]
            if expected is not None and not _same(v, expected, got):
                shown = [" ".join(map(str, values)) for values in (expected, got)]
                yield v.place, f"start {shown[0]}, but the binary has {shown[1]}"


def _same(v: Variable, expected: Values, got: Values) -> bool:
    if len(expected) == 1:
        expected = expected * len(got)
    if None in expected or len(expected) != len(got):
        return True  # the description is wrong, which other rules say
    if v.kind == "Float32":
        return all(math.isclose(a, b, rel_tol=1e-6) for a, b in zip(expected, got, strict=True))
    if v.kind == "Boolean":
        return [bool(x) for x in expected] == [bool(x) for x in got]
    return expected == got


@error("2.1.7", "2.2.7", "store what is set")
def set_value_is_lost(bench: Bench) -> Claims:
    """A parameter that is set before initialisation has another value after it."""
    for v in bench.while_time(bench.parameters[:100]):
        values = other(v)
        if values is None:
            continue
        run = new_run(bench, watching=False)
        try:
            run.begin([(v, values)])
            got = run.instance.get([v])[0]
        except CallFailed:
            continue  # a model may refuse a value; set_refused tells it
        finally:
            if not run.instance.broken:
                bench.free(run.instance)
        if not _same(v, values, got):
            yield v.place, f"was set to {values[0]}, is {got[0]}"


@warning("2.1.7", "2.2.7", "declare min and max, or take the value")
def set_refused(bench: Bench) -> Claims:
    """A parameter cannot be set before initialisation to a value within its range."""
    for v in bench.while_time(bench.parameters[:100]):
        values = other(v)
        instance = bench.new()
        try:
            if values is not None:
                instance.set(v, values)
        except CallFailed as failed:
            yield v.place, f"{failed} for {values[0] if values else None}"
        else:
            bench.free(instance)


@error("2.2.7", "2.4.7.4", "declare it discrete or continuous")
def fixed_value_changes(bench: Bench) -> Claims:
    """A variable that is constant, fixed or tunable changes during a run."""
    first: dict[int, Values] = {}

    def fault(v: Variable, elements: Values) -> str:
        if v.variability not in ("constant", "fixed", "tunable"):
            return ""
        changed = repr(first.setdefault(v.index, elements)) != repr(elements)
        return f"is {v.variability}, but has changed" if changed else ""

    return _first(bench, fault)


@error("2.1.7", "2.2.7", "return the time that was reached")
def time_is_wrong(bench: Bench) -> Claims:
    """The independent variable is not at the time that was reached."""
    independent = [v for v in bench.observed if v.causality == "independent"]
    if not independent:
        return
    run = finished(bench, watching=False)
    got = run.instance.get(independent)[0][0]
    if not run.ended and abs(got - run.time) > 1e-6 * max(bench.step_size, abs(run.time) * 1e-6):
        yield independent[0].place, f"is {got} at t = {run.time}"


@error("2.1.7", "2.2.7", "compute in setters and steps only")
def getter_changes_state(bench: Bench) -> Claims:
    """Reading values changes them, or how the run goes on."""
    watched, blind = finished(bench), finished(bench, watching=False)
    twice = [watched.read(), watched.read()]
    if twice[0] != twice[1]:
        yield bench.interface.kind, "reading twice gives two results"
    elif watched.rows and blind.read() != watched.rows[-1]:
        yield bench.interface.kind, "a run that was read at every step ends elsewhere"
