"""Rules about declared dependencies: each known is moved, and what moves with it is seen."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass

from stickslip.fmi.description.variables import FLOATS
from stickslip.fmucheck.description.model import Unknown, Variable, listed
from stickslip.fmucheck.rules import Claims, error, note
from stickslip.fmucheck.running.bench import Bench
from stickslip.fmucheck.running.calls import CallFailed
from stickslip.fmucheck.running.instance import Values
from stickslip.fmucheck.running.run import STEPS, Run, moved, new_run, other
from stickslip.fmucheck.running.sensitivity import put

_MOST = 100  # knowns moved
_STEPS = (1, 4)
_LATER = "later"


@dataclass(frozen=True)
class Seen:
    """What was seen: these unknowns move with this known."""

    known: Variable
    moved: frozenset[int]
    mode: str


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
    return Seen(known, frozenset(moving), mode)


def _unknowns(bench: Bench, groups: tuple[str, ...]) -> list[Unknown]:
    chosen = (u for u in bench.description.unknowns if u.group in groups and u.variable)
    return [u for u in chosen if u.variable and u.variable in bench.observed]


def _stepped(bench: Bench) -> tuple[str, ...]:
    """Return the groups that are looked at between steps."""
    return ("Output", "ContinuousStateDerivative") if bench.is_exchange else ("Output",)


def _movable(v: Variable) -> bool:
    return v.kind not in ("String", "Binary", "Clock") and v.clocks is None


def _initial(bench: Bench) -> Iterator[Seen]:
    """Yield what is seen in initialisation mode."""
    unknowns = [u.variable for u in _unknowns(bench, ("InitialUnknown",)) if u.variable]
    exact = [v for v in bench.description.variables if _movable(v) and v.variability != "constant"]
    knowns = [v for v in exact if v.initial == "exact" and v.causality != "structuralParameter"]
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
    unknowns = [u.variable for u in _unknowns(bench, _stepped(bench)) if u.variable]
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
    """Yield what is seen after a known was moved, in steps of Co-Simulation or with events alone.

    No dependency in the sense of the standard, but reason enough for one to be declared.
    """
    outputs = [u.variable for u in _unknowns(bench, ("Output",)) if u.variable]
    moves_by_itself = bench.is_exchange and bench.description.states
    knowns = bench.inputs[:_MOST] if outputs and not moves_by_itself else []
    for known in bench.while_time(knowns):
        try:
            rows = [_rows(bench, outputs, shifted) for shifted in (None, known)]
        except CallFailed:
            continue
        pairs = [
            pair for a, b in zip(*rows, strict=False) for pair in zip(outputs, a, b, strict=True)
        ]
        moving = frozenset(v.index for v, a, b in pairs if repr(a) != repr(b))
        yield Seen(known, moving, _LATER)


def _rows(bench: Bench, outputs: list[Variable], shifted: Variable | None) -> list[list[Values]]:
    """Return outputs after each of a few steps, one input moved further or none."""
    run = new_run(bench, watching=False)
    run.begin()
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


def _seen(bench: Bench) -> dict[tuple[str, int], set[int]]:
    """Return for each mode and unknown the indices of the knowns it moves with."""
    if bench.seen is None:
        bench.seen = {}
        for seen in [*_initial(bench), *_stepping(bench), *_after_steps(bench)]:
            bench.seen.setdefault((seen.mode, -1), set()).add(seen.known.index)
            for index in seen.moved:
                bench.seen.setdefault((seen.mode, index), set()).add(seen.known.index)
    return bench.seen


def _mode(unknown: Unknown) -> str:
    return "initialisation" if unknown.group == "InitialUnknown" else "stepping"


def _declared(bench: Bench) -> Iterator[tuple[Unknown, set[int], set[int], set[int]]]:
    """Yield unknown, knowns declared, knowns seen and knowns tried, as indices."""
    seen = _seen(bench)
    for unknown in _unknowns(bench, (*_stepped(bench), "InitialUnknown")):
        if unknown.dependencies is not None and unknown.variable:
            mode = _mode(unknown)
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
        found = found | {unknown.variable.index} if unknown.variable else found
        if unknown.group == "Output":
            found |= seen.get((_LATER, unknown.variable.index if unknown.variable else 0), set())
        idle = [names[index] for index in sorted(declared & tried)]
        if idle and not declared & found:  # the others may wait for a parameter that turns them on
            yield unknown.place, f"does not move with {listed(idle)}"
