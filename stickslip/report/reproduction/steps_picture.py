"""Picture of what each step brings: the errors of Table 4, step by step."""

from __future__ import annotations

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stickslip.evaluation.motion_study import LEARNED
from stickslip.evaluation.validation import PAPER_TABLE4
from stickslip.pipeline.reproduction import Reproduction
from stickslip.pipeline.steps import STEPS
from stickslip.report.style import (
    GREY,
    INK,
    PAGE,
    WITH,
    WITHOUT,
    name_panel,
    new_figure,
)

LOOKS = {
    ("start", "E_max"): ("o", WITHOUT, "white", "start, $E_{max}$"),
    ("start", "E_rms"): ("o", WITHOUT, WITHOUT, "start, $E_{rms}$"),
    ("reverse", "E_max"): ("s", WITH, "white", "reverse, $E_{max}$"),
    ("reverse", "E_rms"): ("s", WITH, WITH, "reverse, $E_{rms}$"),
}
"""Marker, edge, face and name of each error."""


def draw(reproduction: Reproduction) -> Figure:
    """Draw the errors on the drive's true velocity, and on that of the drive with all effects."""
    drives = {"Simulated drive": reproduction.table4()}
    if reproduction.extras and reproduction.extras.table4 is not None:
        drives["Simulated drive, all extras on"] = reproduction.extras.table4
    figure = new_figure(PAGE, 78.0)
    panels = figure.subplots(1, len(drives), sharey=True, squeeze=False)[0]
    for axes, letter, (name, table) in zip(panels, "abc", drives.items(), strict=False):
        _panel(axes, table)
        name_panel(axes, letter, name)
    panels[0].set_ylabel("Error on the true velocity [mm/s]")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3)
    return figure


def _panel(axes: Axes, table: pd.DataFrame) -> None:
    true = table[table["velocity"] == "true"].rename(columns={"with": LEARNED})
    names = [name for name in STEPS if name in true]
    axes.set_yscale("log")
    axes.grid(visible=True, axis="y")
    for shift, (key, (marker, edge, face, label)) in enumerate(LOOKS.items()):
        row = true[(true["region"] == key[0]) & (true["metric"] == key[1])].iloc[0]
        x = [place + 0.14 * (shift - 1.5) for place in range(len(names))]
        axes.plot(
            x, [row[name] for name in names], marker, ls="none", ms=4.5, mec=edge, mfc=face,
            mew=0.9, label=label,
        )  # fmt: skip
    for place, colour, said in ((0, GREY, "without"), (1, INK, "with")):
        values = [both[place] for both in PAPER_TABLE4.values()]
        label = f"real stage (paper), {said}"
        axes.axhspan(min(values), max(values), color=colour, alpha=0.13, lw=0, label=label)
    labels = [STEPS[name] for name in names]
    axes.set_xticks(range(len(names)), labels, rotation=35, ha="right", rotation_mode="anchor")
