"""The learning as published, over seeds, beside least squares from the same coarse starts."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stickslip import ga
from stickslip.catalog.parameters import LUGRE, PAPER
from stickslip.evaluation.motions import MOTIONS
from stickslip.evaluation.scatter import PHASES
from stickslip.papers.lugre.page.curves import cost_axes
from stickslip.papers.lugre.published import (
    OURS,
    PAPER_COST,
    READINGS,
    SQUARES,
    START,
    PublishedStudy,
)
from stickslip.presentation import style
from stickslip.presentation.markup import Html, element, join, paragraph, quiet, table
from stickslip.presentation.page import Illustration, Section
from stickslip.presentation.quantity import (
    number,
    parameter_unit,
    parameter_value,
    percent,
    ranged,
    symbol,
)
from stickslip.servo.datasheet import LOOP
from stickslip.servo.measurement import Array
from stickslip.servo.paper_commands import TRAINING
from stickslip.tuning.coarse_start import SPREAD

FIG5, OUTCOMES = FIGURES = ("fig5_as_published", "as_published")
"""Names of the figures of the section."""

METHODS = {
    START: "Coarse start",
    OURS: "As published",
    SQUARES: "Least squares",
    **{name: f"As published, {name.replace('_', ' ')}" for name in READINGS},
}
LOOKS = {START: ("white", style.GREY), OURS: (style.WITH, style.WITH), SQUARES: ("none", style.INK)}
"""Face and edge of each method's dots."""


def study_section(study: PublishedStudy, drive: Mapping[str, float]) -> Section:
    """Return the section of any study.

    Parameters
    ----------
    drive : the drive's true parameters by name, SI units
    """
    samples = round(TRAINING.duration / LOOP.T_s) + 1
    return Section(
        "The learning as published, and least squares",
        _method(study),
        _panel(study),
        _verdict(study),
        Illustration(
            FIG5,
            partial(draw_band, study),
            "Best cost over the generations, a band over seeds, and the cost after least squares",
            "Fig. 5 of the paper, from coarse starts: cost (6), the sum of ($v$ − $v_r$)² over the "
            f"{number(samples, 6)} samples of a training run, velocities in m/s. The paper "
            f"prints no unit; this reading makes its final {number(PAPER_COST)} comparable, not "
            "equal.",
        ),
        Illustration(
            OUTCOMES,
            partial(draw_seeds, study, drive),
            "Parameters and remaining errors, a dot for each seed and method",
            "What each seed started from and what it found: (a) parameters relative to those of "
            "the simulated drive; (b) error relative to that without compensation.",
        ),
        *_learned(study),
        *_readings(study),
    )


def _method(study: PublishedStudy) -> Html:
    spread = ", ".join(f"{symbol(name)} {number(SPREAD[name])}" for name in LUGRE)
    return paragraph(
        "The paper starts from coarsely identified values. The three experiments here are "
        "accurate, so each seed’s start is what they found times log-normal factors whose "
        f"logarithms have the standard deviations {spread}. From there {len(study.seeds[START])} "
        "seeds learn as published: Table 3, Steps 1 to 4, (6) and (7), no local search, no fit "
        "afterwards. Runs are counted as in the paper, with those of the elite, whose cost is "
        "known. Least squares begins at the same starts, and fits repeated runs of the training "
        "command and of slow motions with the start as a prior.",
    )


def _panel(study: PublishedStudy) -> Html:
    share = partial(percent, digits=0)
    rows = [
        (
            METHODS[row["method"]],
            str(row["seeds"]),
            str(row["runs"] or "–"),
            ranged(row, "cost", partial(number, digits=2)),
            *(ranged(row, motion.name.replace(" ", "_"), share) for motion in MOTIONS),
            f"{row['worse']}, {row['worse_slow']}" if row["runs"] else "–",
        )
        for row in study.panel().to_dict("records")
    ]
    head = (
        "", "Seeds", "Runs", "Cost (6) [m²/s²]", *(one.name.capitalize() for one in MOTIONS),
        "Worse",
    )  # fmt: skip
    return join(
        [
            table(head, rows, "From the same coarse starts: cost, and error left by motion"),
            quiet(
                "By motion: RMS error of the true velocity relative to that without compensation, "
                f"geometric mean over regions; median and range over seeds and {len(PHASES)} "
                "phases of an encoder step. “Worse” counts seeds whose median on the "
                "trapezoid, then in a slow motion, is above the largest error of their start."
            ),
        ]
    )


def _verdict(study: PublishedStudy) -> Html:
    panel = study.panel().set_index("method").to_dict("index")
    ours, squares = panel[OURS], panel[SQUARES]
    names = ("cost", *(motion.name.replace(" ", "_") for motion in MOTIONS))
    better = sum(squares[name] <= ours[name] for name in names)
    start, final = study.costs(START), study.costs(OURS)
    below = int((final <= PAPER_COST).sum())
    return paragraph(
        f"Without compensation a training run costs {number(study.cost_without, 3)} m²/s². As "
        f"published the cost falls to {percent(float(np.median(final / start)), 0)} of the start’s "
        f"in the median of seeds, and {below} of {len(final)} end below the {number(PAPER_COST)} "
        f"of the real stage (paper); {ours['worse']} then follow the trapezoid, which learning "
        f"does not use, worse than their start, and {ours['worse_slow']} a slow motion; with "
        f"least squares {squares['worse']} and {squares['worse_slow']} do. {squares['runs']} runs "
        f"of least squares equal or beat {ours['runs']} of the genetic algorithm in {better} of "
        f"these {len(names)} medians."
        + " For five friction parameters no search is needed."
        * (better == len(names))
    )


def _learned(study: PublishedStudy) -> tuple[Html, Html]:
    rows = []
    frame = study.learned().groupby("quantity", sort=False)
    for name, one in ((name, one) for name, one in frame if name in LUGRE):
        show = partial(parameter_value, str(name), digits=3)
        found: list[Html] = []
        for method in (START, OURS, SQUARES):
            low, middle, high = np.quantile(one[method], (0.0, 0.5, 1.0))
            row: dict[Hashable, float] = {"x": middle, "x_low": low, "x_high": high}
            found.append(ranged(row, "x", show))
        kept = np.isclose(one[OURS], one[START], rtol=0.02).sum()
        rows.append(
            (
                symbol(str(name)),
                *found,
                f"{kept} of {len(one)}",
                parameter_value(str(name), PAPER[str(name)]),
                parameter_unit(str(name)),
            )
        )
    head = (
        "", "Coarse start", "As published", "Least squares", "Seeds at start",
        "Real stage (paper)", "Unit",
    )  # fmt: skip
    return (
        table(head, rows, "Learned values over seeds, and those of the real stage", (0, 6)),
        quiet(
            "“At start” counts the seeds whose value as published differs from its start by less "
            "than 2 %. Mutation draws a new value anywhere from 0.1 to 100 times the start, so 98 "
            "of 100 draws lie above twice the start, and a parameter to which the cost is "
            "sensitive rarely changes.",
        ),
    )


def _readings(study: PublishedStudy) -> tuple[Html, ...]:
    items = [
        element("li", f"{METHODS[name].split(', ')[1]} ({one.place}): {one.ours} → {one.other}.")
        for name, one in READINGS.items()
        if name in study.seeds
    ]
    if not items:
        return ()
    return (
        element("h3", "What the paper leaves open"),
        paragraph(
            "Of 12 other readings of what the paper leaves open, one changes the result by more "
            "than seeds differ: our reading → the other one, in the table above."
        ),
        element("ul", join(items, "\n")),
    )


BAND = "#9dbbd6"


def draw_band(study: PublishedStudy) -> Figure:
    """Draw Fig. 5 of a study."""
    table = study.fitness()
    best = table.pivot_table(index="generation", columns="seed", values="best_cost")
    generation = best.index.to_numpy(dtype=float)
    low, first, middle, third, high = np.quantile(best.to_numpy(), (0, 0.25, 0.5, 0.75, 1), axis=1)
    figure, axes = cost_axes(82.0, generation, r"$\sum (v - v_r)^2$ [m$^2$/s$^2$]")
    for bottom, top, colour, label in (
        (low, high, style.PALE, f"{best.shape[1]} seeds, all"),
        (first, third, BAND, "middle half of them"),
    ):
        axes.fill_between(generation, bottom, top, step="post", color=colour, lw=0, label=label)
    axes.step(generation, middle, where="post", color=style.WITH, lw=style.THICK, label="median")
    costs, runs = study.costs(SQUARES), np.median([one.runs for one in study.seeds[SQUARES]])
    middle_cost, at = float(np.median(costs)), float(runs) / ga.PAPER.population
    axes.errorbar(
        [at], [middle_cost], [[middle_cost - costs.min()], [costs.max() - middle_cost]],
        fmt="D", ms=4.0, mfc="white", mec=style.INK, ecolor=style.INK, capsize=2.0,
        label=f"least squares, {runs:.0f} runs",
    )  # fmt: skip
    axes.axhline(
        PAPER_COST, color=style.INK, lw=0.8, ls=style.DASHED, label="real stage (paper), end"
    )
    axes.axhline(
        study.cost_without, color=style.WITHOUT, lw=0.8, ls=(0, (1, 1.5)),
        label="no compensation",
    )  # fmt: skip
    style.legend_below(axes, 2)
    return figure


def draw_seeds(study: PublishedStudy, drive: Mapping[str, float]) -> Figure:
    """Draw the parameters that each seed found, and what they leave of the errors.

    Parameters
    ----------
    drive : the drive's true parameters by name, SI units
    """
    figure = style.new_figure(style.PAGE, 78.0)
    left, right = figure.subplots(1, 2, width_ratios=(1.15, 1.0))
    for axes in (left, right):
        axes.axhline(1.0, color=style.INK, lw=0.8, ls=style.DASHED)
        axes.set_yscale("log")
    for shift, method in enumerate(LOOKS):
        values = [[one.parameters[n] / drive[n] for one in study.seeds[method]] for n in LUGRE]
        _strips(left, np.array(values), method, shift)
        errors = np.median(study.left_by_seed(method), axis=2)
        _strips(right, errors, method, shift)
    left.set_xticks(range(len(LUGRE)), [symbol(name) for name in LUGRE])
    left.set_ylabel("Value / the simulated drive’s [1]")
    right.set_xticks(range(len(MOTIONS)), [one.name.replace(" ", "\n") for one in MOTIONS])
    right.set_ylabel("Error / that without compensation [1]")
    style.name_panel(left, "a", "Parameters of each seed")
    style.name_panel(right, "b", "Errors of each seed, true velocity")
    style.legend_below(right, 3)
    return figure


def _strips(axes: Axes, rows: Array, method: str, shift: int) -> None:
    """Draw a strip of dots for each row, those of a method side by side with the others'."""
    face, edge = LOOKS[method]
    for place, values in enumerate(rows):
        x = place + 0.27 * (shift - 1) + np.linspace(-0.09, 0.09, len(values))
        label = METHODS[method].lower() if place == 0 else ""
        axes.plot(x, values, "o", ms=2.6, mew=0.6, mfc=face, mec=edge, label=label)
