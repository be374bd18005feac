"""Rules about what must be the same again, bit for bit: runs, and the complete state.

The last two compare with what a first process has left.
"""

from collections.abc import Iterator
from ctypes import c_void_p

from stickslip.fmucheck.rules import Claims, error, warning
from stickslip.fmucheck.running.bench import Bench
from stickslip.fmucheck.running.calls import CallFailed
from stickslip.fmucheck.running.run import STEPS, Run, changes, finished, new_run

_HALF = STEPS // 2


def difference(a: list[str], b: list[str]) -> str | None:
    """Return where two records part, ``None`` when they are the same."""
    for step, (x, y) in enumerate(zip(a, b, strict=False), 1):
        if x != y:
            return f"they part at step {step}"
    return None if len(a) == len(b) else f"one has {len(a)} steps, the other {len(b)}"


@error("2.1.5", "2.3.1", "keep all state in the instance")
def second_run_differs(bench: Bench) -> Claims:
    """A second instance in the same process, after the first, gives another result."""
    first = finished(bench)
    rows = first.rows
    bench.results["rows"] = "\n".join(rows)
    bench.free(first.instance)
    if where := difference(rows, finished(bench).rows):
        yield bench.interface.kind, f"two runs of new instances differ: {where}"


@error("2.1.5", "2.3.1", "keep all state in the instance, none global")
def instances_share_state(bench: Bench) -> Claims:
    """Two instances that run side by side influence each other."""
    alone = []
    for phase in (0.0, 1.0):
        run = _begun(bench, phase)
        run.go(STEPS)
        alone.append(run.rows)
        bench.free(run.instance)
    pair = [_begun(bench, phase) for phase in (0.0, 1.0)]
    for _ in range(STEPS):
        for run in pair:
            run.go(1)
    for expected, run in zip(alone, pair, strict=True):
        if where := difference(expected, run.rows):
            yield bench.interface.kind, f"interleaved with another instance: {where}"
            return


def _begun(bench: Bench, phase: float) -> Run:
    """Return a run that has begun; with a phase also its parameters are others."""
    run = new_run(bench, phase=phase)
    run.begin(changes(bench) if phase else ())
    return run


@error("2.1.6", "2.3.1", "put everything back to its start value")
def reset_forgets_something(bench: Bench) -> Claims:
    """After other parameters, a run and a reset, it does not run as a new instance does."""
    expected = finished(bench).rows
    run = _begun(bench, phase=1.0)
    run.go(STEPS)
    instance = run.instance
    instance.do("Reset")
    if where := difference(expected, finished(bench, instance).rows):
        what = f"the run after it is not that of a new instance: {where}"
        yield f"{bench.binary.prefix}Reset", what


@warning("4.2.2", "4.2", "allow it, or declare the flag false")
def variable_steps_fail(bench: Bench) -> Claims:
    """It declares canHandleVariableCommunicationStepSize, but other steps fail."""
    if bench.is_exchange or not bench.interface.flag("canHandleVariableCommunicationStepSize"):
        return
    run = finished(bench, steps=0)
    time = bench.start_time
    unit = 1.0 if bench.interface.given.get("fixedInternalStepSize") else 0.5
    for factor in (1.0, unit, unit, 2.0):
        try:
            if run.instance.step(time, factor * bench.step_size):
                return
        except CallFailed as failed:
            yield bench.interface.kind, f"{failed}: {factor} times the default step"
            return
        time += factor * bench.step_size


def _saved(bench: Bench) -> Iterator[tuple[Run, c_void_p]]:
    """Yield a run half way through and its saved state, if there is one; free the state."""
    if bench.interface.flag("canGetAndSetFMUState"):
        run = finished(bench, steps=_HALF)
        state = run.instance.save()
        yield run, state
        if state.value is not None:
            run.instance.free_state(state)


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
    finished(bench, instance, steps=0)
    state = instance.deserialise(content)
    instance.restore(state)
    instance.free_state(state)
    again.go(STEPS)
    return again


@error("2.1.5", "2.3.1", "leave out clocks, addresses and random numbers", stage="rerunning")
def other_process_differs(bench: Bench) -> Claims:
    """The same run in another process gives another result."""
    if "rows" in bench.first:
        expected = bench.first["rows"].split("\n")
        if where := difference(expected, finished(bench).rows):
            yield bench.interface.kind, f"two processes differ: {where}"


@error("2.1.8", "2.2.7", "write values, not addresses", stage="rerunning")
def state_lost_in_other_process(bench: Bench) -> Claims:
    """A state that was serialised in one process does not go on in another."""
    if "state" in bench.first:
        expected = bench.first["after"].split("\n")
        half = finished(bench, steps=_HALF)
        again = resumed(bench, half, bytes.fromhex(bench.first["state"]))
        if where := difference(expected, again.rows):
            yield bench.interface.kind, f"after serialising into another process: {where}"
