"""What was learned of a drive, in every mode, and the stages that recordings and logs share.

    recording -> ``learn_recording``: estimation -> loops

What a log gives is then tried in simulation; a reproduction validates it on the drive.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import pandas as pd

from stickslip.cosim.display import html_table
from stickslip.errors import with_settings
from stickslip.evaluation.tracking import Tracking
from stickslip.fmi.messages import escaped
from stickslip.identification.criteria.controller_check import with_force
from stickslip.identification.estimation import Estimation, LearnSettings, Task, candidate_fmus
from stickslip.identification.estimation import learn as estimate
from stickslip.identification.fitting.identifiability import NOT_IDENTIFIABLE
from stickslip.identification.selection.choice import choose
from stickslip.identification.selection.prediction import predictions
from stickslip.identification.sliding.log_offsets import with_log_offsets
from stickslip.identification.sliding.position_force import (
    block_parameters,
    find_position_force,
    with_position_force,
)
from stickslip.logs import Finding, Recording
from stickslip.loops.other_gains import OtherGains
from stickslip.output import SILENT, Progress
from stickslip.servo.axis import ControlError
from stickslip.servo.systems import Compensator
from stickslip.servo.velocity_loop import VelocityLoop
from stickslip.studies.learn import tables
from stickslip.studies.learn.predicted_logs import PredictedLog
from stickslip.trial.benefit import Benefit
from stickslip.trial.candidates import AUTO
from stickslip.trial.compensator_trial import Loops, SimulatedTrial
from stickslip.trial.observed import BOTH, FEEDFORWARD, OBSERVER, Choice


@dataclass(frozen=True)
class Learned:
    """What was learned of a drive."""

    friction: Mapping[str, float]  # the compensator's parameters by name, in SI units
    loops: Loops | ControlError  # of the drive, or why there are none

    @property
    def refusal(self) -> str:
        """Why the compensator should not be used; empty where there is no reason."""
        return ""

    @property
    def designed(self) -> Loops:
        """The loops of the drive; raises ControlError where none can be designed."""
        if isinstance(self.loops, ControlError):
            raise self.loops
        return self.loops

    @property
    def known_loop(self) -> VelocityLoop | None:
        """The loop in which the compensator is to run, None where it is not known."""
        known = not isinstance(self.loops, ControlError) and self.loops.known
        return self.designed.compensated if known else None


@dataclass(frozen=True)
class LearnedFromRecording(Learned):
    """What was learned from one recording."""

    estimation: Estimation
    findings: tuple[Finding, ...]  # of reading and checking it
    seed: int
    # of the compensator in a loop; None where none was closed or the drive itself is there
    trial: SimulatedTrial | None = None
    implausible: str = ""  # why the learned mass or the loop of the log cannot be right, or empty
    # simulated in the loop of the log, without and with the compensator
    tracking: Tracking | None = None
    asked: str = AUTO  # the compensator to be written, see ``candidates``
    other_gains: OtherGains | None = None  # of the controller, with what is written
    predicted: tuple[PredictedLog, ...] = ()  # logs that were not learned from
    hashes: Mapping[str, str] = field(default_factory=dict)  # SHA-256 of the logs, by file name

    def table(self) -> pd.DataFrame:
        """Return a row for each parameter in SI units, with its 95 % interval."""
        return tables.parameters(self.estimation).frame()

    def __repr__(self) -> str:
        values = ", ".join(
            f"{name} = {one.value:.5g}" for name, one in self.estimation.known.items()
        )
        refused = f"; not recommended: {self.refusal}" if self.refusal else ""
        return f"LearnedFromRecording({self.estimation.law.name}: {values}{refused})"

    def _repr_html_(self) -> str:
        """Return what a notebook shows: the parameters, what is written and what is warned of."""
        rows = [
            (
                *(one["parameter"], one["unit"], one["sentence"]),
                *(f"{one[key]:.5g}" for key in ("value", "low", "high")),
            )
            for one in self.table().to_dict("records")
        ]
        heads = ("parameter", "unit", "", "value", "low", "high")
        refused = [f"not recommended: {self.refusal}"] if self.refusal else []
        lines = [f"recommended: {self.writes() or 'no compensation'}", *refused, *self.warnings]
        caption = f"{self.estimation.law.title} in {self.estimation.recording.source}"
        return html_table(heads, rows, caption, words=3) + "".join(
            f"<p>{escaped(line)}</p>" for line in lines
        )

    @property
    def choice(self) -> Choice:
        """What is written, unless it is refused: by default what does best in the trial."""
        if self.trial is None:
            return FEEDFORWARD if self.asked in (AUTO, self.estimation.law.name) else ""
        return self.trial.compared.chosen.choice

    @property
    def benefit(self) -> Benefit | None:
        """What the feedforward does that is written, with the observer that is written."""
        if self.trial is None:
            return None
        chosen = self.trial.compared.chosen
        return (self.choice in (FEEDFORWARD, BOTH) and chosen.benefit) or self.trial.benefit

    @property
    def compensator(self) -> dict[str, float]:
        """Parameters of feedforward of the law, in SI units, at the share of its force tried."""
        return self._shared(self.of_law) if self.of_law else dict(self.friction)

    @property
    def of_law(self) -> Benefit | None:
        """What feedforward of the law does, with the observer where that is written."""
        if self.trial is None or self.benefit is None:
            return None
        own = self.trial.benefit.variant.feedforward_kind
        return self.benefit if self.benefit.variant.feedforward_kind == own else self.trial.benefit

    @property
    def feedforward(self) -> Compensator:
        """The feedforward that is written, at the share of its force tried."""
        if self.benefit is None:
            return Compensator("compensator", "compensator", self.friction)
        model, law = self.benefit.variant.feedforward_kind
        return Compensator("compensator", model, self._shared(self.benefit), law=law)

    @property
    def position_force(self) -> Compensator | None:
        """The block that holds gravity and cogging; None for none."""
        found = self.estimation.position_force
        values = found and block_parameters(found.values)
        return Compensator("position_force", "position_force", values) if values else None

    @property
    def run(self) -> str:
        """What ``tracking`` ran, in words."""
        if self.trial is None or self.benefit is None:
            return ""
        name, share = self.trial.compared.chosen.name, self.benefit.share
        run = f"the feedforward of {name}, without its observer," if self.choice == BOTH else name
        if self.choice not in (FEEDFORWARD, BOTH):
            run = f"feedforward of the law {self.estimation.law.title}"
        run = f"{run} at {share:g} of its force" if share != 1.0 else run
        if self.choice in (FEEDFORWARD, BOTH):
            return run.removesuffix(",")
        return f"{run}, which is not written"

    def _shared(self, benefit: Benefit) -> dict[str, float]:
        return benefit.variant.share(self.estimation.law, benefit.share).feedforward

    def with_whole_force(self) -> "LearnedFromRecording":
        """Return the same with the compensator at its whole force, whatever that does."""
        if self.trial is None:
            return self
        benefit, compared = self.trial.benefit.whole(), self.trial.compared.whole()
        trial = replace(self.trial, benefit=benefit, compared=compared)
        return replace(self, trial=trial, other_gains=None)

    @property
    def refusal(self) -> str:
        """Why the compensator should not be written; empty where there is no reason."""
        benefit = self.benefit
        return (
            self.doubt
            or self._untried
            or (benefit.refusal if benefit and not benefit.acceptable else "")
        )

    @property
    def _untried(self) -> str:
        """Why the compensator was not tried; empty where it was."""
        if not isinstance(self.loops, ControlError):
            return ""
        return f"it was not tried, because no velocity loop can be closed: {self.loops}"

    @property
    def observer(self) -> Compensator | None:
        """The observer that is written; None for none."""
        designed = self.trial.compared.chosen.designed if self.trial else None
        return designed.observer if designed else None

    @property
    def observer_refusal(self) -> str:
        """Why the observer should not be written; empty where there is no reason."""
        if self.trial is None:
            return self._untried or "no disturbance observer was tried"
        chosen = self.trial.compared.chosen
        if chosen.designed is None:
            return "an observer does not reduce the mean tracking error"
        return self.doubt or ("" if chosen.acceptable else self.trial.compared.sentence)

    def writes(self, *, force: bool = False) -> Choice:
        """Return what is written: the choice without what is refused, unless it is forced.

        Forced, the feedforward of the law is written where nothing is chosen.
        """
        choice = self.choice
        if force:
            return choice or (FEEDFORWARD if self.asked == AUTO else "")
        feedforward = choice in (FEEDFORWARD, BOTH) and not self.refusal
        observer = choice in (OBSERVER, BOTH) and not self.observer_refusal
        if feedforward and observer:
            return BOTH
        return FEEDFORWARD if feedforward else OBSERVER if observer else ""

    @property
    def doubt(self) -> str:
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
            known.sentence
            if known.sentence.startswith(f"{name} = ")
            else f"{name} is {known.sentence}; the compensator uses {known.value:.4g}"
            for name, known in self.estimation.known.items()
            if name in self.estimation.law.parameters and known.identifiability == NOT_IDENTIFIABLE
        ]
        return (*guesses, *self.trial_warnings)

    @property
    def trial_warnings(self) -> tuple[str, ...]:
        """What should be known of the trial, a line each."""
        if self.trial is None:
            return ()
        loop, foreign = self.designed.compensated, self.designed.foreign
        where = (
            f"compensators were tried in a PI velocity loop with K_p = {loop.K_p:.4g} and K_i ="
            f" {loop.K_i:.4g}, {foreign}"
        )
        return (*([with_settings(where)] if foreign else []), *self.trial.warnings)


def learn_recording(
    recording: Recording,
    # of the controller FMU by name; None when the controller is not known
    gains: Mapping[str, float] | None,
    design: Callable[[Estimation], Loops],  # gives the loops, or raises ControlError
    findings: tuple[Finding, ...],  # of reading and checking the recording
    settings: LearnSettings,
    progress: Progress = SILENT,
) -> LearnedFromRecording:
    """Estimate a drive that slides from a recording, or raise, and design its loops."""
    position_force, choice = find_position_force(recording), None
    recording = with_position_force(recording)
    recording, differing = with_log_offsets(recording)
    findings = (*findings, *differing)
    faults = tuple(finding for finding in findings if finding.spoils or finding.hides)
    if settings.law == AUTO:
        progress.stage("comparing friction laws")
        compared = with_force(recording, gains)
        tried = predictions(compared, gains, workers=settings.workers)
        choice = choose(tried)
        settings = replace(settings, law=choice.chosen.candidate.law.name)
    with candidate_fmus(settings.law) as fmus:
        task = Task(fmus, recording, gains, settings, faults=faults, choice=choice)
        estimation = replace(estimate(task, progress), position_force=position_force)
    try:
        loops: Loops | ControlError = design(estimation)
    except ControlError as error:
        loops = error
    friction = estimation.compensator
    return LearnedFromRecording(friction, loops, estimation, findings, seed=settings.seed)
