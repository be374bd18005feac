"""The learning: Fig. 5, the settings beside Table 3, and Table 2 with the learned values."""

from __future__ import annotations

import math
from functools import partial

from stickslip import ga
from stickslip.catalog.parameters import LUGRE, PAPER, UNITS
from stickslip.pipeline.reproduction import Reproduction
from stickslip.report.markup import (
    Html,
    element,
    join,
    paragraph,
    parameter,
    parameter_estimate,
    parameter_unit,
    parameter_value,
    symbol,
    table,
)
from stickslip.report.page import Illustration, Section
from stickslip.report.quantity import number, percent
from stickslip.report.reproduction.curves import draw_fitness
from stickslip.report.reproduction.diagrams import draw_flow, draw_scheme
from stickslip.servo.datasheet import TRAINING
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
        *_scheme(reproduction),
        _course(reproduction),
        Illustration(
            "fig5_fitness",
            partial(draw_fitness, reproduction),
            "Best and mean cost over the generations, logarithmic",
            join(
                [
                    "Fig. 5. Cost (6) over the generations: the sum of (",
                    symbol("v"),
                    " − ",
                    symbol("v", "r"),
                    ")² over the samples of one training run of the simulated drive, velocities in "
                    "m/s, as the encoder shows them and low-passed. The line is a run without "
                    "compensation.",
                ]
            ),
        ),
        _training_cost(reproduction),
        _settings(reproduction),
        _table2(reproduction),
        _remarks(reproduction),
    )


def _scheme(reproduction: Reproduction) -> tuple[Illustration, Illustration]:
    scheme = Illustration(
        "fig3_scheme",
        partial(draw_scheme, reproduction),
        "Block diagram: the genetic algorithm sets the compensator’s parameters so that the "
        "drive’s velocity is that of the nominal loop",
        join(
            [
                "Fig. 3. The learning scheme. The drive runs once for each candidate; its "
                "velocity ",
                symbol("v"),
                " is compared with ",
                symbol("v", "r"),
                " of the nominal loop, which has no friction.",
            ]
        ),
    )
    flow = Illustration(
        "fig4_flow",
        partial(draw_flow, reproduction),
        "Flow chart of the four steps of the learning",
        "Fig. 4. The steps of the learning, with the settings of this run.",
    )
    return scheme, flow


def _course(reproduction: Reproduction) -> Html:
    algorithm, learned = reproduction.algorithm, reproduction.learned
    text = _begun(reproduction) + (
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
        text += f"Run again {learned.runs} times, the winner costs {number(learned.cost, 3)} m²/s²."
    elif learned.accepted:
        text += (
            "A least-squares fit then weighed repeated runs of the training command and of its "
            "mirror image against what learning began with; its result "
            f"costs {number(learned.cost, 3)} m²/s² in a typical run ({learned.runs} more runs of "
            "the drive). The best of many candidates owes part of its low cost to luck, so the "
            "typical run of the refined parameters may cost a little more."
        )
    else:
        text += (
            "A least-squares fit was tried and cost more on the drive, over the training command "
            f"and its mirror image, so the {_standing(reproduction)}, at "
            f"{number(learned.cost, 3)} m²/s² in a typical run ({learned.runs} more runs)."
        )
    return paragraph(text)


def _begun(reproduction: Reproduction) -> str:
    """Say where learning began."""
    factors = reproduction.options.coarse
    if not factors:
        return "Learning began with the identified parameters. "
    times = ", ".join(f"{name} × {number(factor, 6)}" for name, factor in factors.items())
    return f"Learning began away from the identified parameters: {times}. "


def _standing(reproduction: Reproduction) -> str:
    if reproduction.learned.chosen == "start":
        return "start values are kept"
    return "winner is kept"


def _settings(reproduction: Reproduction) -> Html:
    algorithm = reproduction.algorithm
    if isinstance(algorithm, ga.GeneticAlgorithm):
        rows = _of_genetic(algorithm.settings)
    else:
        rows = [
            ("algorithm", algorithm.title, "genetic"),
            ("population", str(algorithm.batch), PAPER_TABLE3["population"]),
            ("generations", str(algorithm.generation), PAPER_TABLE3["generations"]),
        ]
    rows.append(("seed", str(reproduction.options.seed), "–"))
    caption = f"Settings, preset “{reproduction.options.preset}”, beside Table 3"
    return table(("", "This run", "Paper"), rows, caption)


def _of_genetic(settings: ga.Settings) -> list[tuple[str, str, str]]:
    names = {
        "population": "population",
        "generations": "generations",
        "elite_rate": "elite rate",
        "mutation_rate": "mutation rate",
        "crossover_rate": "crossover rate",
        "resolution": "resolution",
    }
    surrogates = "sections, bowl and quadratic" if settings.surrogates else "none"
    restarts = "none" if settings.patience is None else f"after {settings.patience} generations"
    return [
        *((text, _setting(settings, name), PAPER_TABLE3[name]) for name, text in names.items()),
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
    identified, learned = reproduction.identification.estimates, reproduction.learned.estimates
    rows = []
    for name in UNITS:
        estimate, truth = learned.get(name), reproduction.truth[name]
        rows.append(
            (
                parameter(name),
                parameter_value(name, PAPER[name]),
                parameter_value(name, truth),
                parameter_estimate(name, identified[name]),
                parameter_estimate(name, estimate) if estimate else "–",
                _error(identified[name].value, truth),
                _error(estimate.value, truth) if estimate else "–",
                parameter_unit(name),
            )
        )
    head = (
        "", "Real stage (paper)", "Simulated drive", "Identified", "Learned",
        "Identified, off by", "Learned, off by", "Unit",
    )  # fmt: skip
    return table(head, rows, "Table 2. Parameters (value ± standard error)", (0, 7))


def _error(value: float, truth: float) -> str:
    return percent(value / truth - 1.0, 2) if truth else "–"


def _remarks(reproduction: Reproduction) -> Html:
    remarks = reproduction.table2().set_index("parameter")["remark"]
    items = [
        element(
            "li", parameter(name), ": ", str(remarks[name]).replace("+-", "±").replace("'", "’")
        )
        for name in LUGRE
    ]
    return join(
        [
            element("ul", join(items, "\n")),
            paragraph(
                parameter("m"), " and ", parameter("b"), " are identified only, not learned."
            ),
        ]
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
        (reproduction.learned.result, reproduction.learned.cost),
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
    gap = join(["RMS of ", symbol("v"), " − ", symbol("v", "r"), " [mm/s]"])
    head = ("", "Cost (6) [m²/s²]", gap, "Of that without")
    return element(
        "div",
        table(head, rows, f"Cost of a training run of {number(samples, 6)} samples"),
        paragraph(
            f"The paper prints {number(PAPER_COST, 2)} without a unit, a sample rate or a "
            "duration. Read in m²/s² over as many samples as here, it is the velocity error in the "
            "last row. What the real stage costs without compensation is not given."
        ),
    )
