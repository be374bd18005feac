"""What a run has seen, and checkpoints: a run as plain data, and back.

A checkpoint holds what was told, not what an optimiser keeps inside: any optimiser that is asked
and told the same again is where it was. Floats survive JSON exactly; a cost of inf is written as
null. What is not a checkpoint, or is of another run, raises `StateError`.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, is_dataclass
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from stickslip.fmi.files import atomic_write, parse_json, read_limited
from stickslip.ga.errors import StateError
from stickslip.ga.problem.problem import Array, Problem

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


FORMAT = 2
MOST = 1 << 30  # bytes that a checkpoint may have
Told = tuple[Array, list[float], list[str]]  # values (n, k), n costs and n reasons of a generation


def head(kind: str, problem: Problem, settings: Mapping[str, Any], seed: int) -> dict[str, Any]:
    """Return what a run must have in common with its checkpoint."""
    repair = problem.repair
    return {
        "format": FORMAT,
        "optimiser": kind,
        "genes": [asdict(gene) for gene in problem.genes],
        "repair": repr(repair) if is_dataclass(repair) else getattr(repair, "__qualname__", None),
        "settings": dict(settings),
        "seed": seed,
    }


def pack(head: Mapping[str, Any], record: Record) -> dict[str, Any]:
    """Return plain data (dicts, lists, str, int, float, None) from a run's parts."""
    told = ((e, None if e.cost == float("inf") else e.cost) for e in record.evaluations)
    return {**head, "evaluations": [[e.generation, list(e.values), c, e.reason] for e, c in told]}


def unpack(head: Mapping[str, Any], state: Mapping[str, Any]) -> Iterator[Told]:
    """Yield what was told, generation after generation."""
    if not isinstance(state, Mapping) or state.get("format") != FORMAT:
        advice = "it is damaged or from another version"
        raise StateError(f"this is no checkpoint of format {FORMAT}; {advice}")
    for part, expected in head.items():
        if expected != state.get(part):
            raise StateError(
                f"the checkpoint was made with other {part}: it has {state.get(part)!s:.200}, "
                f"expected {expected}; resume with those or start afresh"
            )
    try:
        generations = []
        for _, group in groupby(state["evaluations"], lambda row: row[0]):
            rows = list(group)
            values = np.array([values for _, values, _, _ in rows], dtype=float)
            costs = [_cost(cost) for _, _, cost, _ in rows]
            generations.append((values, costs, [str(reason) for _, _, _, reason in rows]))
    except (KeyError, TypeError, ValueError, IndexError) as error:
        raise StateError(f"the checkpoint is damaged ({error!r}); start afresh") from error
    yield from generations


def write(path: Path, state: Mapping[str, Any], about: str) -> None:
    """Write a checkpoint atomically."""
    atomic_write(path, json.dumps({"about": about, **state}, allow_nan=False) + "\n")


def read(path: Path, about: str) -> dict[str, Any]:
    """Read the state from a checkpoint."""
    try:
        state = parse_json(read_limited(path, MOST))
    except ValueError as error:
        raise StateError(f"{path}: this is no checkpoint ({error}); start afresh") from None
    if not isinstance(state, dict):
        raise StateError(f"{path}: this is no checkpoint, it holds no object; start afresh")
    if state.get("about", about) != about:
        what = f"expected {about!r}; resume with that or start afresh"
        raise StateError(f"{path}: the checkpoint is about {state['about']!r:.80}, {what}")
    return state


def _cost(stored: float | None) -> float:
    if stored is None:
        return float("inf")
    if not (isinstance(stored, int | float) and stored >= 0):
        raise ValueError(f"a cost of {stored!r}")
    return float(stored)
