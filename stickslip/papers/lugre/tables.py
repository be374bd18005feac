"""Table 2 with what was found; here the truth of the drive enters."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pandas as pd

from stickslip.catalog.parameters import PAPER, tabulated, unit_of
from stickslip.identification.estimation import Estimation
from stickslip.identification.stages import Estimate, Identification
from stickslip.tuning.refinement import Refinement


def table2(
    identification: Identification,
    start: Mapping[str, Estimate],
    learned: Refinement,
    truth: Mapping[str, float],
) -> pd.DataFrame:
    """Return Table 2 with what was found, in SI units.

    Columns parameter, unit, paper, drive (the proxy's truth), identified, learned, spread (standard
    error of the learned value), identified_spread, remark, start (where learning began). m and b
    are not learned.
    """
    rows = []
    for name, before in identification.estimates.items():
        after = learned.estimates.get(name)
        rows.append(
            {
                **_head(name, truth),
                "identified": before.value,
                "learned": after.value if after else None,
                "spread": after.standard_error if after else None,
                "identified_spread": before.standard_error,
                "remark": _remark(name, identification, start, learned, truth[name]),
                "start": start[name].value if name in start else None,
            }
        )
    return pd.DataFrame(rows)


def table2_of_recording(estimation: Estimation, truth: Mapping[str, float]) -> pd.DataFrame:
    """Return Table 2 with what one recording gave, in SI units.

    ``identified`` is what a straight line through the recorded force gives, which shows
    nothing of friction but F_c. ``spread`` is the standard error of what was learned.
    """
    line = estimation.start.line
    rows = []
    for name in tabulated(estimation.law):
        known = estimation.known[name]
        rows.append(
            {
                **_head(name, truth),
                "identified": line[name] if name in ("m", "b", "F_c") else None,
                "learned": known.value,
                "spread": known.standard_error,
                "low": known.low,
                "high": known.high,
                "remark": known.sentence,
            }
        )
    return pd.DataFrame(rows)


def _head(name: str, truth: Mapping[str, float]) -> dict[str, Any]:
    known = {"paper": PAPER.get(name), "drive": truth[name]}
    return {"parameter": name, "unit": unit_of(name), **known}


def _remark(
    name: str,
    identification: Identification,
    start: Mapping[str, Estimate],
    learned: Refinement,
    truth: float,
) -> str:
    """Say how well a parameter is known, and whether learning took it away from the truth."""
    if name not in start:
        return "identified only, not learned"
    before, after = identification.estimates[name], learned.estimates[name]
    prior = start[name].standard_error / start[name].value
    if learned.chosen == "start":
        remark = "as learning began: the training run alone would know it to "
        remark += f"+-{100 * learned.alone[name]:.2g} %"
    elif learned.alone[name] < prior:
        remark = "identifiable from the training run"
    elif learned.accepted:
        remark = (
            f"weakly identifiable from the training run "
            f"(alone +-{100 * learned.alone[name]:.2g} %): identification decides"
        )
    else:
        remark = (
            f"weakly identifiable from the training run (+-{100 * learned.alone[name]:.2g} %): "
            "less certain than identified"
        )
    error_before, error_after = (abs(value / truth - 1.0) for value in (before.value, after.value))
    if error_after > error_before:
        remark += (
            f"; farther from the drive's value than identified "
            f"({100 * error_after:.2g} % after {100 * error_before:.2g} %)"
        )
    return remark
