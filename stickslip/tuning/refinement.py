"""Least squares on the drive: whether it has more to teach than identification, and what to keep.

The cost sees some parameters well and others hardly. So the fit knows the start with its standard
errors, and slow motions, and the drive decides whether it is kept.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Literal

import numpy as np

from stickslip.catalog.parameters import PAPER, Estimate
from stickslip.evaluation.motions import Motion, Stroke, strokes
from stickslip.evaluation.validation import covered
from stickslip.servo.measurement import Array
from stickslip.thresholds import kept
from stickslip.tuning.learning import Bench, Study, fit

FAST, UPTO = 20.0, 0.2  # speed that starts and reversals reach [v_s], and their time [s]
CREEP, CREEPING, RAMP = (0.1, 0.3, 1.0, 3.0), 1.2, 5e-3
"""Speeds of creep in v_s, for how long it lasts and how soon it is reached [s]: below about v_s a
contact sticks and slips."""
REVERSALS, QUARTER = (1.0, 4.0), 0.25  # peaks of slow reversals [v_s], and time to a peak [s]
MOVES, HALF, REST = (0.36, 1.4, 3.6), 0.025, 0.1
"""Peaks of short moves in v_s, how soon they are reached, and the rest after each [s]: on the
paper's drive 5, 20 and 50 um, where the contact breaks away after 23 um."""

FIGURES: Mapping[str, Callable[[Array], Array]] = {
    "velocity": np.asarray,
    "position": partial(np.cumsum, axis=-1),
}
"""What errors are of, as computed from velocities (..., n)."""


def guard_motion(start: Mapping[str, Estimate]) -> Motion:
    """Return the motion for a drive with these parameters; a law without v_s takes the paper's.

    The training command is fast: its cost (6) hardly shows F_s and v_s, by which friction rises
    towards rest. This motion breaks away, reverses, creeps and moves by presliding deflections. Its
    speeds are in v_s, so that they are slow on any drive.
    """
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

    Each is relative to the command, so that slow and fast strokes of a kind count alike. At a speed
    it is the geometric mean of both, as one of them alone can be that of the encoder. The command
    v_cmd is (n,) [m/s], and the gaps v - v_r are (runs, n) [m/s].
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


ROUNDS = 2

Chosen = Literal["refined", "start"]


@dataclass(frozen=True)
class Refinement:
    """What is known in the end."""

    estimates: dict[str, Estimate]  # the tuned parameters with standard errors, in SI units
    alone: dict[str, float]  # relative standard errors that training runs alone would leave
    cost: float  # of a typical training run on the drive [m^2/s^2]
    chosen: Chosen  # the fit's parameters, or what it began with
    runs: int  # of the drive that it took
    remark: str = ""  # how the fit does in slow motions, as a sentence

    @property
    def result(self) -> str:
        """What the final parameters are, in words."""
        return {"refined": "after least squares", "start": "as learning began, typical run"}[
            self.chosen
        ]

    @property
    def values(self) -> dict[str, float]:
        """The parameters by name, in SI units."""
        return {name: estimate.value for name, estimate in self.estimates.items()}

    @property
    def accepted(self) -> bool:
        """Whether the fit's parameters are the result."""
        return self.chosen == "refined"


def refine(study: Study) -> Refinement:
    """Fit the parameters to repeated runs and to the start.

    The runs are of the training command, its mirror image and the slow motions of ``guard.py``. The
    drive has the last word: a fit is not taken that costs more than the start, or is worse than it
    in a slow motion.
    """
    motion = guard_motion(study.start)
    slow = motion.command.sample(study.rig.samples(motion.duration))
    bench = Bench(study, slow)
    start = bench.run({name: one.value for name, one in study.start.items()})
    runs = start
    for _ in range(ROUNDS):
        runs = bench.run(fit(study, runs).values)
    now, then = (relative_errors(motion, slow, one.gaps[2], study.rig.T_s) for one in (runs, start))
    ratio, what = max((now[name] / then[name], name) for name in now)
    chosen: Chosen = "refined"
    remark = (
        f"in slow motions the fit leaves at most {ratio:.3g} times the error of what "
        f"learning began with ({what})"
    )
    if not (runs.cost <= kept.FIT_WORSE * start.cost and ratio <= kept.FIT_WORSE):
        remark = (
            f"the fit costs {runs.cost / start.cost:.3g} times as much as what learning began with "
            f"and leaves up to {ratio:.3g} times its error in slow motions ({what}); expected at "
            f"most {kept.FIT_WORSE:g} times each"
        )
        runs, chosen = start, "start"
    final, estimates = fit(study, runs), dict(study.start)
    if chosen == "refined":
        estimates = {n: Estimate(x, x * final.errors[n]) for n, x in runs.values.items()}
    return Refinement(
        estimates, final.alone, runs.training_cost, chosen, runs=bench.runs, remark=remark
    )
