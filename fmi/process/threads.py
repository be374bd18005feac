"""Threads, and futures of any pool, whose locks no KeyboardInterrupt leaves taken."""

from collections.abc import Callable, Collection, Iterable
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from contextlib import suppress
from threading import Thread
from typing import Any, ParamSpec, TypeVar

from stickslip.fmi.process.interruption import held

P = ParamSpec("P")
T = TypeVar("T")
R = TypeVar("R")
LOOK = 0.1
"""How often (s) a thread that waits looks for signals."""
PATIENCE = 5.0
"""How long (s) cancelling may take."""


class Threads(ThreadPoolExecutor):
    """A pool of threads. When its block fails, what has not begun is cancelled."""

    def submit(self, fn: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        """Run a function in one of the threads."""
        with held():
            return super().submit(fn, *args, **kwargs)

    def each(self, function: Callable[[T], R], items: Iterable[T]) -> list[R]:
        """Apply a function to every item, side by side; return the results in order."""
        futures: list[Future[R]] = []
        try:
            with held():
                futures += [self.submit(function, item) for item in items]
            return [result_of(future) for future in futures]
        except BaseException:
            cancel_all(futures)
            raise

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the threads when they have done what they are at."""
        with held():
            super().shutdown(wait, cancel_futures=cancel_futures)

    def __exit__(self, kind: object, error: BaseException | None, *_: object) -> None:
        """End the threads."""
        self.shutdown(cancel_futures=error is not None)


def result_of(future: Future[T]) -> T:
    """Wait for a future and return its result, or raise what it raised."""
    while True:
        with held():
            if wait([future], LOOK).done:
                return future.result()


def wait_first(futures: Collection[Future[T]]) -> set[Future[T]]:
    """Wait until one of some futures is done; return those that are."""
    while True:
        with held():
            done = wait(futures, LOOK, FIRST_COMPLETED).done
        if done or not futures:
            return done


def cancel_all(futures: Iterable[Future[Any]]) -> None:
    """Cancel the futures that have not begun; of Dask, as long as its scheduler answers."""
    listed = list(futures)

    def cancel() -> None:
        for future in listed:
            with suppress(Exception):
                future.cancel()

    with held():  # Dask waits without end for a scheduler that is lost
        thread = Thread(target=cancel, daemon=True)
        thread.start()
        thread.join(PATIENCE)
