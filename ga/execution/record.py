"""What is remembered of a learning run: every evaluation, and a line per generation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from stickslip.ga.arrays import Array

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class Evaluation:
    """One candidate that was evaluated."""

    generation: int  # 1 for the first
    index: int  # row in what ``ask`` returned
    values: tuple[float, ...]  # k of them, in the genes' order and units
    cost: float  # inf if it failed
    reason: str = ""  # why it failed


@dataclass(frozen=True)
class Summary:
    """One generation; ``mean_cost`` is over its finite costs, the elite included, or inf."""

    generation: int  # 1 for the first
    evaluations: int  # so far
    best_cost: float  # so far
    mean_cost: float


@dataclass
class Record:
    """Everything that a run has seen, in order."""

    evaluations: list[Evaluation] = field(default_factory=list)
    summaries: list[Summary] = field(default_factory=list)

    def add(self, values: Array, costs: Array, reasons: Sequence[str]) -> None:
        """Note a generation's evaluations: values (n, k), costs (n,) and n reasons."""
        generation = len(self.summaries) + 1
        for index, reason in enumerate(reasons):
            row, cost = tuple(values[index].tolist()), float(costs[index])
            self.evaluations.append(Evaluation(generation, index, row, cost, reason))

    def close_generation(self, costs: Array, best: float) -> None:
        """Note the costs of the generation, elite included, shape (n,), and the run's best."""
        finite = costs[np.isfinite(costs)]
        mean = float(finite.mean()) if finite.size else float("inf")
        generation = len(self.summaries) + 1
        summary = Summary(generation, len(self.evaluations), best, mean)
        self.summaries.append(summary)

    def history(self, names: Sequence[str]) -> pd.DataFrame:
        """Tabulate every evaluation: generation, index, a column per name, cost, reason."""
        import pandas as pd  # late, for those who start quickly

        rows = [
            (e.generation, e.index, *e.values, e.cost, e.reason)  # noqa: PD011 - a tuple
            for e in self.evaluations
        ]
        return pd.DataFrame(rows, columns=["generation", "index", *names, "cost", "reason"])

    def convergence(self) -> pd.DataFrame:
        """Tabulate every generation: generation, evaluations, best_cost, mean_cost."""
        import pandas as pd  # late, for those who start quickly

        columns = ["generation", "evaluations", "best_cost", "mean_cost"]
        return pd.DataFrame(self.summaries, columns=columns)
