"""The arrays that the kernel writes a run into."""

from __future__ import annotations

import numpy as np

from cosim import kernel
from cosim.result import Array


class Memory:
    """Room for the signals of one run; the kernel writes there as long as this exists.

    Attributes
    ----------
    record : (n_steps + 1, n_selected), what is kept
    rows : what the kernel steps through, all signals: the record itself, or one block
    """

    def __init__(self, run: kernel.Run, external: Array, block: Array | None) -> None:
        self._run = run
        self._external = external
        self.record: Array = np.empty((run.n_steps + 1, run.n_selected))
        self._all = block is None
        self.rows = self.record if block is None else block
        if self._all:
            run.rows = self.record.ctypes.data
        else:  # the rows of a block are the run's already
            run.record = self.record.ctypes.data
        run.external = external.ctypes.data if external.size else None

    def row(self, step: int) -> Array:
        """Return a copy of all signals at the end of the last step done."""
        row: Array = self.rows[self._place(step)].copy()
        return row

    def begin(self, step: int, row: Array) -> None:
        """Let the run go on after a step that left these signals."""
        self._run.done = self._run.block_start = step
        self.rows[self._place(step)] = row
        self.record[step] = row if self._all else row[self._run.selected[: self._run.n_selected]]

    def _place(self, step: int) -> int:
        return step if self._all else step - int(self._run.block_start)
