"""The kernel as Python sees it: the structures of ``kernel.h`` and the compiled library."""

from __future__ import annotations

from ctypes import (
    CDLL,
    POINTER,
    Structure,
    c_bool,
    c_char,
    c_char_p,
    c_double,
    c_int,
    c_int32,
    c_int64,
    c_size_t,
    c_uint32,
    c_void_p,
)
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.cosim.kernel import marks
from stickslip.fmi import toolchain


class Setting(Structure):
    """Start values of one type for one component."""

    _fields_ = (
        ("set", c_void_p),
        ("call", c_char_p),
        ("late", c_int64),
        ("n", c_size_t),
        ("references", POINTER(c_uint32)),
        ("values", c_void_p),
    )


class Change(Structure):
    """Values that a component is given when a step is done."""

    _fields_ = (("step", c_int64), ("component", c_int64), ("setting", Setting))


class Log(Structure):
    """Messages of a component since the start of the last run."""

    _fields_ = (
        ("callbacks", c_void_p * 5),
        ("severity", c_int32),
        ("reason", c_int32),
        ("unknown", c_int32),
        ("message", c_char * 1024),
        ("warnings", c_int64),
        ("warned", c_char_p),
        ("warned_at", c_double),
        ("warning", c_char * 1024),
    )


class Disturbance(Structure):
    """What a scenario does to one signal."""

    _fields_ = (
        ("column", c_int64),
        ("keep", POINTER(c_double)),
        ("add", POINTER(c_double)),
        ("ends", POINTER(c_double)),
        ("held", c_double),
    )


class Map(Structure):
    """Pairs of values of one input."""

    _fields_ = (("n", c_size_t), ("pairs", POINTER(c_double)))


class SumOfSquares(Structure):
    """A sum of (signal - reference)^2 over time."""

    _fields_ = (
        ("column", c_int64),
        ("reference", c_int64),
        ("constant", c_double),
        ("first", c_int64),
        ("end", c_int64),
        ("sum", c_double),
    )


class Component(Structure):
    """One instance and its place in the rows."""

    _fields_ = (
        ("version", c_int32),
        ("inputs", c_int32),
        ("instance", c_void_p),
        ("n_inputs", c_size_t),
        ("input_references", POINTER(c_uint32)),
        ("input_offset", c_int64),
        ("n_outputs", c_size_t),
        ("output_references", POINTER(c_uint32)),
        ("column", c_int64),
        ("call", c_void_p * 10),
        ("input_offsets", POINTER(c_int64)),
        ("gathered", POINTER(c_double)),
        ("scales", POINTER(c_double)),
        ("maps", POINTER(Map)),
        ("n_linked", c_size_t),
        ("used", c_int64),
        ("n_settings", c_size_t),
        ("settings", POINTER(Setting)),
        ("log", POINTER(Log)),
        ("n_disturbances", c_size_t),
        ("disturbances", POINTER(Disturbance)),
        ("tolerance", c_double),
    )


class Answers(Structure):
    """What FMI 3.0 FMUs say about their last step."""

    _fields_ = (
        ("event_handling_needed", c_bool),
        ("terminate", c_bool),
        ("early", c_bool),
        ("last_successful_time", c_double),
    )


class InputEvent(Structure):
    """When an exposed input jumps within a step."""

    _fields_ = (("step", c_int64), ("t", c_double))


class Run(Structure):
    """One run: what to step, where to put it, and how it went."""

    _fields_ = (
        ("components", POINTER(Component)),
        ("n_components", c_int64),
        ("uniform", c_int64),
        ("jacobi", c_int64),
        ("constant_step", c_int64),
        ("n_steps", c_int64),
        ("start", c_double),
        ("stop", c_double),
        ("step", c_double),
        ("external", c_void_p),
        ("n_external", c_int64),
        ("rows", c_void_p),
        ("width", c_int64),
        ("block", c_int64),
        ("used_again", c_int64),
        ("record", c_void_p),
        ("selected", POINTER(c_int64)),
        ("n_selected", c_int64),
        ("every", c_int64),
        ("sums", POINTER(SumOfSquares)),
        ("n_sums", c_int64),
        ("block_start", c_int64),
        ("done", c_int64),
        ("closed", c_int64),
        ("t", c_double),
        ("h", c_double),
        ("answers", Answers),
        ("failed", c_int64),
        ("output", c_int64),
        ("status", c_int64),
        ("call", c_char_p),
        ("initial", c_void_p),
        ("coupling", c_void_p),
        ("unsolved", c_void_p),
        ("allows_nan", c_int64),
        ("disturbed", c_int64),
        ("changes", POINTER(Change)),
        ("n_changes", c_int64),
        ("next_change", c_int64),
        ("halt", c_int64),
        ("n_events", c_int64),
        ("events", POINTER(InputEvent)),
        ("event_inputs", c_void_p),
        ("parts", c_void_p),
        ("event", c_int64),
        ("event_end", c_int64),
        ("within", c_int64),
        ("moved", c_void_p),
        ("began", c_void_p),
    )


# Two neighbours copied as one would wait until both have arrived in memory. A loop of calls that
# begins within a line of the cache costs some percent more or less, as chance has it.
_FLAGS = ("-fno-tree-slp-vectorize", "-falign-loops=64")

FINISHED, PAUSED, FAILED, HALTED = range(4)

SIDE_BY_SIDE, SCATTERED, NONE = range(3)  # how a component finds its inputs in a row

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


def doubles(values: NDArray[np.float64]) -> Any:
    """Return the address of an array, as long as which is kept it can be used."""
    return values.ctypes.data_as(POINTER(c_double))


@cache
def built(steps: str | None = None, *, marked: bool = False) -> Path:
    """Return the path of the kernel's library, compiled on first use.

    Parameters
    ----------
    steps : text to compile in place of ``steps.h``
    marked : whether it notes which call it is in, see ``marks.py``

    Raises
    ------
    toolchain.ToolchainError
    """
    import fmpy  # a process that is given the library need not wait for it

    here = Path(__file__).parent
    headers = Path(fmpy.__file__).parent / "c-code"
    files = {file.name: file.read_text(encoding="utf-8") for file in here.glob("*.[ch]")}
    if steps is not None:
        files["steps.h"] = steps
    files |= {f"system/{h.name}": h.read_text(encoding="utf-8") for h in headers.glob("fmi[23]*.h")}
    flags = (*_FLAGS, "-DMARKED") if marked else _FLAGS
    return toolchain.shared_library("cosim_kernel", files, flags=flags)


@cache
def load(steps: str | None = None) -> CDLL:
    """Return the kernel's library, as it is `built`.

    Raises
    ------
    toolchain.ToolchainError
    """
    marked = marks.library()
    path = marked if marked and not steps else built(steps, marked=marked is not None)
    library = CDLL(str(path))
    marks.attach(library)
    library.fmi2_calls.restype = library.fmi3_calls.restype = c_char_p
    library.instantiate.argtypes = (POINTER(Component), c_char_p, c_char_p, c_char_p)
    library.instantiate.restype = library.release.restype = library.forget.restype = None
    library.release.argtypes = (POINTER(Component),)
    library.advance.argtypes = library.forget.argtypes = (POINTER(Run),)
    library.advance.restype = c_int
    library.end_early.argtypes = (POINTER(Run), c_bool)
    library.end_early.restype = c_bool
    return library


def calls(version: int) -> list[str]:
    """Return the names of the FMI functions that the kernel calls, in the order of its table."""
    library = load()
    names: bytes = library.fmi2_calls() if version == 2 else library.fmi3_calls()
    return names.decode().split()
