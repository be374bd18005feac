"""The tracking errors without and with a compensator, as a table for the terminal."""

from __future__ import annotations

from itertools import groupby
from typing import TextIO

from stickslip.evaluation.guards import Worth


def print_worth(worth: Worth, file: TextIO | None = None) -> None:
    """Print a row for each speed and a column for each drive."""
    share = "" if worth.share == 1.0 else f" at {worth.share:g} of its force"
    print(
        f"\nRMS tracking error of simulated drives [{worth.unit}], "
        f"without -> with the compensator{share}:",
        file=file,
    )
    drives = list(dict.fromkeys(row.drive for row in worth.rows))
    print(f"{'speed':10}" + "".join(f"{drive:>22}" for drive in drives), file=file)
    for speed, rows in groupby(worth.rows, key=lambda row: row.speed):
        cells = (f"{1e3 * row.without:.3g} -> {1e3 * row.compensated:.3g}" for row in rows)
        print(f"{1e3 * speed:<10.3g}" + "".join(f"{cell:>22}" for cell in cells), file=file)
