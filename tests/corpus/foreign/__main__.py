"""``python -m tests.corpus.foreign FOLDER``: each FMU and package below it, here and in FMPy.

Each file (once for each content) runs by each of its interfaces, in a process of its own. A line
for each run has how it ended here and in FMPy, and how far the outputs that both have are apart, as
a share of the greatest value of each: equal (1e-12), near (1e-3) or different.
"""

from __future__ import annotations

import argparse
import csv
import hashlib
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

from stickslip.cosim.component import Interface
from stickslip.cosim.errors import CosimError
from stickslip.cosim.fmu.fmu import described
from tests.corpus.foreign.runs import Outcome, Task, apart, here, in_fmpy

EQUAL, NEAR = 1e-12, 1e-3
NO_BINARY = ("no binary for this machine", "cannot be simulated on the current platform")
_TAGS: dict[str, Interface] = {"CoSimulation": "co_simulation", "ModelExchange": "model_exchange"}
_COLUMNS = ("file", "interface", "outcome", "difference", "signal", "here", "FMPy")


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
        for tag in _TAGS.keys() & present.keys():
            yield Task(path, _TAGS[tag])


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
        scale = max(np.nanmax(np.abs(mine), initial=0.0), np.nanmax(np.abs(other), initial=0.0))
        apart_by = np.where(np.isnan(mine) & np.isnan(other), 0.0, np.abs(mine - other))
        difference = float(np.max(apart_by, initial=0.0)) / (scale or 1.0)
        if not difference <= worst:
            worst, where = difference, name
    if not common:
        return "no common output", 0.0, ""
    verdict = "equal" if worst <= EQUAL else "near" if worst <= NEAR else "different"
    return verdict, worst, where


def line(folder: Path, task: Task, limit: float) -> tuple[str, ...]:
    """Run a task here and in FMPy, and return its row of the table."""
    ours = apart(here, task, limit=limit)
    theirs = apart(in_fmpy, task, ours.times, list(ours.signals), limit=limit)
    difference, signal = 0.0, ""
    if ours.fault and any(lack in ours.fault + theirs.fault for lack in NO_BINARY):
        outcome = "no binary"
    elif ours.fault or theirs.fault:
        here_alone = "works here only" if theirs.fault else "works in FMPy only"
        outcome = "works in neither" if ours.fault and theirs.fault else here_alone
    elif ours.again is False:
        outcome = "second run differs"
    else:
        outcome, difference, signal = compare(ours, theirs)
    name = str(task.path.relative_to(folder))
    shown = f"{difference:.2g}" if difference else ""
    return name, task.interface or "package", outcome, shown, signal, ours.fault, theirs.fault


def main() -> None:
    """Run all, print a line for each and the number of each outcome."""
    options = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    options.add_argument("folder", type=Path)
    options.add_argument("--timeout", type=float, default=60.0, help="of each process [s]")
    options.add_argument("--workers", type=int, default=2)
    options.add_argument("--out", type=Path, help="the table as CSV")
    given = options.parse_args()
    rows = []
    with ThreadPoolExecutor(given.workers) as pool:
        for row in pool.map(lambda t: line(given.folder, t, given.timeout), tasks(given.folder)):
            print("  ".join(filter(None, row)), flush=True)
            rows.append(row)
    if given.out:
        with given.out.open("w", newline="") as file:
            csv.writer(file).writerows([_COLUMNS, *rows])
    counts = Counter(row[2] for row in rows)
    runs = len(rows) - counts["no binary"]
    works = [sum(not row[k] for row in rows) for k in (5, 6)]
    print(f"\n{runs} runs; {works[0]} work here, {works[1]} in FMPy")
    for outcome, n in counts.most_common():
        print(f"{n:5}  {outcome}")


if __name__ == "__main__":
    main()
