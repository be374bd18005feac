"""How far the tables of a reproduction may differ between processors.

Another processor, another number of threads or another kernel of the linear algebra changes what is
identified in the last digits, and with it what is fitted and how the encoder's steps fall in a run.
Evidence: docs/decisions/0130-medians-over-encoder-phases.md.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import pandas as pd

from stickslip.catalog.parameters import HIGH, LOW

OF_RANGE, ENDS_OF_RANGE = 0.5, 1.0
"""Of a median, and of the ends of its range, which scatter more: share of the wider range of both
tables. Besides the steps below 0.23 and 0.47 were seen, of what one recording gives.
"""
STEPS: Mapping[str, float] = {"mm/s": 0.01, "um": 0.2, "1": 0.01}
"""Besides, by unit, where all phases agree by chance: half an encoder step of the position; the
velocity of an eighth of a step in 5 ms, as long as the low-pass takes; a point of a reduction."""


@dataclass(frozen=True)
class Tolerance:
    """How far a table may differ."""

    relative: float = 1e-6  # of figures without a range
    unit: str = ""  # of the medians, where no column ``unit`` tells it
    of_range: float = OF_RANGE  # of the medians, as a share of the range
    by: tuple[str, ...] = ()  # columns of which each combination is one row, over seeds


TABLES = {
    "table2": Tolerance(0.01),  # identified 1e-9; fitted to runs, v_s 0.6 % from a coarse start
    "table4": Tolerance(unit="mm/s"),
    "motions": Tolerance(),
    # A search goes another way where one candidate does: with b x (1 +- 1e-9) the medians of two
    # seeds of 150 candidates moved by 0.68 of the range over seeds, of five by 0.56; other stages
    # by nothing.
    "loop_tuning": Tolerance(of_range=1.0, by=("stage", "motion", "friction", "unit")),
}
"""By name of the table."""


def differences(name: str, one: pd.DataFrame, other: pd.DataFrame) -> list[str]:
    """Return where a table of two reproductions differs by more than processors explain.

    Columns with a range are medians. Remarks, and columns that only one of both has, are left out.
    """
    allowed, found = TABLES[name], list[str]()
    if allowed.by:
        one, other = (_over_seeds(table, allowed.by) for table in (one, other))
    if len(one) != len(other):
        return [f"{len(one)} rows instead of {len(other)}"]
    for column in map(str, one):
        if column not in other or column == "remark" or column.endswith((LOW, HIGH)):
            continue
        limits: dict[str, pd.Series[float] | None]
        if not pd.api.types.is_numeric_dtype(other[column]):
            limits = {column: None}
        elif f"{column}{LOW}" in other:
            width = _width(one, column).combine(_width(other, column), max)
            unit = one["unit"] if "unit" in one else pd.Series(allowed.unit, index=one.index)
            step = unit.map(lambda name: STEPS.get(name, 0.0))
            limits = {column: allowed.of_range * width + step}
            limits |= {f"{column}{end}": ENDS_OF_RANGE * width + step for end in (LOW, HIGH)}
        else:
            limits = {column: allowed.relative * other[column].abs()}
        for part, limit in limits.items():
            first, second = one[part], other[part]
            far = first != second if limit is None else (first - second).abs() > limit
            far = (far | first.isna() | second.isna()) & ~(first.isna() & second.isna())
            found += [f"{part}, row {k}: {first[k]} instead of {second[k]}" for k in far.index[far]]
    return found


def _over_seeds(table: pd.DataFrame, by: Sequence[str]) -> pd.DataFrame:
    """Return the median error over seeds, with the range over seeds and phases."""
    rows = table.groupby([*by], as_index=False, sort=False)
    ends = {f"error{LOW}": (f"error{LOW}", "min"), f"error{HIGH}": (f"error{HIGH}", "max")}
    return rows.agg(error=("error", "median"), **ends)


def _width(table: pd.DataFrame, column: str) -> pd.Series[float]:
    return table[f"{column}{HIGH}"] - table[f"{column}{LOW}"]
