"""Ctrl-C, put off while a process is started that must not see it."""

from __future__ import annotations

import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing import resource_tracker

from stickslip.ga.errors import SettingsError


@contextmanager
def without_interrupts() -> Iterator[None]:
    """Put off Ctrl-C; a process that is started meanwhile will never see it.

    Raises
    ------
    SettingsError
        When the system refuses.
    """
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
                f"worker processes cannot be started: {where}{fault.strerror or fault}; they need a"
                " /dev/shm that can be written; use threads (--pool threads)"
            ) from fault


@contextmanager
def _blocked(*signals: signal.Signals) -> Iterator[None]:
    before = signal.pthread_sigmask(signal.SIG_BLOCK, signals)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
