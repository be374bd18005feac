"""The errors at a glance: the real stage, the calibrated drive, the drive with all extras on."""

from __future__ import annotations

from collections.abc import Callable

import pandas as pd

from stickslip.pipeline.reproduction import Reproduction
from stickslip.report.markup import (
    Html,
    element,
    join,
    paragraph,
    table,
)
from stickslip.report.quantity import percent
from stickslip.report.shown import METRICS

REAL = "real stage (paper)"
SIMULATED = "simulated drive"
CALIBRATED = f"{SIMULATED}, calibrated to this row"
EXTRAS = f"{SIMULATED}, all extras on"


def headline(reproduction: Reproduction) -> Html:
    """Return the errors on the measured velocity, without and with compensation, as rows."""
    own = _measured(reproduction.validation.table())
    extras = reproduction.extras
    validation = extras.validation if extras else None
    rows: list[tuple[str, ...]] = []
    for quantity, said, show in (
        ("without", "Without compensation", _error),
        ("with", "With compensation", _error),
        ("reduction", "Reduction", percent),
    ):
        rows.append((said, REAL, *_cells(own, f"paper_{quantity}", _paper(quantity))))
        # Changed, the drive is no longer the one that was calibrated.
        calibrated = quantity == "without" and not reproduction.options.truth
        drive = CALIBRATED if calibrated else SIMULATED
        rows.append(("", drive, *_cells(own, quantity, show)))
        if validation:
            errors = _measured(validation.table())
            rows.append(("", EXTRAS, *_cells(errors, quantity, show)))
    head = [join([f"{region.capitalize()}, ", METRICS[metric]]) for region, metric in own.index]
    return join(
        [
            table(
                ("", "", *head),
                rows,
                "Velocity errors [mm/s] at motion start and reversal, as the encoder shows them",
                (0, 1),
            ),
            _remark(reproduction),
        ]
    )


def _remark(reproduction: Reproduction) -> Html:
    extras = reproduction.extras
    if extras is None:
        return Html("")
    if extras.validation is None:
        return paragraph(f"With all extras on the drive could not be learned: {extras.reason}.")
    return element(
        "p",
        "“All extras on” is the same drive with every effect of its model: identified, learned and "
        "validated from the beginning, with the same settings.",
        class_="quiet",
    )


def _measured(errors: pd.DataFrame) -> pd.DataFrame:
    return errors[errors["velocity"] == "measured"].set_index(["region", "metric"])


def _cells(errors: pd.DataFrame, column: str, show: Callable[[float], str]) -> list[str]:
    return [show(value) for value in errors[column]]


def _error(value: float) -> str:
    return f"{value:.2f}"


def _paper(quantity: str) -> Callable[[float], str]:
    return (lambda share: percent(share, 0)) if quantity == "reduction" else _error
