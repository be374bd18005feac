"""The paper from one recording: record, learn, design, validate.

The drive is run once, for 20 s, in a commissioning loop that needs to know its mass to within a
factor of three. All that is learned comes from that recording; Table 4 is then measured with the
velocity filter and feedforward of inertia that a known mass allows.
"""

from dataclasses import dataclass
from functools import partial
from pathlib import Path

import pandas as pd

from stickslip.identification.estimation import Estimation, LearnSettings, Search
from stickslip.logs import check_recording
from stickslip.output import Progress
from stickslip.papers.lugre.reproduction import BaseResult, Options, build_rig, validated
from stickslip.papers.lugre.tables import table2_of_recording
from stickslip.rigs.fmu import FmuRig
from stickslip.servo.axis import LOOP, Datasheet
from stickslip.servo.tuned_pi import with_inertia, with_velocity_filter
from stickslip.servo.velocity_loop import design_velocity_loop
from stickslip.studies.learn.learned import LearnedFromRecording, learn_recording
from stickslip.studies.learn.recorded import gains_of, record_drive
from stickslip.trial.compensator_trial import Loops
from stickslip.work.jobs import Execution


@dataclass(frozen=True)
class RecordReproduction(BaseResult):
    """All that was computed from one recording."""

    learned: LearnedFromRecording

    def table2(self) -> pd.DataFrame:
        """Return Table 2 with what was learned."""
        return table2_of_recording(self.learned.estimation, self.truth)


def loops_of_drive(sheet: Datasheet, estimation: Estimation) -> Loops:
    """Return the paper's loop for a learned axis, and that with velocity filter and inertia.

    Raises ControlError when the loop cannot be designed.
    """
    known = estimation.known
    plain = design_velocity_loop(sheet.axis(known["m"].value, max(known["b"].value, 0.0)), LOOP)
    F_c = estimation.compensator["F_c"]
    return Loops(plain, with_inertia(with_velocity_filter(plain, sheet, F_c)))


def learn_from_recording(
    rig: FmuRig, seed: int, search: Search, progress: Progress
) -> LearnedFromRecording:
    """Record a drive once, learn from the recording and design the loops.

    Raises stickslip.errors.IdentificationError, stickslip.servo.axis.ControlError when the drive
    does not show what is looked for, or cannot be recorded.
    """
    progress.stage("recording the drive")
    recording = record_drive(rig)
    return learn_recording(
        recording,
        gains_of(rig.loop),
        partial(loops_of_drive, rig.datasheet),
        check_recording(recording),
        settings=LearnSettings(law=rig.law.name, seed=seed, search=search),
        progress=progress,
    )


def reproduce_from_recording(
    options: Options, fmus: Path, progress: Progress, execution: Execution | None = None
) -> RecordReproduction:
    """Run the whole; FMUs are built into the folder ``fmus``. Raises as ``reproduce``."""
    rig = build_rig(options, fmus, progress)
    search = Search(options.preset, execution=execution or Execution())
    learned = learn_from_recording(rig, options.seed, search, progress)
    return RecordReproduction(**vars(validated(options, rig, learned, progress)))
