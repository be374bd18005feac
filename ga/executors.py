"""Where candidates are evaluated: threads, processes, or a Dask cluster.

A worker that dies takes no result with it: its candidates are evaluated again, see
``ga/judging.py``.
"""

from __future__ import annotations

import logging
import math
import os
import pickle
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import ExitStack, contextmanager
from importlib import import_module
from importlib.util import find_spec
from multiprocessing import get_context, parent_process, resource_tracker
from typing import Any, ParamSpec, TypeVar

from ga.errors import SettingsError

P = ParamSpec("P")
T = TypeVar("T")

PARTS = 1
"""Tasks for each Dask worker in a generation; a task costs it a millisecond or two."""


RECOUNT = 5.0
"""How long the number of Dask workers is believed [s]."""


@contextmanager
def executor(where: str = "threads", workers: int = 1) -> Iterator[Executor | None]:
    """Open what `learn` takes as its executor, and close it after the block.

    Parameters
    ----------
    where : ``threads`` or ``processes`` of this machine; ``local``, a Dask cluster that is started
        on it; or the address of a running Dask scheduler, e.g. ``tcp://10.0.0.1:8786``, whose
        workers must have the same packages and see the same files
    workers : how many; a running scheduler has its own

    Yields
    ------
    None, which means the caller's own thread, for one thread

    Raises
    ------
    SettingsError : no such place, no worker at all, or ``distributed`` is not installed
    OSError : no scheduler answers at the address
    """
    if workers < 1:
        raise SettingsError(f"workers must be at least 1, got {workers}")
    if where == "threads":
        if workers == 1:
            yield None
            return
        with ThreadPoolExecutor(workers) as threads:
            yield threads
    elif where == "processes":
        with Processes(workers) as processes:
            yield processes
    elif where == "local" or "://" in where:
        with _dask(where, workers) as cluster:
            yield cluster
    else:
        raise SettingsError(
            f"no workers {where!r}; expected threads, processes, local or the address of a Dask "
            "scheduler such as tcp://10.0.0.1:8786"
        )


class Processes(Executor):
    """A pool of processes that is made anew when one of them dies.

    Its processes leave Ctrl-C to their parent, and end with it however it ends.
    """

    def __init__(self, workers: int) -> None:
        self._workers = workers
        self._pool = self._made()

    def submit(self, fn: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        """Run a function in one of the processes."""
        with _without_interrupts():  # a process may be started
            try:
                return self._pool.submit(fn, *args, **kwargs)
            except BrokenProcessPool:
                self._pool.shutdown(wait=False)
                self._pool = self._made()
                return self._pool.submit(fn, *args, **kwargs)

    def packed(self, function: object) -> bytes:
        """Return a function as bytes that a process unpickles."""
        return pickle.dumps(function)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the processes."""
        self._pool.shutdown(wait, cancel_futures=cancel_futures)

    def _made(self) -> ProcessPoolExecutor:
        return ProcessPoolExecutor(
            self._workers, mp_context=get_context("spawn"), initializer=_depend_on_parent
        )


@contextmanager
def _without_interrupts() -> Iterator[None]:
    """Put off Ctrl-C; a process that is started meanwhile will never see it."""
    if sys.platform == "win32":
        yield
        return
    resource_tracker.ensure_running()  # which would let Ctrl-C in again when it is started
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _depend_on_parent() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


class DaskWorkers(Executor):
    """The workers of a Dask client; candidates go to them in parts, a few for each worker."""

    def __init__(self, client: Any) -> None:
        self._client = client
        self._executor = client.get_executor(pure=False)
        self._counted, self._workers = -math.inf, 1

    @property
    def parts(self) -> int:
        """Into how many tasks a generation is divided; workers are counted again now and then."""
        if time.monotonic() > self._counted + RECOUNT:
            self._counted, self._workers = time.monotonic(), len(self._client.ncores())
        return max(1, PARTS * self._workers)

    def submit(self, fn: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        """Run a function on one of the workers."""
        future: Future[T] = self._executor.submit(fn, *args, **kwargs)
        return future

    def packed(self, function: object) -> bytes:
        """Return a function as bytes that a worker unpickles, even one of a notebook."""
        content: bytes = import_module("cloudpickle").dumps(function)
        return content

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Let go of the workers, which go on without us."""
        del cancel_futures
        self._executor.shutdown(wait)


@contextmanager
def _dask(where: str, workers: int) -> Iterator[DaskWorkers]:
    if find_spec("distributed") is None:
        raise SettingsError(
            f"workers {where!r} need the package distributed; pip install stickslip[dask]"
        )
    distributed: Any = import_module("distributed")
    with ExitStack() as stack:
        scheduler = where
        if where == "local":
            with _without_interrupts():
                cluster = distributed.LocalCluster(
                    n_workers=workers,
                    threads_per_worker=1,
                    processes=True,
                    dashboard_address=":0",
                    silence_logs=logging.ERROR,
                )
            scheduler = stack.enter_context(cluster)
        client = stack.enter_context(distributed.Client(scheduler))
        yield stack.enter_context(DaskWorkers(client))
