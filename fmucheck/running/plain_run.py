"""Rules about a plain run: that it loads and runs, its process, and the values that come out."""

import ctypes
import gc
import itertools
import locale
import math
import os
import signal
import sys
from collections.abc import Callable
from ctypes import Structure, c_char_p, c_int, c_size_t, c_void_p

from stickslip.fmi.description.variables import FLOATS
from stickslip.fmucheck.description.model import Variable, is_number
from stickslip.fmucheck.rules import Claims, error, note, warning
from stickslip.fmucheck.running.bench import Bench, Settings
from stickslip.fmucheck.running.calls import CallFailed
from stickslip.fmucheck.running.instance import Values
from stickslip.fmucheck.running.run import STEPS, finished, new_run, other, scale, start_of

LOADING = {"does-not-load", "wrong-version-string", "refuses-its-token", "accepts-any-token"}
"""All that is tried of Scheduled Execution."""
GATES = ("does-not-load", "refuses-its-token", "does-not-run")
"""When one of these finds something, the rules after it are not tried."""


@error("2.3", "2.5.1.4", "build it for an older system, linked statically")
def does_not_load(bench: Bench) -> Claims:
    """The system cannot load the binary."""
    try:
        _ = bench.binary
    except OSError as fault:
        yield bench.library.name, str(fault)


@error("2.1.4", "2.2", "return the version of the headers")
def wrong_version_string(bench: Bench) -> Claims:
    """GetVersion returns another version than the description claims."""
    returned = bench.binary.function("GetVersion", c_char_p)()
    expected = bench.description.root.get("fmiVersion", "")
    if (returned or b"").decode("latin-1") != expected:
        yield bench.library.name, f"GetVersion returns {returned!r}; expected {expected}"


@error("2.1.4", None, "return 'default'")
def wrong_types_platform(bench: Bench) -> Claims:
    """fmi2GetTypesPlatform does not return the types this tool and all others use."""
    returned = bench.binary.function("GetTypesPlatform", c_char_p)()
    if returned != b"default":
        yield bench.library.name, f"returns {returned!r}; expected 'default'"


@error("2.1.5", "2.3.1", "build binary and description together")
def refuses_its_token(bench: Bench) -> Claims:
    """It gives no instance for the token in its own description."""
    if bench.instantiate() is None:
        yield bench.library.name, f"no instance for token {bench.description.token}"


@warning("2.1.5", "2.3.1", "compare the token, return NULL if it differs")
def accepts_any_token(bench: Bench) -> Claims:
    """It gives an instance for a wrong token, so a stale description goes unnoticed."""
    if bench.instantiate(token="{00000000-wrong-token}") is not None:  # noqa: S106 (no secret)
        yield bench.library.name, "gave an instance for a token that is not its own"


@error("4.2", "2.3", "read its log and correct the model")
def does_not_run(bench: Bench) -> Claims:
    """It fails in a plain run: start values, the default step, inputs moved a little."""
    try:
        finished(bench)
    except CallFailed as moved:
        bench.results["still"] = str(moved)
        try:
            finished(bench)
        except CallFailed as still:
            yield bench.interface.kind, f"{still}{bench.last_words()}"


@note("", "", "give the inputs min and max")
def fails_when_inputs_move(bench: Bench) -> Claims:
    """It fails when inputs move by a tenth of their size within their range."""
    if "still" in bench.results:
        failed = bench.results["still"]
        yield bench.interface.kind, f"{failed}; inputs are kept at their start values"


@warning("2.1.3", "2.2.4", "return OK when nothing is wrong")
def warns_in_a_plain_run(bench: Bench) -> Claims:
    """Calls of a plain run return Warning."""
    instance = finished(bench).instance
    for name in dict.fromkeys(instance.warned):
        yield f"{bench.binary.prefix}{name}", "returned Warning"


@error("2.1.6", "2.3", "return OK")
def does_not_terminate(bench: Bench) -> Claims:
    """Terminate fails after a plain run."""
    run = finished(bench)
    status = 0 if run.ended else run.instance.status("Terminate")
    yield from bench.failed("Terminate", status)


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
            instance.do("ExitInitializationMode")
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


def _first(bench: Bench, fault: Callable[[Variable, Values], str]) -> Claims:
    """Yield where each variable has a fault for the first time, after initialisation or a step."""
    reported = set()
    run = finished(bench, watching=False, steps=0)
    for steps in (0, *[1] * STEPS):
        run.go(steps)
        for v, elements in zip(bench.observed, run.instance.get(bench.observed), strict=True):
            if v.index not in reported and (why := fault(v, elements)):
                reported.add(v.index)
                yield v.place, f"{why} at t = {run.time}"


@error("2.1.7", "2.2.7", "find the division by 0 or missing start")
def value_not_finite(bench: Bench) -> Claims:
    """A value becomes infinite or not a number."""

    def fault(v: Variable, elements: Values) -> str:
        odd = v.kind in FLOATS and not all(map(math.isfinite, elements))
        return f"is {elements}" if odd else ""

    return _first(bench, fault)


@warning("2.2.7", "2.2.7", "widen the range, or keep within it")
def leaves_its_range(bench: Bench) -> Claims:
    """A value leaves the range [min, max] that is declared for it."""

    def fault(v: Variable, elements: Values) -> str:
        if not is_number(v.kind) or v.causality == "input":
            return ""
        low, high = v.number("min"), v.number("max")
        slack = 1e-9 * scale(v, max(abs(low or 0), abs(high or 0)))
        above = high is not None and any(x > high + slack for x in elements)
        below = low is not None and any(x < low - slack for x in elements)
        return f"is {elements}" if above or below else ""

    return _first(bench, fault)


@error("2.2.7", "2.4.7.5", "use the same values in code and description")
def start_differs(bench: Bench) -> Claims:
    """A parameter, constant or input does not have the start value of the description."""
    run = finished(bench, watching=False, steps=0)
    for v in bench.observed:
        fixed = v.causality in ("parameter", "input", "structuralParameter")
        if fixed or v.variability == "constant":
            expected, got = start_of(v), run.instance.get([v])[0]
            if expected is not None and not _same(v, expected, got):
                shown = [" ".join(map(str, values)) for values in (expected, got)]
                yield v.place, f"start {shown[0]}, but the binary has {shown[1]}"


def _same(v: Variable, expected: Values, got: Values) -> bool:
    if len(expected) == 1:
        expected = expected * len(got)
    if None in expected or len(expected) != len(got):
        return True  # the description is wrong, which other rules say
    if v.kind == "Float32":
        return all(math.isclose(a, b, rel_tol=1e-6) for a, b in zip(expected, got, strict=True))
    if v.kind == "Boolean":
        return [bool(x) for x in expected] == [bool(x) for x in got]
    return expected == got


@error("2.1.7", "2.2.7", "store what is set")
def set_value_is_lost(bench: Bench) -> Claims:
    """A parameter that is set before initialisation has another value after it."""
    for v in bench.while_time(bench.parameters[:100]):
        values = other(v)
        if values is None:
            continue
        run = new_run(bench, watching=False)
        try:
            run.begin([(v, values)])
            got = run.instance.get([v])[0]
        except CallFailed:
            continue  # a model may refuse a value; set_refused tells it
        finally:
            if not run.instance.broken:
                bench.free(run.instance)
        if not _same(v, values, got):
            yield v.place, f"was set to {values[0]}, is {got[0]}"


@warning("2.1.7", "2.2.7", "declare min and max, or take the value")
def set_refused(bench: Bench) -> Claims:
    """A parameter cannot be set before initialisation to a value within its range."""
    for v in bench.while_time(bench.parameters[:100]):
        values = other(v)
        instance = bench.new()
        try:
            if values is not None:
                instance.set(v, values)
        except CallFailed as failed:
            yield v.place, f"{failed} for {values[0] if values else None}"
        else:
            bench.free(instance)


@error("2.2.7", "2.4.7.4", "declare it discrete or continuous")
def fixed_value_changes(bench: Bench) -> Claims:
    """A variable that is constant, fixed or tunable changes during a run."""
    first: dict[int, Values] = {}

    def fault(v: Variable, elements: Values) -> str:
        if v.variability not in ("constant", "fixed", "tunable"):
            return ""
        changed = repr(first.setdefault(v.index, elements)) != repr(elements)
        return f"is {v.variability}, but has changed" if changed else ""

    return _first(bench, fault)


@error("2.1.7", "2.2.7", "return the time that was reached")
def time_is_wrong(bench: Bench) -> Claims:
    """The independent variable is not at the time that was reached."""
    independent = [v for v in bench.observed if v.causality == "independent"]
    if not independent:
        return
    run = finished(bench, watching=False)
    got = run.instance.get(independent)[0][0]
    if not run.ended and abs(got - run.time) > 1e-6 * max(bench.step_size, abs(run.time) * 1e-6):
        yield independent[0].place, f"is {got} at t = {run.time}"


@error("2.1.7", "2.2.7", "compute in setters and steps only")
def getter_changes_state(bench: Bench) -> Claims:
    """Reading values changes them, or how the run goes on."""
    watched, blind = finished(bench), finished(bench, watching=False)
    twice = [watched.read(), watched.read()]
    if twice[0] != twice[1]:
        yield bench.interface.kind, "reading twice gives two results"
    elif watched.rows and blind.read() != watched.rows[-1]:
        yield bench.interface.kind, "a run that was read at every step ends elsewhere"
