"""A log with the compensator running against one without: tracking errors on the same command.

Each log's own errors count, where the same command ran. The uncertainty of a reduction is a
jackknife over repetitions of the command, or over parts of the logs where it does not repeat.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t as student

from stickslip.errors import UsageError
from stickslip.evaluation.tracking import (
    FEEDFORWARD,
    NONE,
    TRACKING_FIGURES,
    TrackingError,
    commanded_position,
    commanded_velocity,
    cutoff,
    measured_errors,
)
from stickslip.logs import Motion, Recording
from stickslip.logs.same_command import Overlap, is_moving, period, same_command
from stickslip.servo.measurement import Array
from stickslip.studies.validate.log_prediction import Change
from stickslip.thresholds import transfer

Samples = NDArray[np.intp]

EDGE = 4.0
"""Periods of the low-pass of measured velocities at either end of a log that do not count."""
PARTS = 10  # Parts of the logs where the command does not repeat


@dataclass(frozen=True)
class TrackingComparison:
    """Errors without and with the compensator, measured or simulated."""

    # (n,) errors over the common samples by variant [m/s], [m]
    velocity: Mapping[str, Array]
    position: Mapping[str, Array]
    # by variant; a maximum is the mean over parts of the largest error in each
    errors: Mapping[str, TrackingError]
    # by which share an error is smaller with the compensator, by name of the figure
    reductions: Mapping[str, Change]


@dataclass(frozen=True)
class LogComparison:
    """What the compensator brought in two logs."""

    motion: Motion
    t: Array  # (n,) of the common samples, in the log without compensator [s]
    v_cmd: Array  # (n,) [m/s]
    stretches: tuple[Overlap, ...]  # where in the two logs the command was the same
    part: Samples  # (n,) number of the part that each sample belongs to
    repeated: bool  # whether the parts are repetitions of the command
    measured: TrackingComparison  # in the logs
    # of the learned drive along the same command; None where the loop is not known
    simulated: TrackingComparison | None = None
    fault: str = ""  # why that loop could not be simulated, or not with all, or empty

    @property
    def parts(self) -> int:
        """How many parts there are."""
        return int(self.part.max()) + 1


def common(without: Recording, compensated: Recording) -> tuple[Recording, list[Overlap]]:
    """Return the second log on the first's sampling, and where both have the same command."""
    compensated = resampled(compensated, without.T_s)
    first, second = commanded_velocity(without), commanded_velocity(compensated)
    edge = round(EDGE / cutoff(without.T_s) / without.T_s)
    stretches = [
        Overlap(run.first + begin, run.second + begin, end - begin)
        for run in same_command(first, second, without.T_s)
        for begin, end in [_inside(run, edge, len(first), len(second))]
        if end > begin
    ]
    moving = is_moving(first)
    shared = sum(int(moving[run.first : run.first + run.n].sum()) for run in stretches)
    whole = min(int(moving.sum()), int(is_moving(second).sum()))
    if shared < transfer.IN_COMMON * whole or not shared:
        speeds = " and ".join(f"{1e3 * np.max(np.abs(v)):.3g}" for v in (first, second))
        unit = "mrad/s" if without.motion == "rotary" else "mm/s"
        raise UsageError(
            f"the commands of {without.source} and {compensated.source} differ: the same for "
            f"{shared * without.T_s:.3g} s of {whole * without.T_s:.3g} s of motion, largest "
            f"speeds {speeds} {unit}; log the same command without and with the compensator"
        )
    return compensated, stretches


def _inside(run: Overlap, edge: int, first: int, second: int) -> tuple[int, int]:
    """Return begin and end in a stretch of what is not near the ends of the logs."""
    begin = max(0, edge - run.first, edge - run.second)
    return begin, min(run.n, first - edge - run.first, second - edge - run.second)


def resampled(recording: Recording, T_s: float) -> Recording:
    """Return a recording on another even grid [s], by linear interpolation."""
    if abs(recording.T_s - T_s) <= 1e-6 * T_s:
        return recording
    t = np.arange(int(recording.t[-1] / T_s * (1.0 + 1e-9)) + 1) * T_s
    signals = {name: np.interp(t, recording.t, one) for name, one in recording.arrays.items()}
    return replace(recording, **{**signals, "t": t})


def compare(without: Recording, compensated: Recording, stretches: list[Overlap]) -> LogComparison:
    """Return the measured comparison of two logs on one sampling."""
    first = np.concatenate([np.arange(run.first, run.first + run.n) for run in stretches])
    second = np.concatenate([np.arange(run.second, run.second + run.n) for run in stretches])
    command = commanded_velocity(without)
    part, repeated = _parts(command, stretches, without.T_s)
    measured = compared(without, compensated, first, second, part=part)
    return LogComparison(
        *(without.motion, without.t[first], command[first], tuple(stretches)),
        part=part,
        repeated=repeated,
        measured=measured,
    )


def compared(
    without: Recording, compensated: Recording, first: Samples, second: Samples, part: Samples
) -> TrackingComparison:
    """Return the errors of two recordings at samples (n,) of each."""
    velocity, position = {}, {}
    for name, recording, samples in ((NONE, without, first), (FEEDFORWARD, compensated, second)):
        v_cmd, x_cmd = commanded_velocity(recording), commanded_position(recording)
        v_error, x_error = (error[samples] for error in measured_errors(recording, v_cmd, x_cmd))
        if recording.position_command is None:  # the offset of its integral is not known
            x_error = x_error - x_error.mean()
        velocity[name], position[name] = v_error, x_error
    figures = {name: _figures(velocity[name], position[name], part) for name in velocity}
    errors = {
        name: TrackingError(**{key: _size(key, of[key]) for key in TRACKING_FIGURES})
        for name, of in figures.items()
    }
    reductions = {
        key: _reduction(key, figures[NONE][key], figures[FEEDFORWARD][key])
        for key in TRACKING_FIGURES
    }
    return TrackingComparison(velocity, position, errors, reductions)


def sentences(found: LogComparison) -> tuple[str, ...]:
    """Return what the compensator brought, measured and as simulated, a sentence each."""
    texts = []
    for key, what in (("velocity_rms", "velocity"), ("position_rms", "position")):
        one = found.measured.reductions[key]
        brought, sign = ("smaller", 1.0) if one.value >= 0.0 else ("larger", -1.0)
        low, high = sorted((sign * one.low, sign * one.high))
        text = (
            f"measured: the RMS error of {what} is {_percent(sign * one.value)} {brought} with the"
            f" compensator, 95 % [{_percent(low)}, {_percent(high)}]"
        )
        if found.simulated:
            predicted = found.simulated.reductions[key].value
            text += f"; simulated: {_percent(sign * predicted)} {brought}"
            if not found.fault:
                where = "inside" if one.low <= predicted <= one.high else "outside"
                text += f", {where} the measured interval"
        texts.append(text)
    return (*texts, found.fault) if found.fault else tuple(texts)


def _percent(share: float) -> str:
    return f"{100.0 * share:.3g} %"


def _parts(command: Array, stretches: list[Overlap], T_s: float) -> tuple[Samples, bool]:
    """Return the part of each common sample: repetitions of the command, or equal parts."""
    moving = is_moving(command)
    longest = max(stretches, key=lambda run: run.n)
    repeats = period(command[_moved(moving, longest)], T_s)
    if repeats is not None:
        parts, last = [], 0
        for run in stretches:
            moved = _moved(moving, run)
            whole = max((moved.stop - moved.start) // repeats, 1)
            own = (np.arange(run.first, run.first + run.n) - moved.start) // repeats
            parts.append(last + np.clip(own, 0, whole - 1))
            last += whole
        if last >= transfer.REPETITIONS:
            return np.concatenate(parts), True
    n = sum(run.n for run in stretches)
    return np.arange(n) * PARTS // n, False


def _moved(moving: NDArray[np.bool_], run: Overlap) -> slice:
    """Return the samples of a stretch from the first to the last in which the command moves."""
    where = run.first + np.flatnonzero(moving[run.first : run.first + run.n])
    return slice(int(where[0]), int(where[-1]) + 1)


def _figures(velocity: Array, position: Array, part: Samples) -> dict[str, Array]:
    """Return mean squares and largest errors of each part, by name of the figure."""
    count = np.bincount(part)
    found = {}
    for name, error in (("velocity", velocity), ("position", position)):
        largest = np.zeros(len(count))
        np.maximum.at(largest, part, np.abs(error))
        found[f"{name}_rms"] = np.bincount(part, error**2) / count
        found[f"{name}_max"] = largest
    return found


def _size(key: str, parts: Array) -> float:
    mean = float(np.mean(parts))
    return float(np.sqrt(mean)) if key.endswith("rms") else mean


def _reduction(key: str, without: Array, compensated: Array) -> Change:
    """Return the reduction of parts (k,); its standard error is a jackknife of the logarithm."""
    k = len(without)

    def ratio(kept: Samples) -> float:
        size = _size(key, without[kept])
        return _size(key, compensated[kept]) / size if size > 0.0 else np.nan

    whole = ratio(np.arange(k))
    left = np.log([ratio(np.delete(np.arange(k), j)) for j in range(k)])
    half = float(student.ppf(0.975, k - 1) * np.sqrt((k - 1) * np.var(left)))
    low, high = (float(whole * np.exp(sign * half)) for sign in (1.0, -1.0))
    return Change(1.0 - whole, 1.0 - low, 1.0 - high)
