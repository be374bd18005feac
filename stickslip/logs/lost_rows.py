"""Rows that are missing under an even clock."""

from __future__ import annotations

import numpy as np
import scipy

from stickslip.logs.finding import Finding
from stickslip.logs.recording import Recording
from stickslip.thresholds import log_force

WINDOW = 7  # number of differences of the position in the moving median
ALIKE = 0.25
"""Largest deviation of the neighbours of a jump from that median, relative: steady motion."""
STEPS = 5.0  # encoder steps per row from which one row can be distinguished from two


def lost_rows(recording: Recording) -> Finding | None:
    """Return a finding where single steps of the position are whole multiples of their neighbours.

    A mass cannot move twice as far in one sample as in those before and after; a row is missing
    there, though the clock is even.
    """
    x = recording.position
    if x is None or len(x) < 10 * WINDOW:
        return None
    steps = np.diff(x)
    usual = scipy.ndimage.median_filter(steps, WINDOW)
    noise = 1.4826 * float(np.median(np.abs(np.diff(x, 3)))) / np.sqrt(20.0)
    fast = np.abs(usual) > max(STEPS * recording.encoder_step, 10.0 * noise)
    off = np.abs(steps - usual)
    beside = np.maximum(np.roll(off, 1), np.roll(off, -1))
    fast[[0, -1]] = False
    fast &= beside < ALIKE * np.abs(usual)
    ratio = steps[fast] / usual[fast]
    missing = np.round(ratio) - 1.0
    found = (missing >= 1.0) & (np.abs(ratio - np.round(ratio)) < 0.3 * missing)
    if np.sum(found) < log_force.LOST_ROWS:
        return None
    share = float(np.sum(missing[found]) / (len(ratio) + np.sum(missing[found])))
    figure = f"{share:.2%}, the position jumps {np.sum(found)} times by a multiple of its step"
    advice = "log without gaps, or with the true times"
    return Finding("warning", "rows are lost under an even clock", figure, advice, spoils="values")
