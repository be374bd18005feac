"""The compiled library of the kernel."""

from __future__ import annotations

from ctypes import CDLL, POINTER, c_bool, c_char_p, c_int
from functools import cache
from pathlib import Path

from stickslip.cosim.kernel import marks
from stickslip.cosim.kernel.structures import Component, Run
from stickslip.fmi import toolchain
from stickslip.fmi.standard import standard_files

# Two neighbours copied as one would wait until both have arrived in memory. A loop of calls that
# begins within a line of the cache costs some percent more or less, as chance has it.
_FLAGS = ("-fno-tree-slp-vectorize", "-falign-loops=64")

FINISHED, PAUSED, FAILED, HALTED = range(4)

SIDE_BY_SIDE, PAIR, SCATTERED, NONE = range(4)  # how a component finds its inputs in a row

# Values of ``Run.status``: FMI statuses, then the kernel's own reasons.
OK, WARNING, DISCARD, ERROR, FATAL, PENDING = range(6)
NOT_FINITE, TERMINATED, RETURNED_EARLY, NOT_SOLVED = range(100, 104)
UNKNOWN_STATUS, NO_STATE, RESTORED_WRONGLY = range(104, 107)
STATUS = {
    DISCARD: "returned discard",
    ERROR: "returned error",
    FATAL: "returned fatal",
    PENDING: "returned pending, though asynchronous steps were not requested",
    NOT_FINITE: "gave a value that is not finite",
    TERMINATED: "asked to terminate the simulation",
    RETURNED_EARLY: "returned early though that was not allowed",
    NO_STATE: "gave no state, though the FMU declares that it can",
    RESTORED_WRONGLY: "did not bring back the state: this output differs from what it was then",
    110: "came to no end of events at one time or within one step",
    111: "could not integrate",
    112: "needs more memory than there is",
    113: "gave a time that cannot be",
}


@cache
def built(
    steps: str | None = None, *, marked: bool = False, platform: toolchain.Platform | None = None
) -> Path:
    """Return the path of the kernel's library, compiled on first use.

    Parameters
    ----------
    steps : text to compile in place of ``steps.h``
    marked : whether it notes which call it is in, see ``marks.py``
    platform : what to build for; this machine by default
    """
    here = Path(__file__).parent
    files = {file.name: file.read_text(encoding="utf-8") for file in here.glob("*.[ch]")}
    if steps is not None:
        files["steps.h"] = steps
    files |= {
        f"system/{h.name}": h.read_text(encoding="utf-8")
        for h in standard_files("c-code").glob("fmi[23]*.h")
    }
    flags = (*_FLAGS, "-DMARKED") if marked else _FLAGS
    return toolchain.shared_library("cosim_kernel", files, platform=platform, flags=flags)


@cache
def load(steps: str | None = None) -> CDLL:
    """Return the kernel's library, as it is `built`."""
    marked = marks.library()
    path = marked if marked and not steps else built(steps, marked=marked is not None)
    library = CDLL(str(path))
    marks.attach(library)
    library.instantiate.argtypes = (POINTER(Component), c_char_p, c_char_p, c_char_p)
    library.instantiate.restype = library.release.restype = library.forget.restype = None
    library.release.argtypes = (POINTER(Component),)
    library.advance.argtypes = library.forget.argtypes = (POINTER(Run),)
    library.advance.restype = c_int
    library.end_early.argtypes = (POINTER(Run), c_bool)
    library.end_early.restype = c_bool
    return library
