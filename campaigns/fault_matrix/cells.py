"""The logs of one drive, checked or learned."""

from collections.abc import Callable, Collection
from functools import cache, partial
from pathlib import Path

import numpy as np

from campaigns.fault_matrix.drives import DRIVES, record
from campaigns.fault_matrix.faults import FAULTS, Fault, cases
from campaigns.fault_matrix.outcome import outcome_of, remarks_of
from stickslip.errors import StickslipError
from stickslip.fmi.process import temporary_folder
from stickslip.logs import Description, raise_errors, read_and_check
from stickslip.servo.systems import build_fmus

CELL = ("drive", "seed", "fault")
Row = dict[str, object]
Done = Collection[tuple[object, ...]]
"""Cells of the matrix that are not learned again."""


class _Logs:
    """The logs of one drive; each experiment is recorded once."""

    def __init__(self, folder: Path, name: str, seed: int) -> None:
        self.folder, self.drive, self.seed = folder, DRIVES[name], seed
        build_fmus(folder, {"law": self.drive.law, **self.drive.parameters})
        self._record = cache(partial(record, folder, self.drive, seed=seed))
        self._sound = cache(lambda gains: remarks_of(*self.written(Fault(gains=gains), "none")))

    def written(self, fault: Fault, case: str) -> tuple[Path, Description]:
        """Return the file of a faulty log and its description."""
        number = list(FAULTS).index(case.removesuffix(", no gains"))
        rng = np.random.default_rng([self.seed, number])
        log, description = fault.applied(*self._record(fault.experiment), rng)
        path = self.folder / "log.csv"
        log.to_csv(path, index=False)
        return path, description

    def learned(self, fault: Fault, case: str) -> tuple[str, str]:
        """Return what becomes of a log, and why."""
        sound = partial(self._sound, bool(fault.gains))
        return outcome_of(self.folder, self.drive, *self.written(fault, case), sound)

    def checked(self, fault: Fault, case: str) -> tuple[str, str]:
        """Return what reading and checking a log say about it."""
        path, description = self.written(fault, case)
        try:
            findings = read_and_check(path, description)[1]
            raise_errors(path, findings)
        except StickslipError as error:
            return "error", str(error)[-250:]
        spoils = {finding.spoils for finding in findings if finding.spoils}
        why = " | ".join(str(f) for f in findings if f.spoils or "removed" in f.advice)
        return max(spoils, default="silent"), why  # values before intervals


def _rows(
    outcome: Callable[[_Logs, Fault, str], tuple[str, str]],
    faults: list[str],
    done: Done,
    name: str,
    seed: int,
) -> list[Row]:
    """Return a row for each fault in a recording of one drive."""
    rows: list[Row] = []
    with temporary_folder() as folder:
        logs = _Logs(folder, name, seed)
        for case, fault in cases(faults):
            if (name, seed, case) not in done:
                what, why = outcome(logs, fault, case)
                print(name, seed, case, what, why, sep="  ", flush=True)
                row = {"drive": name, "seed": seed, "fault": case, "outcome": what, "why": why}
                rows.append(row)
    return rows


learn_all = partial(_rows, _Logs.learned)
check_all = partial(_rows, _Logs.checked)
