"""Rules about the complete state: saved, restored, and as bytes."""

from __future__ import annotations

from stickslip.fmucheck.rules import Claims, error, warning
from stickslip.fmucheck.running.bench import Bench
from stickslip.fmucheck.running.repeating import difference
from stickslip.fmucheck.running.run import STEPS, Run, finished, new_run

_HALF = STEPS // 2


def _saves(bench: Bench) -> bool:
    return bench.interface.flag("canGetAndSetFMUState")


def _serialises(bench: Bench) -> bool:
    return _saves(bench) and bench.interface.flag("canSerializeFMUState")


def half_way(bench: Bench) -> Run:
    """Return a run half way through."""
    run = new_run(bench)
    run.begin()
    run.go(_HALF)
    return run


@error("2.1.8", "2.2.7", "save and restore every part of the state")
def restored_state_differs(bench: Bench) -> Claims:
    """A run that goes on from a restored state is not the run that was saved."""
    if not _saves(bench):
        return
    run = half_way(bench)
    state = run.instance.save()
    expected, again = run.branch(), run.branch()
    expected.go(STEPS)
    run.instance.restore(state)
    again.go(STEPS)
    if where := difference(expected.rows, again.rows):
        yield bench.interface.kind, f"after save and restore: {where}"
    run.instance.free_state(state)


@error("2.1.8", "2.2.7", "only copy")
def saving_changes_the_run(bench: Bench) -> Claims:
    """A run in which the state is saved is not the run in which it is not."""
    if not _saves(bench):
        return
    run = half_way(bench)
    state = run.instance.save()
    run.go(STEPS - _HALF)
    run.instance.save(state)
    if where := difference(finished(bench).rows, run.rows):
        yield bench.interface.kind, f"saving changes the run: {where}"
    run.instance.free_state(state)


@warning("2.1.8", "2.2.7", "write NULL to the pointer")
def freed_state_stays(bench: Bench) -> Claims:
    """Freeing a saved state does not set the pointer to NULL."""
    if not _saves(bench):
        return
    run = half_way(bench)
    state = run.instance.save()
    run.instance.free_state(state)
    if state.value is not None:
        yield f"{bench.binary.prefix}Free{run.instance.state_name}", "leaves the pointer as it was"


@error("2.1.8", "2.2.7", "write every part of the state, no pointers")
def serialised_state_differs(bench: Bench) -> Claims:
    """A new instance that goes on from serialised bytes is not the run that was saved."""
    if not _serialises(bench):
        return
    run = half_way(bench)
    state = run.instance.save()
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
