"""The runs of a folder, and the verdict on each.

Each file (once for each content) runs by each of its interfaces, in a process of its own. Outputs
that both have differ by a share of the greatest value of each: equal (1e-12), near (1e-3) or
different.
"""

import hashlib
import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from stickslip.cosim.component import Interface
from stickslip.cosim.errors import CosimError
from stickslip.cosim.fmu.fmu import described
from stickslip.studies.survey.runs import Outcome, Task, apart, here, in_fmpy

EQUAL, NEAR = 1e-12, 1e-3
"""Largest differences that are called so, as shares of the greatest value: rounding alone, and the
tolerance of usual solvers."""
NO_BINARY = ("no binary for this machine", "cannot be simulated on the current platform")
_TAGS: dict[str, Interface] = {"CoSimulation": "co_simulation", "ModelExchange": "model_exchange"}
COLUMNS = ("file", "interface", "outcome", "difference", "signal", "here", "FMPy")


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


def compare(ours: Outcome, theirs: Outcome) -> tuple[str, float, str]:
    """Return the verdict on two runs that worked, the largest difference, and its signal."""
    names = {name: name for name in theirs.signals}
    for name in theirs.signals:  # FMPy gives connectors the path of their systems
        names.setdefault(name.partition(".")[2], name)
    step = ours.times.step if ours.times else 1.0
    # of rows at one time, the last is the one after events
    rows = np.searchsorted(theirs.time, ours.time + 1e-6 * step, side="right") - 1
    known = (rows >= 0) & (np.abs(theirs.time[rows] - ours.time) < 1e-6 * step)
    worst, where, common = 0.0, "", 0
    for name, values in ours.signals.items():
        if name not in names:
            continue
        common += 1
        other = theirs.signals[names[name]][rows][known]
        mine = values[known]
        both = np.abs(np.concatenate((mine, other)))
        scale = np.max(both, where=np.isfinite(both), initial=0.0)
        same = (mine == other) | (np.isnan(mine) & np.isnan(other))
        with np.errstate(invalid="ignore"):  # of infinite values
            apart_by = np.where(same, 0.0, np.abs(mine - other))
        apart_by[np.isnan(apart_by)] = np.inf  # a number and none
        difference = float(np.max(apart_by, initial=0.0)) / (scale or 1.0)
        if difference > worst:
            worst, where = difference, name
    if not common:
        return "no common output", 0.0, ""
    verdict = "equal" if worst <= EQUAL else "near" if worst <= NEAR else "different"
    return verdict, worst, where


def surveyed(folder: Path, task: Task, limit: float, *, fmpy: bool) -> tuple[str, ...]:
    """Run a task here, and in FMPy if asked to, each at most so long [s]; return its row."""
    ours = apart(here, task, limit=limit)
    difference, signal, theirs = 0.0, "", Outcome()
    if fmpy:
        theirs = apart(in_fmpy, task, ours.times, list(ours.signals), limit=limit)
    if ours.fault and any(lack in ours.fault + theirs.fault for lack in NO_BINARY):
        outcome = "no binary"
    elif lacks := re.search(r"No module named '(\w+)", theirs.fault):
        outcome = f"FMPy lacks {lacks[1]}"
    elif theirs.fault:
        outcome = "works in neither" if ours.fault else "works here only"
    elif ours.fault:
        died = ours.fault.startswith(("died", "out of time"))
        kind = ours.fault.partition(":")[0] if died else "refused"
        outcome = "works in FMPy only" if fmpy else kind
    elif ours.again is False:
        outcome = "second run differs"
    elif fmpy:
        outcome, difference, signal = compare(ours, theirs)
    else:
        outcome = "ran"
    name = str(task.path.relative_to(folder))
    shown = f"{difference:.2g}" if difference else ""
    return name, task.interface or "package", outcome, shown, signal, ours.fault, theirs.fault
