"""Where the kernel writes the signals of a run, and what is kept of them."""

from __future__ import annotations

import ctypes
from collections.abc import Callable

import numpy as np

from stickslip.cosim.assembly.plan import Plan
from stickslip.cosim.errors import ExperimentError
from stickslip.cosim.kernel import structures
from stickslip.cosim.signals.signals import Array, Span
from stickslip.cosim.system.settings import Deviation

Room = Callable[[tuple[int, int]], Array]
_MOST_APART = 2**23  # numbers of the rows of a repetition


class Memory:
    """Rows of all signals, the record and the sums; the kernel uses them as long as this exists.

    The rows of all points in time are the record where all signals of all of them are kept. Else
    there are those of a block of steps, used again for the next. ``room`` makes arrays of a shape.
    """

    def __init__(self, run: structures.Run, plan: Plan, room: Room = np.empty) -> None:
        layout, record = plan.layout, plan.record
        self._run, self._room, self._plan = run, room, plan
        self._only_last = record.keep == "last"
        self._columns = [layout.columns[name] for name in layout.recorded]
        self._recorded = 0 if layout.whole or self._only_last else len(self._columns)
        self._every = record.every
        self._points = plan.n_steps // record.every + 1
        self._record: Array = np.empty((self._points, 0))
        run.selected = (ctypes.c_int64 * len(self._columns))(*self._columns)
        run.n_selected = self._recorded
        run.every = record.every
        entries = [_entry(label, d, plan) for label, d in layout.summed.items()]
        sums = (structures.SumOfSquares * len(entries))(*entries)
        run.sums, run.n_sums = sums, len(entries)
        self._sums = dict(zip(layout.summed, sums, strict=True))
        self._whole = layout.whole
        self._rows: Array
        self._block: Array = np.empty((0 if layout.whole else run.block + 1, run.width))
        self._take(self._block, used_again=not layout.whole)

    def prepare(self, external: Array, *, apart: bool = False) -> None:
        """Make room for a run with inputs (n_steps + 1, number); ``apart`` for a repetition."""
        run = self._run
        self._external = external
        run.external = structures.doubles(external) if external.size else None
        room = np.empty if apart else self._room
        if self._whole or (apart and (run.n_steps + 1) * run.width <= _MOST_APART):
            self._take(room((run.n_steps + 1, run.width)), used_again=False)
        elif self._rows is not self._block:
            self._take(self._block, used_again=True)
        if self._recorded:
            self._record = room((self._points, self._recorded))
            run.record = structures.doubles(self._record)

    def prepare_steps(self, inputs: Array) -> None:
        """Make room for steps of which nothing is kept, with the exposed inputs (n,) at first."""
        if not len(self._block):
            self._block = np.empty((self._run.block + 1, self._run.width))
        self._take(self._block, used_again=True)
        self._run.external = self._run.record = None
        self.give(inputs)

    def give(self, inputs: Array) -> None:
        """Let exposed inputs have these values (n,) in the next step, of a run by steps."""
        self._block[:2, : len(inputs)] = inputs  # the present row is one of them

    def last(self) -> Array:
        """Return the signals to record at the end of the last step done."""
        values: Array = self._row(self._run.done)[self._columns]
        return values

    def rows(self) -> Array:
        """Return the rows of all signals up to the last step done; none where they are not kept."""
        return self._rows[: 0 if self._rows is self._block else max(self._run.done + 1, 0)]

    def state(self) -> Array:
        """Return the signals at the end of the last step done, and the sums up to there."""
        return np.append(self._row(self._run.done), list(self.sums.values()))

    def go_on(self, step: int, state: Array) -> None:
        """Let the run go on after a step that left this state."""
        run = self._run
        if state.shape != (run.width + len(self._sums),):
            raise ValueError(f"{state.shape} signals, expected {run.width + len(self._sums)}")
        run.block_start = run.done = run.closed = step
        self._row(step)[:] = state[: run.width]
        if step % self._every == 0:
            self._record[step // self._every] = self._row(step)[self._columns[: self._recorded]]
        for entry, value in zip(self._sums.values(), state[run.width :], strict=True):
            entry.sum = value

    def append(self, first: int, outputs: Array) -> None:
        """Write the row of the next step: the last but for some outputs, from a column on."""
        row = self._row(self._run.done + 1)
        row[:] = self._row(self._run.done)
        row[first : first + len(outputs)] = outputs

    def kept(self, first: int, last: int, *, ended: bool = False) -> tuple[Array, Array]:
        """Return time (n,) and record (n, signals) from step first to last; last if it ended."""
        if self._only_last:
            return self._plan.time[last : last + 1], self.last()[None]
        begin, end = -(-first // self._every), last // self._every + 1
        record = self._rows if self._whole else self._record
        time = self._plan.time[begin * self._every : last + 1 : self._every]
        values: Array = record[begin:end]
        if ended and last % self._every:
            time = np.append(time, self._plan.time[last])
            values = np.vstack([values, self._row(last)[self._columns]])
        return time, values

    @property
    def sums(self) -> dict[str, float]:
        """Return the sums of squares by label."""
        return {label: entry.sum for label, entry in self._sums.items()}

    def _take(self, rows: Array, *, used_again: bool) -> None:
        self._rows = rows
        self._run.rows, self._run.used_again = structures.doubles(rows), used_again

    def _row(self, step: int) -> Array:
        row: Array = self._rows[step - (self._run.block_start if self._run.used_again else 0)]
        return row


def _entry(label: str, what: Deviation, plan: Plan) -> structures.SumOfSquares:
    columns = plan.layout.columns
    steps = np.flatnonzero(Span(what.begin, what.end).covers(plan.time))
    if not len(steps):
        raise ExperimentError(
            f"cannot sum up {label!r}: no point in time lies in {what.begin} to {what.end} s"
        )
    entry = structures.SumOfSquares(columns[what.signal], -1, 0.0, steps[0], steps[-1] + 1)
    if isinstance(what.reference, str):
        entry.reference = columns[what.reference]
    else:
        entry.constant = what.reference
    return entry
