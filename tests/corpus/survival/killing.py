"""Processes killed while they write, at every operation and at random moments."""

from __future__ import annotations

import os
import shutil
import signal
import time
from collections import Counter
from collections.abc import Callable
from itertools import count
from pathlib import Path

import numpy as np

from tests.corpus.survival.faults import die, fault
from tests.corpus.survival.sets import Files, holds, plain, write

Write = Callable[[Path], object]


def kill_at_each_operation(folder: Path, old: Files, new: Files) -> Counter[str]:
    """Kill a process before each thing that it asks of the file system while it replaces a set.

    Returns
    -------
    how often the folder held a whole set at once, and how often only after ``stickslip verify``
    """
    outcomes: Counter[str] = Counter()
    for n in count(1):
        shutil.rmtree(folder, ignore_errors=True)
        write(old, folder)
        child = os.fork()
        if not child:
            with fault(folder, die, n):
                write(new, folder)
            os._exit(0)
        _, status = os.waitpid(child, 0)
        if status == 0:
            if plain(folder) != new:
                raise RuntimeError(f"{folder}: not replaced by a process that was not killed")
            return outcomes
        if os.WTERMSIG(status) != signal.SIGKILL:
            raise RuntimeError(f"the process ended with {status}")
        outcomes[holds(folder, (old, new))] += 1
    raise AssertionError


def kill_at_random(
    folder: Path, writes: tuple[Write, Write], kills: int, seed: int = 0
) -> Counter[str]:
    """Kill processes at random moments while they replace one set by the other, and back.

    Returns
    -------
    how often the folder held the older set, the newer one, and one only after ``stickslip verify``
    """
    rng = np.random.default_rng(seed)
    sets, duration = [], 0.0
    for each in writes:
        begin = time.perf_counter()
        each(folder)
        duration = time.perf_counter() - begin
        sets.append(plain(folder))
    outcomes: Counter[str] = Counter()
    turn = 0
    while outcomes.total() < kills:
        older = plain(folder)
        turn = 1 - sets.index(older)
        child = os.fork()
        if not child:
            os.setpgid(0, 0)
            writes[turn](folder)
            os._exit(0)
        time.sleep(rng.uniform(0.0, duration))
        os.kill(child, signal.SIGKILL)
        if os.waitpid(child, 0)[1] == 0:
            continue  # it was faster
        found = holds(folder, sets)
        which = "the older" if plain(folder) == older else "the newer"
        outcomes[f"{which} set, {found}"] += 1
    return outcomes
