"""The child process from the parent's side: started, asked, watched, ended."""

from __future__ import annotations

import math
import os
import pickle
import secrets
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from queue import Empty
from typing import IO, NoReturn

from stickslip.cosim import kernel
from stickslip.cosim.errors import FmuCrashed
from stickslip.cosim.isolation.answers import NONSENSE, TOKEN_SIZE, Answers, Reply, ThreadedAnswers
from stickslip.cosim.isolation.parcel import pack
from stickslip.cosim.isolation.shared import Shared
from stickslip.cosim.isolation.verdict import crashed, ending
from stickslip.cosim.run import resets
from stickslip.cosim.system.isolation import Isolation
from stickslip.cosim.system.system import Specification
from stickslip.fmi.process import check_interruption, held

MOST_TEXT = 2**24  # bytes that FMUs may print in the life of a child
_LOOK = 0.05  # s between two looks at the mark
_GAP = 1.0  # s between two looks, beyond which this process was suspended
_START_UP = 60.0  # s that Python may take to start
_GRACE = 2.0  # s that a child has to end
_RUSAGE = 1e6 if sys.platform == "darwin" else 1e6 / 1024  # units of memory to the MB
_START = Path(__file__).with_name("start.py")


class _Clock:
    """Measures time; while this process is suspended, it counts ``_GAP`` at most."""

    def __init__(self) -> None:
        self._passed, self._last = 0.0, time.monotonic()

    def passed(self) -> float:
        """Return the time (s) since it began; must be called more often than every ``_GAP``."""
        now = time.monotonic()
        self._passed += min(now - self._last, _GAP)
        self._last = now
        return self._passed


class Process:
    """A child that prepares a simulation and runs it.

    Parameters
    ----------
    order : names of the components as they step
    n : numbers that a result may have

    Attributes
    ----------
    repeats : whether it repeats the run that it was asked for, to see what a reset does
    runs : that it has done
    """

    def __init__(
        self, specification: Specification, limits: Isolation, order: Sequence[str], n: int
    ) -> None:
        self._system, self._order, self._limits = specification.system, order, limits
        self._parent = os.getpid()
        self._printed, self._tail = 0, b""
        self.repeats, self.runs = False, 0
        self._peak = self._inherited = 0.0  # MB
        library = kernel.built(marked=True)
        parcel = pack(
            specification, kernel=str(library), memory=limits.memory, resets=dict(resets.lines)
        )
        self.shared = shared = Shared.make(n)
        token = secrets.token_bytes(TOKEN_SIZE)
        modules = os.pathsep.join(path for path in sys.path if path)
        try:
            with held():
                self._process = subprocess.Popen(
                    [sys.executable, "-P", str(_START), shared.name, str(shared.size), token.hex()],
                    stdin=subprocess.PIPE,
                    stdout=subprocess.PIPE,
                    stderr=subprocess.PIPE,
                    bufsize=0,
                    pass_fds=shared.files,
                    start_new_session=True,
                    env=os.environ | {"PYTHONPATH": modules, "OPENBLAS_NUM_THREADS": "1"},
                )
        finally:
            shared.close_files()
        pipes = self._process.stdin, self._process.stdout, self._process.stderr
        requests, replies, printed = (pipe for pipe in pipes if pipe)
        kind = ThreadedAnswers if sys.platform == "win32" else Answers
        self._answers = kind(requests.fileno(), replies.fileno(), token)
        self._drain = threading.Thread(target=self._take, args=(printed,), daemon=True)
        self._drain.start()
        self._clock = _Clock()
        self._answers.send(parcel)
        self._wait(_START_UP, math.inf)

    def ask(
        self,
        what: str,
        arguments: Mapping[str, object],
        progress: Callable[[float], object] | None = None,
        slack: float = 0.0,
    ) -> Reply:
        """Send a request to the child and return its answer.

        Parameters
        ----------
        progress : is called with the time reached (s) now and then
        slack : s that a step may take beyond the patience for it

        Raises
        ------
        FmuCrashed
            When the child died or had to be ended.
        """
        self._clock, self.repeats = _Clock(), False
        self._answers.send(pickle.dumps((what, arguments), pickle.HIGHEST_PROTOCOL))
        limit = self._limits.timeout or math.inf
        patience = self._limits.patience + slack
        while {"progress", "repeats"} & (reply := self._wait(patience, limit)).keys():
            if "repeats" in reply:  # with as much time again
                self._clock, self.repeats = _Clock(), True
                continue
            if self._clock.passed() >= limit:
                self._die(_too_long(limit))
            if progress:
                progress(reply["progress"])
        if reply.get("error") == "MemoryError":
            self._die(f"took more than the {self._limits.memory:g} MB it may")
        return reply

    def end(self) -> None:
        """End the child with all that it started; a forked process leaves it alone."""
        if self._parent != os.getpid() or self._process.returncode is not None:
            return
        self._kill()
        self._ended(_GRACE)
        self._let_go()

    def leave(self) -> None:
        """Wait until a child that was asked to close ends by itself.

        Raises
        ------
        FmuCrashed
            When it does not, or its exit status is not 0.
        """
        patience = self._limits.timeout or self._limits.patience
        status = self._ended(max(_LOOK, patience - self._clock.passed()))
        if status is None:
            self._die(_hung(patience))
        self._kill()
        self._let_go()
        if status:
            raise self._crashed(status)

    def _wait(self, patience: float, limit: float) -> Reply:
        """Return the next answer.

        Nothing may stand still for ``patience`` (s), or go on when ``limit`` (s) have passed since
        the request.
        """
        still, seen = _Clock(), self._mark()
        while True:
            try:
                reply = self._answers.get(timeout=_LOOK)
            except Empty:
                check_interruption()
                if self._ended(0.0) is not None:  # what it has started still holds the pipe
                    self._die(None)
                now = self._mark()
                if now != seen:
                    still, seen = _Clock(), now
                over = self._clock.passed() >= limit
                if still.passed() >= patience or (over and still.passed() > 0.5 * limit):
                    self._die(_hung(min(patience, limit)))
                if over:
                    self._die(_too_long(limit))
                continue
            if reply is None:
                self._die(None)
            if reply is NONSENSE:
                self._die("or a call before it wrote into files that are not its own")
            return reply

    def _mark(self) -> tuple[object, ...]:
        """Return what must change as long as all is well: the time, or before it runs, the call."""
        mark = self.shared.mark
        return (mark.t,) if math.isfinite(mark.t) else (mark.component, mark.call)

    def _die(self, what: str | None) -> NoReturn:
        """End the child and raise the error; without a reason, the exit status gives it."""
        status = None if what else self._ended(_GRACE)
        self._kill()
        self._ended(_GRACE)
        self._let_go()
        if self._printed > MOST_TEXT:
            what = f"printed more than {MOST_TEXT / 1e6:.0f} MB"
        if what is None:
            raise self._crashed(status)
        raise crashed(self.shared.mark, self._system, self._order, what)

    def _crashed(self, status: int | None) -> FmuCrashed:
        memory = self._limits.memory
        near = self._peak > max(0.8 * memory, 1.1 * self._inherited)
        what = ending(status, memory if near else None)
        return crashed(self.shared.mark, self._system, self._order, what, self._last_line())

    def _ended(self, timeout: float) -> int | None:
        """Return the exit status if it ends within a time (s); note the memory that it had."""
        if sys.platform == "win32":
            with suppress(subprocess.TimeoutExpired):
                self._process.wait(timeout)
            return self._process.returncode
        import resource

        end = time.monotonic() + timeout
        while self._process.returncode is None:
            try:
                ended, status, usage = os.wait4(self._process.pid, os.WNOHANG)
            except ChildProcessError:  # the program ignores SIGCHLD
                self._process.returncode = 0
                break
            if ended:
                self._process.returncode = os.waitstatus_to_exitcode(status)
                self._peak = usage.ru_maxrss / _RUSAGE
                ours = resource.getrusage(resource.RUSAGE_SELF)
                self._inherited = ours.ru_maxrss / _RUSAGE  # as Linux counts, until it began
            elif time.monotonic() >= end:
                break
            else:
                time.sleep(0.002)
        return self._process.returncode

    def _last_line(self) -> str:
        lines = self._tail.decode(errors="replace").split("\n")
        text = next((line for line in reversed(lines) if line.strip()), "")
        return "".join(c if c.isprintable() else " " for c in text).strip()[:200]

    def _kill(self) -> None:
        if sys.platform == "win32":
            self._process.kill()
        else:
            with suppress(ProcessLookupError, PermissionError):
                os.killpg(self._process.pid, signal.SIGKILL)

    def _let_go(self) -> None:
        self._drain.join(_GRACE)
        for pipe in (self._process.stdin, self._process.stdout, self._process.stderr):
            if pipe:
                pipe.close()

    def _take(self, pipe: IO[bytes]) -> None:
        """Take what FMUs print; keep the end of it, and end those that print without end."""
        with suppress(OSError, ValueError):
            while part := pipe.read(2**16):
                self._printed += len(part)
                self._tail = (self._tail + part)[-2000:]
                if self._printed > MOST_TEXT:
                    self._kill()


def _hung(seconds: float) -> str:
    return f"did not return within {seconds:g} s"


def _too_long(limit: float) -> str:
    return f"was going on when the {limit:g} s for all were over"
