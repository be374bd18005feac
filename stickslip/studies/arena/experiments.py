"""Friction parameters that a drive shows in experiments: the paper's, and least squares from there.

They need a rig, thus the encoder and the motor force of the drive only.
"""

from __future__ import annotations

from pathlib import Path

from stickslip.compensators.entrants import Entrant
from stickslip.evaluation.motions import TRAINING
from stickslip.identification.stages import identify
from stickslip.rigs.contract import Command, Log
from stickslip.rigs.fmu import FmuRig
from stickslip.servo.axis import LOOP, Datasheet
from stickslip.servo.velocity_loop import VelocityLoop
from stickslip.tuning.learning import Study
from stickslip.tuning.refinement import refine


class _Rig(FmuRig):
    """A drive that counts its motion."""

    seconds = 0.0

    def move(self, command: Command) -> Log:
        self.seconds += len(command) * self.T_s
        return super().move(command)


def experiments(
    fmus: Path, loop: VelocityLoop, one: Entrant, sheet: Datasheet, seed: int
) -> tuple[dict[str, float], float]:
    """Return the parameters that the parts of an entrant learn by experiments, and the motion [s].

    Raises IdentificationError when the drive does not show what an experiment looks for.
    """
    found, seconds = dict[str, float](), 0.0
    for part in one.parts:
        if not part.experiment or part.law is None:
            continue
        rig = _Rig(fmus, sheet, loop.T_s, part.law.name)
        known = identify(rig, LOOP).tuned
        if part.experiment == "fitted":
            v_cmd = TRAINING.sample(rig.samples(TRAINING.duration))
            fit = refine(Study(rig, loop, known, v_cmd, seed=seed))
            known, seconds = fit.estimates, seconds + fit.runs * TRAINING.duration
        found |= {f"{part.name}.{name}": one.value for name, one in known.items()}
        seconds += rig.seconds
    return found, seconds
