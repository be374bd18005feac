"""Jobs on an executor: each is done once, whatever becomes of workers."""

import os
import threading
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing import parent_process
from typing import TypeVar

from threadpoolctl import threadpool_limits

from stickslip import ga
from stickslip.errors import StickslipError, name_settings, settings_style, with_settings
from stickslip.fmi.process import Threads, cancel_all, interrupted_by, interruptible, wait_first
from stickslip.ga.execution.evaluation import ALONE, DIED, received


@dataclass(frozen=True)
class Execution:
    """Where and how safely jobs run; none of it changes a result."""

    workers: int = 1  # jobs side by side
    # ``threads``, ``processes`` or the address of a Dask scheduler, see ``ga.executor``
    where: str = "threads"
    resume: bool = False  # go on from the results that an interrupted run has kept


def processors() -> int:
    """Return how many processors this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def stopped(stop: KeyboardInterrupt | ga.WorkersLost, kept: str) -> BaseException:
    """Return the same error, which also says what is kept and how to go on."""
    kept = with_settings(f"{kept}; continue with <resume>")
    if isinstance(stop, ga.WorkersLost):
        return ga.WorkersLost(f"{stop}; {kept}")
    return KeyboardInterrupt(f"interrupted; {kept}")


Item = TypeVar("Item")
OnStage = Callable[[str], object]


@dataclass(frozen=True)
class Outcome:
    """What became of an item; plain data, so that it travels."""

    learned: str = ""  # what was found, as text in JSON; empty when the job failed
    reason: str = ""  # why it failed; else empty


Job = Callable[..., Outcome]  # works on one item, as ``learn_drive`` on a drive; is picklable


class _Stop(StickslipError):
    """Unwinds a job in a thread after Ctrl-C."""


def _worded(style: str, job: Job, *given: object) -> Outcome:
    """Do a job whose messages are those of a command, a page or Python, on whatever machine."""
    name_settings(style)
    return job(*given)


def run_jobs(
    job: Job,
    items: Sequence[Item],
    seed: int,
    # see ``ga.executor``
    where: str,
    workers: int,
    on_done: Callable[[Item, Outcome], object],  # called in the caller's thread
) -> None:
    """Run a job for each item and hand over the outcomes as they come.

    A process that dies takes down all that were running; these are then tried alone, one after the
    other, so that the one that kills is known and the others have their result.

    Raises KeyboardInterrupt at Ctrl-C, when all jobs have ended, or WorkersLost when the cluster is
    gone.
    """
    with threadpool_limits(limits=1, user_api="blas"), ga.executor(where, workers) as executor:
        if executor is None:
            for item in items:
                on_done(item, job(item, seed))
            return
        stop = threading.Event()

        def check(_: str) -> None:
            if stop.is_set():
                raise _Stop("interrupted")

        further = (check,) if isinstance(executor, Threads) else ()

        def at_once() -> int:
            """Return two for each thread of a cluster, whose workers may become more or fewer."""
            return 2 * getattr(executor, "parts", 0) or workers

        def submit(item: Item) -> Future[Outcome]:
            return executor.submit(_worded, settings_style(), job, item, seed, *further)

        try:
            suspects = _together(submit, items, at_once, on_done)
            for item in suspects:
                on_done(item, _alone(submit, item))
        finally:
            stop.set()


@contextmanager
def ended_by_signals() -> Iterator[None]:
    """In a process that was made for such jobs, let signals end it once its folders are gone."""
    if parent_process() is None or threading.current_thread() is not threading.main_thread():
        yield
        return
    with interruptible():
        try:
            yield
        except KeyboardInterrupt:
            os._exit(128 + (interrupted_by() or 0))


def _together(
    submit: Callable[[Item], Future[Outcome]],
    items: Sequence[Item],
    at_once: Callable[[], int],
    on_done: Callable[[Item, Outcome], object],
) -> list[Item]:
    """Run as many jobs side by side as there are workers; return those whose worker died."""
    waiting, running, suspects = deque(items), dict[Future[Outcome], Item](), list[Item]()
    try:
        while waiting or running:
            while waiting and len(running) < at_once():
                item = waiting.popleft()
                running[submit(item)] = item
            for future in wait_first(running):
                item, outcome = running.pop(future), received(future)
                if outcome is None:
                    suspects.append(item)
                else:
                    on_done(item, outcome)
    finally:
        cancel_all(running)
    return suspects


def _alone(submit: Callable[[Item], Future[Outcome]], item: Item) -> Outcome:
    for _ in range(ALONE):
        future = submit(item)
        try:
            outcome = received(future)
        finally:
            cancel_all([future])
        if outcome is not None:
            return outcome
    return Outcome(reason=DIED)
