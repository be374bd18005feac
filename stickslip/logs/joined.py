"""Several logs of one drive, or stretches of one, as one recording.

Between two logs the position moves on smoothly, for as long as that takes at the speed of the logs.
Nothing is learned there: the recording says which of its samples are those of a log.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from stickslip.errors import RecordingError
from stickslip.logs.recording import Recording, Segment
from stickslip.servo.measurement import Array, smoothed

SHORTEST = 0.2  # time between two logs [s]
STEEPEST = 1.875  # top speed of a smooth move, over its mean speed
BAND = 0.25  # cut-off of the low-pass before a signal is sampled at a lower rate, over that rate


def join(
    recordings: Sequence[Recording],  # of like motion; the lowest rate is that of the result
    gains: Sequence[Mapping[str, float] | None],  # of the controller FMU in each, where known
    loads: Sequence[float],  # mass that each moved beside that of the drive [kg], or [kg m^2]
) -> Recording:
    """Return logs of one drive as one recording, with what belongs to each.

    Raises RecordingError where a log is of another motion, or lacks the force that others have.
    """
    first = recordings[0]
    for one in recordings:
        if one.motion != first.motion:
            raise RecordingError(
                f"{one.source}: a log of {one.motion} motion, but {first.source} is of "
                f"{first.motion} motion; expected logs of one drive: give <motion>, or learn them "
                "apart"
            )
        for name in ("force", "position"):
            if (getattr(one, name) is None) != (getattr(first, name) is None):
                has, lacks = (one, first) if getattr(first, name) is None else (first, one)
                raise RecordingError(
                    f"{lacks.source}: no {name}, but {has.source} has it; expected the same "
                    f"signals in all logs: name its column, <column {name}=NAME>"
                )
    T_s = max(one.T_s for one in recordings)
    logs = [_sampled(one, T_s) for one in recordings]
    names = set.intersection(*(set(one.arrays) for one in logs)) - {"t"}
    speed = max(float(np.max(np.abs(_velocity(one)))) for one in logs)
    pieces: dict[str, list[Array]] = {name: [] for name in names}
    segments: list[Segment] = []
    n = 0
    for k, log in enumerate(logs):
        if k:
            way = _between(logs[k - 1], log, names, speed)
            for name, signal in way.items():
                pieces[name].append(signal)
            n += len(next(iter(way.values())))
        for name in names:
            pieces[name].append(log.arrays[name])
        segments += (
            Segment(one.begin + n, one.end + n, one.source, gains=gains[k], load=loads[k], log=k)
            for one in log.pieces
        )
        n += len(log.t)
    signals: dict[str, Any] = {
        name: np.concatenate(pieces[name]) if name in names else None for name in first.arrays
    }
    several = f"{first.source} and {len(logs) - 1} others"
    return replace(
        first,
        **signals | {"t": T_s * np.arange(n)},
        encoder_step=max(one.encoder_step for one in logs),
        source=" and ".join(one.source for one in logs) if len(logs) < 3 else several,
        segments=tuple(segments),
    )


def _velocity(log: Recording) -> Array:
    if log.position is not None:
        return np.diff(log.position) / log.T_s
    return np.zeros(1) if log.velocity is None else log.velocity


def _between(one: Recording, other: Recording, names: set[str], speed: float) -> dict[str, Array]:
    """Return signals (n,) by name from the end of one log to the begin of another."""
    way = 0.0
    if one.position is not None and other.position is not None:
        way = abs(float(other.position[0] - one.position[-1]))
    n = round(max(SHORTEST, STEEPEST * way / max(speed, 1e-300)) / one.T_s)
    s = (np.arange(n) + 1.0) / (n + 1.0)
    smooth = s**3 * (10.0 - 15.0 * s + 6.0 * s**2)  # without jerk at either end
    ends = {name: (one.arrays[name][-1], other.arrays[name][0]) for name in names}
    return {name: begin + (end - begin) * smooth for name, (begin, end) in ends.items()}


def _sampled(log: Recording, T_s: float) -> Recording:
    """Return a log at a lower rate."""
    if abs(log.T_s / T_s - 1.0) < 1e-6:
        return log
    t = T_s * np.arange(int(log.t[-1] / T_s) + 1)
    signals: dict[str, Any] = {
        name: signal if name == "position" else smoothed(signal, log.T_s, BAND / T_s)
        for name, signal in log.arrays.items()
    }
    signals = {name: np.interp(t, log.t, signal) for name, signal in signals.items()}
    rate = log.T_s / T_s
    segments = tuple(
        replace(one, begin=math.ceil(one.begin * rate), end=min(int(one.end * rate), len(t)))
        for one in log.segments
    )
    return replace(log, **signals | {"t": t}, segments=segments)
