"""The learning of the loop: Figs. 3 to 5, the settings beside Table 3, and what was learned."""

from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stickslip import ga
from stickslip.catalog.parameters import friction_law
from stickslip.papers.lugre.loop_tuning import LoopTuning
from stickslip.papers.lugre.page.diagrams import draw_flow, draw_scheme
from stickslip.papers.lugre.page.section import section
from stickslip.papers.lugre.reproduction import Reproduction
from stickslip.presentation import style
from stickslip.presentation.page import Section
from stickslip.presentation.quantity import number
from stickslip.thresholds import kept
from stickslip.tuning import loop_learning, search
from stickslip.tuning.drive_model import PROBES
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
    found, fed, models = "what was identified", "", loops.study.models
    if models[0].fitted:
        titles = [friction_law(model.law).title for model in models]
        found = f"{' or '.join(titles)}, fitted to the drive’s errors"
        fed = f" The feedforward has the {titles[0]} friction, too."
    figures = {
        "fig3_scheme": partial(draw_scheme, reproduction),
        "fig4_flow": partial(draw_flow, reproduction),
        "fig5_fitness": partial(draw_fitness, loops),
    }
    values = {"settings": _settings(loops.best.algorithm), "genes": _genes(loops), "PROBES": PROBES}
    values |= {"learning": loop_learning, "search": search, "seconds": training_motion().duration}
    values |= {"found": found, "fed": fed, "kept": kept, "mismatch": models[0].mismatch}
    return section("Learning the loop", "loop_learning", reproduction, figures, **values)


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


def _settings(algorithm: ga.Optimiser) -> list[tuple[str, str, str]]:
    rows = [
        ("algorithm", algorithm.title, "genetic"),
        ("population", str(algorithm.batch), PAPER_TABLE3["population"]),
        ("generations", str(algorithm.generation), PAPER_TABLE3["generations"]),
    ]
    if isinstance(algorithm, ga.GeneticAlgorithm):
        own = algorithm.settings
        rows = [
            *((n.replace("_", " "), _setting(own, n), paper) for n, paper in PAPER_TABLE3.items()),
            ("crossover, mutation", f"{own.crossover}, {own.mutation}", "not stated"),
            ("survival", own.survival, "elitist"),
            ("encoding of the genes", own.encoding, "real numbers"),
        ]
    return [*rows, ("evaluations", str(algorithm.evaluations), "1000")]


def _setting(settings: ga.Settings, name: str) -> str:
    if name == "crossover_rate" and settings.crossover == "arithmetic":
        return f"adaptive (7), k₁ = {settings.k1:g}, k₂ = {settings.k2:g}"
    value = getattr(settings, name)
    if settings.adaptive and name == "mutation_rate":
        return f"{value:g} at first, adaptive"
    return "continuous" if value is None else f"{value:g}"


def _genes(loops: LoopTuning) -> list[tuple[str, ...]]:
    rows: list[tuple[str, ...]] = []
    for gene in GENES:
        values = [one.genes[gene.name] for one in loops.learned]
        rows.append(
            (
                SYMBOLS.get(gene.name, gene.name),
                MEANINGS[gene.name],
                f"{number(gene.lower)} to {number(gene.upper)}",
                number(loops.best.genes[gene.name], 3),
                f"{number(min(values), 2)} to {number(max(values), 2)}",
            )
        )
    return rows
