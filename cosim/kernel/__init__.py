"""The compiled library of the kernel, and which call of an FMU it is in."""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from contextlib import contextmanager
from ctypes import CDLL, POINTER, c_bool, c_char_p, c_int, c_int64, c_uint64, c_void_p
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stickslip.cosim.kernel.structures import Arithmetic, Component, Mark, Run, doubles
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
    """Return the kernel's library, compiled on first use with ``steps`` in place of ``steps.h``."""
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


_marks: list[tuple[Mark, Path]] = []


@cache
def load(steps: str | None = None) -> CDLL:
    """Return the kernel's library, as it is `built`."""
    marked = _marks[0][1] if _marks else None
    path = marked if marked and not steps else built(steps, marked=marked is not None)
    library = CDLL(str(path))
    for mark, _ in _marks:
        library.mark_in(c_void_p(ctypes.addressof(mark)))
    library.instantiate.argtypes = (POINTER(Component), c_char_p, c_char_p, c_char_p)
    library.instantiate.restype = library.release.restype = library.forget.restype = None
    library.release.argtypes = (POINTER(Component),)
    library.advance.argtypes = library.forget.argtypes = (POINTER(Run),)
    library.advance.restype = c_int
    library.end_early.argtypes = (POINTER(Run), c_bool)
    library.end_early.restype = c_bool
    return library


def use_mark(mark: Mark, kernel: Path) -> None:
    """Note all calls in this process from now on in a mark, by a kernel built with marks."""
    _marks.append((mark, kernel))


def note_call(name: str, call: str) -> None:
    """Note a call that the kernel does not make, where notes are taken."""
    for mark, _ in _marks:
        mark.begin(name, call)


@contextmanager
def plain_arithmetic() -> Iterator[None]:
    """Give FMUs the usual arithmetic, to nearest and with subnormal numbers; restore ours."""
    library, before = load(), Arithmetic()
    library.begin_plain_arithmetic(ctypes.byref(before))
    try:
        yield
    finally:
        library.end_plain_arithmetic(ctypes.byref(before))


_LOWEST, _HIGHEST = -292, 324  # powers of ten that doubles need
_LONGEST = 25  # characters of a number, with a comma


@cache
def _powers() -> ctypes.Array[ctypes.Array[c_uint64]]:
    """Return 128 bits of each power of ten, rounded up."""
    found = ((c_uint64 * 2) * (_HIGHEST - _LOWEST + 1))()
    for k, pair in enumerate(found, _LOWEST):
        above, below = 10 ** max(k, 0), 10 ** max(-k, 0)
        shift = 127 + below.bit_length() - above.bit_length() + (k < 0)
        bits = -((-above << shift) // below) if shift >= 0 else -(-above >> -shift)
        pair[:] = divmod(bits, 2**64)
    return found


def lines_of(time: NDArray[np.float64], rows: NDArray[np.float64]) -> memoryview:
    """Return times (n,) and rows (n, width) as lines of a CSV file, as ``repr`` writes numbers."""
    n, width = rows.shape
    text = np.empty(_LONGEST * n * (1 + width), np.uint8)
    numbers = map(doubles, map(np.ascontiguousarray, (time, rows)))
    write = load().write_lines
    write.restype = c_int64
    texts = (c_int64 * (2 * width))()
    shape = map(c_int64, (n, width))
    length = write(c_void_p(text.ctypes.data), *numbers, *shape, _powers(), texts)
    return text[:length].data


MOST_COMPONENTS = 64  # beyond, the code would crowd itself out of the processor's cache
_GROUP = 12  # as in steps.h

_STEPS = """#include "walk.h"

{lists}

INLINE bool step(Run *run, const double *now, double *next) {{
    const Component *c = run->components;
    (void)now, (void)next;
    return {calls};
}}

__attribute__((noinline)) static bool step_until(Run *run, int64_t end) {{
    return walk(run, end, step, {width}, {constant});
}}
"""


def unroll(run: Run) -> str | None:
    """Return ``steps.h`` for the components of a run; None where the tables serve better."""
    n = run.n_components
    if not 0 < n <= MOST_COMPONENTS:
        return None
    size = _GROUP if run.jacobi else 1
    lists, calls = [], []
    for begin in range(0, n, size):
        group = range(begin, min(begin + size, n))
        components = [(i, run.components[i]) for i in group]
        lists += [line for i, c in components for line in _references(i, c)]
        calls += [_set_call(i, c) for i, c in components if c.n_inputs]
        calls += ["plain(true)"] * run.jacobi  # else the step that follows makes it so
        calls += [f"do_step(run, c + {i}, {c.version})" for i, c in components]
        calls += [
            f"get(run, c + {i}, {c.version}, out{i}, {c.n_outputs}, next + {c.column})"
            for i, c in components
            if c.n_outputs
        ]
    return _STEPS.format(
        lists="\n".join(lists),
        calls=" &&\n        ".join(calls),
        width=run.width,
        constant=run.constant_step,
    )


def _references(i: int, c: Component) -> list[str]:
    tables = ("in", c.input_references[: c.n_inputs]), ("out", c.output_references[: c.n_outputs])
    return [
        f"static const uint32_t {name}{i}[] = {{{', '.join(map(str, table))}}};"
        for name, table in tables
        if table
    ]


def _set_call(i: int, c: Component) -> str:
    values = f"now + {c.input_offset}"
    if c.input_offsets:
        terms = [f"now[{offset}]" for offset in c.input_offsets[: c.n_inputs]]
        if c.scales:
            factors, shifts = c.scales[: c.n_inputs], c.scales[c.n_inputs : 2 * c.n_inputs]
            scaled = zip(factors, terms, shifts, strict=True)
            terms = [f"{a!r} * {term} + {b!r}" for a, term, b in scaled]
        values = f"(const double[]){{{', '.join(terms)}}}"
    return f"set(run, c + {i}, {c.version}, in{i}, {c.n_inputs}, {values})"
