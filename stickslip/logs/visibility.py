"""What a recording can and cannot show of a drive's parameters."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from stickslip.logs.excitation import Excitation
from stickslip.logs.finding import Finding
from stickslip.logs.recording import Recording

PLAN = "stickslip plan --show"
LITTLE = 0.05
"""Share of force or time below which a parameter hardly shows."""


def visibility(recording: Recording, shown: Excitation) -> Iterator[Finding]:
    """Yield what can and cannot be identified, and which experiment would show the rest.

    Parameters
    ----------
    recording : for its units
    shown : of the recording
    """
    unit = "rad" if recording.motion == "rotary" else "m"
    yield from _motion(shown, unit)
    yield from _sliding(shown, unit)
    yield _slow(shown, unit)
    yield _presliding(shown, unit)


def _motion(shown: Excitation, unit: str) -> Iterator[Finding]:
    low, high = shown.speeds
    figure = f"{shown.moving:.1%} of the time, 90 % of it at {low:.2g} to {high:.2g} {unit}/s"
    if shown.moving < 2 * LITTLE:
        advice = "move faster or longer; only presliding may be identifiable"
        yield Finding("warning", "the drive hardly moves", figure, advice)
    else:
        yield Finding("note", "the drive moves", figure)
    if shown.spacing < 20:
        figure = f"{shown.spacing:.0f} samples between two"
        what = "reversals are too fast for the sample rate"
        yield Finding("warning", what, figure, "sample faster or move slower")


def _sliding(shown: Excitation, unit: str) -> Iterator[Finding]:
    """Yield what shows m, b and F_c."""
    if shown.reversals < 2:
        figure = f"{shown.reversals} reversals"
        yield Finding("warning", "F_c and the offset are hard to separate", figure, f"{PLAN} F_c")
    if np.isfinite(shown.inertial):
        share = f"{shown.inertial:.1%} of the force"
        figure = f"accelerations up to {shown.acceleration:.3g} {unit}/s^2 cause {share}"
        if shown.inertial < LITTLE:
            yield Finding("warning", "m is poorly identifiable", figure, f"{PLAN} m")
        else:
            yield Finding("note", "m is identifiable", figure)
    low, high = shown.speeds
    if high < 3 * low:
        figure = f"only speeds of {low:.2g} to {high:.2g} {unit}/s"
        yield Finding("warning", "b and F_c are hard to separate", figure, f"{PLAN} b F_c")


def _slow(shown: Excitation, unit: str) -> Finding:
    """Return what shows F_s and v_s; the Stribeck velocity is not known beforehand."""
    share = f"{shown.slow:.1%} of the motion, {shown.slow_samples} samples"
    figure = f"{share} below {shown.slow_speed:.2g} {unit}/s"
    if shown.slow < LITTLE:
        return Finding("warning", "F_s and v_s are poorly identifiable", figure, f"{PLAN} F_s v_s")
    return Finding("note", "F_s and v_s may be identifiable", figure)


def _presliding(shown: Excitation, unit: str) -> Finding:
    """Return what shows sigma_0 and sigma_1."""
    turn = shown.turn_around
    advice = f"{PLAN} sigma_0 sigma_1"
    if turn is None:
        figure = "no velocity reversal was found"
        return Finding("warning", "sigma_0 and sigma_1 are not identifiable", figure, advice)
    counts = f", {turn.counts:.0f} encoder steps" if np.isfinite(turn.counts) else ""
    figure = (
        f"{turn.times} velocity reversals; friction reverses within {turn.distance:.2g} {unit}"
        f"{counts} and {turn.samples:.0f} samples"
    )
    if turn.times * turn.samples < 100 or turn.counts < 3 or turn.samples < 3:
        return Finding("warning", "sigma_0 and sigma_1 are poorly identifiable", figure, advice)
    return Finding("note", "sigma_0 and sigma_1 may be identifiable", figure)
