"""The logs of one drive, checked or learned."""

from collections.abc import Collection
from functools import cache
from pathlib import Path

import numpy as np

from campaigns.fault_matrix.drives import DRIVES
from campaigns.fault_matrix.faults import FAULTS, Fault, cases
from campaigns.fault_matrix.outcome import outcome_of, remarks_of
from campaigns.fault_matrix.recordings import Experiment, record
from stickslip.errors import StickslipError
from stickslip.fmi.process import temporary_folder
from stickslip.logs import Description, raise_errors
from stickslip.servo.systems import build_fmus
from stickslip.studies.learn.log_learning import read_and_check

CELL = ("drive", "seed", "fault")
Row = dict[str, object]
Done = Collection[tuple[object, ...]]
"""Cells of the matrix that are not learned again."""


def learn_all(faults: list[str], done: Done, name: str, seed: int) -> list[Row]:
    """Return a row for each fault in a recording of one drive."""
    with temporary_folder() as folder:
        logs = _Logs(folder, name, seed)

        @cache
        def sound(gains: bool) -> frozenset[str]:
            return remarks_of(*logs.written(Fault(gains=gains), "none"))

        rows = []
        for case, fault in cases(faults):
            if (name, seed, case) not in done:
                log = logs.written(fault, case)
                outcome, why = outcome_of(
                    folder, logs.drive, *log, lambda fault=fault: sound(bool(fault.gains))
                )
                rows.append(_row(name, seed, case, outcome, why))
        return rows


def check_all(faults: list[str], done: Done, name: str, seed: int) -> list[Row]:
    """Return a row for each fault, with what reading and checking the log say about it."""
    rows = []
    with temporary_folder() as folder:
        logs = _Logs(folder, name, seed)
        for case, fault in cases(faults):
            if (name, seed, case) not in done:
                rows.append(_row(name, seed, case, *_checked(*logs.written(fault, case))))
    return rows


def _checked(path: Path, description: Description) -> tuple[str, str]:
    try:
        findings = read_and_check(path, description)[1]
        raise_errors(path, findings)
    except StickslipError as error:
        return "error", str(error)[-250:]
    spoils = {finding.spoils for finding in findings if finding.spoils}
    why = " | ".join(str(f) for f in findings if f.spoils or "removed" in f.advice)
    return max(spoils, default="silent"), why  # values before intervals


class _Logs:
    """The logs of one drive; each experiment is recorded once."""

    def __init__(self, folder: Path, name: str, seed: int) -> None:
        self.folder, self.drive, self.seed = folder, DRIVES[name], seed
        build_fmus(folder, {"law": self.drive.law, **self.drive.parameters})
        self._record = cache(self._recorded)

    def _recorded(self, experiment: Experiment):
        return record(self.folder, self.drive, experiment, self.seed)

    def written(self, fault: Fault, case: str) -> tuple[Path, Description]:
        """Return the file of a faulty log and its description."""
        number = list(FAULTS).index(case.removesuffix(", no gains"))
        rng = np.random.default_rng([self.seed, number])
        log, description = fault.applied(*self._record(fault.experiment), rng)
        path = self.folder / "log.csv"
        log.to_csv(path, index=False)
        return path, description


def _row(name: str, seed: int, case: str, outcome: str, why: str) -> Row:
    print(name, seed, case, outcome, why, sep="  ", flush=True)
    return {"drive": name, "seed": seed, "fault": case, "outcome": outcome, "why": why}
