"""A learned drive against another log, on a terminal."""

from __future__ import annotations

from collections.abc import Mapping

from stickslip.logs import Motion
from stickslip.studies.validate import tables
from stickslip.studies.validate.compared_logs import LogComparison, sentences
from stickslip.studies.validate.log_prediction import LogPrediction
from stickslip.studies.validate.log_verdict import verdict


def print_prediction(found: LogPrediction, values: Mapping[str, float]) -> None:
    """Print the verdict on another log of a learned drive, and its errors."""
    first, *reasons = verdict(found, values)
    print(f"\nverdict: {first}")
    print(*(f"  {reason}" for reason in reasons), sep="\n")
    print("\nrecorded less predicted, RMS in SI units", tables.signals(found).text(), sep="\n")


def print_comparison(found: LogComparison, motion: Motion) -> None:
    """Print tracking errors without and with the compensator, measured and simulated."""
    print(*sentences(found), sep="\n")
    n = int(found.part.max()) + 1
    print(
        f"\ntracking errors, intervals from {n} parts",
        tables.tracking(found, motion).text(),
        sep="\n",
    )
