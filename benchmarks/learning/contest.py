"""Standard functions, each racer with the same evaluations, bounds and start: medians."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.stats import mannwhitneyu

from benchmarks.learning.functions import FURTHER, STANDARD, Function, Instance
from benchmarks.learning.racers import Racer, cma, ours, pymoo_ga, race_one, scipy_de
from stickslip import ga

OURS = "ours"

CONTESTANTS: dict[str, Racer] = {
    OURS: ours("default"),
    "cma, 0.1": cma(0.1),
    "cma, 0.3": cma(0.3),
    "DE, 15": scipy_de(15),
    "DE, 2": scipy_de(2),
    "GA, 100": pymoo_ga(100),
    "GA, 20": pymoo_ga(20),
}
"""Populations of DE are given for each gene, as scipy counts them; of cma, the first sigma."""

REACHED = 1e-8
"""What costs less has arrived: it does not lose to another that has."""

DIMENSIONS = (5, 10)
SEVERAL = (2, 5, 10, 20, 30, 50, 100)


def run(out: Path, seeds: int, budget: int, genes: Sequence[int], *, further: bool) -> str:
    """Race on all functions; write functions.csv, return a table of medians and one of seconds.

    The further functions have other seeds than the standard ones, on which the default was chosen.
    Where the median of ours is above the lowest of the others, the last column has the
    probability (Mann and Whitney) that costs so much higher are chance.
    """
    functions, first = (FURTHER, seeds) if further else (STANDARD, 0)
    numbers = range(first, first + seeds)
    costs = pd.concat(
        [_costs(name, functions[name], k, numbers, budget) for name in functions for k in genes],
        ignore_index=True,
    )
    costs.to_csv(out / "functions.csv", index=False)
    table = costs.pivot_table(
        "cost", ["function", "genes"], "racer", aggfunc="median", sort=False
    ).reindex(columns=list(CONTESTANTS))
    table["lost, p"] = [
        _chance(costs[(costs.function == name) & (costs.genes == k)]) for name, k in table.index
    ]
    return (
        f"lowest cost after {budget} evaluations, median of {seeds} seeds\n"
        f"{table.to_string(float_format='%.2g', na_rep='')}\n\n"
        f"seconds of one processor that {budget} evaluations of ours take, the cost's included\n"
        f"{_seconds(budget).to_string(float_format='%.2f')}"
    )


def _costs(name: str, function: Function, k: int, seeds: range, budget: int) -> pd.DataFrame:
    """Return what the best of every racer costs without noise, a row for each seed."""
    rows = []
    for racer, search in CONTESTANTS.items():
        for seed in seeds:
            instance = Instance(function, k, seed)
            found = race_one(search, instance, instance.problem, seed, budget).found
            rows.append((name, k, racer, seed, np.inf if found is None else instance.true(found)))
    return pd.DataFrame(rows, columns=["function", "genes", "racer", "seed", "cost"])


def _chance(costs: pd.DataFrame) -> float | None:
    """Return the probability that ours lost by chance, or None if its median is not higher."""
    medians = costs.groupby("racer").cost.median()
    best = str(medians.drop(OURS).idxmin())
    if medians[OURS] <= max(medians[best], REACHED):
        return None
    mine, theirs = (costs.cost[costs.racer == racer].clip(REACHED) for racer in (OURS, best))
    return float(mannwhitneyu(mine, theirs, alternative="greater").pvalue)


def _seconds(budget: int) -> pd.DataFrame:
    table = pd.DataFrame(index=pd.Index(SEVERAL, name="genes"))
    for name in ("sphere", "Rastrigin"):
        for k in SEVERAL:
            instance = Instance(STANDARD[name], k, 0)
            begin = time.process_time()
            ga.learn(
                ga.optimiser("default", instance.problem, ga.Limits(evaluations=budget)), instance
            )
            table.loc[k, name] = time.process_time() - begin
    return table
