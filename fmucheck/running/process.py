"""Rules about what an FMU does to the process it is in."""

from __future__ import annotations

import ctypes
import gc
import itertools
import locale
import os
import signal
import sys
from ctypes import Structure, c_int, c_size_t, c_void_p

from stickslip.fmucheck.rules import Claims, error, warning
from stickslip.fmucheck.running.bench import Bench, Settings
from stickslip.fmucheck.running.run import finished

_CYCLES = 200
_LEAK = 16  # bytes a cycle that are told; the smallest block of glibc takes 32
_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGSEGV, signal.SIGFPE, signal.SIGABRT)


class _Memory(Structure):
    """mallinfo2 of glibc."""

    _names = "arena ordblks smblks hblks hblkhd usmblks fsmblks used free keepcost"
    _fields_ = tuple((name, c_size_t) for name in _names.split())


def _used() -> int | None:
    """Return the bytes allocated from the C library, ``None`` where it does not tell."""
    if not sys.platform.startswith("linux"):
        return None
    library = ctypes.CDLL(None)
    if not hasattr(library, "mallinfo2"):
        return None
    library.mallinfo2.restype = _Memory
    memory = library.mallinfo2()
    return int(memory.used + memory.hblkhd)


@warning("2.1.5", "2.3.1", "free in FreeInstance what was allocated")
def leaks_memory(bench: Bench) -> Claims:
    """Memory stays allocated each time an instance is made, initialised and freed."""
    if _used() is None:
        return
    used = []
    for _ in range(3):
        for _ in bench.while_time(range(_CYCLES)):
            instance = bench.new()
            instance.enter_initialisation(bench.start_time)
            instance.exit_initialisation()
            bench.free(instance)
        gc.collect()  # else what Python has not yet freed would count, or hide a leak
        used.append(_used() or 0)
    growth = min(b - a for a, b in itertools.pairwise(used)) / _CYCLES
    if growth >= _LEAK:
        yield bench.interface.kind, f"about {growth:.0f} bytes an instance are not freed"


@error("3.3.1", None, "do not call them, or declare false")
def memory_callbacks_used(bench: Bench) -> Claims:
    """It declares canNotUseMemoryManagementFunctions, but uses callbacks for memory."""
    if bench.interface.flag("canNotUseMemoryManagementFunctions"):
        count = finished(bench).instance.callbacks.allocated
        if count:
            yield bench.interface.kind, f"allocateMemory was called {count} times"


@error("2.1.1", "2.2.1", "leave settings of the process alone")
def changes_the_process(bench: Bench) -> Claims:
    """It changes folder, locale, rounding, signal handlers or open files of the process."""
    finished(bench)
    for (name, old), (_, new) in zip(bench.before, settings(), strict=True):
        if old != new:
            yield name, f"was {old}, is {new}"


def settings() -> Settings:
    """Return what a library must not change."""
    library = ctypes.CDLL("ucrtbase" if sys.platform == "win32" else None)
    found: Settings = [("working folder", os.getcwd())]  # noqa: PTH109
    found.append(("locale", locale.setlocale(locale.LC_ALL)))
    if hasattr(library, "fegetround"):
        library.fegetround.restype = c_int
        found.append(("rounding mode", library.fegetround()))
    if sys.platform != "win32":
        found += [(f"handler of {s.name}", _handler(library, s)) for s in _SIGNALS]
        found += [(f"file {file}", "open" if _is_open(file) else "closed") for file in range(3)]
    return found


def _handler(library: ctypes.CDLL, number: int) -> int | None:
    """Return the address of what a signal calls; in `sigaction` it comes first."""
    action = (c_void_p * 32)()
    library.sigaction(number, None, action)
    return action[0]


def _is_open(file: int) -> bool:
    try:
        os.fstat(file)
    except OSError:
        return False
    return True
