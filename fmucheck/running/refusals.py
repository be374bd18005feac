"""Rules about calls that must be refused."""

from __future__ import annotations

from ctypes import byref, c_bool, c_double, c_int, c_size_t, c_void_p
from typing import Any

from stickslip.fmucheck.rules import Claims, warning
from stickslip.fmucheck.running.bench import Bench
from stickslip.fmucheck.running.calls import references
from stickslip.fmucheck.running.instance import Instance
from stickslip.fmucheck.running.run import new_run


def _step(instance: Instance, time: float, step: float) -> int:
    """Return the status of one step."""
    if instance.description.version == 2:
        return instance.status("DoStep", c_double(time), c_double(step), c_int(0))
    results: list[Any] = [byref(c_bool()), byref(c_bool()), byref(c_bool()), byref(c_double())]
    return instance.status("DoStep", c_double(time), c_double(step), c_bool(False), *results)


def _unused(bench: Bench) -> int:
    """Return a value reference that no variable has."""
    used = {v.reference for v in bench.description.variables}
    return next(n for n in range(4_000_000_000, 2**32) if n not in used)


def _access(instance: Instance, verb: str, reference: int) -> int:
    version = instance.description.version
    name = f"{verb}{'Real' if version == 2 else 'Float64'}"
    one, values = c_size_t(1), (c_double * 1)()
    arguments: list[Any] = [references([reference]), one, values]
    return instance.status(name, *arguments, *([] if version == 2 else [one]))


@warning("2.1.7", "2.2.7", "check the reference and return Error")
def unknown_reference(bench: Bench) -> Claims:
    """A value reference that no variable has is accepted, or fatal."""
    for verb in ("Get", "Set"):
        run = new_run(bench)
        run.begin()
        if _access(run.instance, verb, _unused(bench)) in (0, 1):
            yield f"{verb} of a value", f"value reference {_unused(bench)} is accepted"
        else:
            run.instance.broken = True


@warning("4.2.2", "4.2", "return Error unless the step is above 0")
def bad_step(bench: Bench) -> Claims:
    """A communication step of size 0 or below is accepted, or fatal."""
    if bench.is_exchange:
        return
    for size in (0.0, -bench.step_size):
        run = new_run(bench)
        run.begin()
        run.go(2)
        if not run.ended and _step(run.instance, run.time, size) in (0, 1):
            yield f"{bench.binary.prefix}DoStep", f"a step of {size} is accepted"
        else:
            run.instance.broken = True


@warning("4.2.4", "2.3.2", "return Error in states where it is illegal")
def step_before_initialisation(bench: Bench) -> Claims:
    """A step before the FMU is initialised is accepted, or fatal."""
    if bench.is_exchange:
        return
    instance = bench.new()
    if _step(instance, bench.start_time, bench.step_size) in (0, 1):
        yield f"{bench.binary.prefix}DoStep", "a step before initialisation is accepted"
    else:
        instance.broken = True


@warning("2.1.5", "2.3.1", "return at once when the pointer is NULL")
def freeing_nothing(bench: Bench) -> Claims:
    """FreeInstance of a null pointer is fatal instead of ignored."""
    bench.binary.function("FreeInstance", None)(c_void_p())
    return ()
