"""The loop in which a compensator that a log gave is tried, and what is found there."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from stickslip.catalog.parameters import LUGRE, friction_law
from stickslip.cosim import Trapezoid
from stickslip.evaluation.guards import Benefit, Trial, benefit_of, inspect
from stickslip.fmi.process import temporary_folder
from stickslip.identification.estimation import Estimation
from stickslip.logs import Reading
from stickslip.servo.axis import Axis, ControlError
from stickslip.servo.datasheet import LOOP, VALIDATION, Datasheet
from stickslip.servo.systems import build_fmus
from stickslip.servo.velocity_loop import (
    LoopSpecification,
    VelocityLoop,
    close_velocity_loop,
    design_velocity_loop,
)


@dataclass(frozen=True)
class LogTrial:
    """What trying a compensator gave.

    Attributes
    ----------
    loop : the velocity loop of the log's controller, or one designed for the learned axis
    known : whether it is the former
    command, datasheet : what it was tried on
    benefit : tracking errors, and the share of the compensator's force that is harmless
    warnings : what the guards found, a line each
    """

    loop: VelocityLoop
    known: bool
    command: Trapezoid
    datasheet: Datasheet
    benefit: Benefit
    warnings: tuple[str, ...]


def try_compensator(reading: Reading, estimation: Estimation) -> LogTrial | None:
    """Try a learned compensator at the log's own speed; None where no loop can be closed."""
    controlled = _controlled(reading, estimation)
    loop = controlled or _designed(reading, estimation)
    if loop is None:
        return None
    top = float(np.quantile(np.abs(estimation.figures.velocity_recorded), 0.99))
    scale = top / VALIDATION.height
    command = replace(VALIDATION, height=top, slope=scale * VALIDATION.slope)
    duration = command.corners()[-1] + command.begin
    v_cmd = command.sample(np.arange(round(duration / loop.T_s) + 1) * loop.T_s)
    strongest = float(np.max(np.abs(estimation.figures.measured)))
    sheet = Datasheet(
        peak_force=reading.force_limit or 1e3 * strongest,
        tau_i=loop.axis.tau_i,
        encoder_step=reading.recording.encoder_step or 1e-6 * top,
    )
    errors = {
        name: estimation.known[name].standard_error
        for name in LUGRE
        if estimation.known[name].visible != "not visible"
    }
    learned = estimation.compensator
    with temporary_folder() as folder:
        build_fmus(folder, {})
        trial = Trial(folder, loop, learned, learned, v_cmd, datasheet=sheet)
        benefit = benefit_of(trial, rotary=reading.recording.motion == "rotary")
        written = replace(trial, compensator=friction_law().share(learned, benefit.share))
        found = tuple(str(finding) for finding in inspect(written, errors))
    return LogTrial(loop, controlled is not None, command, sheet, benefit, found)


def _controlled(reading: Reading, estimation: Estimation) -> VelocityLoop | None:
    """Return the velocity loop of the log's controller, None where there is none or it fails."""
    controller = reading.controller
    if "m" not in estimation.known or not controller.K_p or controller.P_x or controller.I_x:
        return None
    T_s = controller.T_s or estimation.recording.T_s
    gains = (T_s, controller.tau_f, controller.K_p, controller.K_i)
    try:
        return close_velocity_loop(_axis(reading, estimation), *gains)
    except ControlError:
        return None


def _designed(reading: Reading, estimation: Estimation) -> VelocityLoop | None:
    """Return a loop like the paper's for the learned axis at the log's rate."""
    if "m" not in estimation.known:
        return None
    T_s = estimation.recording.T_s
    wanted = LoopSpecification(
        bandwidth=LOOP.bandwidth * LOOP.T_s / T_s,
        phase_margin=LOOP.phase_margin,
        T_s=T_s,
        tau_f=T_s,
    )
    try:
        return design_velocity_loop(_axis(reading, estimation), wanted)
    except ControlError:
        return None


def _axis(reading: Reading, estimation: Estimation) -> Axis:
    known = estimation.known
    return Axis(known["m"].value, max(known["b"].value, 0.0), reading.tau_i or 0.0)
