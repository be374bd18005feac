"""The paper from one recording: record, learn, design, validate.

The drive is run once, for 20 s, in a commissioning loop that needs to know its mass to within a
factor of three. All that is learned comes from that recording; Table 4 is then measured with the
velocity filter and feedforward of inertia that a known mass allows.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from stickslip import cosim
from stickslip.catalog.parameters import PAPER, UNITS
from stickslip.evaluation.attribution import attribute
from stickslip.evaluation.validation import Validation, validate
from stickslip.identification.estimation import Estimation, Search, Task, candidate_fmus, learn
from stickslip.logs import Finding, Recording, check_recording
from stickslip.pipeline.reproduction import Options, Progress, drive_truth
from stickslip.planning import plan
from stickslip.servo.datasheet import LOOP, VALIDATION, Datasheet
from stickslip.servo.filtered_loop import with_inertia, with_velocity_filter
from stickslip.servo.rig import Rig
from stickslip.servo.systems import build_fmus, paper_loop
from stickslip.servo.velocity_loop import LoopSpecification, VelocityLoop, design_velocity_loop
from stickslip.tuning.execution import Execution

COMMISSIONING = LoopSpecification(bandwidth=50.0, phase_margin=60.0, T_s=5e-4, tau_f=5e-4)
"""The loop of the recording: soft, so that it bears a third and three times its nominal mass."""


@dataclass(frozen=True)
class RecordReproduction:
    """All that was computed.

    Attributes
    ----------
    truth : every parameter of the drive FMU, joined after learning
    recording_loop : in which the drive was recorded
    plain, loop : the loops that Table 4 compares, without and with compensation
    """

    options: Options
    truth: dict[str, float]
    recording_loop: VelocityLoop
    findings: tuple[Finding, ...]
    estimation: Estimation
    plain: VelocityLoop
    loop: VelocityLoop
    validation: Validation
    attribution: pd.DataFrame
    system: cosim.System

    @property
    def compensator(self) -> dict[str, float]:
        """The compensator's parameters by name, in SI units."""
        return self.estimation.compensator

    def table2(self) -> pd.DataFrame:
        """Return Table 2 with what was learned, in SI units; the drive's truth enters here only.

        ``identified`` is what a straight line through the recorded force says; it knows nothing of
        F_s, v_s, sigma_0 and sigma_1. ``spread`` is the standard error of what was learned.
        """
        line = self.estimation.start.line
        rows = []
        for name, unit in UNITS.items():
            known = self.estimation.known[name]
            row: dict[str, Any] = {
                "parameter": name,
                "unit": unit,
                "paper": PAPER[name],
                "drive": self.truth[name],
                "identified": line[name] if name in ("m", "b", "F_c") else None,
                "learned": known.value,
                "spread": known.standard_error,
                "low": known.low,
                "high": known.high,
                "remark": known.sentence,
            }
            rows.append(row)
        return pd.DataFrame(rows)


def record_drive(rig: Rig) -> tuple[Recording, VelocityLoop]:
    """Record 20 s of a drive without compensation, in the commissioning loop."""
    datasheet = rig.datasheet
    loop = design_velocity_loop(datasheet.axis(datasheet.mass, 0.0), COMMISSIONING)
    v_cmd = plan()["velocity_command"].to_numpy()
    log = rig.follow(v_cmd, loop)
    recording = Recording(
        log.t,
        log.x_enc,
        log.F_m,
        velocity_command=v_cmd,
        encoder_step=datasheet.encoder_step,
        source="drive.fmu",
    )
    return recording, loop


@dataclass(frozen=True)
class Learned:
    """What one recording of a drive gives.

    Attributes
    ----------
    recording_loop : in which the drive was recorded
    plain : the paper's loop, designed on what was learned
    loop : the same with velocity filter and feedforward of inertia
    """

    recording: Recording
    recording_loop: VelocityLoop
    estimation: Estimation
    plain: VelocityLoop
    loop: VelocityLoop


def learn_from_recording(
    rig: Rig, options: Options, progress: Progress, execution: Execution | None = None
) -> Learned:
    """Record a drive once, learn from the recording and design the loops.

    Raises
    ------
    stickslip.errors.IdentificationError, stickslip.servo.axis.ControlError
        When the drive does not show what is looked for, or its loop cannot be designed.
    """
    progress.stage("recording the drive")
    recording, recording_loop = record_drive(rig)
    with candidate_fmus() as candidates:
        how = Search(options.preset, execution=execution or Execution())
        gains = gains_of(recording_loop)
        task = Task(candidates, recording, gains, search=how, seed=options.seed)
        estimation = learn(task, progress.stage, progress.generation)
    known = estimation.known
    axis = rig.datasheet.axis(known["m"].value, max(known["b"].value, 0.0))
    plain = design_velocity_loop(axis, LOOP)
    F_c = estimation.compensator["F_c"]
    loop = with_inertia(with_velocity_filter(plain, rig.datasheet, F_c))
    return Learned(recording, recording_loop, estimation, plain, loop)


def reproduce_from_recording(
    options: Options, fmus: Path, progress: Progress, execution: Execution | None = None
) -> RecordReproduction:
    """Run the whole; FMUs are built into the folder ``fmus``, which must stay.

    Raises
    ------
    models.ModelError, toolchain.ToolchainError
    stickslip.errors.IdentificationError, stickslip.servo.axis.ControlError
        When the drive does not show what is looked for, or its loop cannot be designed.
    """
    truth = drive_truth(options.truth)
    progress.stage("building the FMUs")
    build_fmus(fmus, options.truth)
    rig = Rig(fmus, Datasheet(), LOOP.T_s)
    learned = learn_from_recording(rig, options, progress, execution)
    progress.stage("validating")
    compensator, plain, loop = learned.estimation.compensator, learned.plain, learned.loop
    return RecordReproduction(
        options,
        truth,
        learned.recording_loop,
        check_recording(learned.recording),
        learned.estimation,
        plain,
        loop,
        validate(rig, loop, compensator, VALIDATION, options.feed, plain),
        attribute(rig, plain, compensator, VALIDATION, options.feed),
        paper_loop(fmus, loop, compensator, options.feed),
    )


def gains_of(loop: VelocityLoop) -> dict[str, float]:
    """Return the parameters of the controller FMU in a loop, by name."""
    return {"T_s": loop.T_s, "K_p": loop.K_p, "K_i": loop.K_i, "tau_f": loop.tau_f}
