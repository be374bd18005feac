"""Evaluations and seconds to a given cost, from the same starts, on the paper's closed loop."""

from __future__ import annotations

import contextlib
import time
import warnings
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from benchmarks.learning import figures
from benchmarks.learning.problem import cost
from benchmarks.learning.racers import Judge, Racer, Spent, racers

PAPER = "ours, paper's preset"
AT = (50, 100, 200, 400, 700, 1000)


class Clock:
    """Counts a racer's evaluations and takes the time of each that is better than all before."""

    def __init__(self, judge: Judge, budget: int) -> None:
        self._judge, self._budget = judge, budget
        self.evaluations, self.best = 0, np.inf
        self.rows: list[tuple[int, float, float]] = []
        self._begin = time.process_time()

    def __call__(self, values: np.ndarray) -> float:
        if self.evaluations == self._budget:
            raise Spent
        self.evaluations += 1
        found = self._judge(values)
        if found < self.best:
            self.best = found
            self.rows.append((self.evaluations, time.process_time() - self._begin, found))
        return found


def run(folder: Path, out: Path, kinds: Sequence[str], seeds: int, budget: int) -> str:
    """Race on these kinds of the problem; write race.csv and a figure, return what is printed."""
    tables = []
    for kind in kinds:
        with cost(folder / kind, kind) as judge:
            for name, racer in racers().items():
                for seed in range(seeds):
                    rows = _one(racer, judge, seed, budget)
                    columns = ["evaluation", "seconds", "cost"]
                    table = pd.DataFrame(rows, columns=columns)
                    tables.append(table.assign(problem=kind, racer=name, seed=seed))
    race = pd.concat(tables, ignore_index=True)
    race.to_csv(out / "race.csv", index=False)
    figures.race(out / "race.png", {k: curves(race[race.problem == k], budget) for k in kinds})
    said = "median of {} seeds; costs in 1e-6 m2/s2, seconds of one processor"
    tables = [
        f"{kind}\n{_summary(race, kind, budget).to_string(float_format='%.4g')}" for kind in kinds
    ]
    return "\n\n".join([said.format(seeds), *tables])


def _one(racer: Racer, judge: Judge, seed: int, budget: int) -> list[tuple[int, float, float]]:
    clock = Clock(judge, budget)
    with warnings.catch_warnings(), contextlib.suppress(Spent):
        warnings.simplefilter("ignore")  # of the others
        racer(clock, seed, budget)
    return clock.rows


def curves(race: pd.DataFrame, budget: int) -> dict[str, np.ndarray]:
    """Return the best cost after each evaluation of each seed, (seeds, budget), by racer."""
    found = {}
    for name, theirs in race.groupby("racer", sort=False):
        costs = np.full((theirs.seed.nunique(), budget + 1), np.inf)
        for row, (_, one) in enumerate(theirs.groupby("seed")):
            costs[row, one.evaluation] = one.cost
        found[str(name)] = np.minimum.accumulate(costs, axis=1)[:, 1:]
    return found


def _summary(race: pd.DataFrame, kind: str, budget: int) -> pd.DataFrame:
    """Return a line for each racer: costs in 1e-6 m2/s2, evaluations and seconds to two goals."""
    found = curves(race[race.problem == kind], budget)
    medians = {name: np.median(costs, axis=0) for name, costs in found.items()}
    table = pd.DataFrame(index=list(found))
    for n in AT:
        if n <= budget:
            table[f"after {n}"] = [median[n - 1] * 1e6 for median in medians.values()]
    goals = {
        "paper's end": medians[PAPER][-1],
        "1.5 x best": 1.5 * min(median[-1] for median in medians.values()),
    }
    for goal, level in goals.items():
        table[f"evaluations to {goal}"] = [_evaluations(costs, level) for costs in found.values()]
        table[f"s to {goal}"] = [
            _seconds(race[(race.problem == kind) & (race.racer == name)], level) for name in found
        ]
    return table


def _evaluations(costs: np.ndarray, level: float) -> float:
    reached = np.where(costs <= level, np.arange(1, costs.shape[1] + 1), np.inf)
    return float(np.median(reached.min(axis=1)))


def _seconds(race: pd.DataFrame, level: float) -> float:
    reached = race[race.cost <= level].groupby("seed").seconds.min()
    return float(reached.reindex(race.seed.unique(), fill_value=np.inf).median())
