"""An experiment on a rig becomes a recording, as a log does."""

from dataclasses import replace

from stickslip.logs import Controller, Reading, Recording
from stickslip.planning import LINEAR, Limits, plan
from stickslip.rigs.contract import Rig
from stickslip.servo.velocity_loop import VelocityLoop


def record_drive(rig: Rig, limits: Limits = LINEAR) -> Recording:
    """Run one experiment without compensation in the loop of the rig, at its rate.

    Raises LimitError when a limit of the rig refuses or aborts it, or RigError when it did not end
    as commanded.
    """
    limits = replace(limits, rate=1.0 / rig.T_s)
    v_cmd = plan(limits)["velocity_command"].to_numpy()
    log = rig.follow(v_cmd, rig.loop)
    return Recording(
        log.t,
        log.x_enc,
        log.F_m,
        velocity_command=v_cmd,
        encoder_step=rig.datasheet.encoder_step,
        source=rig.name,
    )


def read_rig(rig: Rig, limits: Limits) -> Reading:
    """Do what ``record_drive`` does, and return what a log would say beside the recording."""
    sheet, gains = rig.datasheet, gains_of(rig.loop)
    recording, controller = record_drive(rig, limits), Controller("PI", **gains)
    return Reading(recording, controller, force_limit=sheet.peak_force, tau_i=sheet.tau_i)


def gains_of(loop: VelocityLoop) -> dict[str, float]:
    """Return the parameters of the controller FMU in a loop, by name."""
    gains = {"T_s": loop.T_s, "K_p": loop.K_p, "K_i": loop.K_i, "tau_f": loop.tau_f}
    if loop.K_x:
        gains |= {"K_x": loop.K_x, "velocity_feedforward": loop.velocity_feedforward}
    return gains
