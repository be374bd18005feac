"""The learning as published, over seeds, and the readings that the paper leaves open."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping
from functools import partial
from itertools import product

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stickslip.catalog.parameters import LUGRE, PAPER
from stickslip.evaluation.validation import PAPER_TABLE4
from stickslip.report import style
from stickslip.report.markup import Html, element, paragraph, prose, quiet, table
from stickslip.report.page import Illustration, Section
from stickslip.report.quantity import (
    METRICS,
    number,
    parameter_unit,
    parameter_value,
    percent,
    symbol,
)
from stickslip.report.reproduction.curves import cost_axes
from stickslip.servo.datasheet import LOOP
from stickslip.servo.measurement import Array
from stickslip.servo.paper_commands import TRAINING
from stickslip.tuning.coarse_start import SPREAD
from stickslip.tuning.published.readings import ERRORS, WholeStudy, summary, worse
from stickslip.tuning.published.study import PAPER_COST, Published, worth

FIG5, OUTCOMES = FIGURES = ("fig5_as_published", "as_published")
"""Names of the figures of the section."""

RMS = ("start_E_rms", "reverse_E_rms")

_HEADS = {
    f"{region}_{metric}": f"{region.capitalize()}, {letter}"
    for region in ("start", "reverse")
    for metric, letter in METRICS.items()
}


def study_section(study: WholeStudy, drive: Mapping[str, float]) -> Section:
    """Return the section of any study.

    Parameters
    ----------
    drive : the drive's true parameters by name, SI units
    """
    published = study.published
    samples = round(TRAINING.duration / LOOP.T_s) + 1
    return Section(
        "The learning as published",
        _method(published),
        Illustration(
            FIG5,
            partial(draw_band, published),
            "Best cost over the generations, a band over seeds",
            "Fig. 5 of the paper, from coarse starts: cost (6), the sum of ($v$ − $v_r$)² over the "
            f"{number(samples, 6)} samples of a training run, velocities in m/s. The paper "
            f"prints no unit; this reading makes its final {number(PAPER_COST)} comparable, not "
            "equal.",
        ),
        _course(published),
        Illustration(
            OUTCOMES,
            partial(draw_seeds, published, drive),
            "Learned parameters and errors on the trapezoid, a dot for each seed",
            "What each seed started from and what it learned: (a) parameters relative to those of "
            "the simulated drive, which are the paper’s Table 2 unless they were changed; (b) the "
            "errors of Table 4 on the simulated drive, beside those of the real stage (paper).",
        ),
        _outcomes(published),
        *_learned(published),
        _criticism(study),
        *_readings(study),
    )


def _method(published: Published) -> Html:
    settings = published.method.settings
    runs = settings.population * settings.generations
    spread = ", ".join(f"{symbol(name)} {number(SPREAD[name])}" for name in LUGRE)
    simulated = int(np.median([one.simulated for one in published.seeds]))
    return paragraph(
        "The paper starts from coarsely identified values. The three experiments here are "
        "accurate, so each seed’s start is what they found times log-normal factors whose "
        f"logarithms have the standard deviations {spread}. From there the algorithm learns as "
        "published: Table 3, Steps 1 to 4, (6) and (7), no local search, no fit afterwards. "
        f"{len(published.seeds)} seeds learned side by side, each with {number(runs, 6)} runs as "
        "the paper counts them "
        f"(the elite included, whose cost is known; {number(simulated)} different candidates were "
        "simulated in the median, because a child that is neither crossed nor mutated is a copy).",
    )


def _course(published: Published) -> Html:
    start, final = published.start_costs(), published.final_costs()
    below = int((final <= PAPER_COST).sum())
    return paragraph(
        f"Without compensation a training run costs {number(published.cost_without, 3)} m²/s², the "
        f"coarse starts {_range(start)}, the end {_range(final)} (median; least to most). In the "
        f"median of seeds the cost falls to {percent(float(np.median(final / start)), 0)} of the "
        f"start’s; "
        f"{below} of {len(final)} seeds on the simulated drive end below the "
        f"{number(PAPER_COST)} of the real stage (paper).",
    )


def _range(values: np.ndarray) -> str:
    ends = f"{number(values.min(), 2)} to {number(values.max(), 2)}"
    return f"{number(float(np.median(values)), 2)} ({ends})"


def _outcomes(published: Published) -> Html:
    frame = published.table4()
    rows = []
    for (velocity, region, metric), group in frame.groupby(
        ["velocity", "region", "metric"], sort=False
    ):
        low, middle, high = np.quantile(group["with"], (0.25, 0.5, 0.75))
        paper = PAPER_TABLE4[str(region), str(metric)][1]
        rows.append(
            (
                f"Motion {region}, {METRICS[str(metric)]}",
                str(velocity),
                f"{group['without'].iloc[0]:.2f}",
                f"{group['start'].median():.2f}",
                f"{middle:.2f} ({low:.2f} to {high:.2f})",
                f"{paper:.2f}",
                f"{(group['with'] > group['start']).sum()} of {len(group)}",
            )
        )
    head = (
        "", "Velocity", "Without", "Coarse start", "Learned: median (middle half)",
        "Real stage (paper)", "Seeds that got worse",
    )  # fmt: skip
    return table(
        head,
        rows,
        "Table 4 as published: the simulated drive over seeds, and the real stage [mm/s]",
        (0, 1),
    )


def _learned(published: Published) -> tuple[Html, Html]:
    rows = []
    for name in LUGRE:
        values = [one.learned[name] for one in published.seeds]
        starts = [one.start[name] for one in published.seeds]
        low, middle, high = np.quantile(values, (0.25, 0.5, 0.75))
        kept = np.isclose(values, starts, rtol=0.02).sum()
        rows.append(
            (
                symbol(name),
                parameter_value(name, float(np.median(starts)), 3),
                parameter_value(name, middle, 3),
                f"{parameter_value(name, low, 3)} to {parameter_value(name, high, 3)}",
                f"{kept} of {len(values)}",
                parameter_value(name, PAPER[name]),
                parameter_unit(name),
            )
        )
    head = (
        "", "Coarse start, median", "Learned, median", "Middle half", "Seeds at start",
        "Real stage (paper)", "Unit",
    )  # fmt: skip
    return (
        table(
            head,
            rows,
            "Learned values as published: the simulated drive over seeds, and the real stage",
            (0, 6),
        ),
        quiet(
            "“At start” counts the seeds whose value differs from its start by less than 2 %. "
            "Mutation draws a new value anywhere from 0.1 to 100 times the start, so 98 of 100 "
            "draws lie above twice the start, and a parameter to which the cost is sensitive "
            "rarely changes.",
        ),
    )


def _criticism(study: WholeStudy) -> Html:
    frame = study.published.table4()
    seeds = len(study.published.seeds)
    count = round(worse(frame[frame["velocity"] == "measured"]) * seeds)
    return paragraph(
        f"In {count} of {seeds} seeds the trapezoid, which learning does not use, is followed "
        "worse with the learned parameters than with the coarse start (by $E_{rms}$ of both "
        "regions together), although the cost of the training command fell. Moreover, "
        f"{worth(study.slow)}.",
    )


def _readings(study: WholeStudy) -> tuple[Html, ...]:
    learning = paragraph("Readings that learn in another way were left out of this run.")
    if len(study.readings):
        learning = _learning_table(study.readings)
    return (
        element("h3", "What the paper leaves open"),
        paragraph(
            "Each place of the paper that can be read in more than one way: our reading, another "
            "one, and how much the result changes. Table 4’s errors are measured velocity, in "
            "mm/s, medians over seeds."
        ),
        learning,
        _evaluation_table(study.evaluations),
        _step3(study.published, study.threshold),
    )


def _learning_table(readings: pd.DataFrame) -> Html:
    seeds = int(readings["seeds"].min())
    rows = [
        (
            row["place"],
            prose(f"{row['ours']} → {row['other']}"),
            _moved(row, "cost", lambda value: number(value, 2)),
            *(_moved(row, name, lambda value: f"{value:.2f}") for name in RMS),
            _moved(row, "worse", lambda share: f"{share * seeds:.0f}"),
        )
        for row in readings.to_dict("records")
    ]
    errors = (_HEADS[name] for name in RMS)
    head = ("Place", "Our reading → another", "Final cost [m²/s²]", *errors, "Got worse")
    caption = f"Readings that learn in another way (ours → other, the same {seeds} seeds)"
    return table(head, rows, caption, (0, 1))


def _moved(row: Mapping[Hashable, float], name: str, show: Callable[[float], str]) -> str:
    before, after = (show(row[f"{name}_{which}"]) for which in ("ours", "other"))
    return f"{before} → {after}"


def _evaluation_table(evaluations: pd.DataFrame) -> Html:
    rows = [
        (
            row["place"],
            row["reading"] + (" (ours)" if row["ours"] else ""),
            *(f"{row[f'without_{name}']:.2f} → {row[f'with_{name}']:.2f}" for name in ERRORS),
        )
        for row in evaluations.to_dict("records")
    ]
    head = ("Place", "Reading", *_HEADS.values())
    caption = "Readings that evaluate the same runs in another way (without → with compensation)"
    return table(head, rows, caption, (0, 1))


def _step3(published: Published, threshold: Mapping[str, float]) -> Html:
    sentence = (
        f"Step 3 stops at a threshold ε or after 100 generations; ours has no threshold. With ε = "
        f"{number(threshold['threshold'])}, {percent(threshold['stops'], 0)} of the seeds stop"
    )
    if threshold["stops"]:
        sentence += f", after {number(threshold['generations'])} generations in the median"
    cost = summary(published)["cost"]
    sentence += (
        f"; the median cost is then {number(threshold['cost'], 2)} instead of {number(cost, 2)}. "
        "Elites are not run again: the simulated drive repeats itself exactly, so on it this "
        "reading changes nothing. “Number of gene 10” of Table 3 has no counterpart."
    )
    return paragraph(sentence)


BAND = "#9dbbd6"


def draw_band(published: Published) -> Figure:
    """Draw Fig. 5 of a study."""
    table = published.fitness()
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
    axes.axhline(
        PAPER_COST, color=style.INK, lw=0.8, ls=style.DASHED, label="real stage (paper), end"
    )
    axes.axhline(
        published.cost_without, color=style.WITHOUT, lw=0.8, ls=(0, (1, 1.5)),
        label="no compensation",
    )  # fmt: skip
    style.legend_below(axes, 2)
    return figure


def draw_seeds(published: Published, drive: Mapping[str, float]) -> Figure:
    """Draw the learned values and the errors of a study.

    Parameters
    ----------
    drive : the drive's true parameters by name, SI units
    """
    figure = style.new_figure(style.PAGE, 78.0)
    left, right = figure.subplots(1, 2, width_ratios=(1.15, 1.0))
    left.axhline(1.0, color=style.INK, lw=0.8, ls=style.DASHED)
    for place, name in enumerate(LUGRE):
        start, learned = (
            np.array([getattr(one, which)[name] for one in published.seeds]) / drive[name]
            for which in ("start", "learned")
        )
        _strip(left, place, start, learned)
    left.set_xticks(range(len(LUGRE)), [symbol(name) for name in LUGRE])
    left.set(yscale="log", ylabel="Value / the simulated drive’s [1]")
    style.name_panel(left, "a", "Parameters of each seed")
    _draw_errors(right, published)
    style.legend_below(right)
    return figure


def _draw_errors(axes: Axes, published: Published) -> None:
    table = published.table4()
    table = table[table["velocity"] == "measured"].set_index(["region", "metric"])
    keys = list(product(("start", "reverse"), METRICS))
    for place, key in enumerate(keys):
        rows, first = table.loc[[key]], place == 0
        _strip(axes, place, rows["start"].to_numpy(), rows["with"].to_numpy(), legend=first)
        for value, colour, which in zip(
            PAPER_TABLE4[key], (style.WITHOUT, style.INK), ("without", "with"), strict=True
        ):
            label = f"real stage (paper), {which}" if first else ""
            axes.hlines(value, place - 0.4, place + 0.4, color=colour, lw=1.2, label=label)
    axes.set_xticks(range(len(keys)), [f"{region}\n{METRICS[metric]}" for region, metric in keys])
    axes.set(yscale="log", ylabel="Error on the trapezoid [mm/s]")
    style.name_panel(axes, "b", "Table 4 of each seed, measured velocity")


def _strip(axes: Axes, place: int, start: Array, learned: Array, *, legend: bool = False) -> None:
    """Draw each seed's start and what was learned as two dots joined by a line."""
    x = place + np.linspace(-0.3, 0.3, len(start))
    axes.vlines(x, start, learned, color=style.GREY, lw=0.4)
    for values, face, edge, label in (
        (start, "white", style.GREY, "coarse start"),
        (learned, style.WITH, style.WITH, "learned"),
    ):
        axes.plot(
            x, values, "o", ms=3.0, mew=0.7, mfc=face, mec=edge, label=label if legend else ""
        )
