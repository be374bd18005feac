"""Pictures of the paper's learning as published: Fig. 5 over seeds, and what it ends with."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stickslip.catalog.parameters import LUGRE
from stickslip.evaluation.validation import METRICS, PAPER_TABLE4
from stickslip.pipeline.reproduction import Reproduction
from stickslip.report.quantity import FORMULAS
from stickslip.report.style import (
    COLUMN,
    GREY,
    INK,
    PAGE,
    PALE,
    THICK,
    WITH,
    WITHOUT,
    name_panel,
    new_figure,
)
from stickslip.servo.measurement import Array
from stickslip.tuning.published.study import PAPER_COST, Published

_LABELS = {"E_max": "$E_{max}$", "E_rms": "$E_{rms}$"}
BAND = "#9dbbd6"


def draw_fitness(reproduction: Reproduction) -> Figure:
    """Draw Fig. 5: the best cost of every seed as a band, and where the paper ends."""
    assert reproduction.published is not None  # noqa: S101 - it is drawn where that was made
    return draw_band(reproduction.published.published)


def draw_outcomes(reproduction: Reproduction) -> Figure:
    """Draw the learned values and the errors of Table 4 of every seed."""
    assert reproduction.published is not None  # noqa: S101 - it is drawn where that was made
    return draw_seeds(reproduction.published.published, reproduction.truth)


def draw_band(published: Published) -> Figure:
    """Draw Fig. 5 of a study."""
    table = published.fitness()
    best = table.pivot_table(index="generation", columns="seed", values="best_cost")
    generation = best.index.to_numpy(dtype=float)
    figure = new_figure(COLUMN, 82.0)
    axes = figure.add_subplot()
    axes.set_yscale("log")
    axes.grid(visible=True, axis="y")
    low, first, middle, third, high = np.quantile(best.to_numpy(), (0, 0.25, 0.5, 0.75, 1), axis=1)
    axes.fill_between(
        generation, low, high, step="post", color=PALE, lw=0, label=f"{best.shape[1]} seeds, all"
    )
    axes.fill_between(
        generation, first, third, step="post", color=BAND, lw=0, label="middle half of them"
    )
    axes.step(generation, middle, where="post", color=WITH, lw=THICK, label="median")
    axes.axhline(PAPER_COST, color=INK, lw=0.8, ls=(0, (4, 2)), label="real stage (paper), end")
    axes.axhline(
        published.cost_without, color=WITHOUT, lw=0.8, ls=(0, (1, 1.5)), label="no compensation"
    )
    axes.set_xlim(generation[0], generation[-1])
    axes.set_xlabel("Generation [1]")
    axes.set_ylabel(r"Cost $\sum (v - v_r)^2$ [m$^2$/s$^2$]")
    figure.legend(loc="outside lower center", ncols=2)
    return figure


def draw_seeds(published: Published, drive: Mapping[str, float]) -> Figure:
    """Draw the learned values and the errors of a study.

    Parameters
    ----------
    drive : the drive's true parameters by name, SI units
    """
    figure = new_figure(PAGE, 78.0)
    left, right = figure.subplots(1, 2, width_ratios=(1.15, 1.0))
    _values(left, published, drive)
    _errors(right, published)
    handles, labels = right.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels))
    return figure


def _values(axes: Axes, published: Published, drive: Mapping[str, float]) -> None:
    axes.set_yscale("log")
    axes.axhline(1.0, color=INK, lw=0.8, ls=(0, (4, 2)))
    for place, name in enumerate(LUGRE):
        start = np.array([one.start[name] for one in published.seeds]) / drive[name]
        learned = np.array([one.learned[name] for one in published.seeds]) / drive[name]
        _strip(axes, place, start, learned)
    axes.set_xticks(range(len(LUGRE)), [FORMULAS[name] for name in LUGRE])
    axes.set_ylabel("Value / the simulated drive’s [1]")
    name_panel(axes, "a", "Parameters of each seed")


def _errors(axes: Axes, published: Published) -> None:
    table = published.table4()
    table = table[table["velocity"] == "measured"]
    axes.set_yscale("log")
    ticks = []
    for place, (region, metric) in enumerate((r, m) for r in ("start", "reverse") for m in METRICS):
        rows = table[(table["region"] == region) & (table["metric"] == metric)]
        _strip(axes, place, rows["start"].to_numpy(), rows["with"].to_numpy(), legend=place == 0)
        without, compensated = PAPER_TABLE4[region, metric]
        for value, colour, said in (
            (without, WITHOUT, "real stage (paper), without"),
            (compensated, INK, "real stage (paper), with"),
        ):
            label = said if place == 0 else ""
            axes.hlines(value, place - 0.4, place + 0.4, color=colour, lw=1.2, label=label)
        ticks.append(f"{region}\n{_LABELS[metric]}")
    axes.set_xticks(range(len(ticks)), ticks)
    axes.set_ylabel("Error on the trapezoid [mm/s]")
    name_panel(axes, "b", "Table 4 of each seed, measured velocity")


def _strip(axes: Axes, place: int, start: Array, learned: Array, *, legend: bool = False) -> None:
    """Draw each seed's start and what was learned as two dots joined by a line."""
    x = place + np.linspace(-0.3, 0.3, len(start))
    axes.vlines(x, start, learned, color=GREY, lw=0.4)
    marks = {"ls": "none", "mew": 0.7}
    said = ("coarse start", "learned") if legend else (None, None)
    axes.plot(x, start, "o", ms=3.0, mfc="white", mec=GREY, label=said[0], **marks)  # type: ignore[arg-type]
    axes.plot(x, learned, "o", ms=3.0, mfc=WITH, mec=WITH, label=said[1], **marks)  # type: ignore[arg-type]
