"""A learned drive in the loop of a log, without and with its compensator.

The controller FMU with the gains of the log's controller, of any kind, runs the drive FMU with the
learned values along the log's commands. The compensator's force depends on the command only, so it
is computed first and added to the controller's.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.integrate import cumulative_trapezoid

from stickslip import cosim
from stickslip.catalog.parameters import DRIVE, friction_law
from stickslip.errors import UsageError
from stickslip.evaluation.tracking import FEEDFORWARD, FRICTIONLESS, NONE
from stickslip.identification.criteria.known_loop import KnownLoop
from stickslip.identification.criteria.motion import position_of
from stickslip.identification.criteria.scaling import Scale, scale_of
from stickslip.logs import Recording
from stickslip.servo.measurement import Array, derivative, smoothed
from stickslip.servo.velocity_loop import VelocityLoop

SHARE = 1.0 / 16.0
"""Cut-off of the low-pass of a velocity that is a derivative, as share of the sample rate."""

NEGLIGIBLE = 1e-6  # share of the friction that counts as none


@dataclass(frozen=True)
class LearnedDrive:
    """A drive as it was learned, in SI units."""

    law: str  # name of its friction law
    values: Mapping[str, float]  # of the drive by name: those of the law, m, b, F_0 and delay
    compensator: Mapping[str, float]  # parameters of the compensator by name; none for no force
    # the loop whose response the compensator takes; None where it takes the command
    reference: VelocityLoop | None = None


@dataclass(frozen=True)
class Motion:
    """Motion of a drive in a loop."""

    # (n,) true [m], [m/s]
    position: Array
    velocity: Array
    encoder: Array  # (n,) position that the encoder shows [m]


def commanded_velocity(recording: Recording) -> Array:
    """Return the velocity command (n,) [m/s], or the derivative of the position command.

    Raises UsageError when neither was logged.
    """
    received = recording.controller_inputs.get("v_cmd")
    if received is not None:
        return received
    if recording.position_command is None:
        raise UsageError(
            f"{recording.source}: no command; log the velocity or position command, or name its "
            "column with --column velocity_command=NAME"
        )
    T_s = recording.T_s
    velocity: Array = derivative(smoothed(recording.position_command, T_s, SHARE / T_s), T_s)
    return velocity


def commanded_position(recording: Recording) -> Array:
    """Return the position command (n,) [m], or the integral of the velocity's from the start on.

    The integral is that of straight lines between the samples: a log may have fewer of them than
    the controller.
    """
    if recording.position_command is not None:
        return recording.position_command
    travel = cumulative_trapezoid(commanded_velocity(recording), dx=recording.T_s, initial=0)
    return np.asarray(position_of(recording)[0] + travel)


def scale_for(recording: Recording, values: Mapping[str, float]) -> Scale:
    """Return units in which the FMUs simulate a drive well that has these values."""
    force = np.full(1, values["F_c"]) if recording.force is None else recording.force
    return scale_of(force, commanded_velocity(recording))


def simulate(
    fmus: Path,
    recording: Recording,
    gains: Mapping[str, float],
    drive: LearnedDrive,
    force_limit: float | None = None,
) -> dict[str, Motion]:
    """Return the motion of the drive by variant: without and with compensator, without friction.

    Parameters
    ----------
    fmus : folder of the candidate's FMUs, see ``candidate_fmus``
    recording : gives commands, start and the encoder's steps
    gains : of the controller FMU by name
    force_limit : of motor or amplifier [N]
    """
    scale = scale_for(recording, drive.values)
    scaled, values = scale.recording(recording), scale.values(drive.values)
    force = feedforward(fmus, recording, drive, scale)
    further = {"candidate.noise_x": 0.0}
    if force_limit is not None:
        further |= dict.fromkeys(("candidate.u_max", "controller.u_max"), scale.force * force_limit)
    law = friction_law(drive.law)
    friction = {name: value for name, value in values.items() if name in law.parameters}
    variants: dict[str, tuple[Mapping[str, float], Array | float]] = {
        NONE: (values, 0.0),
        FEEDFORWARD: (values, force),
        FRICTIONLESS: ({**values, **law.share(friction, NEGLIGIBLE)}, 0.0),
    }
    with KnownLoop(fmus, scaled, scale.values(gains), encoder=True) as loop:
        runs = {name: loop.bounded(of, further, added) for name, (of, added) in variants.items()}
    signals = ("candidate.x", "candidate.v", "candidate.x_enc")
    return {
        name: Motion(*(run[signal] / scale.length for signal in signals))
        for name, run in runs.items()
    }


def feedforward(fmus: Path, recording: Recording, drive: LearnedDrive, scale: Scale) -> Array:
    """Return the compensator's force (n,) from each sample of a recording on, scaled."""
    if not drive.compensator:
        return np.zeros_like(recording.t)
    v = commanded_velocity(recording)
    lead = 0.0
    if drive.reference is not None:
        lead = drive.reference.axis.tau_i
        v = _response(drive.reference, recording.t, v)
        v = np.append(v[1:], v[-1])  # of the end of the step
    values = {n: x for n, x in scale.values(drive.compensator).items() if n not in DRIVE}
    system = cosim.System("feedforward")
    start = {"hold": False, "lead": lead, **values}
    system.add("compensator", fmus / "compensator.fmu", start)
    system.expose("v", "compensator.v")
    stop = (len(v) - 1) * recording.T_s
    record = ("compensator.F_mean",)
    with system.prepare(step=recording.T_s, stop=stop, record=record) as simulation:
        shown = simulation.run({}, {"v": scale.length * v})[record[0]]
    return np.append(shown[1:], shown[-1])  # row n + 1 shows the force from sample n on


def _response(loop: VelocityLoop, t: Array, v_cmd: Array) -> Array:
    """Return the velocity (n,) [m/s] of a loop without friction; it may sample at other times."""
    own = np.arange(round(t[-1] / loop.T_s) + 1) * loop.T_s
    inputs = np.interp(own, t, v_cmd)
    return np.interp(t, own, loop.response(inputs)[0])
