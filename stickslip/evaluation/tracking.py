"""How a drive follows a command, with each compensation that is compared: errors over time.

For a learned drive in the loop of a log, the controller FMU with the gains of the log's controller,
of any kind, runs the drive FMU with the learned values along the log's commands. The compensator's
force depends on the command only, so it is computed first and added to the controller's.
"""

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field, fields, replace
from pathlib import Path

import numpy as np
from scipy.integrate import cumulative_trapezoid

from stickslip import cosim, models
from stickslip.catalog.parameters import DRIVE, friction_law
from stickslip.errors import UsageError
from stickslip.fmi.process import temporary_folder
from stickslip.identification.criteria.known_loop import KnownLoop
from stickslip.identification.criteria.motion import position_of, scale_of
from stickslip.logs import Recording
from stickslip.servo.measurement import CUTOFF, Array, derivative, smoothed
from stickslip.servo.systems import Compensator
from stickslip.servo.velocity_loop import VelocityLoop

NONE, FEEDFORWARD, FRICTIONLESS = "without compensator", "with compensator", "without friction"
"""Variants: no compensation, the force of the compensator, and no friction at all."""
SHARE = 1.0 / 16.0  # largest cut-off of a measured velocity's low-pass, over the sample rate


@dataclass(frozen=True)
class TrackingError:
    """Root mean square and largest absolute value of the errors of velocity and position."""

    velocity_rms: float  # [m/s]
    velocity_max: float  # [m/s]
    position_rms: float  # [m]
    position_max: float  # [m]

    @classmethod
    def of(cls, velocity: Array, position: Array) -> "TrackingError":
        """Return it for errors (n,) of velocity [m/s] and position [m]."""
        return cls(*_size(velocity), *_size(position))


TRACKING_FIGURES = tuple(field.name for field in fields(TrackingError))
"""Names of the figures of a ``TrackingError``."""


def _size(error: Array) -> tuple[float, float]:
    return float(np.sqrt(np.mean(error**2))), float(np.max(np.abs(error)))


@dataclass(frozen=True)
class Tracking:
    """Simulated motion of a drive along one command."""

    t: Array  # (n,) [s]
    v_cmd: Array  # (n,) commanded velocity [m/s]
    velocity: Mapping[str, Array]  # (n,) true velocity by variant [m/s]
    position_error: Mapping[str, Array]  # (n,) true position less commanded position by variant [m]
    used: slice  # the samples that count; the first ones do not where the log began in motion
    loop: str  # in words
    command: str  # in words
    known: bool  # whether the loop is that of the log's controller
    # tracking error of the log itself, without compensation; None where the simulated loop or
    # command is another
    measured: TrackingError | None = None
    # without friction, by what is changed in the loop; none where nothing was tried
    remedies: Mapping[str, TrackingError] = field(default_factory=dict)
    force: float = 0.0  # largest of the compensator [N]
    by_position: bool = False  # whether the loop controls the position

    def velocity_error(self, variant: str) -> Array:
        """Return velocity less command (n,) [m/s]."""
        return self.velocity[variant] - self.v_cmd

    def errors(self) -> dict[str, TrackingError]:
        """Return the tracking errors by variant."""
        return {
            name: TrackingError.of(
                self.velocity_error(name)[self.used], self.position_error[name][self.used]
            )
            for name in self.velocity
        }

    def reduction(self, figure: str, variant: str = FEEDFORWARD) -> float:
        """Return by which share a variant makes a figure of ``TrackingError`` smaller."""
        errors = self.errors()
        without, compensated = (float(vars(errors[name])[figure]) for name in (NONE, variant))
        return 1.0 - compensated / without if without > 0.0 else np.nan


def measured_velocity(position: Array, T_s: float) -> Array:
    """Return the velocity (n,) [m/s] of an encoder's positions (n,) [m], low-passed."""
    return derivative(smoothed(position, T_s, cutoff(T_s)), T_s)


def cutoff(T_s: float) -> float:
    """Return the cut-off of the low-pass of measured velocities [Hz]."""
    return min(CUTOFF, SHARE / T_s)


def measured_errors(recording: Recording, v_cmd: Array, x_cmd: Array) -> tuple[Array, Array]:
    """Return the errors (n,) of velocity [m/s] and position [m] that a log shows.

    Command and motion go through the same low-pass, which has no phase lag. The command is v_cmd
    (n,) [m/s] and x_cmd (n,) [m].
    """
    T_s, position = recording.T_s, position_of(recording)
    velocity = measured_velocity(position, T_s)
    return velocity - smoothed(v_cmd, T_s, cutoff(T_s)), position - x_cmd


NEGLIGIBLE = 1e-6  # share of the friction that counts as none


@dataclass(frozen=True)
class LearnedDrive:
    """A drive as it was learned, in SI units."""

    law: str  # name of its friction law
    values: Mapping[str, float]  # of the drive by name: those of the law, m, b, F_0 and delay
    compensator: Compensator | None = None  # a feedforward
    reference: VelocityLoop | None = None  # whose response the compensator takes, not the command


@dataclass(frozen=True)
class SimulatedMotion:
    """Simulated motion of a drive in a loop."""

    position: Array  # (n,) true [m]
    velocity: Array  # (n,) true [m/s]
    encoder: Array  # (n,) position that the encoder shows [m]

    def error(self, v_cmd: Array, x_cmd: Array, used: slice) -> TrackingError:
        """Return the errors of the samples used against commands (n,) [m/s] and (n,) [m]."""
        return TrackingError.of((self.velocity - v_cmd)[used], (self.position - x_cmd)[used])


def commanded_velocity(recording: Recording) -> Array:
    """Return the velocity command (n,) [m/s], or the derivative of that of position, or raise."""
    received = recording.controller_inputs.get("v_cmd")
    if received is not None:
        return received
    if recording.position_command is None:
        raise UsageError(
            f"{recording.source}: no command; log the velocity or position command, or name its "
            "column with <column velocity_command=NAME>"
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


def simulate(
    fmus: Path,  # folder of the candidate's FMUs, see ``candidate_fmus``
    recording: Recording,  # gives commands, start and the encoder's steps
    gains: Mapping[str, float],  # of the controller FMU by name
    drive: LearnedDrive,
    force_limit: float | None = None,  # of motor or amplifier [N]
) -> dict[str, SimulatedMotion]:
    """Return the motion of the drive by variant: without and with compensator, without friction."""
    case = _Case(recording, gains, drive, force_limit)
    force = case.scale.force * feedforward(recording, drive)
    # What the drive holds by its position acts without a compensator, and is cancelled with it.
    variants: dict[str, tuple[Mapping[str, float], Array | float]] = {
        NONE: (case.values, 0.0),
        FEEDFORWARD: (case.values, force + case.held),
        FRICTIONLESS: (case.free, case.held),
    }
    return case.runs(fmus, variants)


INERTIA = "feedforward of mass and viscous friction"
VELOCITY = "velocity feedforward in the position loop"
"""What can be changed in a loop whose error is not that of friction."""


def remedied(
    fmus: Path,
    recording: Recording,
    gains: Mapping[str, float],
    drive: LearnedDrive,
    force_limit: float | None = None,
) -> dict[str, SimulatedMotion]:
    """Return the motion without friction by what is changed in the loop, if it stays stable."""
    case = _Case(recording, gains, drive, force_limit)
    found: dict[str, SimulatedMotion] = {}
    v_cmd = commanded_velocity(case.recording)
    inertia = case.values["m"] * derivative(v_cmd, recording.T_s) + case.values["b"] * v_cmd
    changes: dict[str, tuple[_Case, Array | float]] = {INERTIA: (case, inertia)}
    if gains.get("K_x") and gains.get("velocity_feedforward", 1.0) < 1.0:
        led = replace(recording, velocity_command=commanded_velocity(recording))
        quicker = _Case(led, {**gains, "velocity_feedforward": 1.0}, drive, force_limit)
        both = quicker, inertia
        changes = {VELOCITY: (quicker, 0.0), **changes, f"{VELOCITY}, and {INERTIA}": both}
    for name, (one, added) in changes.items():
        with suppress(cosim.SimulationError):
            found |= one.runs(fmus, {name: (one.free, added + one.held)})
    return found


class _Case:
    """A recording, its loop and its drive, in an internal scale."""

    def __init__(
        self,
        recording: Recording,
        gains: Mapping[str, float],
        drive: LearnedDrive,
        force_limit: float | None,
    ) -> None:
        force = np.full(1, drive.values["F_c"]) if recording.force is None else recording.force
        self.scale = scale_of(force, commanded_velocity(recording))
        self.recording = self.scale.recording(recording)
        self.gains, self.values = self.scale.values(gains), self.scale.values(drive.values)
        self.further = {"candidate.noise_x": 0.0}
        if force_limit is not None:
            limits = ("candidate.u_max", "controller.u_max")
            self.further |= dict.fromkeys(limits, self.scale.force * force_limit)
        law = friction_law(drive.law)
        friction = {k: value for k, value in self.values.items() if k in law.parameters}
        self.free = {**self.values, **law.share(friction, NEGLIGIBLE)}
        held = self.recording.known_force
        self.held: Array | float = 0.0 if held is None else held

    def runs(
        self, fmus: Path, variants: Mapping[str, tuple[Mapping[str, float], Array | float]]
    ) -> dict[str, SimulatedMotion]:
        """Return the motion by variant, each with values of the drive and a force that is added."""
        signals = ("candidate.x", "candidate.v", "candidate.x_enc")
        with KnownLoop(fmus, self.recording, self.gains, encoder=True) as loop:
            runs = {name: loop.bounded(of, self.further, f) for name, (of, f) in variants.items()}
        return {
            name: SimulatedMotion(*(run[signal] / self.scale.length for signal in signals))
            for name, run in runs.items()
        }


def feedforward(recording: Recording, drive: LearnedDrive) -> Array:
    """Return the compensator's force (n,) [N] from each sample of a recording on."""
    one = drive.compensator
    if one is None:
        return np.zeros_like(recording.t)
    v = commanded_velocity(recording)
    lead = 0.0
    if (loop := drive.reference) is not None:  # it may sample at other times
        lead, t = loop.axis.tau_i, recording.t
        own = np.arange(round(t[-1] / loop.T_s) + 1) * loop.T_s
        v = np.interp(t, own, loop.response(np.interp(own, t, v))[0])
        v = np.append(v[1:], v[-1])  # of the end of the step
    law = (one.law or drive.law) if models.load_model(one.model).law else None
    fixed = {name: x for name, x in one.ports.axis.items() if not isinstance(x, str)}
    values = {name: x for name, x in one.values.items() if name not in DRIVE}
    system = cosim.System("feedforward")
    stop, output = (len(v) - 1) * recording.T_s, f"compensator.{one.ports.output}"
    with temporary_folder() as folder:
        fmu = models.build_fmu(one.model, folder, law=law)
        system.add("compensator", fmu, {**fixed, "lead": lead, **values})
        system.expose("v", "compensator.v")
        with system.prepare(step=recording.T_s, stop=stop, record=(output,)) as simulation:
            shown = simulation.run({}, {"v": v})[output]
    return np.append(shown[1:], shown[-1])  # row n + 1 shows the force from sample n on
