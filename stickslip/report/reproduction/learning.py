"""The learning: Fig. 5, the settings beside Table 3, and Table 2 with the learned values."""

from __future__ import annotations

import math
from functools import partial

from stickslip import ga
from stickslip.catalog.parameters import PAPER
from stickslip.pipeline.reproduction import Reproduction
from stickslip.report.markup import Html, element, join, paragraph, table
from stickslip.report.page import Illustration, Section
from stickslip.report.quantity import (
    number,
    parameter_estimate,
    parameter_unit,
    parameter_value,
    percent,
    symbol,
)
from stickslip.report.reproduction.curves import draw_fitness
from stickslip.report.reproduction.diagrams import draw_flow, draw_scheme
from stickslip.servo.paper_commands import TRAINING
from stickslip.tuning.published.study import PAPER_COST

PAPER_TABLE3 = {
    "population": "10",
    "generations": "100",
    "elite_rate": "0.2",
    "mutation_rate": "0.15",
    "crossover_rate": "adaptive (7)",
    "resolution": "0.0001",
}
"""Table 3; its “number of gene 10” is not explained and has no counterpart."""


def learning_section(reproduction: Reproduction) -> Section:
    """Return the section on learning."""
    return Section(
        "Learning",
        Illustration(
            "fig3_scheme",
            partial(draw_scheme, reproduction),
            "Block diagram: the genetic algorithm sets the compensator’s parameters so that the "
            "drive’s velocity is that of the nominal loop",
            "The learning scheme, Fig. 3 of the paper. The drive runs once for each candidate; its "
            "velocity $v$ is compared with $v_r$ of the nominal loop, which has no friction.",
        ),
        Illustration(
            "fig4_flow",
            partial(draw_flow, reproduction),
            "Flow chart of the four steps of the learning",
            "The steps of the learning, Fig. 4 of the paper, with the settings of this run.",
        ),
        _course(reproduction),
        Illustration(
            "fig5_fitness",
            partial(draw_fitness, reproduction),
            "Best and mean cost over the generations, logarithmic",
            "Cost (6) over the generations, as Fig. 5 of the paper: the sum of ($v$ − $v_r$)² over "
            "the samples of one training run of the simulated drive, velocities in m/s, as the "
            "encoder shows them and low-passed. The line is a run without compensation.",
        ),
        _training_cost(reproduction),
        _settings(reproduction),
        _table2(reproduction),
        *_remarks(reproduction),
    )


def _course(reproduction: Reproduction) -> Html:
    algorithm, learned = reproduction.algorithm, reproduction.refinement
    factors = reproduction.options.coarse
    text = "Learning began with the identified parameters. "
    if factors:
        times = ", ".join(f"{name} × {number(factor, 6)}" for name, factor in factors.items())
        text = f"Learning began away from the identified parameters: {times}. "
    text += (
        f"Without compensation a training run costs {number(reproduction.cost_without, 3)} m²/s², "
        f"with these parameters {number(reproduction.cost_of_identified, 3)} m²/s². "
    )
    if learned.skipped:
        why = learned.skipped.replace("m2/s2", "m²/s²")
        return paragraph(
            f"{text}Nothing was searched beyond a first generation of "
            f"{number(algorithm.evaluations, 6)} candidates, and the start values are kept: {why}."
        )
    text += (
        f"With the best of {number(algorithm.evaluations, 6)} candidates it costs "
        f"{number(algorithm.best.cost, 3)} m²/s². "
    )
    if not reproduction.options.refined:
        text += f"Run again {learned.runs} times, the winner costs {number(learned.cost, 3)} m²/s²"
    elif learned.accepted:
        text += (
            "A least-squares fit then combined repeated runs of the training command, of its "
            "mirror image and of slow motions with the start values as a prior; its result costs "
            f"{number(learned.cost, 3)} m²/s² in a typical run ({learned.runs} more runs of the "
            "drive). The best of many candidates owes part of its low cost to chance, so the "
            "typical run of the refined parameters may cost a little more"
        )
    else:
        text += (
            "A least-squares fit was tried and was worse on the drive, so the start values are "
            f"kept, at {number(learned.cost, 3)} m²/s² in a typical run ({learned.runs} more runs)"
        )
    return paragraph(f"{text}: {learned.remark}.")


def _settings(reproduction: Reproduction) -> Html:
    algorithm = reproduction.algorithm
    rows = [
        ("algorithm", algorithm.title, "genetic"),
        ("population", str(algorithm.batch), PAPER_TABLE3["population"]),
        ("generations", str(algorithm.generation), PAPER_TABLE3["generations"]),
    ]
    if isinstance(algorithm, ga.GeneticAlgorithm):
        rows = _of_genetic(algorithm.settings)
    rows.append(("seed", str(reproduction.options.seed), "–"))
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


def _table2(reproduction: Reproduction) -> Html:
    identified, learned = reproduction.identification.estimates, reproduction.refinement.estimates
    rows = []
    for name, found in identified.items():
        estimate, truth = learned.get(name), reproduction.truth[name]
        rows.append(
            (
                symbol(name),
                parameter_value(name, PAPER.get(name, math.nan)),
                parameter_value(name, truth),
                parameter_estimate(name, found),
                parameter_estimate(name, estimate) if estimate else "–",
                *(
                    percent(e.value / truth - 1.0, 2) if e and truth else "–"
                    for e in (found, estimate)
                ),
                parameter_unit(name),
            )
        )
    head = (
        "", "Real stage (paper)", "Simulated drive", "Identified", "Learned",
        "Identified, off by", "Learned, off by", "Unit",
    )  # fmt: skip
    return table(head, rows, "Table 2. Parameters (value ± standard error)", (0, 7))


def _remarks(reproduction: Reproduction) -> tuple[Html, Html]:
    remarks = reproduction.table2().set_index("parameter")["remark"]
    items = [
        element("li", f"{symbol(name)}: {remarks[name]}".replace("+-", "±").replace("'", "’"))
        for name in reproduction.refinement.estimates
    ]
    return (
        element("ul", join(items, "\n")),
        paragraph("$m$ and $b$ are identified only, not learned."),
    )


def _training_cost(reproduction: Reproduction) -> Html:
    """Return the costs as a table, with the RMS of v - v_r that each means."""
    samples = round(TRAINING.duration / reproduction.identification.loop.T_s) + 1
    without = reproduction.cost_without
    begun = "coarse start" if reproduction.options.coarse else "identified parameters"
    costs = [
        ("without compensation", without),
        (begun, reproduction.cost_of_identified),
        ("best candidate", reproduction.algorithm.best.cost),
        (reproduction.refinement.result, reproduction.refinement.cost),
        ("real stage (paper), as read below", PAPER_COST),
    ]
    rows = [
        (
            label,
            number(cost, 3),
            number(1e3 * math.sqrt(cost / samples), 3),
            percent(cost / without, 2) if cost != PAPER_COST else "–",
        )
        for label, cost in costs
    ]
    head = ("", "Cost (6) [m²/s²]", "RMS of $v$ − $v_r$ [mm/s]", "Of that without")
    return element(
        "div",
        table(head, rows, f"Cost of a training run of {number(samples, 6)} samples"),
        paragraph(
            f"The paper prints {number(PAPER_COST, 2)} without a unit, a sample rate or a "
            "duration. Read in m²/s² over as many samples as here, it is the velocity error in the "
            "last row. What the real stage costs without compensation is not given."
        ),
    )
