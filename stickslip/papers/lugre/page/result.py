"""The head of the page: what was done, the result, and the errors at a glance."""

from functools import partial
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FormatStrFormatter, NullLocator

from stickslip import models
from stickslip.evaluation.motions import MOTIONS
from stickslip.papers.lugre import tables
from stickslip.papers.lugre.loop_tuning import FRICTION, STAGES, LoopTuning
from stickslip.papers.lugre.page.section import section
from stickslip.papers.lugre.reproduction import Reproduction
from stickslip.papers.lugre.steps import FILTERED, REDUCTION_WITH_FILTER
from stickslip.presentation import style
from stickslip.presentation.page import Section
from stickslip.presentation.quantity import METRICS, number, percent, unit
from stickslip.servo.systems import drive_law

EFFECTS = {
    "current_loop": "lag of the current loop",
    "dac": "steps of the force command",
    "encoder": "steps of the encoder",
    "asymmetric": "asymmetric friction",
    "position_dependent": "position-dependent friction",
    "ripple": "force ripple",
    "noise": "measurement noise",
}
FEEDS = {"nominal": "the nominal loop’s velocity", "command": "the velocity command"}


def head(reproduction: Reproduction) -> Section:
    """Return what was done, what each step brings, and the verdict."""
    table = reproduction.table4()
    own = table[table["velocity"] == "measured"]
    start, law = drive_law(reproduction.options.truth)
    model = models.load_model("drive", law)
    variables = {v.name: v for v in model.variables if v.role == "parameter"}
    changes = [
        f"{name} = {number(float(value), 6)} {unit(variables[name].unit or '1')}".strip()
        + f" (instead of {number(float(variables[name].start), 6)})"
        for name, value in start.items()
    ]
    if model.law is not None and law != "lugre":
        changes.insert(0, f"friction law = {model.law.title} (instead of LuGre)")
    switches = [name for name, v in variables.items() if v.type == "boolean"]
    effects = {
        state: [EFFECTS.get(n, n) for n in switches if bool(reproduction.truth[n]) == state]
        for state in (True, False)
    }
    loops = reproduction.loops
    return section(
        "",
        "result",
        reproduction,
        {"loop_tuning": partial(draw_stages, loops)},
        feed=FEEDS[reproduction.options.feed],
        FRICTION=[f"{level:g}" for level in FRICTION],
        changes=changes,
        effects=effects,
        better=int((own["reduction"] > own["paper_reduction"]).sum()),
        found=_tiles(reproduction),
    )


def _tiles(reproduction: Reproduction) -> list[tuple[str, ...]]:
    """Return the reductions of the measured errors, each with those beside it."""
    table = reproduction.table4()
    own, true = (table[table["velocity"] == shown] for shown in ("measured", "true"))
    extras = reproduction.extras.table4 if reproduction.extras else None
    found = []
    for k, row in enumerate(own.to_dict("records")):
        beside = ["simulated drive", f"true velocity {percent(true['reduction'].iloc[k])}"]
        if FILTERED in true:
            reduced = true[REDUCTION_WITH_FILTER].iloc[k]
            beside.append(f"true velocity, with velocity filter {percent(reduced)}")
        if extras is not None:
            reduced = extras[extras["velocity"] == "measured"]["reduction"].iloc[k]
            beside.append(f"all extras on {percent(reduced)}")
        beside.append(f"real stage (paper) {percent(row['paper_reduction'], 0)}")
        name = f"Motion {row['region']}, {METRICS[row['metric']]}"
        found.append((name, percent(row["reduction"]), *beside))
    return found


LEVEL_LOOKS: Any = {
    0.7: {"marker": "v", "mfc": "white"},
    1.0: {"marker": "o", "mfc": style.WITH},
    1.3: {"marker": "^", "mfc": "white"},
}


def draw_stages(loops: LoopTuning) -> Figure:
    """Draw the errors of each step relative to the tuned PI controller, a panel for each motion."""
    figure = style.new_figure(style.PAGE, 74.0)
    panels = figure.subplots(1, len(MOTIONS), sharey=True)
    for axes, letter, motion in zip(panels, "abcd", MOTIONS, strict=True):
        rows = loops.ratios[loops.ratios["motion"] == motion.name]
        for shift, level in zip((-0.22, 0.0, 0.22), FRICTION, strict=True):
            own = rows[rows["friction"] == level].groupby("stage", sort=False)["ratio"]
            middle, low, high = own.median(), own.min(), own.max()
            axes.errorbar(
                np.arange(len(middle)) + shift, middle, (middle - low, high - middle),
                ls="none", ms=4.0, mec=style.WITH, ecolor=style.WITH, elinewidth=0.8,
                label=f"friction × {level:g}", **LEVEL_LOOKS[level],
            )  # fmt: skip
        axes.axhline(1.0, color=style.GREY, lw=style.THIN)
        axes.set_yscale("log")
        axes.yaxis.set_major_locator(FixedLocator([0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0]))
        axes.yaxis.set_minor_locator(NullLocator())
        axes.yaxis.set_major_formatter(FormatStrFormatter("%g"))
        axes.grid(visible=True, axis="y")
        labels = [tables.STAGES[stage] for stage in STAGES]
        axes.set_xticks(range(len(labels)), labels, rotation=40, ha="right", rotation_mode="anchor")
        style.name_panel(axes, letter, motion.name.capitalize())
    panels[0].set_ylabel("Error relative to tuned PI [1]")
    style.legend_below(panels[0], 3)
    return figure
