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
    """Yield what can and cannot be identified, and which experiment shows the rest."""
    unit = "rad" if recording.motion == "rotary" else "m"
    low, high = shown.speeds
    figure = f"{shown.moving:.1%} of the time, 90 % of it at {low:.2g} to {high:.2g} {unit}/s"
    advice = "move faster or longer; only presliding may be identifiable"
    fine = shown.moving >= 2 * LITTLE
    yield Finding.either(fine, "the drive moves", "the drive hardly moves", figure, advice)
    if shown.spacing < 20:
        figure = f"{shown.spacing:.0f} samples between two"
        what = "reversals are too fast for the sample rate"
        yield Finding("warning", what, figure, "sample faster or move slower")
    if shown.reversals < 2:
        figure = f"{shown.reversals} reversals"
        yield Finding("warning", "F_c and the offset are hard to separate", figure, f"{PLAN} F_c")
    if np.isfinite(shown.inertial):
        share = f"{shown.inertial:.1%} of the force"
        figure = f"accelerations up to {shown.acceleration:.3g} {unit}/s^2 cause {share}"
        words = "m is identifiable", "m is poorly identifiable"
        yield Finding.either(shown.inertial >= LITTLE, *words, figure, f"{PLAN} m")
    if high < 3 * low:
        figure = f"only speeds of {low:.2g} to {high:.2g} {unit}/s"
        yield Finding("warning", "b and F_c are hard to separate", figure, f"{PLAN} b F_c")
    share = f"{shown.slow:.1%} of the motion, {shown.slow_samples} samples"
    figure = f"{share} below {shown.slow_speed:.2g} {unit}/s"
    words = "F_s and v_s may be identifiable", "F_s and v_s are poorly identifiable"
    yield Finding.either(shown.slow >= LITTLE, *words, figure, f"{PLAN} F_s v_s")
    turn, advice = shown.turn_around, f"{PLAN} sigma_0 sigma_1"
    if turn is None:
        what = "sigma_0 and sigma_1 are not identifiable"
        yield Finding("warning", what, "no velocity reversal was found", advice)
        return
    counts = f", {turn.counts:.0f} encoder steps" if np.isfinite(turn.counts) else ""
    figure = (
        f"{turn.times} velocity reversals; friction reverses within {turn.distance:.2g} {unit}"
        f"{counts} and {turn.samples:.0f} samples"
    )
    fine = turn.times * turn.samples >= 100 and turn.counts >= 3 and turn.samples >= 3
    words = "sigma_0 and sigma_1 may be identifiable", "sigma_0 and sigma_1 are poorly identifiable"
    yield Finding.either(fine, *words, figure, advice)
