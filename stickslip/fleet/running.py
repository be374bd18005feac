"""Jobs on an executor: each is done once, whatever becomes of workers."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import CancelledError, Future

from threadpoolctl import threadpool_limits

from stickslip import ga
from stickslip.errors import StickslipError
from stickslip.fleet.job import OnStage, Outcome
from stickslip.fleet.table import Drive
from stickslip.fmi.process import Threads, cancel_all, wait_first
from stickslip.ga.execution.evaluation import received

ALONE = 2
"""How often a drive whose worker died is tried alone."""
DIED = "the worker process that learned it died"

Job = Callable[..., Outcome]
"""Learns one drive, as ``learn_drive`` does; must be picklable."""


class _Stop(StickslipError):
    """Unwinds a job in a thread after Ctrl-C."""


def run_jobs(
    job: Job,
    drives: Sequence[Drive],
    seed: int,
    where: str,
    workers: int,
    on_done: Callable[[Drive, Outcome], object],
) -> None:
    """Run a job for each drive and hand over the outcomes as they come.

    A process that dies takes down all that were running; these are then tried alone, one after the
    other, so that the one that kills is known and the others have their result.

    Parameters
    ----------
    where, workers : see ``ga.executor``
    on_done : called in the caller's thread

    Raises
    ------
    KeyboardInterrupt
        At Ctrl-C, when all jobs have ended.
    StickslipError
        When the cluster is gone.
    """
    with threadpool_limits(limits=1, user_api="blas"), ga.executor(where, workers) as executor:
        if executor is None:
            for drive in drives:
                on_done(drive, job(drive, seed))
            return
        stop = threading.Event()
        further = (_stopper(stop),) if isinstance(executor, Threads) else ()
        at_once = len(drives) if hasattr(executor, "parts") else workers

        def submit(drive: Drive) -> Future[Outcome]:
            return executor.submit(job, drive, seed, *further)

        try:
            suspects = _together(submit, drives, at_once, on_done)
            for drive in suspects:
                on_done(drive, _alone(submit, drive))
        except CancelledError:
            raise StickslipError(
                f"the workers at {where} are gone; continue with --resume when they are back"
            ) from None
        finally:
            stop.set()


def _together(
    submit: Callable[[Drive], Future[Outcome]],
    drives: Sequence[Drive],
    at_once: int,
    on_done: Callable[[Drive, Outcome], object],
) -> list[Drive]:
    """Run as many jobs side by side as there are workers; return those whose worker died."""
    waiting, running, suspects = deque(drives), dict[Future[Outcome], Drive](), list[Drive]()
    try:
        while waiting or running:
            while waiting and len(running) < at_once:
                drive = waiting.popleft()
                running[submit(drive)] = drive
            for future in wait_first(running):
                drive, outcome = running.pop(future), received(future)
                if outcome is None:
                    suspects.append(drive)
                else:
                    on_done(drive, outcome)
    finally:
        cancel_all(running)
    return suspects


def _alone(submit: Callable[[Drive], Future[Outcome]], drive: Drive) -> Outcome:
    for _ in range(ALONE):
        future = submit(drive)
        try:
            outcome = received(future)
        finally:
            cancel_all([future])
        if outcome is not None:
            return outcome
    return Outcome(reason=DIED)


def _stopper(stop: threading.Event) -> OnStage:
    def check(_: str) -> None:
        if stop.is_set():
            raise _Stop("interrupted")

    return check
