"""Before and after the search: whether the drive has more to teach, and what of it to keep.

The cost sees some parameters well and others hardly; left to the genetic algorithm the latter end
anywhere, or where they fit what only the training run shows. So a least-squares fit, which knows
the start with its standard errors and slow motions, follows the search, and the drive decides
whether it is kept. The same fit decides beforehand whether a search is useful.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from stickslip.identification.stages.estimate import Estimate
from stickslip.tuning.guard import WORSE, guard_motion, relative_errors
from stickslip.tuning.learning import Study
from stickslip.tuning.linear_fit import REPEATS, Bench, Fit, Runs, fit

SEARCH_BELOW = 0.5
"""Share of its cost below which the start must come, in a fit, for a search to be useful."""
ROUNDS = 2
COUNTS = ("none", "one", "two", "three", "four", "five", "six", "seven", "eight")
MARGIN = WORSE - 1.0
"""By how much a fit may cost more than the start: the scatter of repeated runs."""

Chosen = Literal["refined", "winner", "start"]


@dataclass(frozen=True)
class Refinement:
    """What is known in the end.

    Attributes
    ----------
    estimates : the tuned parameters with standard errors, in SI units
    alone : relative standard error that the training runs alone would leave, by name
    cost : of a typical training run on the drive [m^2/s^2]
    chosen : the fit's parameters, the winner of the search, or what the search began with
    runs : further runs of the drive that it took
    skipped : why nothing was searched, as a sentence, or empty
    remark : how the result does in slow motions, as a sentence, where one was searched for
    """

    estimates: dict[str, Estimate]
    alone: dict[str, float]
    cost: float
    chosen: Chosen
    runs: int
    skipped: str = ""
    remark: str = ""

    @property
    def result(self) -> str:
        """What the final parameters are, in words."""
        return {
            "refined": "after refinement",
            "winner": "best candidate, typical run",
            "start": "as learning began, typical run",
        }[self.chosen]

    @property
    def values(self) -> dict[str, float]:
        """The parameters by name, in SI units."""
        return {name: estimate.value for name, estimate in self.estimates.items()}

    @property
    def accepted(self) -> bool:
        """Whether the fit's parameters are the result."""
        return self.chosen == "refined"


def without_search(study: Study) -> Refinement | None:
    """Return the start as the result, where the drive shows that a search cannot improve it much.

    Repeated runs with the start say how the gap v - v_r would change with the parameters. Where no
    parameters would halve the cost, what is left is noise, or is not in the compensator's model:
    a search would fit it to one command.
    """
    bench = Bench(study)
    runs = bench.run(_start(study))
    best = fit(study, runs, prior=False)
    if best.cost < SEARCH_BELOW * runs.cost:
        return None
    reason = (
        f"with the parameters it would begin at, {2 * REPEATS} runs of the training command and "
        f"its mirror image cost {runs.cost:.3g} m2/s2 in the mean, and no parameters would bring "
        f"that below {best.cost:.3g} m2/s2 ({100.0 * best.cost / runs.cost:.0f} %), as a "
        f"least-squares fit of the {COUNTS[len(best.values)]} to these runs shows; a search is "
        f"made for less than {100.0 * SEARCH_BELOW:.0f} %"
    )
    return _refinement(study, runs, best, "start", bench, skipped=reason)


def refine(
    study: Study, winner: Mapping[str, float] | None = None, *, fitted: bool = True
) -> Refinement:
    """Fit the parameters to repeated runs and to the start, beginning at it and at ``winner``.

    The runs are of the training command, its mirror image and the slow motions of ``guard.py``. The
    drive has the last word: a fit is not taken that costs more than the start, or is worse than it
    in a slow motion. With ``fitted`` False the winner is kept, as the paper does, and compared.
    """
    motion = guard_motion(study.start)
    slow = motion.command.sample(study.rig.samples(motion.duration))
    bench = Bench(study, slow)
    start = bench.run(_start(study))
    won = start if winner is None else bench.run(winner)

    def worst(runs: Runs) -> tuple[float, str]:
        """Return the largest ratio of an error in the slow motions to the start's, and of what."""
        now, then = (
            relative_errors(motion, slow, one.gaps[2], study.rig.T_s) for one in (runs, start)
        )
        return max((now[name] / then[name], name) for name in now)

    if not fitted:
        ratio, what = worst(won)
        remark = (
            "the best candidate is kept, as in the paper; in slow motions it leaves up to "
            f"{ratio:.3g} times the error of what learning began with ({what})"
        )
        return _refinement(study, won, fit(study, won), "winner", bench, remark=remark)
    begins = [start] if winner is None else [won, start]
    fits = sorted((_refined(study, bench, runs) for runs in begins), key=lambda r: r.cost)
    for runs in fits:
        ratio, what = worst(runs)
        if runs.cost <= (1.0 + MARGIN) * start.cost and ratio <= WORSE:
            remark = (
                f"in slow motions the fit leaves at most {ratio:.3g} times the error of what "
                f"learning began with ({what})"
            )
            return _refinement(study, runs, fit(study, runs), "refined", bench, remark=remark)
    ratio, what = worst(fits[0])
    remark = (
        f"the fit costs {fits[0].cost / start.cost:.3g} times as much as what learning began with "
        f"and leaves up to {ratio:.3g} times its error in slow motions ({what}); expected at most "
        f"{1.0 + MARGIN:g} times each"
    )
    return _refinement(study, start, fit(study, start), "start", bench, remark=remark)


def _refined(study: Study, bench: Bench, runs: Runs) -> Runs:
    for _ in range(ROUNDS):
        runs = bench.run(fit(study, runs).values)
    return runs


def _refinement(
    study: Study,
    runs: Runs,
    final: Fit,
    chosen: Chosen,
    bench: Bench,
    *,
    skipped: str = "",
    remark: str = "",
) -> Refinement:
    if chosen == "start":
        estimates = dict(study.start)
    else:
        errors = final.errors if chosen == "refined" else final.alone
        estimates = {n: Estimate(runs.values[n], runs.values[n] * errors[n]) for n in study.start}
    cost, count = runs.training_cost, bench.runs
    return Refinement(estimates, final.alone, cost, chosen, count, skipped, remark)


def _start(study: Study) -> dict[str, float]:
    return {name: one.value for name, one in study.start.items()}
