"""Rules about the complete state: saved, restored, and as bytes."""

from __future__ import annotations

from collections.abc import Iterator
from ctypes import c_void_p

from stickslip.fmucheck.rules import Claims, error, warning
from stickslip.fmucheck.running.bench import Bench
from stickslip.fmucheck.running.repeating import difference
from stickslip.fmucheck.running.run import STEPS, Run, finished, new_run

_HALF = STEPS // 2


def _saved(bench: Bench) -> Iterator[tuple[Run, c_void_p]]:
    """Yield a run half way through and its saved state, if there is one; free the state."""
    if bench.interface.flag("canGetAndSetFMUState"):
        run = half_way(bench)
        state = run.instance.save()
        yield run, state
        if state.value is not None:
            run.instance.free_state(state)


def half_way(bench: Bench) -> Run:
    """Return a run half way through."""
    run = new_run(bench)
    run.begin()
    run.go(_HALF)
    return run


@error("2.1.8", "2.2.7", "save and restore every part of the state")
def restored_state_differs(bench: Bench) -> Claims:
    """A run that goes on from a restored state is not the run that was saved."""
    for run, state in _saved(bench):
        expected, again = run.branch(), run.branch()
        expected.go(STEPS)
        run.instance.restore(state)
        again.go(STEPS)
        if where := difference(expected.rows, again.rows):
            yield bench.interface.kind, f"after save and restore: {where}"


@error("2.1.8", "2.2.7", "only copy")
def saving_changes_the_run(bench: Bench) -> Claims:
    """A run in which the state is saved is not the run in which it is not."""
    for run, state in _saved(bench):
        run.go(STEPS - _HALF)
        run.instance.save(state)
        if where := difference(finished(bench).rows, run.rows):
            yield bench.interface.kind, f"saving changes the run: {where}"


@warning("2.1.8", "2.2.7", "write NULL to the pointer")
def freed_state_stays(bench: Bench) -> Claims:
    """Freeing a saved state does not set the pointer to NULL."""
    for run, state in _saved(bench):
        run.instance.free_state(state)
        if state.value is not None:
            state.value = None  # it is not freed twice
            name = f"{bench.binary.prefix}Free{run.instance.state_name}"
            yield name, "leaves the pointer as it was"


@error("2.1.8", "2.2.7", "write every part of the state, no pointers")
def serialised_state_differs(bench: Bench) -> Claims:
    """A new instance that goes on from serialised bytes is not the run that was saved."""
    if not bench.interface.flag("canSerializeFMUState"):
        return
    for run, state in _saved(bench):
        content = run.instance.serialise(state)
        if not content:
            yield bench.interface.kind, "the serialised state has no bytes"
            return
        expected = run.branch()
        expected.go(STEPS)
        bench.results["state"] = content.hex()
        bench.results["after"] = "\n".join(expected.rows)
        again = resumed(bench, run, content)
        if where := difference(expected.rows, again.rows):
            yield bench.interface.kind, f"after serialising into a new instance: {where}"


def resumed(bench: Bench, run: Run, content: bytes) -> Run:
    """Return a run of a new instance from where ``run`` was when its state was serialised."""
    instance = bench.new()
    again = run.branch(instance)
    start = new_run(bench, instance)
    start.begin()
    state = instance.deserialise(content)
    instance.restore(state)
    instance.free_state(state)
    again.go(STEPS)
    return again
