"""One thread of one process is in a simulation."""

from __future__ import annotations

import os
import threading
from typing import NoReturn

from stickslip.cosim.errors import SharedSimulation


class Exclusive:
    """Lets a thread in unless another is, or the process has forked and has no copy of all."""

    def __init__(self, name: str, *, outlives_fork: bool) -> None:
        self._name, self._outlives_fork = name, outlives_fork
        self._lock = threading.Lock()
        self._process = os.getpid()

    @property
    def is_ours(self) -> bool:
        """Whether this process may call the FMUs."""
        return not self._forked() or (self._outlives_fork and not self._lock.locked())

    def __enter__(self) -> None:
        if not self._outlives_fork and self._forked():
            self._refuse()
        if not self._lock.acquire(blocking=False):
            self._refuse()

    def __exit__(self, *_: object) -> None:
        self._lock.release()

    def _forked(self) -> bool:
        return os.getpid() != self._process

    def _refuse(self) -> NoReturn:
        if self._forked():
            what = "was prepared before the process was forked, and belongs to the other process"
            advice = "prepare another one here: simulation.spec.prepare()"
            raise SharedSimulation(f"{self._name}: this simulation {what}; {advice}")
        what = "it runs in one thread at a time, and not from its own progress function"
        advice = "prepare another one for each thread: simulation.spec.prepare()"
        raise SharedSimulation(f"{self._name}: this simulation is in use; {what}; {advice}")
