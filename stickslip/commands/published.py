"""The paper's learning as published on a terminal."""

from __future__ import annotations

import numpy as np

from stickslip.tuning.published import Published
from stickslip.tuning.published.readings import worse
from stickslip.tuning.published.study import PAPER_COST


def print_published(published: Published) -> None:
    """Print costs and Table 4 over the seeds."""
    start, final = published.start_costs(), published.final_costs()
    print(f"the paper's learning as published, from coarse starts; seeds: {len(final)}")
    print(
        f"cost in m2/s2: {published.cost_without:.3g} without compensation, median "
        f"{np.median(start):.3g} at the start and {np.median(final):.3g} at the end "
        f"(paper: {PAPER_COST:.2g})"
    )
    print("errors in mm/s, median over seeds; worse: seeds that track worse than their start")
    print("velocity region  metric  without   start    with   paper   worse")
    table = published.table4()
    keys = ["velocity", "region", "metric"]
    for (velocity, region, metric), rows in table.groupby(keys, sort=False):
        print(
            f"{velocity:8} {region:7} {metric:6} {rows['without'].iloc[0]:8.3f} "
            f"{rows['start'].median():7.3f} {rows['with'].median():7.3f} "
            f"{rows['paper_with'].iloc[0]:7.2f} {(rows['with'] > rows['start']).sum():7d}"
        )
    measured = table[table["velocity"] == "measured"]
    print(
        f"{100 * worse(measured):.0f} % of the seeds follow the trapezoid worse than from their "
        "start (measured E_rms of both regions), although the training cost fell"
    )
