"""Table 4 on a terminal."""

from __future__ import annotations

import pandas as pd


def print_table4(table: pd.DataFrame) -> None:
    """Print what ``Validation.table`` returns."""
    print(
        "velocity errors in mm/s; loop, ramps and windows were calibrated so that the simulated\n"
        "drive of Table 2, measured, comes near the real stage without compensation\n"
        "                         simulated drive              real stage (paper)\n"
        "velocity region  metric  without    with reduction    without    with reduction"
    )
    for row in table.to_dict("records"):
        print(
            f"{row['velocity']:8} {row['region']:7} {row['metric']:6}"
            f" {row['without']:8.3f} {row['with']:7.3f} {100 * row['reduction']:7.1f} %"
            f"   {row['paper_without']:8.2f} {row['paper_with']:7.2f}"
            f" {100 * row['paper_reduction']:7.0f} %"
        )
