"""The child process from the parent's side: started, asked, watched, ended."""

import builtins
import logging
import math
import os
import pickle
import secrets
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack, suppress
from functools import cache
from pathlib import Path
from queue import Empty
from typing import IO, NoReturn

from stickslip.cosim import errors, kernel
from stickslip.cosim.errors import CosimError, FmuCrashed, SimulationError
from stickslip.cosim.fmu.fmu import Fmu
from stickslip.cosim.fmu.library import prepare_library
from stickslip.cosim.isolation.messages import (
    NONSENSE,
    TOKEN_SIZE,
    Answers,
    Reply,
    Shared,
    ThreadedAnswers,
    crashed,
    ending,
    pack,
    present,
)
from stickslip.cosim.run import resets
from stickslip.cosim.system.settings import Isolation
from stickslip.cosim.system.system import Specification
from stickslip.fmi.process import check_interruption, held, sandbox, temporary_folder
from stickslip.fmi.process.child import close_pipes, kill, start_python
from stickslip.fmi.process.guard import Guard
from stickslip.fmi.process.sandbox import Permissions

_LOOK = 0.05  # s between two looks at the mark
_GAP = 1.0  # s between two looks, beyond which this process was suspended
_START_UP = 60.0  # s that Python may take to start
_GRACE = 2.0  # s that a child has to end
_RUSAGE = 1e6 if sys.platform == "darwin" else 1e6 / 1024  # units of memory to the MB
_MOST_TOLD = 20  # lines of what the sandbox denied
_START = Path(__file__).with_name("start.py")
_HINTS = {
    **dict.fromkeys(("read", "write", "delete"), " (--allow files=DIR)"),
    "open": " (--allow network)",
    "start": " (--allow exec)",
}
_PACKAGES = ("stickslip", "stickslip.cosim", "stickslip.fmi")
_log = logging.getLogger(__name__)


@cache
def _tell_once(line: str) -> None:
    _log.warning(line)


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
    """A child that prepares a simulation and runs it; a result may have n numbers.

    It imports ``modules`` before it enters the sandbox, and may write the file ``state``, which
    stands for the user's ``stands_for`` in messages. ``repeats`` says whether it repeats a run to
    see what a reset does.
    """

    def __init__(
        self,
        specification: Specification,
        limits: Isolation,
        order: Sequence[str],
        n: int,
        modules: tuple[str, ...] = (),
    ) -> None:
        self._system, self._order, self._limits = specification.system, order, limits
        self._parent = os.getpid()
        self._tail = b""
        self.repeats, self.runs, self.stands_for = False, 0, ""
        self._told = 0
        self._peak = self._inherited = 0.0  # MB
        library = kernel.built(marked=True)
        self.shared = Shared.make(n)
        self._folders = ExitStack()
        with ExitStack() as undone:  # by an error, or Ctrl-C, before the child is ready
            undone.callback(self._folders.close)
            self._start(specification, library, modules, undone)
            undone.pop_all()

    def _start(
        self, specification: Specification, library: Path, modules: Sequence[str], undone: ExitStack
    ) -> None:
        shared, limits = self.shared, self._limits
        self._room = self._folders.enter_context(temporary_folder())
        self.state = self._room / "state"
        allow = Permissions.of(limits.allow)
        self._guard = self._guarded(specification, allow, library)
        token = secrets.token_bytes(TOKEN_SIZE)
        try:
            with held():
                self._process = start_python(
                    ["-P", str(_START), shared.name, str(shared.size), token.hex()],
                    self._room,
                    self._guard,
                    allow,
                    {"OPENBLAS_NUM_THREADS": "1"},
                    shared.files,
                )
                pipes = self._process.stdin, self._process.stdout, self._process.stderr
                requests, replies, printed = (pipe for pipe in pipes if pipe)
                self._drain = threading.Thread(target=self._take, args=(printed,), daemon=True)
                self._drain.start()
                undone.callback(self.end)
        finally:
            shared.close_files()
        parcel = pack(  # while the child begins
            specification,
            kernel=str(library),
            memory=limits.memory,
            resets=dict(resets.lines),
            sandbox=self._guard.entry() if self._guard else None,
            modules=modules,
        )
        kind = ThreadedAnswers if sys.platform == "win32" else Answers
        self._answers = kind(requests.fileno(), replies.fileno(), token)
        self._clock = _Clock()
        self._answers.send(parcel)
        self._wait(_START_UP, math.inf)

    def _guarded(self, spec: Specification, allow: Permissions, library: Path) -> Guard | None:
        """Return the guard of the sandbox, None without one."""
        if why := sandbox.unavailable():
            _tell_once(f"FMUs run without a sandbox: {why}")
            return None
        if spec.compiled:  # the child compiles
            return None
        fmus = [c for c in self._system.components.values() if isinstance(c, Fmu)]
        libraries = [library]
        for fmu in fmus:
            fmu.restore()
            libraries += prepare_library(fmu)
        readable = [
            *(str(fmu.folder) for fmu in fmus),
            *(str(fmu.folder.with_suffix(".json")) for fmu in fmus),
            *(str(each.parents[1]) for each in libraries),
        ]

        def where() -> str:
            return present(self.shared.mark, self._system, self._order)

        room, memory = [str(self._room)], self._limits.memory
        return Guard.of_python(_PACKAGES, readable, room, allow, memory, where)

    def denied(self) -> list[str]:
        """Return what the sandbox has denied since the last call, one line each."""
        if not self._guard:
            return []
        tried, self._told = self._guard.tried[self._told : _MOST_TOLD], len(self._guard.tried)
        hint = {what: _HINTS.get(what.split()[0], "") for _, what in tried}
        return [f"{at} tried to {what}, which the sandbox denies{hint[what]}" for at, what in tried]

    def ask(
        self,
        what: str,
        arguments: Mapping[str, object],
        progress: Callable[[float], object] | None = None,
        take: Callable[[Reply], object] | None = None,
    ) -> Reply:
        """Return the answer to a request."""
        self._clock, self.repeats = _Clock(), False
        self._answers.send(pickle.dumps((what, arguments), pickle.HIGHEST_PROTOCOL))
        limit = self._limits.timeout or math.inf
        patience = self._limits.patience
        while {"progress", "repeats", "part"} & (reply := self._wait(patience, limit)).keys():
            if "repeats" in reply:  # with as much time again
                self._clock, self.repeats = _Clock(), True
                continue
            if self._clock.passed() >= limit:
                self._die(_too_long(limit))
            if progress and "progress" in reply:
                progress(reply["progress"])
            if take and "part" in reply:
                take(reply["part"])
                self._answers.send(pickle.dumps("taken"))
        if reply.get("error") == "MemoryError":
            self._die(f"took more than the {self._limits.memory:g} MB it may")
        return reply

    def told(self, reply: Reply) -> Reply:
        """Log what an answer brings, and what the sandbox denied; return the answer."""
        known: dict[str, str] = reply.get("resets", {})
        for line in dict.fromkeys(known.values()):
            resets.declare([Path(binary) for binary in known if known[binary] == line], line)
        for level, line in reply.get("logged", ()):
            if line not in known.values():
                _log.log(level, line)
        denied = self.denied()
        if "error" in reply:
            message = reply["message"].replace(str(self.state), self.stands_for)
            reply["message"] = "; ".join([message, *denied])
            _raise(reply)
        for line in denied:
            _log.warning(line)
        return reply

    def end(self) -> None:
        """End the child with all that it started; a forked process leaves it alone."""
        if self._parent != os.getpid() or self._process.returncode is not None:
            return
        kill(self._process)
        self._ended(_GRACE)
        self._let_go()

    def leave(self) -> None:
        """Wait until a child that was asked to close ends by itself."""
        patience = self._limits.timeout or self._limits.patience
        status = self._ended(max(_LOOK, patience - self._clock.passed()))
        if status is None:
            self._die(_hung(patience))
        kill(self._process)
        self._let_go()
        if status:
            raise self._crashed(status)

    def _wait(self, patience: float, limit: float) -> Reply:
        """Return the next answer: after at most ``patience`` s at a standstill, or ``limit`` s."""
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
        kill(self._process)
        self._ended(_GRACE)
        self._let_go()
        if what is None:
            raise self._crashed(status)
        last = self._last_line()
        raise crashed(self.shared.mark, self._system, self._order, what, last, self.denied())

    def _crashed(self, status: int | None) -> FmuCrashed:
        memory = self._limits.memory
        near = self._peak > max(0.8 * memory, 1.1 * self._inherited)
        what = ending(status, memory if near else None)
        if self._guard and self._guard.exhausted:
            what = f"took more than the {memory:g} MB it may"
        last = self._last_line()
        return crashed(self.shared.mark, self._system, self._order, what, last, self.denied())

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

    def _let_go(self) -> None:
        self._drain.join(_GRACE)
        close_pipes(self._process)
        if self._guard:
            self._guard.end(_GRACE)
        self._folders.close()

    def _take(self, pipe: IO[bytes]) -> None:
        with suppress(OSError, ValueError):
            while part := pipe.read(2**16):
                self._tail = (self._tail + part)[-2000:]


def _raise(reply: Reply) -> NoReturn:
    if "file" in reply:
        raise OSError(*reply["file"])
    kind = getattr(errors, reply["error"], None) or getattr(builtins, reply["error"], None)
    if isinstance(kind, type) and issubclass(kind, CosimError | ValueError | TypeError | OSError):
        raise kind(reply["message"])
    raise SimulationError(f"{reply['error']}: {reply['message']}")


def _hung(seconds: float) -> str:
    return f"did not return within {seconds:g} s"


def _too_long(limit: float) -> str:
    return f"was going on when the {limit:g} s for all were over"
