"""The search of a loop, on a drive, on models of it or on the drives that a log supports.

A candidate has a ratio for each motion and level of friction: an error or a force over that of a
reference. The largest ratios count most. The search ends with the choice among its best candidates
and the reference, measured with more care than in the search.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from stickslip import ga
from stickslip.ga.execution.evaluation import Evaluate
from stickslip.output import shown_by
from stickslip.thresholds import kept

POWER = 8
"""Exponent of the mean over the ratios: with 8, one that is a quarter smaller than the largest
counts a tenth as much as it."""
NEAR, STEEP = 0.9, 3.0
"""From where on a ratio costs more, and how much. Without it, searches on drives of Armstrong and
Coulomb-Stribeck friction ended where nothing could be taken."""
FINALISTS = 4  # best candidates that are measured with more care

Ratios = dict[Any, float]  # by kind of motion, or a force, and what else tells them apart


@dataclass(frozen=True)
class Finalist:
    """A candidate that was measured with more care."""

    name: str  # what it is
    genes: Mapping[str, float]
    ratios: Ratios  # to the reference
    cost: float


def mean_of(ratios: Ratios) -> float:
    """Return the mean of ratios with the power ``POWER``, and what those near 1 cost more."""
    values = np.array(list(ratios.values()))
    near = np.maximum(values - NEAR, 0.0).sum()
    return float(np.mean(values**POWER) ** (1.0 / POWER) + STEEP * near)


def search(
    algorithm: ga.Optimiser,
    cost: Evaluate,
    workers: int,  # candidates side by side
    on_generation: Callable[[ga.Optimiser], object] | None = None,
) -> None:
    """Search, and show no steps of candidates; raise ga.NothingLearned, ga.Interrupted."""
    one_thread = threadpool_limits(limits=1, user_api="blas")  # matrices are small, workers many
    with one_thread, shown_by(lambda *_: None), ga.executor("threads", workers) as executor:
        ga.learn(algorithm, cost, executor, on_generation)


def best_of(algorithm: ga.Optimiser) -> list[dict[str, float]]:
    """Return the genes of the best ``FINALISTS`` candidates of a search, none twice."""
    names = algorithm.names
    best = algorithm.history.drop_duplicates(names).nsmallest(FINALISTS, "cost")
    return [dict(zip(names, row, strict=True)) for row in best[names].to_numpy()]


def choose(finalists: Sequence[Finalist]) -> Finalist:
    """Return the cheapest that is better and in no ratio worse, or the last, the reference."""
    found = [(one, [*one.ratios.values()]) for one in finalists[:-1]]
    better = [(one, each) for one, each in found if np.mean(each) <= kept.LOOP_BETTER]
    good = [one for one, each in better if max(each) <= kept.LOOP_WORSE]
    return min([*good, finalists[-1]], key=lambda one: one.cost)
