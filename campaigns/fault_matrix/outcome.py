"""The outcome of one log, compared with the drive that made it."""

import math
import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

import stickslip as ss
from campaigns.fault_matrix.drives import Drive, steady
from stickslip.errors import StickslipError
from stickslip.evaluation.motions import VALIDATION
from stickslip.logs import Description, Finding, raise_errors, read_and_check
from stickslip.models import build_fmu
from stickslip.servo.systems import Compensator, build_loop
from stickslip.studies.learn.learned import LearnedFromRecording

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
    if learned.refusal:
        return "refused", learned.refusal[:200]
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
    build_fmu("compensator", fmus, law=law.name)
    chain = [Compensator("compensator", "compensator", learned.compensator)]
    if trial is not None:
        chain = list(trial.benefit.variant.share(law, trial.benefit.share).chain)
    for speed in (1.0, 0.1, 0.01):
        command = replace(
            VALIDATION, height=speed * VALIDATION.height, slope=speed * VALIDATION.slope
        )
        v_cmd = command.sample(np.arange(round(command.corners()[-1] / loop.T_s) + 1) * loop.T_s)
        errors = []
        for used in ([], chain):
            system = build_loop(fmus, loop, used)
            stop = (len(v_cmd) - 1) * loop.T_s
            with system.prepare(step=loop.T_s, stop=stop, record=("drive.v",)) as simulation:
                runs = [
                    simulation.run(friction, loop.commands(v_cmd))["drive.v"] - v_cmd
                    for friction in map(drive.at, LEVELS)
                ]
            errors.append(math.sqrt(float(np.mean(np.square(runs)))))
        if errors[1] > WORSE * errors[0]:
            yield f"{errors[1] / errors[0]:.2f} times the error at {1e3 * command.height:g} mm/s"
