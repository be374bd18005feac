"""What each step brings, and the learning of the loop, with Figs. 3 to 5."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FormatStrFormatter, NullLocator

from stickslip import ga
from stickslip.evaluation.motions import MOTIONS
from stickslip.evaluation.scatter import PHASES
from stickslip.pipeline.loop_tuning import FRICTION, STAGES, LoopTuning, spread
from stickslip.pipeline.reproduction import Reproduction
from stickslip.report import style
from stickslip.report.markup import Html, paragraph, quiet, table
from stickslip.report.page import Illustration, Section
from stickslip.report.quantity import number, percent, unit
from stickslip.report.reproduction.diagrams import draw_flow, draw_scheme
from stickslip.tuning.loop_genes import GENES
from stickslip.tuning.loop_learning import LEVELS, LIMIT, LearnedLoop, training_motion

NAMES = {
    "none": "None",
    "tuned_pi": "Tuned PI alone",
    "identified": "+ identified friction",
    "least_squares": "+ least squares",
    "learned": "Loop learned",
}
"""The stages as the page names them."""
MEANINGS = {
    "K_p": "proportional gain, of the tuned PI’s",
    "K_i": "integral gain, of the tuned PI’s",
    "tau_f": "low-pass of the velocity estimate, of the loop’s",
    "m_ff": "feedforward of inertia, of the identified mass",
    "share": "feedforward of friction, of its whole force",
    "rate": "rate of the disturbance that the observer follows, in $F_c$",
    "observed": "of the observer’s estimate that is compensated",
}
SYMBOLS = {"K_p": "$K_p$", "K_i": "$K_i$", "tau_f": r"$\tau_f$", "m_ff": "$m_{ff}$"}
LEVEL_LOOKS: Any = {
    0.7: {"marker": "v", "mfc": "white"},
    1.0: {"marker": "o", "mfc": style.WITH},
    1.3: {"marker": "^", "mfc": "white"},
}


PAPER_TABLE3 = {
    "population": "10",
    "generations": "100",
    "elite_rate": "0.2",
    "mutation_rate": "0.15",
    "crossover_rate": "adaptive (7)",
    "resolution": "0.0001",
}
"""Table 3; its “number of gene 10” is not explained and has no counterpart."""


def steps_at_a_glance(reproduction: Reproduction) -> tuple[Html | Illustration, ...]:
    """Return what the page opens with: errors of each step, relative to a tuned PI controller."""
    loops = reproduction.loops
    assert loops is not None  # noqa: S101 - a page is of a whole reproduction
    return (
        paragraph(f"{loops.sentence[0].upper()}{loops.sentence[1:]}."),
        Illustration(
            "loop_tuning",
            partial(draw_stages, loops),
            "Errors of four motions, step by step, relative to a tuned PI controller",
            "What each step brings, in four motions: the error of the true velocity relative to "
            "that of a PI controller whose gains are tuned without any model of friction. The "
            "simulated drive has its own friction (circles), and 0.7 and 1.3 times as much, to "
            "which nothing is learned again. Bars: range over "
            f"{len(loops.learned)} seeds of the search. Each point is a median over "
            f"{len(PHASES)} places within a step of the encoder from which the motion begins.",
        ),
        _stages(loops),
    )


def _stages(loops: LoopTuning) -> Html:
    summary, rows = loops.summary(), []
    for stage, name in NAMES.items():
        own = summary.loc[stage]
        cells = [spread(*own[motion.name]) for motion in MOTIONS]
        rows.append((name, *cells, f"{own['Ms'].iloc[0]:.2f}", _cost(loops, stage)))
    head = ("", *(motion.name.capitalize() for motion in MOTIONS), "Ms", "Runs of the drive")
    caption = (
        "Errors relative to the tuned PI controller alone: median [range] over friction "
        f"× {', × '.join(f'{level:g}' for level in FRICTION)} and seeds"
    )
    return table(head, rows, caption)


def _cost(loops: LoopTuning, stage: str) -> str:
    if stage == "learned":
        return f"{max(one.runs for one in loops.learned)} more"
    if stage == "least_squares":
        own = loops.table[loops.table["stage"] == stage]
        return f"{own['evaluations'].max()} more"
    return {"none": "–", "tuned_pi": "–", "identified": "three experiments"}[stage]


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
        labels = [NAMES[stage] for stage in STAGES]
        axes.set_xticks(range(len(labels)), labels, rotation=40, ha="right", rotation_mode="anchor")
        style.name_panel(axes, letter, motion.name.capitalize())
    panels[0].set_ylabel("Error relative to tuned PI [1]")
    style.legend_below(panels[0], 3)
    return figure


def loop_learning_section(reproduction: Reproduction) -> Section:
    """Return the section on the learning of the loop."""
    loops = reproduction.loops
    assert loops is not None  # noqa: S101 - a page is of a whole reproduction
    below, above = (f"{level:g}" for level in LEVELS)
    seconds = number(training_motion().duration, 2)
    return Section(
        "Learning the loop",
        paragraph(
            "The five parameters of friction are found by regression. What no regression finds is "
            "the loop: its gains, how much of the identified friction and inertia to feed "
            "forward, and how fast an observer corrects the rest. There an evolutionary search "
            f"helps. A candidate runs a motion of {seconds} s, with starts and reversals, slow "
            "reversals, creep and small moves at other speeds than those of the validation, once "
            f"on the drive, and on two models of it, FMUs of what was identified, with {below} "
            f"and {above} times the identified friction, which no one can command on a drive. Its "
            "cost is the mean, with the power 8, of the tracking errors and of the change of the "
            "force from sample to sample, each relative to the tuned PI controller; a candidate "
            f"with a peak sensitivity Ms above {LIMIT:g} is not run. The best are run again, and "
            "one is taken only if it is worse than the tuned PI controller in nothing."
        ),
        Illustration(
            "fig3_scheme",
            partial(draw_scheme, reproduction),
            "Block diagram: the genetic algorithm sets the parameters of controller, compensator "
            "and observer so that drive and models follow the command",
            "The learning scheme, as Fig. 3 of the paper, with the loop as what is learned. The "
            "drive runs once for each candidate.",
        ),
        Illustration(
            "fig4_flow",
            partial(draw_flow, reproduction),
            "Flow chart of the four steps of the learning",
            "The steps of the learning, Fig. 4 of the paper, with the settings of this run.",
        ),
        Illustration(
            "fig5_fitness",
            partial(draw_fitness, loops),
            "Best cost over the evaluations, median and range over seeds",
            f"Cost of the best candidate over the evaluations, as Fig. 5 of the paper: median and "
            f"range over {len(loops.learned)} seeds. 1 is the tuned PI controller alone.",
        ),
        _settings(reproduction),
        _genes(loops),
        _outcomes(loops),
    )


def draw_fitness(loops: LoopTuning) -> Figure:
    """Draw the best cost over the evaluations, a band over seeds."""
    figure = style.new_figure(style.COLUMN, 70.0)
    axes: Axes = figure.add_subplot()
    costs = [one.algorithm.history["cost"].to_numpy(dtype=float) for one in loops.learned]
    most = max(map(len, costs))
    at = np.arange(1, most + 1)
    best = [
        np.pad(np.minimum.accumulate(cost), (0, most - len(cost)), mode="edge") for cost in costs
    ]
    low, middle, high = (f(best, axis=0) for f in (np.min, np.median, np.max))
    axes.fill_between(at, low, high, color=style.WITH, alpha=0.18, lw=0, label="range over seeds")
    axes.plot(at, middle, color=style.WITH, lw=style.THICK, label="median")
    axes.axhline(1.0, color=style.GREY, lw=style.LINE, label="tuned PI alone")
    axes.grid(visible=True, axis="y")
    axes.set(xlabel="Evaluations [1]", ylabel="Cost relative to tuned PI [1]", xlim=(1, most))
    axes.set_ylim(0.0, 1.1 * max(1.0, float(high[np.isfinite(high)].max())))
    style.legend_below(axes, 3)
    return figure


def _settings(reproduction: Reproduction) -> Html:
    assert reproduction.loops is not None  # noqa: S101 - a page is of a whole reproduction
    algorithm = reproduction.loops.best.algorithm
    rows = [
        ("algorithm", algorithm.title, "genetic"),
        ("population", str(algorithm.batch), PAPER_TABLE3["population"]),
        ("generations", str(algorithm.generation), PAPER_TABLE3["generations"]),
    ]
    if isinstance(algorithm, ga.GeneticAlgorithm):
        rows = _of_genetic(algorithm.settings)
    rows.append(("evaluations", str(algorithm.evaluations), "1000"))
    caption = f"Settings, preset “{reproduction.options.preset}”, beside Table 3"
    return table(("", "This run", "Paper"), rows, caption)


def _of_genetic(settings: ga.Settings) -> list[tuple[str, str, str]]:
    surrogates = "sections, bowl and quadratic" if settings.surrogates else "none"
    restarts = "none" if settings.patience is None else f"after {settings.patience} generations"
    return [
        *((n.replace("_", " "), _setting(settings, n), paper) for n, paper in PAPER_TABLE3.items()),
        ("crossover", settings.crossover, "not stated"),
        ("mutation", settings.mutation, "not stated"),
        ("survival", settings.survival, "elitist"),
        ("encoding of the genes", settings.encoding, "real numbers"),
        ("models of the cost", surrogates, "none"),
        ("restart without progress", restarts, "none"),
    ]


def _setting(settings: ga.Settings, name: str) -> str:
    if name == "crossover_rate" and settings.crossover == "arithmetic":
        return f"adaptive (7), k₁ = {settings.k1:g}, k₂ = {settings.k2:g}"
    value = getattr(settings, name)
    if settings.adaptive and name == "mutation_rate":
        return f"{value:g} at first, adaptive"
    return "continuous" if value is None else f"{value:g}"


def _genes(loops: LoopTuning) -> Html:
    best, rows = loops.best, []
    for gene in GENES:
        values = [one.genes[gene.name] for one in loops.learned]
        rows.append(
            (
                SYMBOLS.get(gene.name, gene.name),
                MEANINGS[gene.name],
                f"{number(gene.lower)} to {number(gene.upper)}",
                number(best.genes[gene.name], 3),
                f"{number(min(values), 2)} to {number(max(values), 2)}",
            )
        )
    head = ("Gene", "", "Searched", f"Seed {best.seed}, least cost", "All seeds")
    return table(head, rows, "What is learned of the loop", (0, 1))


def _outcomes(loops: LoopTuning) -> Html:
    """Return what the seeds found, and the loop of the one that is written."""
    found = loops.by_seed()
    rows = [
        (
            str(one.seed),
            {"learned": "a candidate"}.get(one.chosen, NAMES.get(one.chosen, one.chosen)),
            f"{one.cost:.3f}",
            f"{found['median'][one.seed]:.2f}",
            f"{found['largest'][one.seed]:.2f}",
            f"{one.Ms:.2f}",
            str(one.evaluations),
            str(one.runs),
        )
        for one in loops.learned
    ]
    head = (
        "Seed", "Chosen", "Cost", "Median error", "Largest error", "Ms", "Candidates",
        "Runs of the drive",
    )  # fmt: skip
    caption = "The searches; errors in the validation, relative to the tuned PI controller"
    return Html(table(head, rows, caption, (1,)) + quiet(_written(loops.best)))


def _written(best: LearnedLoop) -> str:
    """Return the loop of the seed with the least cost, in units."""
    loop = best.tuned.loop
    observer = best.tuned.observer
    return (
        f"Seed {best.seed} has the least cost and is what learned_loop.ssp contains: "
        f"$K_p$ = {number(loop.K_p)} {unit('N.s/m')}, $K_i$ = {number(loop.K_i)} N/m, "
        rf"$\tau_f$ = {number(1e3 * loop.tau_f)} ms, feedforward of {number(loop.m_ff)} kg and of "
        f"{percent(best.tuned.share)} of the identified friction, and {percent(observer.share)} of "
        f"the observer’s estimate."
    )
