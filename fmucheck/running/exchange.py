"""A run of Model Exchange, with a small integrator of our own."""

from __future__ import annotations

import math
from ctypes import c_double

from stickslip.fmucheck.description.arrays import size
from stickslip.fmucheck.description.model import Description, Variable
from stickslip.fmucheck.description.values import whole
from stickslip.fmucheck.running.bench import Bench
from stickslip.fmucheck.running.calls import CallFailed
from stickslip.fmucheck.running.instance import Event, Instance, Values
from stickslip.fmucheck.running.run import STEPS, Run
from stickslip.fmucheck.running.variation import other


class ExchangeRun(Run):
    """A run of Model Exchange: Heun's method, its step chosen by the difference to Euler's."""

    def __init__(
        self, bench: Bench, instance: Instance, *, phase: float = 0.0, watching: bool = True
    ) -> None:
        super().__init__(bench, instance, phase=phase, watching=watching)
        self._time = bench.start_time
        self._step = bench.step_size
        self._next: float | None = None
        self._size = state_count(bench.description)

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
        event = Event(more=True, end=False, changed=False, next_time=None)
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
        self._put(
            self._time + step,
            [a + step * (b + c) / 2 for a, b, c in zip(x, f, slope, strict=True)],
        )
        self._time += step
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


def state_count(description: Description) -> int:
    """Return how many continuous states the description declares."""
    return sum(size(v, description) or 1 for v in description.states)


def indicator_count(description: Description) -> int:
    """Return how many event indicators the description declares."""
    if description.version == 2:
        return whole(description.root.get("numberOfEventIndicators")) or 0
    listed = (u.variable for u in description.group("EventIndicator") if u.variable)
    return sum(size(v, description) or 1 for v in listed)


def new_run(
    bench: Bench, instance: Instance | None = None, *, phase: float = 0.0, watching: bool = True
) -> Run:
    """Return a run of a new instance, or of a given one."""
    kind = ExchangeRun if bench.is_exchange else Run
    return kind(bench, instance or bench.new(), phase=phase, watching=watching)


def finished(
    bench: Bench, instance: Instance | None = None, *, phase: float = 0.0, watching: bool = True
) -> Run:
    """Return a run of ``STEPS`` steps."""
    run = new_run(bench, instance, phase=phase, watching=watching)
    run.begin()
    run.go(STEPS)
    return run


def changes(bench: Bench) -> list[tuple[Variable, Values]]:
    """Return other values of parameters with which a run works, none if none do."""
    if bench.changes is None:
        bench.changes = [(v, x) for v in bench.parameters[:100] if (x := other(v))]
        run = new_run(bench, phase=1.0)
        try:
            run.begin(bench.changes)
            run.go(STEPS)
        except CallFailed:
            bench.changes = []
        else:
            bench.free(run.instance)
    return bench.changes
