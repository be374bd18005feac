"""The logs of one drive, checked or learned, and their outcomes compared with the drive."""

import math
import re
from collections.abc import Callable, Collection, Iterator
from dataclasses import replace
from functools import cache, partial
from pathlib import Path

import numpy as np

import stickslip as ss
from campaigns.fault_matrix.drives import DRIVES, Drive, record, steady
from campaigns.fault_matrix.faults import FAULTS, Fault, cases
from stickslip.errors import StickslipError
from stickslip.evaluation.motions import VALIDATION
from stickslip.fmi.process import temporary_folder
from stickslip.logs import Description, Finding, raise_errors, read_and_check
from stickslip.models import build_fmu
from stickslip.servo.systems import Compensator, build_fmus, build_loop
from stickslip.studies.learn.learned import LearnedFromRecording
from stickslip.trial.benefit import feed_of

MASS_TOLERANCE = 0.02
FRICTION_TOLERANCE = 0.05
"""Of the largest friction at the speeds visited."""
WORSE = 1.02
LEVELS = (0.99, 0.997, 1.003, 1.01)
"""Levels of friction of the runs; single ones of a drive that sticks and slips scatter."""
OUTCOMES = ("right", "flagged", "refused", "confident and wrong")


def outcome_of(
    fmus: Path,  # folder with those of the drive's loop
    drive: Drive,
    path: Path,
    description: Description,
    sound: Callable[[], frozenset[str]],  # warnings on its sound log, which flag no fault
) -> tuple[str, str]:
    """Return what becomes of a log, one of ``OUTCOMES``, and why."""
    try:
        findings = read_and_check(path, description)[1]
        raise_errors(path, findings)
        for finding in findings:
            if finding.spoils == "values":  # refused without learning, too
                return "refused", str(finding)[:200]
        learned = ss.learn(path, description)
    except StickslipError as error:
        return "refused", str(error).splitlines()[0][-200:]
    if learned.refusal or not learned.writes():
        return "refused", (learned.refusal or "no compensator helps enough")[:200]
    remarks = frozenset(map(_words, learned.estimation.faults))
    wrong = "; ".join(_wrong(fmus, drive, learned))
    if not wrong:
        return "right", " | ".join(sorted(remarks))
    new = remarks - sound() if remarks else remarks
    return "flagged" if new else "confident and wrong", f"{wrong} ({' | '.join(sorted(new))})"[:300]


def remarks_of(path: Path, description: Description) -> frozenset[str]:
    """Return the warnings about a log that make its values doubtful."""
    try:
        return frozenset(map(_words, ss.learn(path, description).estimation.faults))
    except StickslipError:
        return frozenset()


def _words(finding: Finding) -> str:
    """Return what was found without its numbers."""
    return re.sub(r"[-+]?\d[\d.e+-]*", "...", finding.what)


def _wrong(fmus: Path, drive: Drive, learned: LearnedFromRecording) -> Iterator[str]:
    """Yield what is stated too surely: values off by more than a tolerance and their interval."""
    estimation = learned.estimation
    known = estimation.known
    if (m := known.get("m")) is not None:
        off = m.value / drive.mass - 1.0
        if abs(off) > MASS_TOLERANCE and not m.low <= drive.mass <= m.high:
            yield f"m {off:+.1%} [{m.low / drive.mass - 1:+.1%}, {m.high / drive.mass - 1:+.1%}]"
    v = np.quantile(np.abs(estimation.figures.velocity_recorded), (0.5, 0.75, 0.95))
    truth = drive.friction(v)
    off = steady(estimation.parameters, v) - truth
    worst = int(np.argmax(np.abs(off)))
    if abs(off[worst]) > FRICTION_TOLERANCE * np.max(truth):
        low, high = (
            steady({name: getattr(one, end) for name, one in known.items()} | _chosen(learned), v)
            for end in ("low", "high")
        )
        if not low[worst] <= truth[worst] <= high[worst]:
            yield f"F({1e3 * v[worst]:.3g} mm/s) off by {off[worst] / truth[worst]:+.0%}"
    yield from _worse(fmus, drive, learned)


def _chosen(learned: LearnedFromRecording) -> dict[str, float]:
    """Return the parameters of the law that have no interval."""
    estimation = learned.estimation
    return {k: v for k, v in estimation.parameters.items() if k not in estimation.known}


def _worse(fmus: Path, drive: Drive, learned: LearnedFromRecording) -> Iterator[str]:
    """Yield commands that the drive follows worse with the compensator that would be written."""
    law, loop, trial = learned.estimation.law, drive.loop, learned.trial
    chain = [Compensator("compensator", "compensator", learned.compensator)]
    if trial is not None and (written := trial.compared.chosen.benefit):
        chain = list(written.variant.share(law, written.share).chain)
    for one in chain:
        own = one.law or law.name if one.model == "compensator" else None
        build_fmu(one.model, fmus, law=own, called=one.file or one.model)
    for speed in (1.0, 0.1, 0.01):
        command = replace(
            VALIDATION, height=speed * VALIDATION.height, slope=speed * VALIDATION.slope
        )
        v_cmd = command.sample(np.arange(round(command.corners()[-1] / loop.T_s) + 1) * loop.T_s)
        errors = []
        for used in ([], chain):
            system = build_loop(fmus, loop, used, feed_of(used))
            stop = (len(v_cmd) - 1) * loop.T_s
            with system.prepare(step=loop.T_s, stop=stop, record=("drive.v",)) as simulation:
                runs = [
                    simulation.run(friction, loop.commands(v_cmd))["drive.v"] - v_cmd
                    for friction in map(drive.at, LEVELS)
                ]
            errors.append(math.sqrt(float(np.mean(np.square(runs)))))
        if errors[1] > WORSE * errors[0]:
            yield f"{errors[1] / errors[0]:.2f} times the error at {1e3 * command.height:g} mm/s"


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
