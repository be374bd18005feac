"""How candidates are run: where, how many side by side, and what survives a crash.

None of it changes a result.
"""

from __future__ import annotations

import os
from concurrent.futures import Executor
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from pathlib import Path

from stickslip import ga


@dataclass(frozen=True)
class Execution:
    """Where and how safely learning runs."""

    # candidates side by side; also, in threads, the runs of an experiment while what a search found
    # is fitted
    workers: int = 1
    # of candidates: ``threads``, ``processes``, ``local`` or the address of a Dask scheduler, see
    # ``ga.executor``
    where: str = "threads"
    # file of what was learned so far, written after every generation; None for none
    checkpoint: Path | None = None
    resume: bool = False  # go on from the checkpoint, if it exists

    def of_seed(self, seed: int) -> Execution:
        """Return how one of several searches runs: with a checkpoint of its own."""
        path = self.checkpoint
        own = path and path.with_name(f"{path.stem}.seed{seed}{path.suffix}")
        return replace(self, checkpoint=own)

    def opened(self) -> AbstractContextManager[Executor | None]:
        """Return the workers as a context, to be entered when there is work."""
        return ga.executor(self.where, self.workers)


def processors() -> int:
    """Return how many processors this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def stopped(stop: KeyboardInterrupt | ga.WorkersLost, kept: str) -> BaseException:
    """Return the same error, which also says what is kept and how to go on."""
    if isinstance(stop, ga.WorkersLost):
        return ga.WorkersLost(f"{stop}; {kept}; continue with --resume")
    return KeyboardInterrupt(f"interrupted; {kept}; continue with --resume")
