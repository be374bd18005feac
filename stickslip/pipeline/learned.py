"""What was learned of a drive, in every mode, and the stages that recordings and logs share.

    recording -> ``learn_recording``: estimation -> loops -> ``try_compensator``, for a log

A reproduction validates the result on the drive instead of trying it in simulation.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import pandas as pd

from stickslip import ga
from stickslip.catalog.space import ParameterSpace
from stickslip.cosim import Trapezoid
from stickslip.evaluation.guards import (
    Benefit,
    Drive,
    Known,
    Variant,
    bench_of,
    best_of,
    family,
    feedforward,
    findings_of,
)
from stickslip.evaluation.tracking import Tracking
from stickslip.identification.controller.controller_check import AGREES
from stickslip.identification.estimation import (
    CriterionName,
    Estimation,
    Search,
    Task,
    candidate_fmus,
)
from stickslip.identification.estimation import learn as estimate
from stickslip.identification.fitting.conservative import bounded_by
from stickslip.identification.fitting.identifiability import IDENTIFIABLE, NOT_IDENTIFIABLE
from stickslip.identification.selection import choose, predictions
from stickslip.logs import Finding, Reading, Recording, implausible_mass
from stickslip.models import Law
from stickslip.pipeline.observed import BOTH, FEEDFORWARD, OBSERVER, Choice, Observed, try_observer
from stickslip.servo.axis import Axis, ControlError
from stickslip.servo.datasheet import LOOP, VALIDATION, Datasheet
from stickslip.servo.velocity_filter import Observer
from stickslip.servo.velocity_loop import (
    LoopSpecification,
    VelocityLoop,
    close_velocity_loop,
    design_velocity_loop,
)

RESERVE = 1.3
"""Largest static friction on which a compensator is tried, over the largest in the log."""
RULED_OUT = 5.0
"""Ratio to the least force error among the laws above which values of a law are ruled out."""
WIDE = 2.0
"""Largest ratio to the value taken of one on which it is tried."""
AUTO = "auto"
"""Name that stands for the law that a recording shows."""


class Loops(NamedTuple):
    """Velocity loops of a drive.

    Attributes
    ----------
    plain : without compensation
    compensated : in which the compensator runs
    known : whether the drive runs in them; False where they only serve to try the compensator
    """

    plain: VelocityLoop
    compensated: VelocityLoop
    known: bool = True


@dataclass(frozen=True)
class Learned:
    """What was learned of a drive.

    Attributes
    ----------
    friction : the compensator's parameters by name, in SI units
    loops : of the drive, or why there are none
    """

    friction: Mapping[str, float]
    loops: Loops | ControlError

    @property
    def designed(self) -> Loops:
        """The loops of the drive.

        Raises
        ------
        ControlError
            Where none can be designed.
        """
        if isinstance(self.loops, ControlError):
            raise self.loops
        return self.loops

    @property
    def known_loop(self) -> VelocityLoop | None:
        """The loop in which the compensator is to run, None where it is not known."""
        known = not isinstance(self.loops, ControlError) and self.loops.known
        return self.designed.compensated if known else None


@dataclass(frozen=True)
class SimulatedTrial:
    """What trying a compensator on simulated drives gave.

    Attributes
    ----------
    command, datasheet, drives : what it was tried on
    benefit : tracking errors of what is written, and the share of its force that passes
    warnings : of the guards, a line each
    others : the same as ``benefit`` for other ways to compensate
    observed : what a disturbance observer adds; None where none was tried
    """

    command: Trapezoid
    datasheet: Datasheet
    benefit: Benefit
    warnings: tuple[str, ...]
    drives: tuple[Drive, ...] = ()
    others: tuple[Benefit, ...] = ()
    observed: Observed | None = None

    def table(self) -> pd.DataFrame:
        """Return a row for each way to compensate, drive and command.

        Speeds and errors are in m/s, or rad/s for a rotary drive.
        """
        rows = [
            {
                "compensation": benefit.variant.name,
                "share": benefit.share,
                "drive": row.drive,
                "command": row.command,
                "speed": row.speed,
                "without": row.without,
                "with": row.compensated,
                "ratio": row.ratio,
            }
            for benefit in (self.benefit, *self.others)
            for row in benefit.rows
        ]
        return pd.DataFrame(rows)


@dataclass(frozen=True)
class LearnedFromRecording(Learned):
    """What was learned from one recording.

    Attributes
    ----------
    findings : of reading and checking it
    trial : of the compensator in a loop; None where none was closed or the drive itself is there
    implausible : why the learned mass cannot be right, or empty
    tracking : simulated in the loop of the log, without and with the compensator
    asked : what is to be written, None for what is recommended
    """

    estimation: Estimation
    findings: tuple[Finding, ...]
    seed: int
    trial: SimulatedTrial | None = None
    implausible: str = ""
    tracking: Tracking | None = None
    asked: Choice | None = None

    @property
    def choice(self) -> Choice:
        """What is written, unless it is refused: by default what is recommended."""
        observed = self.trial.observed if self.trial else None
        if self.asked is not None:
            return self.asked
        return (observed.recommended if observed else "") or FEEDFORWARD

    @property
    def benefit(self) -> Benefit | None:
        """What the feedforward does that is written, with the observer where that was asked for."""
        if self.trial is None:
            return None
        both = self.trial.observed.both if self.trial.observed else None
        return both if both and self.asked == BOTH else self.trial.benefit

    @property
    def compensator(self) -> dict[str, float]:
        """The compensator's parameters by name, in SI units, at the share of its force tried."""
        if self.benefit is None:
            return dict(self.friction)
        return self.benefit.variant.share(self.estimation.law, self.benefit.share).feedforward

    def with_whole_force(self) -> LearnedFromRecording:
        """Return the same with the compensator at its whole force, whatever that does."""
        if self.trial is None:
            return self
        benefit, observed = _whole(self.trial.benefit), self.trial.observed
        if observed and observed.both:
            observed = replace(observed, both=_whole(observed.both))
        return replace(self, trial=replace(self.trial, benefit=benefit, observed=observed))

    @property
    def refusal(self) -> str:
        """Why the compensator should not be written; empty where there is no reason."""
        benefit = self.benefit
        return self._doubt or (benefit.refusal if benefit and not benefit.acceptable else "")

    @property
    def observer(self) -> Observer | None:
        """The disturbance observer that was designed; None for none."""
        observed = self.trial.observed if self.trial else None
        return observed.designed.observer if observed and observed.designed else None

    @property
    def observer_refusal(self) -> str:
        """Why the observer should not be written; empty where there is no reason."""
        if self.trial is None or self.trial.observed is None:
            return "no disturbance observer was tried"
        return self._doubt or self.trial.observed.refusal(self.choice)

    def writes(self, *, force: bool = False) -> Choice:
        """Return what is written: the choice without what is refused, unless it is forced."""
        feedforward = self.choice in (FEEDFORWARD, BOTH) and (force or not self.refusal)
        if self.observer is None or self.choice not in (OBSERVER, BOTH):
            return FEEDFORWARD if feedforward else ""
        if self.observer_refusal and not force:
            return FEEDFORWARD if feedforward else ""
        return BOTH if feedforward else OBSERVER

    @property
    def _doubt(self) -> str:
        """Why the estimated values should not be used."""
        if self.implausible:
            return self.implausible
        for fault in self.estimation.faults:
            if fault.spoils == "values":
                return f"{fault.what}: {fault.figure}; {fault.advice}"
        return ""

    @property
    def warnings(self) -> tuple[str, ...]:
        """What should be known before the compensator is used, a line each."""
        guesses = [
            f"{name} is not identifiable in this log; the compensator takes {known.value:.4g}: "
            f"{known.sentence}"
            for name, known in self.estimation.known.items()
            if name in self.estimation.law.parameters and known.identifiability == NOT_IDENTIFIABLE
        ]
        if self.trial is None:
            return (*guesses, "no velocity loop can be closed, so the compensator is not tried")
        loop = self.designed.compensated
        if not self.designed.known:
            guesses.append(
                "no velocity loop of the log is known, so the compensator is tried in one designed "
                f"for the learned mass, K_p = {loop.K_p:.4g} and K_i = {loop.K_i:.4g}"
            )
        return (*guesses, *self.trial.warnings)


def _whole(benefit: Benefit) -> Benefit:
    return replace(benefit, share=1.0, rows=benefit.full)


def learn_recording(
    recording: Recording,
    gains: Mapping[str, float] | None,
    design: Callable[[Estimation], Loops],
    findings: tuple[Finding, ...],
    *,
    law: str = "lugre",
    criterion: CriterionName = "auto",
    seed: int = 0,
    seeds: int = 1,
    search: Search | None = None,
    on_stage: Callable[[str], object] = lambda _: None,
    on_generation: Callable[[ga.Optimiser], object] = lambda _: None,
) -> LearnedFromRecording:
    """Estimate a drive from a recording and design its loops.

    Parameters
    ----------
    gains : of the controller FMU by name; None when the controller is not known
    design : gives the loops, or raises ControlError
    findings : of reading and checking the recording
    law : of the catalogue, or ``auto`` for the one that predicts best where it is not fitted
    criterion, seed, seeds, search : see ``estimation.Task``

    Raises
    ------
    IdentificationError
        When the recording does not show a drive that slides.
    """
    faults = tuple(finding for finding in findings if finding.spoils)
    choice = None
    if law == AUTO:
        on_stage("comparing friction laws")
        workers = search.execution.workers if search else 1
        choice = choose(predictions(recording, gains, workers=workers))
        law = choice.chosen.candidate.law.name
    with candidate_fmus(law) as fmus:
        task = Task(
            fmus,
            recording,
            gains,
            criterion,
            search or Search(),
            seed,
            seeds,
            law,
            faults,
            choice,
        )
        estimation = estimate(task, on_stage, on_generation)
    try:
        loops: Loops | ControlError = design(estimation)
    except ControlError as error:
        loops = error
    return LearnedFromRecording(estimation.compensator, loops, estimation, findings, seed)


def try_compensator(
    reading: Reading,
    learned: LearnedFromRecording,
    *,
    with_observer: bool = True,
    workers: int = 1,
) -> LearnedFromRecording:
    """Try a learned compensator at the log's own speed, where a loop can be closed.

    Parameters
    ----------
    with_observer : whether a disturbance observer is designed and tried beside it
    workers : number of runs in parallel
    """
    estimation = learned.estimation
    mass = estimation.known.get("m")
    question = implausible_mass(reading, mass.low, mass.high) if mass else None
    if question and question.severity == "error":
        learned = replace(learned, implausible=str(question))
    if isinstance(learned.loops, ControlError):
        return learned
    loop = learned.loops.compensated
    top = float(np.quantile(np.abs(estimation.figures.velocity_recorded), 0.99))
    scale = top / VALIDATION.height
    command = replace(VALIDATION, height=top, slope=scale * VALIDATION.slope)
    strongest = float(np.max(np.abs(estimation.figures.measured)))
    sheet = Datasheet(
        peak_force=reading.force_limit or 1e3 * strongest,
        tau_i=loop.axis.tau_i,
        encoder_step=reading.recording.encoder_step or 1e-6 * top,
    )
    law, rotary = estimation.law, reading.recording.motion == "rotary"
    drives = family(law, learned.friction, command, known_friction(estimation))
    errors = {
        name: estimation.known[name].standard_error
        for name in estimation.fit.space.friction
        if estimation.known[name].identifiability != NOT_IDENTIFIABLE
    }
    own = learned.friction
    with bench_of(law, loop, own, drives, command, sheet, rotary=rotary, workers=workers) as bench:
        benefits = bench.benefits(feedforwards(law, learned.friction))
        best = best_of(benefits)
        found = findings_of(bench, learned.friction, best, best.share, errors)
        observed = None
        if with_observer:
            m = estimation.known["m"]
            observed = try_observer(bench, best, learned.friction, (m.low, m.high))
    others = [benefit for benefit in benefits if benefit is not best]
    if observed is not None:
        others += [part for part in (observed.alone, observed.both) if part is not None]
    trial = SimulatedTrial(
        command, sheet, best, tuple(map(str, found)), drives, tuple(others), observed
    )
    return replace(learned, trial=trial)


def feedforwards(law: Law, friction: Mapping[str, float]) -> tuple[Variant, ...]:
    """Return what may be written: feedforward of the friction, and of its level alone."""
    bounded = ParameterSpace.of(law).bounded
    level = {**friction, **{name: friction[bound] for name, bound in bounded.items()}}
    names = ", ".join(f"{name} = {bound}" for name, bound in bounded.items())
    whole = feedforward(friction)
    return (whole,) if level == friction else (whole, feedforward(level, f"feedforward, {names}"))


def known_friction(estimation: Estimation) -> Known:
    """Return what a log tells of friction besides the estimate, for ``family``.

    Static friction is bounded by the largest friction in the log, with a reserve. Other laws are
    those that were fitted to the log because its own does not explain all of it, and that the log
    does not rule out.
    """
    space, known = estimation.fit.space, estimation.known
    taken = (known[name].value for name in space.bounded)
    largest = RESERVE * max(estimation.largest_friction, *taken, 0.0)
    ranges = {}
    for name in space.friction:
        one = known[name]
        if one.identifiability != IDENTIFIABLE:
            low, high = max(one.low, one.value / WIDE), min(one.high, one.value * WIDE)
            if name in space.bounded:
                high = min(one.high, largest)
            ranges[name] = (low, high)
    values = (bounded_by(one, space, largest) for one in estimation.plausible)
    plausible = tuple(map(_of_drive, values))
    rivals = {}
    least = min((prediction.force for prediction in estimation.predictions), default=0.0)
    for prediction in estimation.predictions:
        law = prediction.candidate.law
        is_rival = law.name != estimation.law.name and not prediction.candidate.is_level
        if is_rival and prediction.force <= RULED_OUT * least:
            bounded = bounded_by(prediction.parameters, ParameterSpace.of(law), largest)
            rivals[law.name] = _of_drive(bounded)
    return Known(plausible, ranges, rivals)


def _of_drive(values: Mapping[str, float]) -> dict[str, float]:
    """Return what a drive FMU takes of the values of an estimation."""
    kept = {name: value for name, value in values.items() if name not in ("F_0", "delay")}
    return {**kept, "b": max(kept["b"], 0.0)} if "b" in kept else kept


def loops_of_log(reading: Reading, estimation: Estimation) -> Loops:
    """Return the loop of the log's controller, or one like the paper's for the learned axis.

    A controller that does not command the logged force is not that of the drive.

    Raises
    ------
    ControlError
        When the mass is not known, or no loop is stable.
    """
    known, controller = estimation.known, reading.controller
    if "m" not in known:
        raise ControlError("the mass is not known")
    axis = Axis(known["m"].value, max(known["b"].value, 0.0), reading.tau_i or 0.0)
    T_s = estimation.recording.T_s
    rejected = estimation.controller is not None and estimation.controller.error > AGREES
    if controller.K_p and not (controller.P_x or controller.I_x or rejected):
        gains = (controller.T_s or T_s, controller.tau_f, controller.K_p, controller.K_i)
        try:
            loop = close_velocity_loop(axis, *gains)
        except ControlError:
            pass
        else:
            return Loops(loop, loop)
    bandwidth = LOOP.bandwidth * LOOP.T_s / T_s
    loop = design_velocity_loop(axis, LoopSpecification(bandwidth, LOOP.phase_margin, T_s, T_s))
    return Loops(loop, loop, known=False)
