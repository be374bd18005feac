"""The paper from beginning to end: build, identify, learn, validate.

Data flow: the drive's truth goes into drive.fmu and, when all is learned, into Table 2. What is in
between sees a ``Rig``.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import pandas as pd

from stickslip import cosim, models
from stickslip.catalog.parameters import check_learnable, estimated, friction_law
from stickslip.evaluation.comparison import Evaluation, evaluate
from stickslip.evaluation.motions import VALIDATION
from stickslip.evaluation.validation import PHASES, Validation, validate
from stickslip.identification.stages import Identification
from stickslip.output import Progress
from stickslip.papers.lugre.loop_tuning import LoopTuning, validate_loops
from stickslip.papers.lugre.steps import steps, with_steps
from stickslip.papers.lugre.tables import table2
from stickslip.rigs.fmu import FmuRig
from stickslip.servo.axis import LOOP, Datasheet
from stickslip.servo.systems import Changes, build_fmus, drive_law, paper_loop
from stickslip.servo.tuned_pi import tuned_pi
from stickslip.studies.learn.learned import Learned
from stickslip.studies.learn.rig_learning import LearnedOnRig, learn_on_rig
from stickslip.tuning.drive_model import fit_models
from stickslip.tuning.loop_learning import LoopStudy, learn_loop, what_is_left
from stickslip.tuning.refinement import Refinement


@dataclass(frozen=True)
class Options:
    """What can be chosen."""

    # parameters of the drive FMU that differ from Table 2, in the units of its model.toml, and its
    # friction law as ``law``
    truth: Changes = field(default_factory=dict)
    law: str = "lugre"  # friction law of the compensator
    seed: int = 0
    # what searches, a name in ``ga.ALGORITHMS``; ``default`` is CMA-ES for the loop, and our
    # genetic algorithm for a recording
    preset: str = "default"
    # how many seeds search the loop or learn as published, ``seed`` the first
    seeds: int = 5

    def __post_init__(self) -> None:
        check_learnable(self.law)

    @property
    def all_seeds(self) -> range:
        """The seeds."""
        return range(self.seed, self.seed + self.seeds)


@dataclass(frozen=True)
class BaseResult:
    """What both modes compute."""

    options: Options
    truth: Mapping[str, float]  # every parameter of the drive FMU; it enters after all is learned
    learned: Learned
    validation: Validation
    system: cosim.System  # the loop of Fig. 2a with the learned compensator


@dataclass(frozen=True)
class Reproduction(BaseResult):
    """All that was computed with the three experiments, and by running the drive."""

    identification: Identification
    refinement: Refinement  # what was known in the end
    cost_without: float  # of the training run without compensation [m^2/s^2]
    motions: Evaluation  # all motions with each step
    loops: LoopTuning  # the loop as it was learned, and what each step before it brings

    def table2(self) -> pd.DataFrame:
        """Return Table 2 with what was found."""
        return table2(self.identification, self.refinement, self.truth)

    def table4(self) -> pd.DataFrame:
        """Return Table 4, with a column for each step."""
        return with_steps(self.validation.table(), self.motions)


def drive_truth(changes: Changes, law: str = "lugre") -> dict[str, float]:
    """Return every parameter of the drive FMU, NaN for those of ``law`` that it lacks; or raise."""
    start, own = drive_law(changes)
    model = models.load_model("drive", own).with_start(start)
    known = {v.name: v.start for v in model.variables if v.role == "parameter"}
    return dict.fromkeys(estimated(friction_law(law)), math.nan) | known


def build_rig(options: Options, fmus: Path, progress: Progress) -> FmuRig:
    """Build the FMUs of the loop into a folder, which must stay; return its drive as a rig."""
    progress.stage("building the FMUs")
    build_fmus(fmus, options.truth, options.law)
    return FmuRig(fmus, Datasheet(), LOOP.T_s, options.law)


def validated(options: Options, rig: FmuRig, learned: Learned, progress: Progress) -> BaseResult:
    """Run the trapezoid without and with what was learned; return it with the truth; or raise."""
    plain, loop, _ = learned.designed
    progress.stage("validating")
    validation = validate(rig, loop, learned.friction, VALIDATION, plain=plain, phases=PHASES)
    system = paper_loop(rig.fmus, loop, learned.friction)
    return BaseResult(options, drive_truth(options.truth, options.law), learned, validation, system)


def reproduce(options: Options, fmus: Path, progress: Progress, workers: int = 1) -> Reproduction:
    """Run the whole paper; FMUs are built into the folder ``fmus``, which must stay.

    Raises ModelError, ToolchainError, or IdentificationError, ControlError when the drive does not
    show what is looked for, or its loop cannot be designed.
    """
    rig = build_rig(options, fmus, progress)
    found = learn_on_rig(rig, seed=options.seed, progress=progress)
    loops = _tuned(options, rig, found, progress, workers)
    result = validated(options, rig, found, progress)
    progress.stage("all motions")
    entries = steps(found.identification, found)
    motions = evaluate(rig, entries, phases=PHASES, workers=workers)
    return Reproduction(
        **vars(result),
        identification=found.identification,
        refinement=found.refinement,
        motions=motions,
        loops=loops,
        cost_without=found.study.cost_without(),
    )


def _tuned(
    options: Options, rig: FmuRig, found: LearnedOnRig, progress: Progress, workers: int
) -> LoopTuning:
    """Let the genetic algorithm learn the loop, and find out what each step brings."""
    paper = found.identification.loop
    study = LoopStudy(rig, tuned_pi(paper), found.friction)
    if options.preset != "default":
        study = replace(study, algorithm=options.preset)
    progress.stage("modelling the drive in loops")
    study = replace(study, models=fit_models(study, progress.generation, workers))
    searched = with_law_found(study, options, progress)
    learned = []
    for seed in options.all_seeds:
        progress.stage(f"learning the loop, seed {seed}")
        learned.append(learn_loop(replace(searched, seed=seed), progress.generation, workers))
    progress.stage("what each step brings")
    identified = {name: one.value for name, one in found.identification.tuned.items()}
    return validate_loops(
        study,
        searched,
        drive_law(options.truth)[1],
        drive_truth(options.truth, options.law),
        paper,
        identified,
        learned,
        runs=found.refinement.runs,
        workers=workers,
    )


def with_law_found(study: LoopStudy, options: Options, progress: Progress) -> LoopStudy:
    """Return the study with the feedforward of its first model, if that leaves less.

    Only a model that was fitted is tried: what was identified does not err like the drive then.
    """
    model, rig = study.models[0], study.rig
    if not model.fitted:
        return study
    if model.law != rig.law.name:
        rig = build_rig(replace(options, law=model.law), rig.fmus / model.law, progress)
    return min(study, replace(study, rig=rig, friction=model.friction), key=what_is_left)
