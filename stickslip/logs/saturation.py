"""Forces that stay at an extreme while more is asked for.

A force that stays at its extreme may be one that was commanded, or Coulomb friction of a drive at
constant speed. It is limited only where the force command is larger, or where the error of the
motion grows, by so much that the loop would command more.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from stickslip.logs.finding import Finding
from stickslip.logs.grid import runs
from stickslip.logs.motion import kinematics
from stickslip.logs.recording import Recording
from stickslip.servo.measurement import Array, smoothed

FLAT = 0.02
"""Distance of a force from its extreme, relative, up to which it stays there."""
STATED = 0.995
"""Share of a stated limit from which a force is at it."""
SHORTEST = 3
"""Samples at an extreme."""
MORE = 0.05
"""Share of the extreme by which more is asked for; a loop without a limit has 0 where its force
stays equal, and noise of the force is less than ``FLAT``."""
SELDOM = 0.002
"""Share of the samples at a limit up to which it is not reported."""


def saturation(recording: Recording, limit: float | None) -> Iterator[Finding]:
    """Yield forces at a limit, and such that are beyond the one that is stated.

    Parameters
    ----------
    recording : on its even grid
    limit : of the force, stated [N]; None where none is
    """
    for name in ("force", "force_command"):
        force = getattr(recording, name)
        if force is None:
            continue
        marked = np.zeros(len(force), dtype=bool)
        for sign in (1.0, -1.0):
            one = sign * force
            most = float(np.quantile(one, 0.999))
            level = STATED * limit if limit else (1.0 - FLAT) * most
            if level > 0.0:
                demand = _demand(recording, name, sign, one < level, level)
                for begin, end in runs(one >= level):
                    if end - begin >= SHORTEST and _more(demand, begin, end, level, limit):
                        marked[begin:end] = True
        most, share = float(np.max(np.abs(force))), float(np.mean(marked))
        if share > (0.0 if limit else SELDOM):
            advice = "there it does not follow its command; log a gentler motion"
            what = f"{name} saturates at {float(np.max(np.abs(force[marked]))):.4g}"
            yield Finding("warning", what, f"{share:.2%}", advice, spoils="intervals")
        if limit and most > 1.05 * limit:
            figure = f"{most:.4g} against {limit:.4g}"
            advice = "check unit and scale, and that it was logged behind the limit"
            what = f"{name} exceeds the force limit"
            yield Finding("warning", what, figure, advice, spoils="values")


def _more(demand: Array | None, begin: int, end: int, level: float, limit: float | None) -> bool:
    """Tell whether more is asked for in samples begin to end, or, at a stated limit, nothing is."""
    if demand is None:
        return limit is not None
    return float(np.max(demand[begin:end]) - demand[begin]) > MORE * level or bool(
        np.mean(demand[begin:end]) > (1.0 + MORE) * level
    )


def _demand(
    recording: Recording, name: str, sign: float, free: NDArray[np.bool_], level: float
) -> Array | None:
    """Return the force (n,) that is asked for in one direction [N], None if no command is known.

    Without a force command it is that which the error of the motion adds in a loop whose gain the
    rest of the log shows.
    """
    force = sign * getattr(recording, name)
    command = recording.force_command
    if name == "force" and command is not None:
        large = free & (np.abs(force) > 0.3 * level)
        ratio = float(np.median(sign * command[large] / force[large])) if large.any() else 1.0
        return np.asarray(sign * command / (ratio if ratio > 0.0 else 1.0))
    motion = kinematics(recording)
    if recording.velocity_command is not None:
        wanted, shown = recording.velocity_command, motion.v
    elif recording.position_command is not None:
        wanted, shown = recording.position_command, motion.x
    else:
        return None
    error = sign * (smoothed(wanted, recording.T_s, motion.cutoff) - shown)
    reach = max(1, round(0.5 / (motion.cutoff * recording.T_s)))
    rise = smoothed(force, recording.T_s, motion.cutoff)
    rise, change = rise[reach:] - rise[:-reach], error[reach:] - error[:-reach]
    used = free[reach:] & free[:-reach]
    gain = float(rise[used] @ change[used]) / max(float(change[used] @ change[used]), 1e-300)
    return np.asarray(max(gain, 0.0) * error)
