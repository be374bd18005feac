"""Candidates on a Dask cluster.

A task costs Dask some milliseconds, so a generation goes there in few, and what is the same for all
candidates is sent to each worker once.
"""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, Future
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import replace
from importlib import import_module
from importlib.util import find_spec
from typing import Any, ParamSpec, TypeVar

from stickslip.fmi.messages import installing
from stickslip.ga.errors import SettingsError, WorkersLost
from stickslip.ga.execution.evaluation import Evaluate, Packed

_log = logging.getLogger(__name__)
P = ParamSpec("P")
T = TypeVar("T")

WITHOUT_WORKERS = 60.0  # how long a scheduler that has no workers is waited for [s]
LOOK = 1.0  # how often the workers of a scheduler are counted while it is watched [s]
ANSWER = 10.0  # how long a scheduler may take to say how many workers it has [s]


class DaskWorkers(Executor):
    """The workers of a Dask client; a generation goes there in as many tasks as they have threads.

    What is sent first is done first; by itself Dask orders what comes within a tenth of a second by
    name.
    """

    def __init__(self, client: Any, watch: _Watch) -> None:
        self._client = client
        self._executor = client.get_executor(pure=False)
        self._watch = watch
        self._turn = 0
        self._sent: set[str] = set()

    @property
    def parts(self) -> int:
        """Into how many tasks a generation is divided: as many as the workers have threads."""
        return max(1, self._watch.threads)

    def submit_all(self, fn: Callable[..., T], calls: Sequence[Sequence[Any]]) -> list[Any]:
        """Run a function with several lists of arguments, sent in one message."""
        self._turn += 1
        how = {"pure": False, "priority": -self._turn}
        return list(self._client.map(fn, *zip(*calls, strict=True), **how))

    def submit(self, fn: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        """Run a function on one of the workers."""
        self._turn += 1
        future: Future[T] = self._executor.submit(fn, *args, priority=-self._turn, **kwargs)
        return future

    def packed(self, evaluate: Evaluate) -> Packed:
        """Send a cost, even one of a notebook, to all workers that there are and will be."""
        packed = Packed.of(evaluate)
        if packed.name not in self._sent:
            self._client.register_plugin(_keeping(packed), packed.name)
            self._sent.add(packed.name)
        return replace(packed, content=None)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Let go of the workers, which go on without us."""
        del cancel_futures
        if self._client.status != "running":
            return
        self._executor.shutdown(wait)
        for name in self._sent:
            self._client.unregister_worker_plugin(name)


def _keeping(packed: Packed) -> Any:
    """Return what Dask calls in each of its workers."""

    class Keeping(import_module("distributed").WorkerPlugin):  # type: ignore[misc]
        def setup(self, worker: object) -> None:
            del worker
            packed.keep()

        def teardown(self, worker: object) -> None:
            del worker
            packed.forget()

    return Keeping()


@contextmanager
def cluster(address: str) -> Iterator[DaskWorkers]:
    """Open the workers of a running scheduler; see `ga.executor`."""
    if find_spec("distributed") is None:
        raise SettingsError(
            f"workers {address!r} need the package distributed; {installing('dask')}"
        )
    distributed: Any = import_module("distributed")
    with ExitStack() as stack:
        stack.enter_context(_silenced())
        _require_reachable(address)
        client = stack.enter_context(distributed.Client(address))
        # What waits for a lost connection is cancelled already.
        client._timeout = LOOK  # noqa: SLF001
        watch = _Watch(client, address)
        stack.callback(watch.ended.set)
        try:
            yield stack.enter_context(DaskWorkers(client, watch))
        except Exception:  # what Dask raises once it has no scheduler
            if client.status == "running":
                raise
            raise WorkersLost(watch.reason) from None


@contextmanager
def _silenced() -> Iterator[None]:
    """Keep Dask from logging in lines of its own what becomes one error of ours."""
    loggers = [
        logging.getLogger(name)
        for name in logging.root.manager.loggerDict
        if name.split(".")[0] in ("asyncio", "distributed", "tornado")
    ]
    levels = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        for logger, level in zip(loggers, levels, strict=True):
            logger.setLevel(level)


class _Watch:
    """Counts the threads of a client's workers, and closes it without any, or an answer.

    Closing it cancels all tasks. ``ended`` is to be set at the end.
    """

    def __init__(self, client: Any, where: str) -> None:
        self.ended = threading.Event()
        self.reason = f"the connection to the Dask scheduler at {where} is lost"
        self.threads = 0
        self._client, self._where = client, where
        self._missing = 0.0
        self._look()
        threading.Thread(target=self._run, daemon=True).start()

    def _run(self) -> None:
        while not self.ended.wait(LOOK) and self._client.status == "running":
            with suppress(Exception):  # the scheduler is gone, which is noticed where it is used
                self._look()

    def _look(self) -> None:
        try:
            self.threads = sum(self._client.ncores(callback_timeout=ANSWER).values())
        except TimeoutError:
            self._close(f"has not answered for {ANSWER:g} s")
            return
        if self.threads:
            self._missing = 0.0
            return
        if not self._missing:
            _log.warning(
                "the Dask scheduler at %s has no workers; waiting up to %g s for one",
                *(self._where, WITHOUT_WORKERS),
            )
        self._missing += LOOK
        if self._missing > WITHOUT_WORKERS:
            self._close(
                f"had no workers for {WITHOUT_WORKERS:g} s;"
                f" start some, as by: dask worker {self._where}"
            )

    def _close(self, why: str) -> None:
        self.reason = f"the Dask scheduler at {self._where} {why}"
        self._client.close(timeout=LOOK)


def _require_reachable(address: str) -> None:
    """Raise SettingsError unless a scheduler answers.

    A Client also raises, but one that fails is closed by the garbage collector, whose thread
    may then wait ten seconds for the lock with which the next Client starts that thread.
    """
    distributed: Any = import_module("distributed")

    async def identity() -> dict[str, Any]:
        secrets = distributed.Security().get_connection_args("client")
        async with distributed.rpc(address, connection_args=secrets) as peer:
            found: dict[str, Any] = await peer.identity()
            return found

    limit = import_module("dask.utils").parse_timedelta(
        import_module("dask").config.get("distributed.comm.timeouts.connect")
    )
    loop = import_module("distributed.utils").LoopRunner(asynchronous=False)
    try:
        peer = loop.run_sync(identity, callback_timeout=limit)
        fault = "" if "workers" in peer else f"there is a {peer.get('type')}"
    except TimeoutError:  # with a message or without
        fault = f"timed out after {limit:g} s"
    except (OSError, ValueError, TypeError) as error:  # Dask's errors for an invalid address
        fault = str(error)
    if fault:
        advice = "expected the address of one that runs, such as tcp://10.0.0.1:8786"
        raise SettingsError(f"no Dask scheduler at {address!r} ({fault}); {advice}")
