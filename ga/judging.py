"""Costs of candidates, wherever they are evaluated, and what becomes of those that fail."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future
from dataclasses import dataclass

import numpy as np

from ga.arrays import Array
from ga.errors import CandidateFailed

Evaluate = Callable[[Array], float]
"""values (k,), in the genes' units -> cost, 0 .. inf; raises CandidateFailed if it has none.

An attribute ``fatal``, a tuple of exceptions, names those that no candidate is to blame for."""

Outcome = tuple[float, str]
"""cost, and why it is infinite or an empty text"""

ALONE = 2
"""How often a candidate whose worker died is tried alone."""

DIED = "the worker process that ran it died"

_FATAL: tuple[type[Exception], ...] = (OSError, ImportError, MemoryError, CancelledError)
"""The machine's fault, not the candidate's: the run ends, and can be resumed."""


def judge_all(
    population: Array, evaluate: Evaluate, executor: Executor | None, *, begins: bool
) -> list[Outcome]:
    """Return cost and reason of every row, in order, whatever the executor.

    Candidates whose worker died are tried alone, one after the other. So the one that kills its
    worker is known, and the others have their cost.

    Parameters
    ----------
    population : shape (n, k)
    evaluate : cost of one candidate
    executor : where; None for the caller's own thread
    begins : whether the first row is the start. What it raises is not a candidate's fault.

    Raises
    ------
    Exception : what the start raises, or what no candidate is to blame for
    """
    if executor is None:
        return judge(evaluate, population, begins)
    packed = getattr(executor, "packed", None)
    sent: Evaluate | Packed = evaluate if packed is None else Packed(packed(evaluate))
    parts = np.array_split(
        population, min(getattr(executor, "parts", len(population)), len(population))
    )
    futures = [
        executor.submit(judge, sent, part, begins and index == 0)
        for index, part in enumerate(parts)
    ]
    try:
        judged: list[Outcome | None] = []
        for part, future in zip(parts, futures, strict=True):
            judged += _received(future) or [None] * len(part)
    finally:
        for future in futures:
            future.cancel()
    return [
        _judge_alone(sent, row, executor, begins and index == 0) if outcome is None else outcome
        for index, (row, outcome) in enumerate(zip(population, judged, strict=True))
    ]


@dataclass(frozen=True)
class Packed:
    """A cost on its way to another process, where it is unpacked once and not for each task.

    Attributes
    ----------
    content : of `pickle`; unpacking a system of FMUs takes as long as running a candidate
    """

    content: bytes

    def unpacked(self) -> Evaluate:
        """Return the cost, which stays for the next task."""
        if self.content not in _unpacked:
            _unpacked.clear()
            _unpacked[self.content] = pickle.loads(self.content)  # noqa: S301 - of our own making
        return _unpacked[self.content]


_unpacked: dict[bytes, Evaluate] = {}


def judge(evaluate: Evaluate | Packed, rows: Array, begins: bool) -> list[Outcome]:
    """Return cost and reason of rows (n, k), one after the other; runs where the worker is."""
    if isinstance(evaluate, Packed):
        evaluate = evaluate.unpacked()
    return [_judge_one(evaluate, row, begins and index == 0) for index, row in enumerate(rows)]


def _judge_one(evaluate: Evaluate, row: Array, is_start: bool) -> Outcome:
    try:
        return float(evaluate(row)), ""
    except CandidateFailed as failure:
        return float("inf"), str(failure)
    except (*_FATAL, *getattr(evaluate, "fatal", ())):
        raise
    except Exception as error:
        if is_start:
            raise
        return float("inf"), f"{type(error).__name__}: {error}"


def _judge_alone(
    evaluate: Evaluate | Packed, row: Array, executor: Executor, begins: bool
) -> Outcome:
    for _ in range(ALONE):
        future = executor.submit(judge, evaluate, row[np.newaxis], begins)
        outcomes = _received(future)
        if outcomes is not None:
            return outcomes[0]
    return float("inf"), DIED


def _received(future: Future[list[Outcome]]) -> list[Outcome] | None:
    """Return what a worker sent, or None if it died."""
    try:
        return future.result()
    except BrokenExecutor:
        return None
    except Exception as error:
        if type(error).__name__ == "KilledWorker":  # of distributed, which need not be there
            return None
        raise
