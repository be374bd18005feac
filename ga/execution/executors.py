"""Where candidates are evaluated: threads, processes, or a Dask cluster.

A worker that dies takes no result with it: its candidates are evaluated again, see
``ga/execution/evaluation.py``.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from functools import partial
from multiprocessing import get_context, parent_process
from multiprocessing.context import BaseContext
from numbers import Integral
from typing import Any, ParamSpec, TypeVar

from stickslip.fmi.process import Threads, held
from stickslip.ga.errors import SettingsError
from stickslip.ga.execution.cluster import cluster
from stickslip.ga.execution.evaluation import Evaluate, Packed, Raised, pickled, unpickled
from stickslip.ga.execution.starting import process_start

P = ParamSpec("P")
T = TypeVar("T")


@contextmanager
def executor(where: str = "threads", workers: int = 1) -> Iterator[Executor | None]:
    """Open what `learn` takes as its executor, and close it after the block.

    Parameters
    ----------
    where : ``threads`` or ``processes`` of this machine; or the address of a running Dask
        scheduler, e.g. ``tcp://10.0.0.1:8786``, whose workers must have the same packages and see
        the same files
    workers : how many; a running scheduler has its own

    Yields
    ------
    None, which means the caller's own thread, for one thread

    Raises
    ------
    SettingsError : no such place, no worker at all, no scheduler that answers at the address, or
        ``distributed`` is not installed
    WorkersLost : the connection to the scheduler is lost, it has not answered for 10 s, or it
        has had no workers for a minute
    """
    if not isinstance(workers, Integral) or workers < 1:
        raise SettingsError(f"workers must be a whole number and at least 1, got {workers!r}")
    if where == "threads":
        if workers == 1:
            yield None
            return
        with Threads(workers) as threads:
            yield threads
    elif where == "processes":
        with Processes(workers) as processes:
            yield processes
    elif "://" in where:
        with cluster(where) as dask:
            yield dask
    else:
        what = "the address of a Dask scheduler such as tcp://10.0.0.1:8786"
        raise SettingsError(f"no workers {where!r}; expected threads, processes or {what}")


class Processes(Executor):
    """A pool of processes that is replaced when one of them dies.

    Its processes leave Ctrl-C to their parent, and end with it however it ends. They get the
    functions of a notebook or script by value, and do not run it again. When its block
    fails they are ended by SIGTERM.
    """

    def __init__(self, workers: int) -> None:
        self._workers = workers
        self._others = set(multiprocessing.active_children())
        with held(), process_start():
            self._pool = self._made()

    def submit(self, fn: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        """Run a function in one of the processes.

        It is pickled here, because errors in the thread of the pool are not always caught.
        """
        call = pickled((fn, args, kwargs))
        with held(), process_start():  # a process may be started
            try:
                return self._pool.submit(_called, call)
            except BrokenProcessPool:
                self._pool.shutdown(wait=False)
                self._pool = self._made()
                return self._pool.submit(_called, call)

    def packed(self, evaluate: Evaluate) -> Packed:
        """Return a cost as a process gets it."""
        return Packed.of(evaluate)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the processes."""
        with held():
            self._pool.shutdown(wait, cancel_futures=cancel_futures)

    def __exit__(self, kind: object, error: BaseException | None, *_: object) -> None:
        """End the processes, at once where the block has failed."""
        with held():
            if error is not None:
                for process in set(multiprocessing.active_children()) - self._others:
                    process.terminate()
            self.shutdown(cancel_futures=error is not None)

    def _made(self) -> ProcessPoolExecutor:
        context: BaseContext = get_context("spawn")
        # The path of a server's socket has at most 107 bytes
        if sys.platform == "linux" and len(os.fsencode(tempfile.gettempdir())) <= 70:
            # From a server that has loaded this, once for all pools
            context = get_context("forkserver")
            context.set_forkserver_preload([__name__, "stickslip.cosim"])
        begin = partial(_depend_on_parent, dict(os.environ))
        return ProcessPoolExecutor(self._workers, mp_context=context, initializer=begin)


def _called(call: bytes) -> Any:
    function, args, kwargs = unpickled(call)
    try:
        return function(*args, **kwargs)
    except Exception as fault:
        raise Raised(pickled(fault)) from fault


def _depend_on_parent(environment: dict[str, str]) -> None:
    os.environ.clear()
    os.environ.update(environment)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
