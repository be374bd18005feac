"""Rules about what must be the same again, bit for bit."""

from __future__ import annotations

from stickslip.fmucheck.rules import Claims, error, warning
from stickslip.fmucheck.running.bench import Bench
from stickslip.fmucheck.running.calls import CallFailed
from stickslip.fmucheck.running.run import STEPS, Run, changes, finished, new_run


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
        yield (
            f"{bench.binary.prefix}Reset",
            f"the run after it is not that of a new instance: {where}",
        )


@warning("4.2.2", "4.2", "allow it, or declare the flag false")
def variable_steps_fail(bench: Bench) -> Claims:
    """It declares canHandleVariableCommunicationStepSize, but other steps fail."""
    if bench.is_exchange or not bench.interface.flag("canHandleVariableCommunicationStepSize"):
        return
    run = new_run(bench)
    run.begin()
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
