"""The learning of the loop: Figs. 3 to 5, the settings beside Table 3, and what was learned."""

from __future__ import annotations

from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stickslip import ga
from stickslip.catalog.parameters import friction_law
from stickslip.papers.lugre.loop_tuning import LoopTuning
from stickslip.papers.lugre.page.diagrams import draw_flow, draw_scheme
from stickslip.papers.lugre.page.loop_tuning import NAMES
from stickslip.papers.lugre.reproduction import Reproduction
from stickslip.presentation import style
from stickslip.presentation.markup import Html, paragraph, quiet, table
from stickslip.presentation.page import Illustration, Section
from stickslip.presentation.quantity import number, percent, unit
from stickslip.thresholds import kept
from stickslip.tuning.drive_model import PROBES
from stickslip.tuning.loop_learning import LEVELS, NEAR, POWER, LearnedLoop
from stickslip.tuning.loop_runs import GENES, training_motion

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
PAPER_TABLE3 = {
    "population": "10",
    "generations": "100",
    "elite_rate": "0.2",
    "mutation_rate": "0.15",
    "crossover_rate": "adaptive (7)",
    "resolution": "0.0001",
}
"""Table 3; its “number of gene 10” is not explained and has no counterpart."""


def loop_learning_section(reproduction: Reproduction) -> Section:
    """Return the section on the learning of the loop."""
    loops = reproduction.loops
    below, above = (f"{level:g}" for level in LEVELS)
    seconds = number(training_motion().duration, 2)
    return Section(
        "Learning the loop",
        paragraph(
            "The five parameters of friction are found by regression. What no regression finds is "
            "the loop: its gains, how much of the identified friction and inertia to feed "
            "forward, and how fast an observer corrects the rest. There an evolutionary search "
            f"helps. A candidate runs a motion of {seconds} s, with starts and reversals, slow "
            "reversals, creep and small moves at speeds of the validation and between them, once "
            f"on the drive, whose encoder and motor force show the velocity, and on models of it, "
            f"FMUs with {below} and {above} times its friction, which no one can command on a "
            f"drive. {_models(loops)} The cost is the mean, with the power {POWER}, of the "
            "tracking errors and of the change of the force from sample to sample, each relative "
            f"to the tuned PI controller; ratios above {NEAR:g} cost more, and a candidate with a "
            f"peak sensitivity Ms above {kept.SENSITIVITY:g} is not run. The best are run again, "
            "and one is taken only if nothing is worse than with the tuned PI controller, by more "
            f"than {percent(kept.LOOP_WORSE - 1.0, 0)}."
        ),
        Illustration(
            "fig3_scheme",
            partial(draw_scheme, reproduction),
            "Block diagram: the search sets the parameters of controller, compensator "
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
            f"range over {len(loops.learned)} seeds. It is a mean of ratios to the tuned PI "
            f"controller, and more where one exceeds {NEAR:g}.",
        ),
        _settings(reproduction),
        _genes(loops),
        _outcomes(loops),
    )


def _models(loops: LoopTuning) -> str:
    """Return what the models are, and how well they err like the drive."""
    best, found, fed = loops.study.models[0], "what was identified", ""
    if best.fitted:
        titles = [friction_law(model.law).title for model in loops.study.models]
        found = f"{' or '.join(titles)}, fitted to the drive’s errors"
        fed = f" The feedforward has the {titles[0]} friction, too."
    return (
        f"Their friction is {found}: in {len(PROBES)} loops their errors differ from those of the "
        f"drive by {percent(best.mismatch, 0)} (RMS of the logarithms).{fed}"
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
    axes.grid(visible=True, axis="y")
    axes.set(xlabel="Evaluations [1]", ylabel="Cost [1]", xlim=(1, most))
    axes.set_ylim(0.0, 1.1 * float(high[np.isfinite(high)].max()))
    style.legend_below(axes)
    return figure


def _settings(reproduction: Reproduction) -> Html:
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
    return [
        *((n.replace("_", " "), _setting(settings, n), paper) for n, paper in PAPER_TABLE3.items()),
        ("crossover, mutation", f"{settings.crossover}, {settings.mutation}", "not stated"),
        ("survival", settings.survival, "elitist"),
        ("encoding of the genes", settings.encoding, "real numbers"),
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
        f"{percent(best.tuned.share)} of the {best.tuned.law.title} friction, and "
        f"{percent(observer.share)} of the observer’s estimate."
    )
