"""What holds while a process is started: it will see neither Ctrl-C nor the user's script."""

import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing import resource_tracker

from stickslip.ga.errors import SettingsError

_one_at_a_time = threading.RLock()


@contextmanager
def process_start() -> Iterator[None]:
    """Put off Ctrl-C, and hide the main module, from a process that is started meanwhile."""
    with _without_main():
        if sys.platform == "win32":
            yield
            return
        with _blocked(signal.SIGINT, signal.SIGHUP):
            resource_tracker.ensure_running()  # which would let Ctrl-C in again when it is started
        with _blocked(signal.SIGINT):
            try:
                yield
            except OSError as fault:
                where = f"{fault.filename}: " if fault.filename else ""
                raise SettingsError(
                    f"worker processes cannot be started: {where}{fault.strerror or fault}; they"
                    " need a /dev/shm that can be written; use threads (--pool threads)"
                ) from fault
            except AssertionError as fault:  # of multiprocessing, in a daemonic process
                what = f"worker processes cannot be started: {fault}"
                raise SettingsError(f"{what}; use threads (--pool threads)") from fault


@contextmanager
def _without_main() -> Iterator[None]:
    """Keep ``multiprocessing`` from running the script again in a process that it spawns.

    A script without a main guard would start processes there in its turn; standard input cannot
    be read again. ``multiprocessing`` finds the script by these two attributes.
    """
    main = sys.modules["__main__"]
    with _one_at_a_time:
        spec, file = main.__spec__, vars(main).pop("__file__", None)
        main.__spec__ = None
        try:
            yield
        finally:
            main.__spec__ = spec
            if file is not None:
                main.__file__ = file


@contextmanager
def _blocked(*signals: signal.Signals) -> Iterator[None]:
    before = signal.pthread_sigmask(signal.SIG_BLOCK, signals)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
