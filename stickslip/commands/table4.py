"""Table 4 on a terminal."""

from __future__ import annotations

import pandas as pd


def print_table4(table: pd.DataFrame) -> None:
    """Print what ``Validation.table`` returns."""
    print(
        "velocity errors of the simulated drive in mm/s, beside the real stage's (paper) reduction"
    )
    print("velocity  region   metric  without     with  reduction  real stage (paper)")
    for row in table.to_dict("records"):
        print(
            f"{row['velocity']:9} {row['region']:8} {row['metric']:6}"
            f" {row['without']:8.3f} {row['with']:8.3f}"
            f" {100 * row['reduction']:8.1f} %  {100 * row['paper_reduction']:.0f} %"
        )
