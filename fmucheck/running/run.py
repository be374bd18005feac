"""A run: the same steps with the same inputs, by either interface, recorded bit for bit."""

from __future__ import annotations

import copy
import math
from collections.abc import Sequence

from stickslip.fmucheck.description.model import Variable
from stickslip.fmucheck.running.bench import Bench
from stickslip.fmucheck.running.instance import Instance, Values
from stickslip.fmucheck.running.variation import other

STEPS = 12


class Run:
    """A run of one instance.

    ``rows`` hold what was read after each step as text that shows every bit.

    Parameters
    ----------
    phase : shifts the inputs, so that two runs can differ
    watching : read everything after each step, not only at the end
    """

    def __init__(
        self, bench: Bench, instance: Instance, *, phase: float = 0.0, watching: bool = True
    ) -> None:
        self.bench, self.instance = bench, instance
        self.phase, self.watching = phase, watching
        self.count, self.ended = 0, False
        self.rows: list[str] = []

    def begin(self, parameters: Sequence[tuple[Variable, Values]] = ()) -> None:
        """Initialise."""
        for variable, values in parameters:
            self.instance.set(variable, values)
        self.instance.enter_initialisation(self.bench.start_time)
        self.instance.exit_initialisation()
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

    def branch(self, instance: Instance | None = None) -> Run:
        """Return a run that goes on from here, with another instance if one is given."""
        twin = copy.copy(self)
        twin.rows = []
        twin.instance = instance or self.instance
        return twin
