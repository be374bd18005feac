"""Faults of a log that its values alone do not show: rows lost, commands before a limit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.ndimage import median_filter

from stickslip.logs.finding import Finding
from stickslip.logs.motion import unexplained
from stickslip.logs.recording import Recording

WINDOW = 7
"""Differences of the position whose median is the usual one."""
STEPS = 5.0
"""Encoder steps that the position must change by from row to row, to tell one row from two."""
EVENTS = 5
LEVELS = (0.5, 0.6, 0.7, 0.75, 0.8, 0.85, 0.9, 0.925, 0.95, 0.97, 0.98, 0.99, 0.995)
"""Quantiles of the force at which a limit is tried."""
EXPLAINED = 0.25
"""Share of the unexplained force that a limit may leave, to be believed."""


def lost_rows(recording: Recording) -> Finding | None:
    """Return a finding where single steps of the position are whole multiples of their neighbours.

    A mass cannot move twice as far in one sample as in those before and after; a row is missing
    there, though the clock is even.
    """
    x = recording.position
    if x is None or len(x) < 10 * WINDOW:
        return None
    steps = np.diff(x)
    usual = median_filter(steps, WINDOW)
    noise = 1.4826 * float(np.median(np.abs(np.diff(x, 3)))) / np.sqrt(20.0)
    fast = np.abs(usual) > max(STEPS * recording.encoder_step, 10.0 * noise)
    ratio = steps[fast] / usual[fast]
    missing = np.round(ratio) - 1.0
    found = (missing >= 1.0) & (np.abs(ratio - np.round(ratio)) < 0.3 * missing)
    if np.sum(found) < EVENTS:
        return None
    share = float(np.sum(missing[found]) / (len(ratio) + np.sum(missing[found])))
    figure = f"{share:.2%}, the position jumps {np.sum(found)} times by a multiple of its step"
    advice = "log without gaps, or with the true times"
    return Finding("warning", "rows are lost under an even clock", figure, advice, spoils="values")


def clipped_command(recording: Recording) -> Finding | None:
    """Return a finding where the motion shows a limit that the logged force does not have.

    The force of a rigid drive is fitted to the motion for each limit that may have acted.
    """
    force = recording.force
    if force is None:
        return None
    limits = np.quantile(np.abs(force), LEVELS)
    left = [unexplained(replace(recording, force=np.clip(force, -at, at))) for at in limits]
    best = int(np.argmin(left))
    if best == 0 or not left[best] < EXPLAINED * unexplained(recording):
        return None
    share = float(np.mean(np.abs(force) > limits[best]))
    figure = f"{np.abs(force).max():.4g}, while the motion shows at most {limits[best]:.4g}"
    advice = "log it behind the limit, or the current"
    what = "the force was logged before a limit"
    return Finding("warning", what, f"{figure}; {share:.1%} of the time", advice, spoils="values")
