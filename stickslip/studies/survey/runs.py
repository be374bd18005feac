"""The runs of a folder, here and in FMPy, and the verdict on each.

Each file (once for each content) runs by each of its interfaces, in a process of its own. Outputs
that both have differ by a share of the greatest value of each: equal (1e-12), near (1e-3) or
different.
"""

import hashlib
import logging
import multiprocessing
import os
import re
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
from stickslip.cosim.errors import CosimError
from stickslip.cosim.fmu.fmu import described
from stickslip.simulation import Model

_CONTEXT = multiprocessing.get_context("forkserver")
_CONTEXT.set_forkserver_preload(["fmpy.simulation", "stickslip.simulation"])
_FMPY = {"co_simulation": "CoSimulation", "model_exchange": "ModelExchange"}

Run = Callable[..., "Iterator[RunOutcome]"]
Times = tuple[float, float, float]  # start, stop and step of both runs [s]


@dataclass(frozen=True)
class Task:
    """What is run: a file, of an FMU by one of its interfaces."""

    path: Path
    interface: Interface | None = None


@dataclass
class RunOutcome:
    """What came of a run."""

    fault: str = ""  # the error in one line, or ``died`` or ``out of time``; empty where it worked
    times: Times | None = None  # of the run
    time: np.ndarray[Any, Any] = field(default_factory=lambda: np.empty(0))
    # name -> (n,) float64, at the points in time ``time`` (s)
    signals: dict[str, np.ndarray[Any, Any]] = field(default_factory=dict)
    # whether a second run gave the same bits; None where none came to its end
    again: bool | None = None


def here(task: Task) -> Iterator[RunOutcome]:
    """Run a file here as ``stickslip simulate --allow-nan`` does, and again; packages as FMPy."""
    model = _model(task)
    start, stop = model.experiment.start or 0.0, model.experiment.stop
    if stop is None or stop <= start:
        stop = start + 1.0
    n = max(1, round((stop - start) / model.step(start, stop)))
    times = start, stop, (stop - start) / n
    coupling = "gauss_seidel" if task.interface else "jacobi"
    prefix = "" if task.interface is None else f"{next(iter(model.system.components))}."
    with model.prepare(
        stop=stop, step=times[2], coupling=coupling, allow_nan=True, isolation="process"
    ) as simulation:
        first = simulation.run(inputs=model.inputs)
        signals = {name.removeprefix(prefix): first[name] for name in first.names}
        yield RunOutcome("", times, first.time, signals)
        second = simulation.run(inputs=model.inputs)
    again = np.array_equal(first.values, second.values, equal_nan=True)
    yield RunOutcome("", times, first.time, signals, again=again)


def _model(task: Task) -> Model:
    if task.interface is None:
        return Model.open(task.path)
    fmu = cosim.Fmu(task.path, interface=task.interface)
    system = cosim.System(task.path.stem)
    system.add(fmu.identifier, fmu)
    return Model(task.path, system, fmu.experiment)


def in_fmpy(task: Task, times: Times | None, names: Iterable[str]) -> Iterator[RunOutcome]:
    """Run a file in FMPy, as ``fmpy simulate`` does; it records these names, or what it chooses.

    Its rows of a package have the time at which the step began, which is corrected.
    """
    from fmpy.simulation import simulate_fmu
    from fmpy.ssp.simulation import simulate_ssp

    how: dict[str, Any] = {}
    if times:
        step = "output_interval" if task.interface else "step_size"
        how = dict(zip(("start_time", "stop_time", step), times, strict=True))
    if task.interface:
        owners = {name.partition("[")[0] for name in names} | {*names}
        how |= {"output": sorted(owners)} if times else {}
        how |= {"validate": False, "record_events": False, "fmi_type": _FMPY[task.interface]}
        table = simulate_fmu(str(task.path), **how)
    else:
        table = simulate_ssp(str(task.path), **how)
    time_column = np.asarray(table["time"], dtype=float)
    if task.interface is None and len(time_column) > 1:
        time_column = time_column + (time_column[1] - time_column[0])
    signals = {}
    for name in table.dtype.names[1:]:
        values = np.asarray(table[name], dtype=float)
        for place in np.ndindex(values.shape[1:]):
            indices = f"[{','.join(str(i + 1) for i in place)}]" if place else ""
            signals[name + indices] = values[(slice(None), *place)]
    yield RunOutcome("", times, time_column, signals)


def apart(run: Run, *arguments: object, limit: float) -> RunOutcome:
    """Return the last outcome of a run in a process of its own, within a limited time (s)."""
    receiver, sender = _CONTEXT.Pipe(duplex=False)
    outcome, end = None, time.monotonic() + limit
    with tempfile.TemporaryDirectory(prefix="stickslip-") as folder:
        process = _CONTEXT.Process(target=_serve, args=(run, arguments, folder, sender))
        process.start()
        sender.close()
        with suppress(EOFError, OSError):  # it may die in the middle of a message
            while receiver.poll(max(0.0, end - time.monotonic())):
                following: RunOutcome = receiver.recv()
                outcome = following if outcome is None or not following.fault else outcome
            outcome = outcome or RunOutcome("out of time")
        with suppress(OSError):
            os.killpg(process.pid or 0, signal.SIGKILL)
        process.join()
    if outcome is None:
        code = process.exitcode or 0
        return RunOutcome(f"died: {signal.Signals(-code).name if code < 0 else f'status {code}'}")
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
        sender.send(RunOutcome(f"{type(error).__name__}: {' '.join(str(error).split())}"))


EQUAL, NEAR = 1e-12, 1e-3
"""Largest differences that are called so, as shares of the greatest value: rounding alone, and the
tolerance of usual solvers."""
NO_BINARY = ("no binary for this machine", "cannot be simulated on the current platform")
_TAGS: dict[str, Interface] = {"CoSimulation": "co_simulation", "ModelExchange": "model_exchange"}
TOOLS = ("here", "FMPy")  # what failed in each
COLUMNS = ("file", "interface", "outcome", "difference", "signal", *TOOLS)


def tasks(folder: Path) -> Iterator[Task]:
    """Return the runs of all files below a folder, those of one content once."""
    seen = set()
    for path in sorted(p for p in folder.rglob("*") if p.suffix in (".fmu", ".ssp")):
        content = hashlib.sha256(path.read_bytes()).digest()
        if content in seen:
            continue
        seen.add(content)
        if path.suffix == ".ssp":
            yield Task(path)
            continue
        try:
            present = described(path)[1].interfaces
        except CosimError:  # the run tells
            present = {"CoSimulation": {}}
        yield from (Task(path, interface) for tag, interface in _TAGS.items() if tag in present)


def compare(ours: RunOutcome, theirs: RunOutcome) -> tuple[str, float, str]:
    """Return the verdict on two runs that worked, the largest difference, and its signal."""
    names = {name: name for name in theirs.signals}
    for name in theirs.signals:  # FMPy gives connectors the path of their systems
        names.setdefault(name.partition(".")[2], name)
    step = ours.times[2] if ours.times else 1.0
    # of rows at one time, the last is the one after events
    rows = np.searchsorted(theirs.time, ours.time + 1e-6 * step, side="right") - 1
    known = (rows >= 0) & (np.abs(theirs.time[rows] - ours.time) < 1e-6 * step)
    differences = {"": 0.0}
    for name in (name for name in ours.signals if name in names):
        other, mine = theirs.signals[names[name]][rows][known], ours.signals[name][known]
        both = np.abs(np.concatenate((mine, other)))
        scale = np.max(both, where=np.isfinite(both), initial=0.0)
        same = (mine == other) | (np.isnan(mine) & np.isnan(other))
        with np.errstate(invalid="ignore"):  # of infinite values
            apart_by = np.where(same, 0.0, np.abs(mine - other))
        apart_by[np.isnan(apart_by)] = np.inf  # a number and none
        differences[name] = float(np.max(apart_by, initial=0.0)) / (scale or 1.0)
    if len(differences) == 1:
        return "no common output", 0.0, ""
    where = max(differences, key=differences.__getitem__)
    worst = differences[where]
    verdict = "equal" if worst <= EQUAL else "near" if worst <= NEAR else "different"
    return verdict, worst, where


def verdict(ours: RunOutcome, theirs: RunOutcome, *, fmpy: bool) -> tuple[str, float, str]:
    """Return what came of a task, the largest difference, and its signal."""
    if ours.fault and any(lack in ours.fault + theirs.fault for lack in NO_BINARY):
        outcome = "no binary"
    elif lacks := re.search(r"No module named '(\w+)", theirs.fault):
        outcome = f"FMPy lacks {lacks[1]}"
    elif theirs.fault:
        outcome = "works in neither" if ours.fault else "works here only"
    elif ours.fault and fmpy:
        outcome = "works in FMPy only"
    elif ours.fault:
        ends = {"died": "died", "FmuCrashed": "died", "out of time": "out of time"}
        outcome = ends.get(ours.fault.partition(":")[0], "refused")
    elif ours.again is False:
        outcome = "second run differs"
    elif fmpy:
        return compare(ours, theirs)
    else:
        outcome = "ran"
    return outcome, 0.0, ""


def surveyed(folder: Path, task: Task, limit: float, *, fmpy: bool) -> tuple[str, ...]:
    """Run a task here, and in FMPy if asked to, each at most so long [s]; return its row."""
    ours = apart(here, task, limit=limit)
    theirs = RunOutcome()
    if fmpy:
        theirs = apart(in_fmpy, task, ours.times, list(ours.signals), limit=limit)
    outcome, difference, signal = verdict(ours, theirs, fmpy=fmpy)
    name = str(task.path.relative_to(folder))
    shown = f"{difference:.2g}" if difference else ""
    return name, task.interface or "package", outcome, shown, signal, ours.fault, theirs.fault
