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
from stickslip.logs.steps import step_of
from stickslip.servo.measurement import Array, smoothed
from stickslip.thresholds import log_force


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
        marked, step = np.zeros(len(force), dtype=bool), step_of(force)
        for sign in (1.0, -1.0):
            one = sign * force
            most = float(np.quantile(one, 0.999))
            level = log_force.AT_STATED * limit if limit else (1.0 - log_force.AT_LIMIT) * most
            if level > 0.0:
                demand = _demand(recording, name, sign, one < level, level=level)
                least = log_force.DEMANDED * level + step
                for begin, end in runs(one >= level):
                    part = slice(begin, end)
                    more = _more(demand, part, level) > least if demand else bool(limit)
                    marked[part] |= more and end - begin >= log_force.PLATEAU
        most, share = float(np.max(np.abs(force))), float(np.mean(marked))
        if share > (0.0 if limit else log_force.SELDOM):
            advice = "there it does not follow its command; log a gentler motion"
            what = f"{name} saturates at {float(np.max(np.abs(force[marked]))):.4g}"
            yield Finding("warning", what, f"{share:.2%}", advice, spoils="intervals")
        if limit and most > log_force.EXCEEDED * limit:
            figure = f"{most:.4g} against {limit:.4g}"
            advice = "check unit and scale, and that it was logged behind the limit"
            what = f"{name} exceeds the force limit"
            yield Finding("warning", what, figure, advice, spoils="values")


def _more(demand: tuple[Array, bool], samples: slice, level: float) -> float:
    """Return how much more [N] is asked for in some samples than the force there."""
    signal, changes = demand
    part = signal[samples]
    return float(np.max(part) - part[0] if changes else np.mean(part) - level)


def _demand(
    recording: Recording, name: str, sign: float, free: NDArray[np.bool_], level: float
) -> tuple[Array, bool] | None:
    """Return the force (n,) that is asked for in one direction [N], None if no command is known.

    Without a force command it is that of a velocity loop, or of a cascade where the position was
    commanded, whose gains the rest of the log shows. Only its changes are known then: the second
    value.
    """
    force = sign * getattr(recording, name)
    command = recording.force_command
    if name == "force" and command is not None:
        large = free & (np.abs(force) > 0.3 * level)
        ratio = float(np.median(sign * command[large] / force[large])) if large.any() else 1.0
        return np.asarray(sign * command / (ratio if ratio > 0.0 else 1.0)), False
    motion = kinematics(recording)
    if recording.velocity_command is not None:
        wanted, shown, more = recording.velocity_command, motion.v, []
    elif recording.position_command is not None:
        wanted, shown, more = recording.position_command, motion.x, [motion.v]
    else:
        return None
    error = smoothed(wanted, recording.T_s, motion.cutoff) - shown
    terms = sign * np.column_stack([error, *more])
    reach = max(1, round(0.5 / (motion.cutoff * recording.T_s)))
    smooth = smoothed(force, recording.T_s, motion.cutoff)
    used = free[reach:] & free[:-reach]
    changes = terms[reach:] - terms[:-reach]
    rise = (smooth[reach:] - smooth[:-reach])[used]
    gains = np.linalg.lstsq(changes[used], rise, rcond=None)[0]
    if gains[0] <= 0.0 or np.any(gains[1:] > 0.0):  # those of no loop
        return np.zeros_like(force), True
    return np.asarray(terms @ gains), True
