"""Evaluations and seconds to a given cost, from the same starts, on the paper's closed loop."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from benchmarks.learning.problem import cost, problem
from benchmarks.learning.racers import race_one, racers

PAPER = "ours, paper's preset"
AT = (50, 100, 200, 400, 700, 1000)


def run(folder: Path, out: Path, kinds: Sequence[str], seeds: int, budget: int) -> str:
    """Race on these kinds of the problem; write race.csv, return what is printed."""
    tables = []
    for kind in kinds:
        with cost(folder / kind, kind) as evaluate:
            for name, racer in racers().items():
                for seed in range(seeds):
                    rows = race_one(racer, evaluate, problem(seed), seed, budget).rows
                    columns = ["evaluation", "seconds", "cost"]
                    table = pd.DataFrame(rows, columns=columns)
                    tables.append(table.assign(problem=kind, racer=name, seed=seed))
    race = pd.concat(tables, ignore_index=True)
    race.to_csv(out / "race.csv", index=False)
    said = "median of {} seeds; costs in 1e-6 m2/s2, seconds of one processor"
    shown = {kind: _summary(race, kind, budget) for kind in kinds}
    tables = [f"{kind}\n{one.to_string(float_format='%.4g')}" for kind, one in shown.items()]
    return "\n\n".join([said.format(seeds), *tables])


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
    lowest = min(median[-1] for median in medians.values())
    goals = {"paper's end": medians[PAPER][-1], "1.5 x best": 1.5 * lowest}
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
