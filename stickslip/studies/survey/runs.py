"""One run of a file of another tool, here or in FMPy, in a process of its own."""

import logging
import multiprocessing
import os
import signal
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import numpy as np

from stickslip import cosim
from stickslip.cosim.component import Interface
from stickslip.simulation import Model

_CONTEXT = multiprocessing.get_context("forkserver")
_CONTEXT.set_forkserver_preload(["fmpy.simulation", "stickslip.simulation"])
_FMPY = {"co_simulation": "CoSimulation", "model_exchange": "ModelExchange"}


Run = Callable[..., "Iterator[Outcome]"]


@dataclass(frozen=True)
class Task:
    """What is run: a file, of an FMU by one of its interfaces."""

    path: Path
    interface: Interface | None = None


@dataclass(frozen=True)
class Times:
    """Start, stop and step of both runs, s."""

    start: float
    stop: float
    step: float


@dataclass
class Outcome:
    """What came of a run."""

    fault: str = ""  # the error in one line, or ``died`` or ``out of time``; empty where it worked
    times: Times | None = None  # of the run
    time: np.ndarray[Any, Any] = field(default_factory=lambda: np.empty(0))
    # name -> (n,) float64, at the points in time ``time`` (s)
    signals: dict[str, np.ndarray[Any, Any]] = field(default_factory=dict)
    # whether a second run gave the same bits; None where none came to its end
    again: bool | None = None


def here(task: Task) -> Iterator[Outcome]:
    """Run a file here as ``stickslip simulate --allow-nan`` does, and again; packages as FMPy."""
    model = _model(task)
    start, stop = model.experiment.start or 0.0, model.experiment.stop
    if stop is None or stop <= start:
        stop = start + 1.0
    n = max(1, round((stop - start) / model.step(start, stop)))
    times = Times(start, stop, (stop - start) / n)
    coupling = "gauss_seidel" if task.interface else "jacobi"
    prefix = "" if task.interface is None else f"{next(iter(model.system.components))}."
    with model.prepare(
        stop=stop, step=times.step, coupling=coupling, allow_nan=True, isolation="process"
    ) as simulation:
        first = simulation.run(inputs=model.inputs)
        signals = {name.removeprefix(prefix): first[name] for name in first.names}
        yield Outcome("", times, first.time, signals)
        second = simulation.run(inputs=model.inputs)
    again = np.array_equal(first.values, second.values, equal_nan=True)
    yield Outcome("", times, first.time, signals, again=again)


def _model(task: Task) -> Model:
    if task.interface is None:
        return Model.open(task.path)
    fmu = cosim.Fmu(task.path, interface=task.interface)
    system = cosim.System(task.path.stem)
    system.add(fmu.identifier, fmu)
    return Model(task.path, system, fmu.experiment)


def in_fmpy(task: Task, times: Times | None, names: Iterable[str]) -> Iterator[Outcome]:
    """Run a file in FMPy, as ``fmpy simulate`` does; it records these names, or what it chooses.

    Its rows of a package have the time at which the step began, which is corrected.
    """
    from fmpy.simulation import simulate_fmu
    from fmpy.ssp.simulation import simulate_ssp

    how: dict[str, Any] = {}
    if task.interface is None:
        if times:
            how = {"start_time": times.start, "stop_time": times.stop, "step_size": times.step}
        table = simulate_ssp(str(task.path), **how)
    else:
        if times:
            how = {"start_time": times.start, "stop_time": times.stop}
            how["output_interval"] = times.step
            owners = {name.partition("[")[0] for name in names} | {*names}
            how["output"] = sorted(owners)
        table = simulate_fmu(
            str(task.path),
            validate=False,
            fmi_type=_FMPY[task.interface],
            record_events=False,
            **how,
        )
    time_column = np.asarray(table["time"], dtype=float)
    if task.interface is None and len(time_column) > 1:
        time_column = time_column + (time_column[1] - time_column[0])
    signals = {}
    for name in table.dtype.names[1:]:
        values = np.asarray(table[name], dtype=float)
        if values.ndim == 1:
            signals[name] = values
            continue
        for place in np.ndindex(values.shape[1:]):
            indices = ",".join(str(i + 1) for i in place)
            signals[f"{name}[{indices}]"] = values[(slice(None), *place)]
    yield Outcome("", times, time_column, signals)


def apart(run: Run, *arguments: object, limit: float) -> Outcome:
    """Return the last outcome of a run in a process of its own, within a limited time (s)."""
    receiver, sender = _CONTEXT.Pipe(duplex=False)
    outcome, end = None, time.monotonic() + limit
    with tempfile.TemporaryDirectory(prefix="stickslip-") as folder:
        process = _CONTEXT.Process(target=_serve, args=(run, arguments, folder, sender))
        process.start()
        sender.close()
        with suppress(EOFError):
            while receiver.poll(max(0.0, end - time.monotonic())):
                following: Outcome = receiver.recv()
                outcome = following if outcome is None or not following.fault else outcome
            outcome = outcome or Outcome("out of time")
        with suppress(OSError):
            os.killpg(process.pid or 0, signal.SIGKILL)
        process.join()
    if outcome is None:
        code = process.exitcode or 0
        return Outcome(f"died: {signal.Signals(-code).name if code < 0 else f'status {code}'}")
    return outcome


def _serve(run: Run, arguments: tuple[object, ...], folder: str, sender: Connection) -> None:
    os.setsid()
    os.chdir(folder)
    os.environ["TMPDIR"] = tempfile.tempdir = folder
    nothing = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nothing, 1)
    os.dup2(nothing, 2)
    logging.disable()
    try:
        for outcome in run(*arguments):
            sender.send(outcome)
    except (Exception, SystemExit) as error:  # noqa: BLE001 - of any tool
        sender.send(Outcome(f"{type(error).__name__}: {' '.join(str(error).split())}"))
