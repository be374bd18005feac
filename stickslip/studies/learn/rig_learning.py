"""The friction of a drive, whatever the rig: three experiments, then least squares on its runs."""

from __future__ import annotations

from dataclasses import dataclass, field

from stickslip.cosim import SineSweep, Trapezoid
from stickslip.errors import HarmfulError
from stickslip.evaluation import validation
from stickslip.evaluation.motions import TRAINING, VALIDATION
from stickslip.evaluation.validation import Validation
from stickslip.identification.stages import Identification, identify
from stickslip.output import SILENT, Progress
from stickslip.rigs.contract import Rig
from stickslip.servo.axis import LOOP, LoopSpecification
from stickslip.studies.learn.learned import Learned
from stickslip.trial.compensator_trial import Loops
from stickslip.tuning.learning import Study
from stickslip.tuning.refinement import Refinement, refine


@dataclass(frozen=True)
class LearnedOnRig(Learned):
    """What was learned of a drive by running it."""

    identification: Identification
    study: Study = field(repr=False)  # what least squares needed
    refinement: Refinement  # what was known in the end


def learn_on_rig(
    rig: Rig,
    specification: LoopSpecification = LOOP,
    training: SineSweep = TRAINING,
    *,
    seed: int = 0,
    progress: Progress = SILENT,
) -> LearnedOnRig:
    """Identify a drive by three experiments, then fit the friction to repeated runs of it.

    The paper lets a genetic algorithm try compensators here; least squares find as much in a
    twentieth of the runs (docs/measurements/as-published.md).

    Parameters
    ----------
    specification : of the velocity loop, whose gains the drive must take
    training : velocity command of the runs [m/s]
    seed : of the small changes between repeated runs

    Raises
    ------
    RigError
        When a motion did not end as commanded.
    IdentificationError, ControlError
        When the drive does not show what is looked for, or its loop cannot be designed.
    """
    found = identify(rig, specification, lambda name: progress.stage(f"identifying: {name}"))
    loop = found.loop
    v_cmd = training.sample(rig.samples(training.duration))
    study = Study(rig, loop, found.tuned, v_cmd, seed=seed)
    progress.stage("fitting the friction to runs of the drive")
    refinement = refine(study)
    return LearnedOnRig(refinement.values, Loops(loop, loop), found, study, refinement=refinement)


def validate(rig: Rig, learned: Learned, command: Trapezoid = VALIDATION) -> Validation:
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
    return validation.validate(rig, loop, learned.friction, command, plain=plain)
