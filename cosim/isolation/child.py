"""The child process: prepares a simulation and runs it on request."""

import ctypes
import json
import logging
import os
import pickle
import select
import signal
import sys
import threading
from collections.abc import Callable, Sequence
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from typing import Any

from stickslip.cosim import kernel
from stickslip.cosim.isolation.messages import LOST, Shared, receive, send
from stickslip.cosim.run import resets
from stickslip.cosim.run.result import Result
from stickslip.cosim.run.simulation import Simulation
from stickslip.cosim.signals.signals import Array
from stickslip.fmi.process import sandbox
from stickslip.fmi.process.child import limit


def main(name: str, size: int, token: bytes) -> None:
    """Serve the parent at the other ends of standard input and output until it is gone."""
    requests, replies = _take_pipes()
    shared = Shared.open(name, size)
    own = os.getpid()

    def reply(**what: object) -> None:
        if os.getpid() != own:  # an FMU has forked, and this is the other one
            os._exit(0)
        try:
            send(replies, token, json.dumps(what).encode())
        except OSError:  # an FMU has closed it
            os._exit(LOST)

    order = _receive(requests, token)
    kernel.use_mark(shared.mark, Path(order["kernel"]))
    limit(order["memory"])
    resets.lines.update(order["resets"])
    for module in order["modules"]:
        with suppress(ImportError, OSError):
            import_module(module)
    if order["sandbox"]:
        sandbox.enter(**order["sandbox"])
    threading.Thread(target=_watch, args=(requests,), daemon=True).start()
    reply()
    served = _Served(order["specification"], shared, reply, lambda: _receive(requests, token))
    what = ""
    while what != "close":
        what, arguments = served.receive()
        served.do(what, arguments)
    if sys.platform != "win32":
        ctypes.CDLL(None).exit(0)  # libraries end as in any process, and keep what they still use
    os._exit(0)


_LINES = 100  # of the log, for each answer
_FEW = 3  # points in time that are sent one by one


class _Kept(logging.Handler):
    def __init__(self) -> None:
        super().__init__()
        self._lines: list[tuple[int, str]] = []

    def emit(self, record: logging.LogRecord) -> None:
        if len(self._lines) < _LINES:
            self._lines.append((record.levelno, record.getMessage()[:2000]))

    def take(self) -> list[tuple[int, str]]:
        lines, self._lines = self._lines, []
        return lines


class _Served:
    def __init__(
        self,
        specification: Any,
        shared: Shared,
        reply: Callable[..., None],
        receive: Callable[[], Any],
    ) -> None:
        self._specification, self._shared, self._reply = specification, shared, reply
        self.receive = receive
        self._simulation: Simulation | None = None
        self._logged = _Kept()
        logging.getLogger("stickslip.cosim").addHandler(self._logged)

    def do(self, what: str, arguments: dict[str, Any]) -> None:
        """Carry out a request of the parent and reply with the result or the error."""
        kernel.note_call("", "")
        try:
            answer = getattr(self, what)(**arguments)
        except MemoryError:
            answer = {"error": "MemoryError", "message": ""}
        except Exception as error:  # noqa: BLE001 - raised again where it was asked for
            answer = {"error": type(error).__name__, "message": str(error)}
            if isinstance(error, OSError) and error.filename:
                answer["file"] = [error.errno, error.strerror, str(error.filename)]
        known = {str(binary): line for binary, line in resets.lines.items()}
        self._reply(**answer, logged=self._logged.take(), resets=known)

    def prepare(self) -> dict[str, object]:
        self._simulation = Simulation(self._specification, self._room)
        self._simulation.before_repetition(lambda: self._reply(repeats=True))
        return {}

    def call(self, function: Callable[..., object], arguments: Sequence[Any]) -> dict[str, object]:
        """Call a function of ours, which takes the specification before its arguments."""
        return {"result": function(self._specification, *arguments)}

    def ask(self, method: str, arguments: Sequence[Any]) -> dict[str, object]:
        """Call a method of the simulation."""
        return {"result": getattr(self._prepared, method)(*arguments)}

    def save(self, path: str) -> dict[str, object]:
        self._prepared.save(path)
        return {}

    def close(self) -> dict[str, object]:
        if self._simulation:
            self._simulation.close()
        kernel.note_call("", "unloading its binary")
        return {}

    @property
    def _prepared(self) -> Simulation:
        assert self._simulation is not None  # noqa: S101 - the parent begins with prepare
        return self._simulation

    def _room(self, shape: tuple[int, int]) -> Array:
        return self._shared.numbers[: shape[0] * shape[1]].reshape(shape)

    def run(self, how: str, progress: bool, parts: bool, **arguments: Any) -> dict[str, object]:
        simulation = self._prepared
        report = (lambda t: self._reply(progress=t)) if progress else None
        hand = self._hand if parts else None
        result = getattr(simulation, how)(**arguments, progress=report, out=hand)
        return self._put(result) | {"effort": dict(simulation.effort)}

    def _hand(self, part: Result) -> None:
        """Let the parent take a part of the result before the next one comes into its place."""
        self._reply(part=self._put(part))
        self.receive()

    def _put(self, result: Result) -> dict[str, object]:
        """Put a result where the parent finds it; return what it needs to know."""
        place = self._room(result.rows.shape)
        if place.ctypes.data != result.rows.ctypes.data or not result.rows.flags.c_contiguous:
            place[:] = result.rows.copy()
        return {
            "shape": result.rows.shape,
            "points": result.points,
            "times": (result.time if len(result.time) <= _FEW else result.time[[0, -1]]).tolist(),
            "stopped": result.stopped,
            "texts": result.changes,
        }


def _take_pipes() -> tuple[int, int]:
    """Return duplicates of standard input and output; redirect what FMUs print to stderr."""
    pipes = os.dup(0), os.dup(1)
    nothing = os.open(os.devnull, os.O_RDWR)
    os.dup2(nothing, 0)
    os.dup2(2, 1)
    os.close(nothing)
    return pipes


def _receive(requests: int, token: bytes) -> Any:
    try:
        request = receive(requests, token)
    except OSError:  # an FMU has closed the pipe or read from it, or the parent is gone
        os._exit(LOST)
    return pickle.loads(request)  # noqa: S301 - our parent's


def _watch(requests: int) -> None:
    """End all processes of the group when the parent is gone, even while an FMU is busy."""
    if sys.platform != "win32":
        poll = select.poll()
        poll.register(requests, 0)  # still reports that the other end is closed
        poll.poll()
        os.killpg(0, signal.SIGKILL)
