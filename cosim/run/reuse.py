"""Runs that are what they would be with new instances, though instances are used again.

A run leaves traces: how it ended, which components moved, which parameters were set. An instance
is reset only after runs whose traces a reset has been seen to remove: such a run was repeated after
a reset and gave the same. After any other run the next one has new instances.
"""

import zlib
from collections.abc import Callable, Mapping

import numpy as np

from stickslip.cosim.errors import SimulationError
from stickslip.cosim.run import resets
from stickslip.cosim.run.result import Result
from stickslip.cosim.run.stepping import Discarded, Stepper
from stickslip.cosim.signals.signals import Array
from stickslip.fmi.description.variables import Value

_Trace = tuple[str, str]
_ENDED = {how: {("ended", how)} for how in ("stopped", "halted", "finished")}
_RESUMED = ("begun", "from a state")  # is never known to be removed


class Reuse:
    """Takes FMUs through one run after the other; may call ``before_repetition``."""

    def __init__(self, stepper: Stepper) -> None:
        self.before_repetition: Callable[[], object] = lambda: None
        self._stepper, self._fmus = stepper, stepper.fmus
        self._plan, self._system = stepper.plan, stepper.plan.spec.system
        self._removed: set[_Trace] = set()  # by a reset
        self._traces: set[_Trace] = set()  # of the runs since all instances were new
        self._set: dict[str, Value] = {}  # by them, the last value of each
        self._failed = False  # the last of them
        self._first: tuple[object, int] | None = None  # settings and result of the first run
        self._deterministic = self._watched = True
        self._proven = np.zeros_like(self._fmus.moved)

    def free(self) -> None:
        """Free all instances, and with them what runs have left."""
        self._traces, self._set = set(), {}
        self._fmus.free()

    def renew(self, values: Mapping[str, Value]) -> set[_Trace]:
        """Let a run have instances as good as new; return the traces of what it leaves unset.

        Until it comes to its end it counts as failed, so that all are new for the next one.
        """
        unset: set[_Trace] = set()
        if not self._set.keys() <= values.keys():
            unset = {("set", name) for name in self._set.keys() - values.keys()} - self._removed
        removed = self._traces <= self._removed and not (unset or self._failed)
        self._renew_for(values, everything=not (removed and self._deterministic))
        self._failed = True
        return unset

    def run(
        self,
        values: Mapping[str, Value],
        external: Array,
        go: Callable[[bool], Result],
        *,
        same_as: object = None,
        resumed: bool = False,
    ) -> Result:
        """Run, by ``go``, with instances that are new, or as good as new.

        One that is ``resumed`` is not repeated. Runs with equal ``same_as`` are the same where the
        values and the inputs ``external`` are.
        """
        again, before = bool(self._traces), self._set
        unset = self.renew(values)
        if self._watched:
            self._fmus.moved[:] = self._proven
        self._stepper.begin(values, external)
        result = go(False)
        self._failed = False
        left = self._left_by(result)
        self._traces |= left
        left |= unset
        if again and not resumed and self._deterministic and not left <= self._removed:
            earlier = {**before, **values} if unset else {}
            self._repeat(values, earlier, external, go, result, left)
            if same_as is not None and self._deterministic:
                first = (same_as, values, _digest(external)), _digest(result.time, result.rows)
                if self._first and self._first[0] == first[0] and self._first[1] != first[1]:
                    self._deterministic = False
                    what = "this run is not the first one again"
                    resets.declare_erratic(self._system, self._plan.order, what)
        elif self._first is None and same_as is not None:
            found = _digest(result.time, result.rows)
            self._first = (same_as, dict(values), _digest(external)), found
        if resumed:
            self._traces.add(_RESUMED)
        return result

    def _renew_for(self, values: Mapping[str, Value], *, everything: bool) -> None:
        """Make sure that no used instance is left but those that a reset serves."""
        if everything:
            self._fmus.renew(self._plan.order)
            self._traces, self._set = set(), {}
        elif resets.lines:
            self._fmus.renew(name for name in self._plan.order if not self._can_be_reset(name))
        self._set = {**self._set, **values} if self._set else dict(values)

    def _can_be_reset(self, name: str) -> bool:
        return self._system.components[name].binary not in resets.lines

    def _left_by(self, result: Result) -> set[_Trace]:
        how = "stopped" if result.stopped else "halted" if self._stepper.halted else "finished"
        left = _ENDED[how].copy()
        if self._stepper.changed:
            left.update(("changed", name) for name in self._stepper.changed)
        if self._watched:
            moved = np.flatnonzero(self._fmus.moved != self._proven)
            left.update(("moved", self._plan.order[i]) for i in moved)
        return left

    def _repeat(
        self,
        values: Mapping[str, Value],
        earlier: Mapping[str, Value],
        external: Array,
        go: Callable[[bool], Result],
        result: Result,
        left: set[_Trace],
    ) -> None:
        """Repeat a run after a reset, at first with ``earlier``; note which traces that removes."""
        able = [name for name in self._plan.order if self._can_be_reset(name)]
        if not able:
            return
        self.before_repetition()
        self._failed = True
        failed: tuple[list[str], str] | None = None
        try:
            if earlier:
                self._renew_for(values, everything=False)
                self._stepper.begin(earlier, external, apart=True)
                self._stepper.advance(0)
            self._renew_for(values, everything=False)
            self._stepper.begin(values, external, apart=True)
            if _same(go(True), result):
                self._removed |= left
                self._proven |= self._fmus.moved
                self._watched = not self._proven.all()
                self._failed = False
                return
        except (SimulationError, Discarded) as fault:
            failed = [self._plan.order[self._fmus.run.failed]], str(fault)
        after_reset = self._fmus.memory.rows().copy()
        traces = self._traces
        self._renew_for(values, everything=True)
        self._stepper.begin(values, external, apart=True)
        try:
            same = _same(go(True), result)
            self._failed = False
        except SimulationError:
            same = False
        self._traces = traces
        self._conclude(after_reset, failed, able, same=same)

    def _conclude(
        self,
        after_reset: Array,
        failed: tuple[list[str], str] | None,
        able: list[str],
        *,
        same: bool,
    ) -> None:
        """Say who of the ``able`` cannot be reset, by the rows of the run after a reset."""
        found = self._first_difference(after_reset, self._fmus.memory.rows())
        names, what = found or failed or (able, "the results differ")
        if same and set(names) <= set(able):
            resets.declare_unresettable(self._system, names, what)
            return
        self._deterministic = False
        if not same:
            resets.declare_erratic(self._system, names, what)

    def _first_difference(self, after_reset: Array, new: Array) -> tuple[list[str], str] | None:
        """Return which component differs first, and how; None where none is seen to."""
        n = min(len(after_reset), len(new))
        differs = ~np.isclose(after_reset[:n], new[:n], rtol=0.0, atol=0.0, equal_nan=True)
        rows = np.flatnonzero(differs.any(axis=1))
        for name in self._plan.order if len(rows) else ():
            slot, row = self._fmus.slots[name], rows[0]
            columns = range(slot.column, slot.column + slot.n_outputs)
            for place, column in enumerate(columns):
                if differs[row, column]:
                    signal, t = (self._plan.layout.outputs[name][place], self._plan.time[row])
                    values = f"{after_reset[row, column]:.9g} instead of {new[row, column]:.9g}"
                    return [name], f"{signal} is {values} at t = {t:.9g} s"
        return None


def _digest(*arrays: Array) -> int:
    found = 0
    for array in arrays:
        found = zlib.crc32(np.ascontiguousarray(array).data, found)
    return found


def _same(one: Result, other: Result) -> bool:
    return one.stopped == other.stopped and all(
        np.array_equal(a, b) or np.array_equal(a, b, equal_nan=True)  # the former takes a tenth
        for a, b in ((one.time, other.time), (one.rows, other.rows))
    )
