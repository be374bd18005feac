"""Rules about derivatives and dependencies: each known is moved, and what moves is seen."""

import itertools
from collections.abc import Iterator
from ctypes import c_double, c_size_t
from dataclasses import dataclass
from functools import cache

from stickslip.fmi.description.variables import FLOATS
from stickslip.fmucheck.description.model import Unknown, Variable, listed, whole
from stickslip.fmucheck.rules import Claims, error, note
from stickslip.fmucheck.running.bench import Bench
from stickslip.fmucheck.running.calls import CallFailed, references
from stickslip.fmucheck.running.instance import Instance, Values
from stickslip.fmucheck.running.run import STEPS, Run, finished, moved, new_run, other, scale

_MOST_COMPARED = 40  # knowns and unknowns compared
_PLACES = (0, 5)  # steps after which it is compared
_BETWEEN = (-0.83, -0.37, 0.21, 0.64)  # parts of the step at which straightness is checked


@dataclass(frozen=True)
class Slope:
    """A derivative from differences, and how far two of them disagree."""

    value: float
    doubt: float

    def agrees(self, other: float, doubt: float = 0.0) -> bool:
        """Tell whether a derivative is near enough."""
        slack = 1e-3 * max(abs(other), abs(self.value)) + self.doubt + doubt
        return abs(other - self.value) <= slack


def _scalar(v: Variable) -> bool:
    return v.kind in ("Real", "Float64") and not v.dimensions and not v.clocks


def _knowns(bench: Bench) -> list[Variable]:
    inputs = [v for v in bench.inputs if _scalar(v) and v.variability == "continuous"]
    states = [v for v in bench.description.states if _scalar(v)] if bench.is_exchange else []
    return [*inputs, *states][:_MOST_COMPARED]


def _stepped(bench: Bench) -> tuple[str, ...]:
    """Return the groups of unknowns that are looked at between steps."""
    return ("Output", "ContinuousStateDerivative") if bench.is_exchange else ("Output",)


def _smooth_unknowns(bench: Bench) -> list[Unknown]:
    every = [u for u in bench.description.unknowns if u.group in _stepped(bench)]
    return [u for u in every if _scalar(u.variable)][:_MOST_COMPARED]


def _pairs(bench: Bench) -> Iterator[tuple[Variable, Variable]]:
    """Yield unknown and known wherever the first may depend on the second."""
    for unknown in _smooth_unknowns(bench):
        depends = unknown.dependencies
        for known in _knowns(bench):
            listed = depends is None or any(v is known for _, v in depends)
            if listed and unknown.variable is not known:
                yield unknown.variable, known


def put(run: Run, v: Variable, value: float) -> None:
    """Set an input, or one state of the state vector."""
    states = run.bench.description.states
    if v.causality == "input":
        run.instance.set(v, (value,))
        return
    vector = run.instance.vector("ContinuousStates", len(states))
    vector[states.index(v)] = value
    run.instance.set_states(vector)


def _slope(run: Run, unknown: Variable, known: Variable) -> Slope | None:
    """Return the central difference, ``None`` where it is not smooth or cannot be taken."""
    middle = float(run.instance.get([known])[0][0])
    span = 1e-4 * scale(known, middle)
    values = {}
    for part in (1.0, -1.0, 0.5, -0.5, *_BETWEEN):
        put(run, known, middle + part * span)
        values[part] = float(run.instance.get([unknown])[0][0])
    put(run, known, middle)
    found = [(values[part] - values[-part]) / (2 * part * span) for part in (1.0, 0.5)]
    centre = (values[0.5] + values[-0.5]) / 2
    # Terms far greater than their sum leave rounding errors that its size does not show.
    off = max(abs(values[part] - centre - part * span * found[0]) for part in _BETWEEN)
    noise = (1e-11 * abs(centre) + 5 * off) / span
    doubt = abs(found[0] - found[1])
    if not doubt <= 1e-3 * max(map(abs, found)) + noise:
        return None
    return Slope(found[1], 10 * doubt + 2 * noise + 1e-12)


def _derivative(
    instance: Instance, unknown: Variable, known: Variable, name: str = "GetDirectionalDerivative"
) -> float:
    """Return d unknown / d known as the FMU tells it."""
    rows, columns = references([unknown.reference or 0]), references([known.reference or 0])
    seed, result, one = (c_double * 1)(1.0), (c_double * 1)(), c_size_t(1)
    if instance.description.version == 2:
        instance.do(name, rows, one, columns, one, seed, result)
    else:
        instance.do(name, rows, one, columns, one, seed, one, result, one)
    return float(result[0])


def _compared(bench: Bench, name: str) -> Claims:
    """Yield where a function's derivatives are not those of differences."""
    reported = set()
    for steps in _PLACES if not bench.still else ():
        run = finished(bench, watching=False, steps=steps)
        for unknown, known in _pairs(bench) if not run.ended else ():
            pair = f"d {unknown.name} / d {known.name}"
            if pair in reported:
                continue
            slope = _slope(run, unknown, known)
            got = _derivative(run.instance, unknown, known, name)
            # FMI 2.0 need not compute outputs before the next step of Co-Simulation.
            blind = bench.description.version == 2 and not bench.is_exchange
            if slope is None or (blind and slope.value == 0.0) or slope.agrees(got):
                continue
            reported.add(pair)
            what = f"{got:.6g} from {name}, {slope.value:.6g} from differences"
            yield pair, f"{what}, at t = {run.time:g}"


@error("2.1.9", "2.2", "correct the derivative, or do not provide it")
def wrong_directional_derivative(bench: Bench) -> Claims:
    """A directional derivative is not what central differences give."""
    if bench.interface.flag("providesDirectionalDerivatives"):
        yield from _compared(bench, "GetDirectionalDerivative")


@error(None, "2.2", "correct the derivative, or do not provide it")
def wrong_adjoint_derivative(bench: Bench) -> Claims:
    """An adjoint derivative is not what central differences give."""
    if bench.interface.flag("providesAdjointDerivatives"):
        yield from _compared(bench, "GetAdjointDerivative")


@error("2.2.8", "2.4.8", "write dependent")
def wrong_dependency_kind(bench: Bench) -> Claims:
    """A dependency is declared as a constant or fixed factor, but the factor changes in a run."""
    runs = [finished(bench, watching=False, steps=steps) for steps in (*_PLACES, 9)]
    for unknown in _smooth_unknowns(bench) if not any(run.ended for run in runs) else ():
        for (_, known), kind in zip(unknown.dependencies or (), unknown.kinds or (), strict=False):
            if kind not in ("constant", "fixed") or known is None or known not in _knowns(bench):
                continue
            if unknown.variable is known or bench.still:
                continue
            slopes = [s for run in runs if (s := _slope(run, unknown.variable, known))]
            if any(not slopes[0].agrees(other.value, other.doubt) for other in slopes[1:]):
                factors = ", ".join(f"{s.value:.6g}" for s in slopes)
                yield unknown.place, f"{kind} factor of {known.name}, but it is {factors}"


def _first_order(bench: Bench, name: str, variables: list[Variable]) -> Claims:
    """Yield that the first derivatives of variables cannot be read or set."""
    count, orders = c_size_t(len(variables)), references([1] * len(variables))
    numbers = references([v.reference or 0 for v in variables])
    counts = [] if bench.description.version == 2 else [count]
    values = (c_double * len(variables))()
    instance = finished(bench, watching=False, steps=3).instance
    status = instance.status(name, numbers, count, orders, values, *counts)
    yield from bench.failed(name, status)


@error("4.2.1", "4.2", "compute it, or declare order 0")
def output_derivatives_fail(bench: Bench) -> Claims:
    """It declares maxOutputDerivativeOrder, but has no derivatives of outputs."""
    order = whole(bench.interface.given.get("maxOutputDerivativeOrder"))
    wanted = [u.variable for u in _smooth_unknowns(bench)]
    if not bench.is_exchange and order and wanted:
        real = "Real" if bench.description.version == 2 else ""
        yield from _first_order(bench, f"Get{real}OutputDerivatives", wanted)


@error("4.2.1", None, "accept them, or declare false")
def input_derivatives_fail(bench: Bench) -> Claims:
    """It declares canInterpolateInputs, but takes no derivatives of inputs."""
    known = [v for v in _knowns(bench) if v.causality == "input"]
    if not bench.is_exchange and bench.interface.flag("canInterpolateInputs") and known:
        yield from _first_order(bench, "SetRealInputDerivatives", known)


_MOST = 100  # knowns moved
_STEPS = (1, 4)
_LATER = "later"
Seen = tuple[str, Variable, set[int]]
"""Mode, known, and the indices of the unknowns that move with it."""


def _probe(run: Run, known: Variable, unknowns: list[Variable], mode: str) -> Seen:
    """Move a known both ways and see which unknowns move."""
    before = run.instance.get(unknowns)
    middle = run.instance.get([known])[0]
    moving: set[int] = set()
    for factor in (0.1, -0.1, 0.37):
        there = tuple(moved(known, x, factor) for x in middle)
        if known.causality == "input" or mode == "initialisation":
            run.instance.set(known, there)
        else:
            put(run, known, there[0])
        after = run.instance.get(unknowns)
        pairs = zip(unknowns, before, after, strict=True)
        moving |= {v.index for v, a, b in pairs if repr(a) != repr(b) and v is not known}
    return mode, known, moving


def _unknowns(bench: Bench, *groups: str) -> list[Unknown]:
    chosen = (u for u in bench.description.unknowns if u.group in groups)
    return [u for u in chosen if u.variable in bench.observed]


def _initial(bench: Bench) -> Iterator[Seen]:
    """Yield what is seen in initialisation mode."""
    unknowns = [u.variable for u in _unknowns(bench, "InitialUnknown")]
    every = [v for v in bench.description.variables if v.clocks is None and v.initial == "exact"]
    every = [v for v in every if v.kind not in ("String", "Binary", "Clock")]
    every = [v for v in every if v.causality != "structuralParameter"]
    knowns = [v for v in every if v.variability != "constant"]
    everything = [*bench.inputs, *knowns][:_MOST] if unknowns else []
    for known, shift in bench.while_time(itertools.product(everything, (False, True))):
        instance = bench.new()
        try:
            instance.enter_initialisation(bench.start_time)
            for v in [*bench.inputs, *knowns] if shift else ():  # by 0 nothing shows
                moves = v.kind in FLOATS and v.causality != "parameter"
                if moves and (values := other(v, 0.3)):
                    instance.set(v, values)
            run = new_run(bench, instance)
            if repr(instance.get(unknowns)) == repr(instance.get(unknowns)):
                yield _probe(run, known, unknowns, "initialisation")
        except CallFailed:
            continue  # it may refuse a value
        bench.free(instance)


def _stepping(bench: Bench) -> Iterator[Seen]:
    """Yield what is seen between steps."""
    unknowns = [u.variable for u in _unknowns(bench, *_stepped(bench))]
    inputs = [v for v in bench.inputs if not bench.is_exchange or v.variability == "continuous"]
    states = [v for v in bench.description.states if not v.dimensions] if bench.is_exchange else []
    for known in bench.while_time([*inputs, *states][:_MOST]) if unknowns else ():
        for steps in _STEPS:
            run = new_run(bench, watching=False)
            try:
                run.begin()
                run.go(steps)
                if not run.ended:
                    yield _probe(run, known, unknowns, "stepping")
            except CallFailed:
                continue
            bench.free(run.instance)


def _after_steps(bench: Bench) -> Iterator[Seen]:
    """Yield what is seen in steps or events after a known was moved: reason to declare it."""
    outputs = [u.variable for u in _unknowns(bench, "Output")]
    moves_by_itself = bench.is_exchange and bench.description.states
    knowns = bench.inputs[:_MOST] if outputs and not moves_by_itself else []
    for known in bench.while_time(knowns):
        try:
            rows = [_rows(bench, outputs, shifted) for shifted in (None, known)]
        except CallFailed:
            continue
        steps = zip(*rows, strict=False)
        pairs = [one for a, b in steps for one in zip(outputs, a, b, strict=True)]
        yield _LATER, known, {v.index for v, a, b in pairs if repr(a) != repr(b)}


def _rows(bench: Bench, outputs: list[Variable], shifted: Variable | None) -> list[list[Values]]:
    """Return outputs after each of a few steps, one input moved further or none."""
    run = finished(bench, watching=False, steps=0)
    rows = []
    while run.count < STEPS and not run.ended:
        run.move_inputs()
        if shifted and (values := other(shifted, 0.5)):
            run.instance.set(shifted, values)
        run.advance()
        run.count += 1
        rows.append(run.instance.get(outputs))
    bench.free(run.instance)
    return rows


@cache
def _seen(bench: Bench) -> dict[tuple[str, int], set[int]]:
    """Return for each mode and unknown the knowns it moves with, at -1 all tried, as indices."""
    seen: dict[tuple[str, int], set[int]] = {}
    for mode, known, moving in [*_initial(bench), *_stepping(bench), *_after_steps(bench)]:
        for index in (-1, *moving):
            seen.setdefault((mode, index), set()).add(known.index)
    return seen


def _declared(bench: Bench) -> Iterator[tuple[Unknown, set[int], set[int], set[int]]]:
    """Yield unknown, knowns declared, knowns seen and knowns tried, as indices."""
    seen = _seen(bench)
    for unknown in _unknowns(bench, *_stepped(bench), "InitialUnknown"):
        if unknown.dependencies is not None:
            mode = "initialisation" if unknown.group == "InitialUnknown" else "stepping"
            declared = {v.index for _, v in unknown.dependencies if v}
            found = seen.get((mode, unknown.variable.index), set())
            yield unknown, declared, found, seen.get((mode, -1), set())


@error("2.2.8", "2.4.8", "list it, or importers miss a loop")
def undeclared_dependency(bench: Bench) -> Claims:
    """A variable moves with a known that its dependencies do not list."""
    names = {v.index: v.name for v in bench.description.variables}
    for unknown, declared, found, _ in _declared(bench):
        if extra := [names[index] for index in sorted(found - declared)]:
            yield unknown.place, f"moves with {listed(extra)}, which is not listed"


@note("2.2.8", "2.4.8", "remove what never matters")
def dependency_never_seen(bench: Bench) -> Claims:
    """A variable moves with nothing that its dependencies list, by whatever interface."""
    names = {v.index: v.name for v in bench.description.variables}
    seen = _seen(bench)
    for unknown, declared, found, tried in _declared(bench):
        found = found | {unknown.variable.index}
        if unknown.group == "Output":
            found |= seen.get((_LATER, unknown.variable.index), set())
        idle = [names[index] for index in sorted(declared & tried)]
        if idle and not declared & found:  # the others may wait for a parameter that turns them on
            yield unknown.place, f"does not move with {listed(idle)}"
