"""A run: the same steps with the same inputs, by either interface, recorded bit for bit."""

import copy
import math
from collections.abc import Sequence
from ctypes import c_double
from functools import cache
from typing import Any, Self

from stickslip.fmi.description.variables import FLOATS
from stickslip.fmucheck.description.model import RANGES, Description, Variable, number, whole
from stickslip.fmucheck.running.bench import Bench
from stickslip.fmucheck.running.calls import CallFailed
from stickslip.fmucheck.running.instance import Event, Instance, Values


def start_of(v: Variable) -> tuple[Any, ...] | None:
    """Return a variable's start values in its own type, ``None`` when it has none."""
    if v.start is None:
        return None
    if v.kind == "String":
        return tuple(text.encode() for text in v.start)
    if v.kind == "Binary":
        return tuple(bytes.fromhex(text) for text in v.start)
    if v.kind == "Boolean":
        return tuple(text.strip() in ("true", "1") for text in v.start)
    return tuple(number(text, v.kind) for text in v.start)


def other(v: Variable, factor: float = 0.1) -> tuple[Any, ...] | None:
    """Return start values moved within the variable's range, ``None`` if they cannot be."""
    starts = start_of(v)
    if starts is None or v.kind in ("String", "Binary") or None in starts:
        return None
    return tuple(moved(v, start, factor) for start in starts)


def moved(v: Variable, value: Any, factor: float) -> Any:
    """Return a value moved by ``factor`` of the variable's size, kept within its range."""
    if v.kind == "Boolean":
        return not value if factor > 0 else value
    low, high = v.number("min"), v.number("max")
    if v.kind == "Enumeration":
        items = sorted(v.items) or [value]
        return items[(items.index(value) + 1) % len(items)] if value in items else value
    if v.kind in RANGES:
        least, most = RANGES[v.kind]
        low, high = max(least, low or least), min(most, most if high is None else high)
        there = value + (1 if factor > 0 else -1)
    else:
        there = value + factor * scale(v, value)
    if low is not None and there < low:
        return (value + low) / 2 if v.kind in FLOATS else low
    if high is not None and there > high:
        return (value + high) / 2 if v.kind in FLOATS else high
    return there


def scale(v: Variable, value: float) -> float:
    """Return the usual size of a variable."""
    nominal = v.number("nominal")
    if nominal and math.isfinite(nominal):
        return abs(nominal)
    return abs(value) if value and math.isfinite(value) else 1.0


STEPS = 12


class Run:
    """A run of one instance; ``rows`` hold what was read after each step, with every bit.

    ``phase`` shifts the inputs, so that two runs can differ; without ``watching``, nothing is read.
    """

    def __init__(self, bench: Bench, instance: Instance, *, phase: float, watching: bool) -> None:
        self.bench, self.instance = bench, instance
        self.phase, self.watching = phase, watching
        self.count, self.ended = 0, False
        self.rows: list[str] = []

    def begin(self, parameters: Sequence[tuple[Variable, Values]] = ()) -> None:
        """Initialise."""
        self.instance.enter_initialisation(self.bench.start_time, parameters)
        self.instance.do("ExitInitializationMode")
        self.enter()

    def enter(self) -> None:
        """Go to where steps are done."""
        if self.instance.event_mode:
            self.instance.leave_event_mode()

    def go(self, steps: int) -> None:
        """Do steps, fewer when the FMU ends."""
        for _ in range(steps):
            if self.ended:
                break
            self.move_inputs()
            self.advance()
            self.count += 1
            if self.watching:
                self.rows.append(self.read())

    def advance(self) -> None:
        """Do one step."""
        step = self.bench.step_size
        time = self.bench.start_time + self.count * step
        self.ended = self.instance.step(time, step)

    @property
    def time(self) -> float:
        """Where it is, in s."""
        return self.bench.start_time + self.count * self.bench.step_size

    def read(self) -> str:
        """Return all observed values."""
        return repr(self.instance.get(self.bench.observed))

    def move_inputs(self) -> None:
        """Set every input to its value of this step."""
        if self.bench.still:
            return
        for place, v in enumerate(self.bench.inputs):
            factor = 0.1 * math.sin(0.7 * self.count + place + self.phase)
            if (values := other(v, factor)) and self.may_set(v):
                self.instance.set(v, values)

    def may_set(self, _: Variable) -> bool:
        """Tell whether an input can be set where steps are done."""
        return True

    def branch(self, instance: Instance | None = None) -> Self:
        """Return a run that goes on from here, with another instance if one is given."""
        twin = copy.copy(self)
        twin.rows = []
        twin.instance = instance or self.instance
        return twin


class ExchangeRun(Run):
    """A run of Model Exchange: Heun's method, its step chosen by the difference to Euler's."""

    def __init__(self, bench: Bench, instance: Instance, *, phase: float, watching: bool) -> None:
        super().__init__(bench, instance, phase=phase, watching=watching)
        self._time = bench.start_time
        self._step = bench.step_size
        self._next: float | None = None
        self._size = bench.description.count(bench.description.states)

    @property
    def time(self) -> float:
        return self._time

    def may_set(self, variable: Variable) -> bool:
        return variable.variability == "continuous"

    def enter(self) -> None:
        self._settle()  # initialisation ends in event mode
        self.nominals = self.instance.vector("NominalsOfContinuousStates", self._size)

    def _settle(self) -> None:
        """Iterate the event until nothing changes."""
        event = Event(more=True)
        for _ in range(1000):
            event = self.instance.update_discrete_states()
            if event.end or not event.more:
                break
        else:
            raise CallFailed("event iteration", 0, " 1000 times and still wants more")
        self.ended, self._next = event.end, event.next_time
        if not self.ended:
            self.instance.do("EnterContinuousTimeMode")

    def advance(self) -> None:
        before = self.indicators()
        x, f = self.states(), self.rates()
        limit = math.inf if self._next is None else self._next
        step = min(self._step, max(limit - self._time, 0.0))
        for _ in range(60):
            trial = [a + step * b for a, b in zip(x, f, strict=True)]
            self._put(self._time + step, trial)
            slope = self.rates()
            error = self._error(x, f, slope, step)
            if error <= 1.0 or not x:
                break
            step *= 0.25
        self._time += step
        self._put(self._time, [a + step * (b + c) / 2 for a, b, c in zip(x, f, slope, strict=True)])
        self._step = min(self.bench.step_size, 2.0 * step) if step else self.bench.step_size
        event, self.ended = self.instance.complete_step()
        crossed = any((a > 0) != (b > 0) for a, b in zip(before, self.indicators(), strict=True))
        if not self.ended and (event or crossed or self._time >= limit):
            self.instance.do("EnterEventMode")
            self._settle()

    def _error(self, x: list[float], f: list[float], slope: list[float], step: float) -> float:
        """Return the difference of Heun's and Euler's step in units of what is tolerated."""
        worst = 0.0
        for a, b, c, nominal in zip(x, f, slope, self.nominals, strict=True):
            worst = max(worst, abs(step * (c - b) / 2) / (1e-3 * (abs(a) + abs(nominal or 1.0))))
        return worst if math.isfinite(worst) else math.inf

    def _put(self, time: float, states: list[float]) -> None:
        self.instance.do("SetTime", c_double(time))
        self.instance.set_states(states)

    def states(self) -> list[float]:
        """Return the continuous states."""
        return self.instance.vector("ContinuousStates", self._size)

    def rates(self) -> list[float]:
        """Return the derivatives of the states."""
        three = self.bench.description.version == 3
        name = "ContinuousStateDerivatives" if three else "Derivatives"
        return self.instance.vector(name, self._size)

    def indicators(self) -> list[float]:
        """Return the event indicators."""
        return self.instance.vector("EventIndicators", indicator_count(self.bench.description))


def indicator_count(description: Description) -> int:
    """Return how many event indicators the description declares."""
    if description.version == 2:
        return whole(description.root.get("numberOfEventIndicators")) or 0
    return description.count(u.variable for u in description.group("EventIndicator"))


def new_run(
    bench: Bench, instance: Instance | None = None, *, phase: float = 0.0, watching: bool = True
) -> Run:
    """Return a run of a new instance, or of a given one."""
    kind = ExchangeRun if bench.is_exchange else Run
    return kind(bench, instance or bench.new(), phase=phase, watching=watching)


def finished(
    bench: Bench, instance: Instance | None = None, *, watching: bool = True, steps: int = STEPS
) -> Run:
    """Return a run that has begun and done some steps, by default all."""
    run = new_run(bench, instance, watching=watching)
    run.begin()
    run.go(steps)
    return run


@cache
def changes(bench: Bench) -> list[tuple[Variable, Values]]:
    """Return other values of parameters with which a run works, none if none do."""
    changed = [(v, x) for v in bench.parameters[:100] if (x := other(v))]
    run = new_run(bench, phase=1.0)
    try:
        run.begin(changed)
        run.go(STEPS)
    except CallFailed:
        return []
    bench.free(run.instance)
    return changed
