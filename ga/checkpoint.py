"""Checkpoints: a run as plain data, and back.

Floats survive JSON exactly. Infinity has no place in JSON, so a cost of inf is written as null.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from ga.errors import StateError
from ga.gene import Gene
from ga.generation import Generation
from ga.record import Evaluation, Record, Summary
from ga.settings import Settings

FORMAT = 1


def pack(
    genes: Sequence[Gene],
    settings: Settings,
    rng: Mapping[str, Any],
    current: Generation | None,
    record: Record,
) -> dict[str, Any]:
    """Plain data (dicts, lists, str, int, float, None) from a run's parts."""
    return {
        "format": FORMAT,
        "problem": _problem(genes, settings),
        "rng": dict(rng),
        "current": current
        and {
            "strings": current.strings.tolist(),
            "values": current.values.tolist(),
            "costs": [_finite(cost) for cost in current.costs.tolist()],
        },
        "evaluations": [
            [e.generation, e.index, list(e.values), _finite(e.cost), e.reason]
            for e in record.evaluations
        ],
        "summaries": [
            [s.generation, s.evaluations, _finite(s.best_cost), _finite(s.mean_cost)]
            for s in record.summaries
        ],
    }


def unpack(
    genes: Sequence[Gene], settings: Settings, state: Mapping[str, Any]
) -> tuple[Generation | None, Record, dict[str, Any]]:
    """Return the current generation, the record and the generator state of a checkpoint.

    Raises
    ------
    StateError : the state is of other genes or settings, or is no state
    """
    if not isinstance(state, Mapping) or state.get("format") != FORMAT:
        raise StateError(
            f"this is no checkpoint of format {FORMAT}; it is damaged or from another version"
        )
    asked, stored = _problem(genes, settings), state.get("problem", {})
    for part in asked:
        if asked[part] != stored.get(part):
            raise StateError(
                f"the checkpoint was made with other {part}: it has {stored.get(part)}, "
                f"expected {asked[part]}; resume with those or start afresh"
            )
    try:
        return _current(state), _record(state), dict(state["rng"])
    except (KeyError, TypeError, ValueError) as error:
        raise StateError(f"the checkpoint is damaged ({error!r}); start afresh") from error


def _current(state: Mapping[str, Any]) -> Generation | None:
    stored = state["current"]
    return stored and Generation(
        np.array(stored["strings"], dtype=float),
        np.array(stored["values"], dtype=float),
        np.array([_cost(cost) for cost in stored["costs"]]),
    )


def _record(state: Mapping[str, Any]) -> Record:
    return Record(
        [
            Evaluation(generation, index, tuple(values), _cost(cost), reason)
            for generation, index, values, cost, reason in state["evaluations"]
        ],
        [
            Summary(generation, count, _cost(best), _cost(mean))
            for generation, count, best, mean in state["summaries"]
        ],
    )


def _problem(genes: Sequence[Gene], settings: Settings) -> dict[str, Any]:
    kept = asdict(settings)
    del kept["generations"], kept["threshold"]  # a run may go on for longer than first planned
    return {"genes": [asdict(gene) for gene in genes], "settings": kept}


def _finite(cost: float) -> float | None:
    return None if cost == float("inf") else cost


def _cost(stored: float | None) -> float:
    return float("inf") if stored is None else stored
