"""Scatter: the figures of a run depend on where within an encoder step the drive begins.

One run is one draw: how the encoder's steps fall changes the largest errors by some ten percent,
and a change of a parameter by 1e-10, as another processor makes, draws again. Published figures
are therefore medians over ``PHASES``, with their range. Noise is drawn anew with each phase.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Mapping, Sequence
from typing import TypeVar, cast

import pandas as pd

from stickslip import cosim
from stickslip.catalog.estimate import HIGH, LOW

Key = TypeVar("Key", bound=Hashable)

ONCE = (0.0,)  # the drive begins where its FMU does
PHASES = tuple(sorted((k / 9.0 for k in range(-4, 5)), key=abs))
"""Where the drive begins, in steps of the encoder from where its FMU does; at each of them the
encoder shows the same position at first."""


def beginnings(system: cosim.System, phases: Sequence[float]) -> list[dict[str, float]]:
    """Return for each phase the values with which the drive of a system begins a run."""
    variables = system.components["drive"].variables
    x, step = (cast(float, variables[name].start) for name in ("x", "encoder_step"))
    seed, seeds = cast(int, variables["seed"].start), 1 + int(variables["seed"].maximum or 0)
    return [
        {"drive.x": x + phase * step, "drive.seed": (seed + k) % seeds}
        for k, phase in enumerate(phases)
    ]


def repetitions(found: Iterable[Mapping[Key, float]], names: Sequence[str]) -> pd.DataFrame:
    """Tabulate figures by keys (an index with these names), with a column for each repetition."""
    columns = {k: pd.Series(one) for k, one in enumerate(found)}
    return pd.DataFrame(columns).rename_axis(index=names)


def summary(repeated: Mapping[str, pd.DataFrame]) -> pd.DataFrame:
    """Return the median of figures that were found repeatedly, and behind all medians the ranges.

    Where one of the repetitions is NaN, as the drive ran away, so is what is returned.

    Parameters
    ----------
    repeated : by the name of a column, the figures with a column for each repetition; of a single
        one there is no range
    """
    found = {name: table.median(axis=1, skipna=False) for name, table in repeated.items()}
    for name, table in repeated.items():
        if table.shape[1] > 1:
            found[f"{name}{LOW}"] = table.min(axis=1, skipna=False)
            found[f"{name}{HIGH}"] = table.max(axis=1, skipna=False)
    return pd.DataFrame(found)


def ranges_last(table: pd.DataFrame) -> pd.DataFrame:
    """Return a table with the columns of ranges behind all others."""
    return table[sorted(table, key=lambda name: str(name).endswith((LOW, HIGH)))]
