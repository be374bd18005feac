"""Signals that end a program: noted at once, raised in the main thread where nothing breaks of it.

Python runs a signal's handler between any two steps of the main thread. A ``KeyboardInterrupt``
raised there may leave a lock of a pool taken for ever, or a folder that nobody removes. So a
handler of ours only notes the signal; ``KeyboardInterrupt`` is raised

- by ``check_interruption``, at points where it does no harm, in any thread;
- at the end of a block of ``held``, in which nothing is ever raised;
- where the main thread is, if it has come to no such point for ``PATIENCE``: while it reads a large
  file, for example.

``interruptible`` does so for SIGINT, SIGTERM and SIGHUP, for the command line. Without it, as in a
notebook, Ctrl-C is Python's own, but ``held`` puts it off just the same.
"""

import os
import select
import signal
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from io import RawIOBase
from pathlib import Path
from types import FrameType
from typing import Any

SIGNALS = ("SIGINT", "SIGTERM", "SIGHUP")
"""What ends a program; Windows has no SIGHUP."""
PATIENCE = 0.3
"""How long (s) the main thread may take to come to a point that raises by itself."""
AGAIN = 1.0
"""How long (s) after the first signal another one ends the process at once."""
DEADLINE = 20.0
"""How long (s) all may take to end; a native function that does not return takes for ever."""
Handler = Callable[[int, FrameType | None], Any] | int | None


class _State:
    """What the handlers, which have no other way to tell, tell the rest of the process."""

    noted: int | None = None  # the first signal
    depth = 0  # of blocks of ``held`` in the main thread
    nudged = False  # the watcher asks the main thread to raise where it is
    ours = False  # the handlers, in a block of ``interruptible``


def check_interruption() -> None:
    """Raise KeyboardInterrupt if a signal has told the program to end; for loops that take long."""
    if _State.noted is not None and not _unwinding():
        raise KeyboardInterrupt


def interrupted_by() -> int | None:
    """Return the number of the signal that has told the program to end, None if there was none."""
    return _State.noted


class held:  # noqa: N801 - reads as a word in a with statement
    """A block in whose midst no KeyboardInterrupt is raised; it is at the end."""

    def __enter__(self) -> None:
        """Put signals off."""
        self._before: Handler = None
        self._came: tuple[int, FrameType | None] | None = None
        self._counts = threading.current_thread() is threading.main_thread()
        if not self._counts:
            return
        if not (_State.ours or _State.depth):
            before = signal.getsignal(signal.SIGINT)
            if callable(before):
                signal.signal(signal.SIGINT, self._put_off)
                self._before = before
        _State.depth += 1

    def __exit__(self, kind: object, error: BaseException | None, *_: object) -> None:
        """Raise what was put off."""
        if not self._counts:
            return
        _State.depth -= 1
        if callable(self._before):
            signal.signal(signal.SIGINT, self._before)
            if self._came:
                self._before(*self._came)
        if not _State.depth and error is None:
            check_interruption()

    def _put_off(self, number: int, frame: FrameType | None) -> None:
        self._came = number, frame


@contextmanager
def interruptible() -> Iterator[None]:
    """Let SIGINT, SIGTERM and SIGHUP raise KeyboardInterrupt in this block, where it is safe.

    What the caller ignores, such as SIGHUP under nohup, stays ignored. A second signal, or one that
    has not ended the block after ``DEADLINE``, ends the process; its temporary folders are removed.
    Outside the main thread there are no signals, and this does nothing.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    numbers = [getattr(signal, name) for name in SIGNALS if hasattr(signal, name)]
    before = {number: signal.getsignal(number) for number in numbers}
    taken = [n for n, handler in before.items() if handler not in (signal.SIG_IGN, None)]
    _State.noted, _State.nudged = None, False
    watched, report = _watched(), sys.unraisablehook
    try:
        sys.unraisablehook = _report
        _State.ours = True
        for number in taken:
            signal.signal(number, _note)
        yield
    finally:
        _State.ours = False
        sys.unraisablehook = report
        for number in taken:
            signal.signal(number, before[number])
        if watched:
            signal.set_wakeup_fd(watched[1])
            os.close(watched[0])
        _State.noted = None


def _note(number: int, _: FrameType | None) -> None:
    if _State.noted is None:
        _State.noted = number
        if hasattr(signal, "pthread_kill"):
            return  # the watcher will see to it
        _State.nudged = True
    if _State.nudged and _State.ours and not (_State.depth or _unwinding()):
        _State.nudged = False
        raise KeyboardInterrupt


def _report(failed: "sys.UnraisableHookArgs") -> None:
    """Report what a finaliser raised, but not that it was interrupted: that is raised again."""
    if not issubclass(failed.exc_type, KeyboardInterrupt):
        sys.__unraisablehook__(failed)


def _unwinding() -> bool:
    """Tell whether this thread is on its way out already."""
    error = sys.exc_info()[1]
    while error is not None and not isinstance(error, KeyboardInterrupt):
        error = error.__context__
    return error is not None


def _watched() -> tuple[int, int] | None:
    """Start the watcher; return the end of its pipe, and the wake-up file that was set before."""
    if not hasattr(signal, "pthread_kill"):
        return None
    heard, told = os.pipe()
    os.set_blocking(told, False)
    before = signal.set_wakeup_fd(told, warn_on_full_buffer=False)
    main = threading.get_ident()
    threading.Thread(target=_watch, args=(heard, main), daemon=True).start()
    return told, before


def _watch(heard: int, main: int) -> None:
    """See to it that a signal has its effect, even while the main thread is in native code."""
    with open(heard, "rb", buffering=0) as pipe:
        came = pipe.read(1)
        if came and not _ended(pipe, came[0], main):
            with suppress(OSError):
                os.write(2, b"stickslip: interrupted; ended at once\n")
            for folder in list(_folders):
                _remove(folder)
            os._exit(128 + came[0])


def _ended(pipe: RawIOBase, number: int, main: int) -> bool:
    """Ask the main thread again and again to end; return whether it did."""
    poll = select.poll()
    poll.register(pipe, select.POLLIN)
    signals, nudges = 1, 0
    while nudges * PATIENCE < DEADLINE:
        if poll.poll(1000.0 * PATIENCE):
            more = pipe.read(64)
            if not more:
                return True
            signals += len(more)
            if signals > 1 + nudges and nudges * PATIENCE >= AGAIN:
                return False
            continue
        nudges += 1
        _State.nudged = True
        signal.pthread_kill(main, number)
    return False


_folders: set[Path] = set()


@contextmanager
def temporary_folder(prefix: str = "stickslip-") -> Iterator[Path]:
    """Make a folder that goes with the block, or with the process at the latest."""
    folder = None
    try:
        with held():
            folder = Path(tempfile.mkdtemp(prefix=prefix))
            _folders.add(folder)
        yield folder
    finally:
        if folder is not None:
            with held():
                _remove(folder)
                _folders.discard(folder)


def _remove(folder: Path) -> None:
    """Delete a folder with all in it, as far as that is possible, however deep it is."""
    token, n, before = os.urandom(8).hex(), 0, set[str]()
    while (inside := _inside(folder)) != before:
        before = inside
        for path in inside:
            with suppress(OSError):
                if os.path.islink(path) or not os.path.isdir(path):  # noqa: PTH112, PTH114
                    os.unlink(path)  # noqa: PTH108
                    continue
                os.chmod(path, 0o700)  # noqa: PTH101
                for deeper in _inside(path):
                    n += 1
                    os.rename(deeper, folder / f"{token}-{n}")  # noqa: PTH104
                os.rmdir(path)  # noqa: PTH106
    with suppress(OSError):
        folder.rmdir()


def _inside(folder: Path | str) -> set[str]:
    with suppress(OSError):
        return {entry.path for entry in os.scandir(folder)}
    return set()
