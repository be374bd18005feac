"""Slow motions, on which a result must not be worse than what learning began with.

The training command is fast: its cost (6) hardly shows F_s and v_s, by which friction rises towards
rest. This motion breaks away, reverses, creeps and moves by presliding deflections. Its speeds are
in v_s, so that they are slow on any drive.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial

import numpy as np

from stickslip.catalog.estimate import Estimate
from stickslip.catalog.parameters import PAPER
from stickslip.evaluation.motions import Motion, Stroke, strokes
from stickslip.evaluation.validation import covered
from stickslip.servo.measurement import Array

FAST, UPTO = 20.0, 0.2
"""Speed that starts and reversals reach, in v_s, and the time in which they do [s]."""
CREEP, CREEPING, RAMP = (0.1, 0.3, 1.0, 3.0), 1.2, 5e-3
"""Speeds of creep in v_s, for how long it lasts and how soon it is reached [s]: below about v_s a
contact sticks and slips."""
REVERSALS, QUARTER = (1.0, 4.0), 0.25
"""Peaks of slow reversals in v_s, and the time between zero and peak [s]."""
MOVES, HALF, REST = (0.36, 1.4, 3.6), 0.025, 0.1
"""Peaks of short moves in v_s, how soon they are reached, and the rest after each [s]: on the
paper's drive 5, 20 and 50 um, where the contact breaks away after 23 um."""

FIGURES: Mapping[str, Callable[[Array], Array]] = {
    "velocity": np.asarray,
    "position": partial(np.cumsum, axis=-1),
}
"""What errors are of, as computed from velocities (..., n)."""


def guard_motion(start: Mapping[str, Estimate]) -> Motion:
    """Return the motion for a drive with these parameters; a law without v_s takes the paper's."""
    v_s = start["v_s"].value if "v_s" in start else PAPER["v_s"]
    fast = Stroke(FAST, UPTO, 0.0, 0.0, counted=0.5 * UPTO)
    kinds = [
        ("start", (1,), fast),
        ("reversals", (-1, 1, -1), fast),
        *(("creep", (1, -1), Stroke(k, RAMP, CREEPING, REST, counted=CREEPING)) for k in CREEP),
        *(
            ("slow reversals", (1, -1) * 2, Stroke(k, QUARTER, 0.0, 0.0, counted=QUARTER))
            for k in REVERSALS
        ),
        *(
            ("moves", (1, -1) * 2, Stroke(k, HALF, 0.0, REST, counted=2 * HALF + REST))
            for k in MOVES
        ),
    ]
    moves = [
        (f"{kind}, {1e3 * one.speed * v_s:.2g} mm/s", replace(one, speed=sign * one.speed * v_s))
        for kind, signs, one in kinds
        for sign in signs
    ]
    return strokes("guard", "What the training command does not show.", moves)


def relative_errors(motion: Motion, v_cmd: Array, gaps: Array, T_s: float) -> dict[str, float]:
    """Return the RMS errors of velocity and position in each kind of motion and at each speed.

    Each is relative to the command, so that slow and fast strokes of a kind count alike. At a
    speed it is the geometric mean of both, as one of them alone can be that of the encoder.

    Parameters
    ----------
    v_cmd : (n,) command [m/s]
    gaps : (runs, n) v - v_r [m/s]
    """
    t = np.asarray(np.arange(len(v_cmd)) * T_s)
    shares: dict[str, list[float]] = {}
    for region, spans in motion.regions.items():
        inside = [covered(t, [span]) for span in spans]
        both = 1.0
        for figure, of in FIGURES.items():
            error, size = (
                np.mean([np.mean(of(signal[..., part]) ** 2) for part in inside])
                for signal in (gaps, v_cmd)
            )
            kind = f"{figure} in {region.split(',')[0]}"
            shares.setdefault(kind, []).append(float(error / size))
            both *= error / size
        shares[f"velocity and position in {region}"] = [math.sqrt(both)]
    return {kind: math.sqrt(sum(of) / len(of)) for kind, of in shares.items()}
