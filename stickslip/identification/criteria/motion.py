"""The motion of a recording, and units of the recording in which values are of the order of 1."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stickslip.catalog.parameters import force_and_length_of
from stickslip.errors import UsageError
from stickslip.logs import Recording
from stickslip.servo.measurement import Array, derivative, smoothed

SHARE = 1.0 / 16.0  # cut-off of the low-pass, as a share of the rate of the rows
LONGEST = 1 << 6  # largest number of samples in a row
_PASSED = 0.2  # integral of f^4 |H|^4 over f from 0, in cut-offs; H is of second order
_FEW = 200  # samples that are too few to show noise
_ORDER = 6  # of the differences that show it
_MEDIAN = 0.6745  # median of the absolute value of normal noise, over its standard deviation


@dataclass(frozen=True)
class SmoothMotion:
    """Velocity v (n,) [m/s] and acceleration a (n,) [m/s^2], low-passed without phase lag."""

    v: Array
    a: Array


def smooth_motion(position: Array, T_s: float, cutoff: float) -> SmoothMotion:
    """Differentiate a position (n,) [m] twice, behind a zero-phase low-pass [Hz]."""
    v = derivative(smoothed(position, T_s, cutoff), T_s)
    return SmoothMotion(v, derivative(v, T_s))


def position_noise(position: Array, step: float) -> float:
    """Return the standard deviation [m] of what is not motion in a position (n,) [m].

    Third differences of a smooth motion are small, those of white noise sqrt(20) times itself; an
    encoder's step counts as evenly distributed at least.
    """
    third = float(np.mean(np.diff(position, 3) ** 2)) / 20.0
    return float(np.sqrt(max(third, step**2 / 12.0, np.finfo(float).tiny)))


def encoder_noise(position: Array, step: float) -> float:
    """Return the standard deviation [m] of the noise on a position (n,) [m], beside its steps.

    It shows where the drive moves a step a sample. At rest the steps hide the noise.
    """
    moving = np.abs(position[_ORDER:] - position[:-_ORDER]) > _ORDER * step
    deviation = white_noise(position, moving)
    return math.sqrt(max(deviation**2 - step**2 / 12.0, 0.0))


def differences(signal: Array) -> Array:
    """Return high differences (n - 6, ...) of signals (n, ...), in which slow ones vanish."""
    return np.diff(signal, _ORDER, axis=0)


def white_noise(signal: Array, used: slice | NDArray[np.bool_] = slice(None)) -> float:
    """Return the standard deviation of the noise on a signal (n,), 0 where that is too short.

    It is the median of high differences (n - 6,), of those that are used.
    """
    high = np.abs(differences(signal))[used]
    if len(high) < _FEW:
        return 0.0
    return float(np.median(high)) / (_MEDIAN * math.sqrt(math.comb(2 * _ORDER, _ORDER)))


def means(signal: Array, q: int) -> Array:
    """Return the rows of a signal (n,): means of q samples each; the samples left are dropped."""
    return signal if q == 1 else signal[: len(signal) // q * q].reshape(-1, q).mean(axis=1)


def samples_per_row(
    position: Array,  # (n,) [m]
    T_s: float,
    noise: float,  # standard deviation of the position [m]
    least: int,  # number to begin with, which is doubled as often as needed
    share: float,  # largest variance of the acceleration by noise, over that of the motion
    rows: float,  # number that must be left
) -> int:
    """Return how many samples a row takes so that encoder noise does not hide the acceleration."""
    q = least
    while q < LONGEST and len(position) // (2 * q) > rows:
        cutoff = SHARE / (q * T_s)
        a = smooth_motion(means(position, q), q * T_s, cutoff).a
        # White noise of this deviation, twice differentiated behind the two passes of the filter.
        own = 2.0 * T_s * noise**2 * (2.0 * np.pi) ** 4 * cutoff**5 * _PASSED
        if own < share * float(np.var(a)):
            break
        q *= 2
    return q


def velocity_noise(noise: float, T_s: float, cutoff: float) -> float:
    """Return the deviation [m/s] of a velocity, cut off [Hz], by noise on the position [m]."""
    return float(2.0 * np.pi * noise * np.sqrt(2.0 * cutoff**3 * T_s / 3.0))


def position_of(recording: Recording) -> Array:
    """Return the position (n,) [m] or the velocity's integral; raise UsageError without both."""
    if recording.position is not None:
        return recording.position
    if recording.velocity is None:
        raise UsageError(
            f"{recording.source}: no position and no velocity; log one of them to learn from it"
        )
    v = recording.velocity
    return np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * recording.T_s)])


def measured_force(recording: Recording) -> Array:
    """Return the force (n,) [N] of motor or friction, less what is known of it otherwise."""
    for signal in (recording.force, recording.friction, recording.force_command):
        if signal is not None:
            return recording.moving(signal)
    raise UsageError(
        f"{recording.source}: no force; log the motor's force or current, or give <controller>"
        " and <gain>"
    )


def against_motion(recording: Recording) -> tuple[Recording, tuple[str, ...]]:
    """Return a recording whose measured friction acts against the motion, and what was changed."""
    if recording.force is not None or recording.friction is None:
        return recording, ()
    position = position_of(recording)
    work = float(recording.friction[1:] @ np.diff(position))
    if work >= 0.0:
        return recording, ()
    turned = replace(recording, friction=-recording.friction)
    return turned, ("the friction logged does work on the motion: its sign was turned",)


FORCES = (0.3, 1e4)  # root mean square that needs no scale [N]
SPEEDS = (2e-3, 2.0)  # top speed that needs none [m/s]
FORCE, SPEED = 10.0, 0.05  # what others are brought near to

_LENGTHS = {"position", "velocity", "position_command", "velocity_command", "added_velocity"}
_FORCES = {"force", "friction", "force_command", "added_force", "known_force"}
_MEMORY = {"F_held", "F_fading"}  # initial state of the controller [N]


@dataclass(frozen=True)
class Scale:
    """Scaled = SI times these factors, which are powers of ten.

    The FMUs' integrators have absolute tolerances and their parameters ranges, made for linear
    axes; a small rotary drive has a torque of 0.01 N m and a speed of 100 rad/s.
    """

    force: float = 1.0
    length: float = 1.0

    def of(self, name: str) -> float:
        """Return the factor of a parameter or gain."""
        force, length = (1, 0) if name in _MEMORY else force_and_length_of(name)
        return self.force**force * self.length**length

    def values(self, values: Mapping[str, float]) -> dict[str, float]:
        """Return SI values by name, scaled."""
        return {name: value * self.of(name) for name, value in values.items()}

    def restored(self, values: Mapping[str, float]) -> dict[str, float]:
        """Return scaled values by name in SI."""
        return {name: value / self.of(name) for name, value in values.items()}

    def recording(self, recording: Recording) -> Recording:
        """Return a recording, scaled."""
        factors = dict.fromkeys(_LENGTHS, self.length) | dict.fromkeys(_FORCES, self.force)
        signals: dict[str, Array | None] = {
            name: getattr(recording, name) * factor
            for name, factor in factors.items()
            if getattr(recording, name) is not None
        }
        step = recording.encoder_step * self.length
        segments = tuple(
            replace(one, gains=one.gains and self.values(one.gains), load=one.load * self.of("m"))
            for one in recording.segments
        )
        both = {"encoder_step": step, "segments": segments}
        return replace(recording, **signals, **both)  # type: ignore[arg-type]


SI = Scale()  # no scale


def recording_scale(recording: Recording) -> Scale:
    """Return the scale that suits a recording; none where no force was logged."""
    velocity = np.diff(position_of(recording)) / recording.T_s
    forces = (recording.force, recording.friction, recording.force_command)
    force = next((signal for signal in forces if signal is not None), None)
    if force is None:  # the controller's gains will tell
        return SI
    return scale_of(force, velocity)


def scale_of(force: Array, velocity: Array) -> Scale:
    """Return the scale that suits a force (n,) [N] and a velocity (n,) [m/s]."""
    size = float(np.sqrt(np.mean(force**2)))
    top = float(np.quantile(np.abs(velocity), 0.99))
    return Scale(_power(size, FORCES, FORCE), _power(top, SPEEDS, SPEED))


def _power(size: float, bearable: tuple[float, float], wanted: float) -> float:
    low, high = bearable
    if size <= 0.0 or low <= size <= high:
        return 1.0
    return float(10.0 ** np.round(np.log10(wanted / size)))
