"""Costs of candidates, wherever they are evaluated, and what becomes of those that fail."""

from __future__ import annotations

import hashlib
import io
import pickle
import sys
from collections.abc import Callable
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future
from dataclasses import dataclass
from functools import cache, cached_property, partial
from typing import Any, TypeVar

import cloudpickle
import numpy as np

from stickslip.fmi.process import cancel_all, result_of
from stickslip.ga.errors import CandidateFailed, SettingsError
from stickslip.ga.problem.problem import Array

T = TypeVar("T")
Evaluate = Callable[[Array], Any]
"""values (k,), in the genes' units -> cost, 0 .. inf, or a dictionary; raises CandidateFailed.

An attribute ``fatal``, a tuple of exceptions, names those that no candidate is to blame for. A
method ``together`` begins rows (n, k) at once; it returns functions that go on with each."""

Outcome = tuple[Any, str]  # cost, and why it is infinite or an empty text
ALONE = 2  # how often a candidate whose worker died is tried alone
DIED = "the worker process that ran it died"
_UNPICKLABLE = pickle.PicklingError, AttributeError, TypeError
_FATAL: tuple[type[Exception], ...] = (OSError, ImportError, MemoryError, CancelledError)
"""The machine's fault, not the candidate's: the run ends, and can be resumed."""


class Evaluator:
    """Evaluates generation after generation, in the caller's own thread or by workers.

    Workers that have nothing to do begin with what is known of the next generation, so none waits
    for the slowest. What is learned does not depend on it. Rows go to workers in so many ``parts``,
    by default each in one of its own, or as the executor likes.
    """

    def __init__(
        self, evaluate: Evaluate, executor: Executor | None, parts: int | None = None
    ) -> None:
        packed = getattr(executor, "packed", None)
        self._evaluate: Evaluate | Packed = packed(evaluate) if packed else evaluate
        self._executor, self._parts = executor, parts
        self._begun: dict[bytes, _Place] = {}
        self._last: list[_Place | None] = []

    def outcomes(self, population: Array, ahead: Array, *, begins: bool) -> list[Outcome]:
        """Return cost and reason of every row (n, k), in order, whatever the executor.

        Rows ``ahead`` (m, k) of the next population are begun. Candidates whose worker died are
        tried alone, so that the one that kills its worker is known. What the start raises, the
        first row where ``begins``, is not a candidate's fault.
        """
        if self._executor is None:
            return evaluate_rows(self._evaluate, population, begins)
        places = [self._begun.pop(row.tobytes(), None) for row in population]
        self.dismiss()
        missing = [index for index, place in enumerate(places) if place is None]
        sent = self._send(population[missing], self._executor, begins and 0 in missing)
        for index, place in zip(missing, sent, strict=True):
            places[index] = place
        try:
            begun = self._send(ahead, self._executor, begins=False)
            self._begun = {row.tobytes(): place for row, place in zip(ahead, begun, strict=True)}
            outcomes = [place.outcome() for place in places if place is not None]
        except BaseException:
            cancel_all(place.task.future for place in sent)
            raise
        self._last = places  # Dask would release these first, and send the next 10 ms later
        return [
            self._alone(row, self._executor, begins and index == 0) if outcome is None else outcome
            for index, (row, outcome) in enumerate(zip(population, outcomes, strict=True))
        ]

    def dismiss(self) -> None:
        """Cancel what was begun and is no longer wanted."""
        cancel_all(task.future for task in {place.task: None for place in self._begun.values()})
        self._begun = {}

    def _send(self, rows: Array, executor: Executor, begins: bool) -> list[_Place]:
        """Give rows (n, k) to the workers."""
        if not len(rows):
            return []
        wanted = getattr(executor, "parts", self._parts or len(rows))
        parts = np.array_split(rows, min(wanted, len(rows)))
        calls = [(self._evaluate, part, begins and not n) for n, part in enumerate(parts)]
        if together := getattr(executor, "submit_all", None):
            futures = together(evaluate_rows, calls)
        else:
            futures = [executor.submit(evaluate_rows, *call) for call in calls]
        return [
            _Place(task, index)
            for task, part in zip(map(_Task, futures), parts, strict=True)
            for index in range(len(part))
        ]

    def _alone(self, row: Array, executor: Executor, begins: bool) -> Outcome:
        for _ in range(ALONE):
            outcome = self._send(row[np.newaxis], executor, begins)[0].outcome()
            if outcome is not None:
                return outcome
        return float("inf"), DIED


class _Task:
    """Some candidates at a worker."""

    def __init__(self, future: Any) -> None:
        self.future = future

    @cached_property
    def outcomes(self) -> list[Outcome] | None:
        """What the worker sends, as soon as it does; None if it died."""
        outcomes: list[Outcome] | None = received(self.future)
        return outcomes


def received(future: Future[T]) -> T | None:
    """Wait for what a worker sends, and return it; None if the worker died."""
    try:  # futures of Dask are not those of concurrent.futures
        return result_of(future) if isinstance(future, Future) else future.result()
    except BrokenExecutor:
        return None
    except Raised as raised:
        raise unpickled(raised.content) from raised
    except Exception as error:
        if isinstance(error, _UNPICKLABLE) and "pickle" in str(error):
            raise _unsent(error) from None
        if type(error).__name__ == "KilledWorker":  # of distributed, which need not be there
            return None
        raise


def pickled(thing: object) -> bytes:
    """Return something as bytes for another process, functions of a notebook or script whole."""
    stream = io.BytesIO()
    try:
        _Pickler(stream, pickle.HIGHEST_PROTOCOL).dump(thing)
    except _UNPICKLABLE as error:
        raise _unsent(error) from None
    return stream.getvalue()


class _Pickler(cloudpickle.Pickler):  # type: ignore[misc]
    """Pickles by value what is of the main module, or of another that cannot be imported."""

    def reducer_override(self, thing: Any) -> Any:
        _carry(getattr(thing, "__module__", None) or "builtins")
        return super().reducer_override(thing)


@cache
def _carry(name: str) -> None:
    """Have a module pickled by value if it came from elsewhere than the path of modules."""
    found = (finder.find_spec(name.partition(".")[0], None) for finder in sys.meta_path)
    if name in sys.modules and not any(found):
        cloudpickle.register_pickle_by_value(sys.modules[name])


def unpickled(content: bytes) -> Any:
    """Return what `pickled` has made bytes of, in the process that received it."""
    try:
        return pickle.loads(content)  # noqa: S301 - of our own making
    except (ImportError, AttributeError) as error:
        raise SettingsError(
            f"a worker process cannot load the function that it was sent ({error}); define it in"
            " the script or notebook, or in a module that PYTHONPATH finds, or use threads"
        ) from None


class Raised(Exception):
    """What a function raised in another process, as bytes: its class may be of a script."""

    def __init__(self, content: bytes) -> None:
        super().__init__(content)
        self.content = content


def _unsent(error: Exception) -> SettingsError:
    return SettingsError(
        f"the function cannot be sent to another process ({error}); create what it uses within it,"
        " or use threads"
    )


@dataclass(frozen=True)
class _Place:
    """Where the outcome of a candidate will be found."""

    task: _Task
    index: int

    def outcome(self) -> Outcome | None:
        """Wait for the outcome; return None if the worker died."""
        outcomes = self.task.outcomes
        return None if outcomes is None else outcomes[self.index]


@dataclass(frozen=True)
class Packed:
    """A cost on its way to another process, where it is unpacked once and not for each task.

    Its name is a hash of the content, which is None where processes have received it by `keep`.
    """

    name: str
    content: bytes | None

    @classmethod
    def of(cls, evaluate: Evaluate) -> Packed:
        """Pickle a cost."""
        content = pickled(evaluate)
        return cls(hashlib.sha256(content).hexdigest(), content)

    def keep(self) -> None:
        """Store the content in this process, for tasks that come without."""
        if self.content is not None:
            _kept[self.name] = self.content

    def forget(self) -> None:
        """Drop what was kept."""
        _kept.pop(self.name, None)
        _unpacked.pop(self.name, None)

    def unpacked(self) -> Evaluate:
        """Return the cost, which stays for the next task."""
        if self.name not in _unpacked:
            content = self.content or _kept[self.name]
            _unpacked.clear()
            _unpacked[self.name] = unpickled(content)
        return _unpacked[self.name]


_kept: dict[str, bytes] = {}
_unpacked: dict[str, Evaluate] = {}


def evaluate_rows(evaluate: Evaluate | Packed, rows: Array, begins: bool) -> list[Outcome]:
    """Return cost and reason of rows (n, k), one after the other; runs where the worker is."""
    if isinstance(evaluate, Packed):
        evaluate = evaluate.unpacked()
    together = getattr(evaluate, "together", None)
    calls = together(rows) if together else [partial(evaluate, row) for row in rows]
    fatal = getattr(evaluate, "fatal", ())
    return [_evaluate_one(call, fatal, begins and index == 0) for index, call in enumerate(calls)]


def _evaluate_one(
    call: Callable[[], float], fatal: tuple[type[Exception], ...], is_start: bool
) -> Outcome:
    try:
        found = call()
        return (found if isinstance(found, dict) else float(found)), ""
    except CandidateFailed as failure:
        return float("inf"), str(failure)
    except (*_FATAL, *fatal):
        raise
    except Exception as error:
        if is_start:
            raise
        return float("inf"), f"{type(error).__name__}: {error}"
