"""The paper's learning on a drive (Fig. 3), whatever the rig: identify, search, refine."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from stickslip import ga
from stickslip.cosim import SineSweep, Trapezoid
from stickslip.errors import HarmfulError
from stickslip.evaluation import validation
from stickslip.evaluation.validation import Validation
from stickslip.identification.stages import Estimate, Identification, identify
from stickslip.pipeline.learned import Learned, Loops
from stickslip.rigs.contract import Rig
from stickslip.servo.datasheet import LOOP
from stickslip.servo.paper_commands import TRAINING, VALIDATION
from stickslip.servo.specification import LoopSpecification
from stickslip.servo.systems import Feed
from stickslip.tuning.coarse_start import coarsened
from stickslip.tuning.execution import Execution
from stickslip.tuning.learning import Study, learn
from stickslip.tuning.refinement import Refinement, refine, without_search


@dataclass(frozen=True)
class LearnedOnRig(Learned):
    """What was learned by running candidates on a drive.

    Attributes
    ----------
    study : what the search needed
    start : the tuned parameters that learning began with
    algorithm : what searched; where that was skipped it has done its first generation alone
    refinement : what was known in the end
    """

    identification: Identification
    study: Study = field(repr=False)
    start: Mapping[str, Estimate]
    algorithm: ga.Optimiser = field(repr=False)
    refinement: Refinement


def learn_on_rig(
    rig: Rig,
    specification: LoopSpecification = LOOP,
    training: SineSweep = TRAINING,
    *,
    feed: Feed = "nominal",
    preset: str = "default",
    seed: int = 0,
    coarse: Mapping[str, float] | None = None,
    execution: Execution | None = None,
    on_stage: Callable[[str], object] = lambda _: None,
    on_generation: Callable[[ga.Optimiser], object] | None = None,
) -> LearnedOnRig:
    """Identify a drive by three experiments, then let candidates run on it, as in the paper.

    A candidate whose motion a limit refuses or aborts has failed; a limit in the three experiments
    ends the learning.

    Parameters
    ----------
    specification : of the velocity loop, whose gains the drive must take
    training : velocity command that each candidate follows [m/s]
    feed : what drives the compensator
    preset : how to learn, a name in ``ga.ALGORITHMS``; ``default`` skips the search where the drive
        shows that it would not be useful, and only ``paper`` does not end with a fit
    coarse : factors by name on what identification found, to begin learning there

    Raises
    ------
    RigError
        When a motion did not end as commanded.
    IdentificationError, ControlError
        When the drive does not show what is looked for, or its loop cannot be designed.
    """
    found = identify(rig, specification, lambda name: on_stage(f"identifying: {name}"))
    start, loop = found.tuned, found.loop
    if coarse:
        start = coarsened(start, coarse, rig.law)
    v_cmd = training.sample(rig.samples(training.duration))
    study = Study(rig, loop, start, v_cmd, feed, preset, seed=seed)
    on_stage("checking whether a search is useful")
    refinement = without_search(study) if preset == "default" else None
    on_stage("learning")
    limits = ga.Limits(generations=1) if refinement else None
    algorithm = learn(study, on_generation, execution, limits)
    if refinement is None:
        on_stage("refining")
        best = study.parameters(algorithm.best.values)
        refinement = refine(study, best, fitted=preset != "paper")
    loops = Loops(loop, loop)
    return LearnedOnRig(refinement.values, loops, found, study, start, algorithm, refinement)


def validate(
    rig: Rig, learned: Learned, command: Trapezoid = VALIDATION, feed: Feed = "nominal"
) -> Validation:
    """Run a trapezoid on a drive without and with the learned compensator.

    Parameters
    ----------
    learned : of ``learn`` or ``learn_on_rig``
    command : velocity [m/s]

    Raises
    ------
    HarmfulError
        When learning does not recommend the compensator; nothing is run.
    RigError
        When a motion did not end as commanded.
    ControlError
        When no loop of the drive is known.
    """
    if learned.refusal:
        raise HarmfulError(f"{rig.name}: learn does not recommend it: {learned.refusal}; not run")
    plain, loop, _ = learned.designed
    return validation.validate(rig, loop, learned.friction, command, feed, plain)
