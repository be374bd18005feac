"""Least squares on the drive: whether it has more to teach than identification, and what to keep.

The cost sees some parameters well and others hardly. So the fit knows the start with its standard
errors, and slow motions, and the drive decides whether it is kept.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from stickslip.catalog.estimate import Estimate
from stickslip.thresholds import kept
from stickslip.tuning.guard import guard_motion, relative_errors
from stickslip.tuning.learning import Study
from stickslip.tuning.linear_fit import Bench, fit

ROUNDS = 2

Chosen = Literal["refined", "start"]


@dataclass(frozen=True)
class Refinement:
    """What is known in the end."""

    estimates: dict[str, Estimate]  # the tuned parameters with standard errors, in SI units
    # relative standard error that the training runs alone would leave, by name
    alone: dict[str, float]
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
    if runs.cost <= kept.FIT_WORSE * start.cost and ratio <= kept.FIT_WORSE:
        final = fit(study, runs)
        values = runs.values
        estimates = {n: Estimate(x, x * final.errors[n]) for n, x in values.items()}
        remark = (
            f"in slow motions the fit leaves at most {ratio:.3g} times the error of what "
            f"learning began with ({what})"
        )
        return Refinement(
            estimates, final.alone, runs.training_cost, "refined", runs=bench.runs, remark=remark
        )
    remark = (
        f"the fit costs {runs.cost / start.cost:.3g} times as much as what learning began with "
        f"and leaves up to {ratio:.3g} times its error in slow motions ({what}); expected at most "
        f"{kept.FIT_WORSE:g} times each"
    )
    alone = fit(study, start).alone
    return Refinement(
        dict(study.start), alone, start.training_cost, "start", runs=bench.runs, remark=remark
    )
